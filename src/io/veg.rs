//! VegaFEM's `.veg` tet meshes.

use std::path::Path;

use super::tet_cells::tet_mesh;
use super::text::{Place, data_lines, decode};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// Where the reader stands in the file.
#[derive(Clone, Copy, Default)]
enum Section {
    VertexCount,
    Vertices,
    ElementType,
    ElementCount,
    Elements,
    #[default]
    Other,
}

/// Reads `*VERTICES` and `*ELEMENTS` (type TET), numbered from 0 or 1; materials, regions and sets
/// are left out.
pub fn parse_veg(bytes: &[u8], path: &Path) -> Result<TetMesh> {
    let text = decode(bytes);
    let mut file = File::default();
    for (place, line) in data_lines(&text, path) {
        if line.starts_with('*') {
            file.section = section(line, place)?;
        } else {
            file.add_line(line, place)?;
        }
    }
    for (promised, found, what) in [
        (file.promised[0], file.points.len(), "vertices"),
        (file.promised[1], file.tets.len(), "tets"),
    ] {
        if promised != found {
            let message = format!("{promised} {what} are promised, but the file has {found}");
            return Err(Error::parse(path, None, message));
        }
    }
    // What does not fit becomes a number that no vertex has, which `tet_mesh` reports.
    let from_zero = |v: usize| v.checked_sub(file.first).and_then(|v| u32::try_from(v).ok());
    let from_zero = |v: usize| from_zero(v).unwrap_or(u32::MAX);
    let tets = file.tets.iter().map(|tet| tet.map(from_zero)).collect();
    tet_mesh(&file.points, tets, path)
}

fn section(line: &str, place: Place) -> Result<Section> {
    Ok(match line.to_uppercase().as_str() {
        "*VERTICES" => Section::VertexCount,
        "*ELEMENTS" => Section::ElementType,
        name if name.starts_with("*INCLUDE") => {
            return Err(place.error("included files are not read; put all into one file"));
        }
        _ => Section::Other,
    })
}

#[derive(Default)]
struct File {
    section: Section,
    /// Number of the first vertex.
    first: usize,
    points: Vec<Vec3>,
    tets: Vec<[usize; 4]>,
    /// Counts of vertices and tets that the file states.
    promised: [usize; 2],
}

impl File {
    fn add_line(&mut self, line: &str, place: Place) -> Result<()> {
        let mut tokens = line.split_whitespace();
        let mut number = |what| place.index(place.next(&mut tokens, what)?, what);
        match self.section {
            Section::VertexCount => {
                self.promised[0] = number("the count")?;
                self.section = Section::Vertices;
            }
            Section::Vertices => {
                let number = number("the vertex number")?;
                if self.points.is_empty() {
                    self.first = number;
                }
                if self.first > 1 || number != self.first + self.points.len() {
                    return Err(place.error(format!("vertex {number} is out of order")));
                }
                self.points.push(place.position(&mut tokens)?);
            }
            Section::ElementType => {
                if !matches!(line.to_uppercase().as_str(), "TET" | "TETS") {
                    let message = format!("elements of type '{line}' are not read; TET are");
                    return Err(place.error(message));
                }
                self.section = Section::ElementCount;
            }
            Section::ElementCount => {
                self.promised[1] = number("the count")?;
                self.section = Section::Elements;
            }
            Section::Elements => self.tets.push(corners(&mut tokens, place)?),
            Section::Other => {}
        }
        Ok(())
    }
}

fn corners<'t>(tokens: &mut impl Iterator<Item = &'t str>, place: Place) -> Result<[usize; 4]> {
    let mut tokens = tokens.skip(1);
    let mut tet = [0; 4];
    for corner in &mut tet {
        *corner = place.index(place.next(&mut tokens, "the fourth corner")?, "a corner")?;
    }
    Ok(tet)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# Vega mesh file\n\n*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
        4 0 0 1\n\n*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n\n*MATERIAL BODY\nENU, 1000, 1e7, 0.45\n\
        *REGION\nallElements, BODY\n";

    fn parse(text: &str) -> Result<TetMesh> {
        parse_veg(text.as_bytes(), Path::new("a.veg"))
    }

    #[test]
    fn vertices_and_tets_are_read() {
        let mesh = parse(FILE).unwrap();
        assert_eq!((mesh.points.len(), mesh.tets.as_slice()), (4, [[0, 1, 2, 3]].as_slice()));
    }

    #[test]
    fn errors_name_the_line() {
        for (from, to, expected) in [
            ("4 3 0 0", "9999999999 3 0 0", "9999999999 vertices are promised, but the file has 4"),
            ("1 4 0\n", "2 4 0\n", "2 tets are promised, but the file has 1"),
            ("TET", "CUBIC", "line 11: elements of type 'CUBIC' are not read"),
            ("3 0 1 0", "3 0 nan 0", "line 7: y is nan"),
            ("3 0 1 0", "5 0 1 0", "line 7: vertex 5 is out of order"),
            ("1 1 2 3 4", "1 0 2 3 4", "tet 0 refers to a vertex that is not"),
            ("# Vega mesh file", "*INCLUDE a.node", "included files are not read"),
        ] {
            let message = parse(&FILE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
