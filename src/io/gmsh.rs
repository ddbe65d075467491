//! Gmsh `.msh` files, versions 2.2 and 4.1, text and binary.
//!
//! Own code: the crate for this format (`mshio`) reads version 4.1 only.

use std::collections::HashMap;
use std::path::Path;

use super::bytes::Bytes;
use super::tet_cells::tet_mesh;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// Gmsh's number of the tet with four corners, and of the one with ten nodes.
const TET_TYPES: [u64; 2] = [4, 11];

/// Nodes of Gmsh's element types 1 to 21.
const NODES_OF_TYPE: [usize; 21] =
    [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10];

/// Reads the nodes and the tets; elements of other types are left out.
pub fn parse_gmsh(bytes: &[u8], path: &Path) -> Result<TetMesh> {
    let mut file = Reader::open(bytes, path)?;
    file.find("$Nodes")?;
    let nodes = if file.version == 4 { file.nodes_4()? } else { file.nodes_2()? };
    file.find("$Elements")?;
    let elements = if file.version == 4 { file.tets_4()? } else { file.tets_2()? };
    let mut ids = HashMap::with_capacity(nodes.len());
    for (id, (tag, _)) in nodes.iter().enumerate() {
        if ids.insert(*tag, id as u32).is_some() {
            return Err(Error::parse(path, None, format!("node {tag} is there twice")));
        }
    }
    let points: Vec<Vec3> = nodes.iter().map(|(_, point)| *point).collect();
    // A node that is not there becomes a number no point has, which `tet_mesh` reports.
    let id = |tag: u64| ids.get(&tag).copied().unwrap_or(u32::MAX);
    tet_mesh(&points, elements.into_iter().map(|tet| tet.map(id)).collect(), path)
}

struct Reader<'a> {
    path: &'a Path,
    all: &'a [u8],
    bytes: Bytes<'a>,
    binary: bool,
    /// Major version: 2 or 4.
    version: u32,
}

impl<'a> Reader<'a> {
    fn open(all: &'a [u8], path: &'a Path) -> Result<Self> {
        let mut file = Self { path, all, bytes: Bytes::new(all, false), binary: false, version: 0 };
        file.find("$MeshFormat")?;
        let version = file.word()?;
        file.version = match version {
            "2.2" => 2,
            "4.1" => 4,
            other => {
                let message = format!(
                    "Gmsh version '{}' is not read; save as version 4.1 or 2.2",
                    super::text::shorten(other)
                );
                return Err(Error::parse(path, None, message));
            }
        };
        file.binary = file.word()? == "1";
        if file.word()? != "8" {
            return Err(file.error("only 8-byte numbers are read"));
        }
        if file.binary {
            file.end_line();
            let one = file.bytes.take(4).ok_or_else(|| file.error("the file ends too early"))?;
            let rest = file.bytes.rest();
            file.bytes = Bytes::new(rest, one == [0, 0, 0, 1]);
        }
        Ok(file)
    }

    /// Goes behind the line `section`.
    fn find(&mut self, section: &str) -> Result<()> {
        let rest = self.bytes.rest();
        let at = rest
            .windows(section.len())
            .position(|window| window == section.as_bytes())
            .ok_or_else(|| Error::parse(self.path, None, format!("the file has no {section}")))?;
        let _ = self.bytes.take(at + section.len());
        self.end_line();
        Ok(())
    }

    fn end_line(&mut self) {
        let rest = self.bytes.rest();
        let end = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |n| n + 1);
        let _ = self.bytes.take(end);
    }

    fn error(&self, message: &str) -> Error {
        let read = self.all.len() - self.bytes.rest().len();
        let line = self.all[..read].split(|&b| b == b'\n').count();
        Error::parse(self.path, (!self.binary).then_some(line), message)
    }

    fn word(&mut self) -> Result<&'a str> {
        let rest = self.bytes.rest();
        let blank = |&b: &u8| b.is_ascii_whitespace();
        let start = rest.iter().position(|b| !blank(b)).unwrap_or(rest.len());
        let length = rest[start..].iter().position(blank).unwrap_or(rest.len() - start);
        let word = self.bytes.take(start + length).map_or(&[][..], |taken| &taken[start..]);
        match str::from_utf8(word) {
            Ok(word) if !word.is_empty() => Ok(word),
            _ => Err(self.error("the file ends too early")),
        }
    }

    /// A whole number that takes `width` bytes in binary files.
    fn whole(&mut self, width: usize) -> Result<u64> {
        if self.binary {
            let value = self.bytes.unsigned(width);
            return value.ok_or_else(|| self.error("the file ends too early"));
        }
        let word = self.word()?;
        // Entity tags may be negative; they are read but not used.
        let value = word.parse::<i64>().ok();
        value.map(|v| v as u64).ok_or_else(|| {
            self.error(&format!("'{}' is not a whole number", super::text::shorten(word)))
        })
    }

    fn float(&mut self) -> Result<f64> {
        let value = if self.binary {
            self.bytes.f64().ok_or_else(|| self.error("the file ends too early"))?
        } else {
            let word = self.word()?;
            word.parse().map_err(|_| {
                self.error(&format!("'{}' is not a number", super::text::shorten(word)))
            })?
        };
        if value.is_finite() { Ok(value) } else { Err(self.error("a coordinate is not finite")) }
    }

    fn point(&mut self) -> Result<Vec3> {
        Ok(Vec3::new(self.float()?, self.float()?, self.float()?))
    }

    fn nodes_4(&mut self) -> Result<Vec<(u64, Vec3)>> {
        let blocks = self.whole(8)?;
        for _ in 0..3 {
            self.whole(8)?;
        }
        let mut nodes = Vec::new();
        for _ in 0..blocks {
            let dimension = self.whole(4)?;
            self.whole(4)?;
            let parametric = self.whole(4)? != 0;
            let count = self.whole(8)?;
            let first = nodes.len();
            for _ in 0..count {
                nodes.push((self.whole(8)?, Vec3::zeros()));
            }
            for node in first..nodes.len() {
                nodes[node].1 = self.point()?;
                for _ in 0..if parametric { dimension } else { 0 } {
                    self.float()?;
                }
            }
        }
        Ok(nodes)
    }

    fn tets_4(&mut self) -> Result<Vec<[u64; 4]>> {
        let blocks = self.whole(8)?;
        for _ in 0..3 {
            self.whole(8)?;
        }
        let mut tets = Vec::new();
        for _ in 0..blocks {
            self.whole(4)?;
            self.whole(4)?;
            let kind = self.whole(4)?;
            for _ in 0..self.whole(8)? {
                self.whole(8)?;
                self.element(kind, 8, &mut tets)?;
            }
        }
        Ok(tets)
    }

    fn nodes_2(&mut self) -> Result<Vec<(u64, Vec3)>> {
        let count = self.count_line()?;
        let mut nodes = Vec::new();
        for _ in 0..count {
            nodes.push((self.whole(4)?, self.point()?));
        }
        Ok(nodes)
    }

    fn tets_2(&mut self) -> Result<Vec<[u64; 4]>> {
        let count = self.count_line()?;
        let mut tets = Vec::new();
        let mut done = 0;
        while done < count {
            // Binary files group elements of one type; in text each has its own header.
            let (kind, group, tags) = if self.binary {
                (self.whole(4)?, self.whole(4)?, self.whole(4)?)
            } else {
                self.whole(4)?;
                (self.whole(4)?, 1, self.whole(4)?)
            };
            for _ in 0..group {
                for _ in 0..tags + u64::from(self.binary) {
                    self.whole(4)?;
                }
                self.element(kind, 4, &mut tets)?;
            }
            done += group.max(1);
        }
        Ok(tets)
    }

    /// The count at the head of a version 2 section, which is text in binary files too.
    fn count_line(&mut self) -> Result<u64> {
        let word = self.word()?;
        let count = word.parse().map_err(|_| self.error("the section does not begin with a count"));
        if self.binary {
            self.end_line();
        }
        count
    }

    /// The nodes of one element, kept if it is a tet.
    fn element(&mut self, kind: u64, width: usize, tets: &mut Vec<[u64; 4]>) -> Result<()> {
        let count = (kind as usize).checked_sub(1).and_then(|k| NODES_OF_TYPE.get(k)).copied();
        let count = count.ok_or_else(|| {
            self.error(&format!("elements of Gmsh's type {kind} are not known; save tets only"))
        })?;
        let mut corners = [0; 4];
        for node in 0..count {
            let tag = self.whole(width)?;
            if let Some(corner) = corners.get_mut(node) {
                *corner = tag;
            }
        }
        if TET_TYPES.contains(&kind) {
            tets.push(corners);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const V4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n\
        $Nodes\n2 4 1 9\n2 1 0 3\n1\n2\n5\n0 0 0\n1 0 0\n0 1 0\n3 1 0 1\n9\n0 0 1\n$EndNodes\n\
        $Elements\n2 2 1 2\n2 1 2 1\n1 1 2 5\n3 1 4 1\n2 1 2 5 9\n$EndElements\n";
    const V2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n5 0 1 0\n\
        9 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 0 1 1 2 5\n2 4 2 0 1 1 2 5 9\n$EndElements\n";

    fn parse(bytes: &[u8]) -> Result<TetMesh> {
        parse_gmsh(bytes, Path::new("a.msh"))
    }

    fn binary_2() -> Vec<u8> {
        let mut bytes = b"$MeshFormat\n2.2 1 8\n".to_vec();
        bytes.extend(1_i32.to_le_bytes());
        bytes.extend(b"\n$EndMeshFormat\n$Nodes\n4\n");
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f64]];
        for (tag, point) in [1_i32, 2, 5, 9].into_iter().zip(points) {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(point.into_iter().flat_map(f64::to_le_bytes));
        }
        bytes.extend(b"\n$EndNodes\n$Elements\n1\n");
        bytes.extend([4, 1, 2, 1, 7, 7, 1, 2, 5, 9_i32].into_iter().flat_map(i32::to_le_bytes));
        bytes.extend(b"\n$EndElements\n");
        bytes
    }

    #[test]
    fn both_versions_and_encodings_give_the_same_mesh() {
        let mesh = parse(V4.as_bytes()).unwrap();
        assert_eq!(mesh.tets, [[0, 1, 2, 3]]);
        assert_eq!(parse(V2.as_bytes()).unwrap(), mesh);
        assert_eq!(parse(&binary_2()).unwrap(), mesh);
    }

    #[test]
    fn cut_files_are_errors_at_every_length() {
        let whole = binary_2();
        for length in 0..whole.len() - 20 {
            assert!(parse(&whole[..length]).is_err(), "{length}");
        }
        for length in 0..V4.len() - 20 {
            assert!(parse(&V4.as_bytes()[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn errors_say_what_is_wrong() {
        for (from, to, expected) in [
            ("4.1 0", "3.0 0", "version '3.0' is not read"),
            ("4.1 0 8", "4.1 0 4", "only 8-byte numbers"),
            ("0 1 0\n", "0 one 0\n", "line 15: 'one' is not a number"),
            (
                "2 4 1 9\n2 1 0 3",
                "2 4 1 9\n2 1 0 99999999999",
                "line 18: '0.0' is not a whole number",
            ),
            ("2 1 2 5 9", "2 1 2 5 8", "tet 0 refers to a vertex that is not"),
            ("3 1 4 1", "3 1 99 1", "elements of Gmsh's type 99 are not known"),
            ("1\n2\n5\n", "1\n2\n2\n", "node 2 is there twice"),
            ("$Elements", "$Element", "the file has no $Elements"),
        ] {
            let text = V4.replace(from, to).replace("9\n0 0 1\n", "9\n0.0 0.5 1\n");
            let message = parse(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(expected), "{to}: {message}");
        }
    }
}
