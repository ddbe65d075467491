//! Wavefront OBJ: read what the shape needs, keep the text for writing it back.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::text::Place;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// One corner of a polygon; indices from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjCorner {
    /// Index of the `v` line.
    pub vertex: u32,
    /// Index of the `vt` line.
    pub texture: Option<u32>,
    /// Index of the `vn` line.
    pub normal: Option<u32>,
}

/// An OBJ file: its polygons, and its text, so that it can be written back with moved points and
/// everything else byte for byte (see [`ObjDocument::text_with_points`]).
#[derive(Clone, Debug)]
pub struct ObjDocument {
    pub(super) path: PathBuf,
    pub(super) text: Vec<u8>,
    pub(super) points: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    /// Where the three numbers of each `v` and `vn` line stand in the text.
    pub(super) point_spans: Vec<Range<usize>>,
    pub(super) normal_spans: Vec<Range<usize>>,
    corners: Vec<ObjCorner>,
    /// First corner of each polygon, and the number of all corners.
    starts: Vec<usize>,
}

impl ObjDocument {
    /// Reads an OBJ file.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(super::read_bytes(path)?, path)
    }

    /// Reads `v`, `vn` and `f` lines (n-gons, negative indices, all corner forms, line
    /// continuation); everything else is kept as text. Faces of fewer than three corners have no
    /// area and are left out of [`ObjDocument::polygons`].
    pub fn parse(bytes: Vec<u8>, path: &Path) -> Result<Self> {
        let mut document = Self {
            path: path.to_path_buf(),
            text: bytes,
            points: Vec::new(),
            normals: Vec::new(),
            point_spans: Vec::new(),
            normal_spans: Vec::new(),
            corners: Vec::new(),
            starts: vec![0],
        };
        let mut face_lines = Vec::new();
        let mut texture_count = 0;
        let text = std::mem::take(&mut document.text);
        for (line, span) in logical_lines(&text) {
            let place = Place { path, line };
            let tokens = tokens(&text, span);
            match tokens.first().map(|t| &text[t.clone()]) {
                Some(b"v") => {
                    let (point, span) = three_numbers(&text, &tokens, place)?;
                    document.points.push(point);
                    document.point_spans.push(span);
                }
                Some(b"vn") => {
                    let (normal, span) = three_numbers(&text, &tokens, place)?;
                    document.normals.push(normal);
                    document.normal_spans.push(span);
                }
                Some(b"vt") => texture_count += 1,
                Some(b"f" | b"fo") => {
                    let counts = [document.points.len(), texture_count, document.normals.len()];
                    document.add_face(&text, &tokens[1..], counts, place)?;
                    face_lines.push(line);
                }
                _ => {}
            }
        }
        document.text = text;
        document.check_faces(&face_lines, texture_count)?;
        Ok(document)
    }

    fn add_face(
        &mut self,
        text: &[u8],
        corners: &[Range<usize>],
        counts: [usize; 3],
        place: Place,
    ) -> Result<()> {
        for span in corners {
            let token = str::from_utf8(&text[span.clone()]).unwrap_or("?");
            self.corners.push(parse_corner(token, counts, place)?);
        }
        self.starts.push(self.corners.len());
        Ok(())
    }

    /// Positive indices may refer to later lines, so the ranges are known only at the end.
    fn check_faces(&self, face_lines: &[usize], texture_count: usize) -> Result<()> {
        let counts = [self.points.len(), texture_count, self.normals.len()];
        for (polygon, &line) in self.starts.windows(2).zip(face_lines) {
            for corner in &self.corners[polygon[0]..polygon[1]] {
                let indices = [Some(corner.vertex), corner.texture, corner.normal];
                for ((index, count), what) in indices.into_iter().zip(counts).zip(["v", "vt", "vn"])
                {
                    if let Some(index) = index.filter(|&i| i as usize >= count) {
                        return Err(Error::parse(
                            &self.path,
                            line,
                            format!(
                                "the face refers to {what} {} but the file has only {count} {what} lines",
                                u64::from(index) + 1
                            ),
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// Vertex positions in file order.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The polygons with at least three corners, in file order.
    pub fn polygons(&self) -> impl Iterator<Item = &[ObjCorner]> {
        self.starts
            .windows(2)
            .map(|polygon| &self.corners[polygon[0]..polygon[1]])
            .filter(|corners| corners.len() >= 3)
    }

    /// The surface, each polygon as a fan of triangles around its first corner.
    pub fn mesh(&self) -> Result<TriMesh> {
        let mut triangles = Vec::with_capacity(self.corners.len());
        for polygon in self.polygons() {
            for pair in polygon[1..].windows(2) {
                triangles.push([polygon[0].vertex, pair[0].vertex, pair[1].vertex]);
            }
        }
        TriMesh::new(self.points.clone(), triangles)
    }
}

/// Physical lines joined where a backslash ends them: the first line's number and the byte range.
fn logical_lines(text: &[u8]) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
    let mut at = 0;
    let mut line = 1;
    std::iter::from_fn(move || {
        if at >= text.len() {
            return None;
        }
        let (start, first_line) = (at, line);
        loop {
            let end = text[at..].iter().position(|&b| b == b'\n').map_or(text.len(), |n| at + n);
            let content = text[at..end].strip_suffix(b"\r").unwrap_or(&text[at..end]);
            at = (end + 1).min(text.len());
            line += 1;
            if !content.ends_with(b"\\") || end >= text.len() {
                return Some((first_line, start..end));
            }
        }
    })
}

/// Byte ranges of the words of a line, without its comment.
fn tokens(text: &[u8], line: Range<usize>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut inside = false;
    for at in line {
        let byte = text[at];
        if byte == b'#' {
            break;
        }
        let separator = byte.is_ascii_whitespace() || byte == b'\\';
        if !separator && inside {
            if let Some(last) = found.last_mut() {
                last.end = at + 1;
            }
        } else if !separator {
            found.push(at..at + 1);
        }
        inside = !separator;
    }
    // A byte order mark belongs to no word.
    if let Some(first) = found.first_mut()
        && text[first.clone()].starts_with(b"\xef\xbb\xbf")
    {
        first.start += 3;
        if first.start == first.end {
            found.remove(0);
        }
    }
    found
}

fn three_numbers(
    text: &[u8],
    tokens: &[Range<usize>],
    place: Place,
) -> Result<(Vec3, Range<usize>)> {
    let mut words = tokens[1..].iter().map(|t| str::from_utf8(&text[t.clone()]).unwrap_or("?"));
    let position = place.position(&mut words)?;
    Ok((position, tokens[1].start..tokens[3].end))
}

/// `counts`: v, vt and vn lines so far, which negative indices count back from.
fn parse_corner(token: &str, counts: [usize; 3], place: Place) -> Result<ObjCorner> {
    let mut parts = token.split('/');
    let mut index = |count: usize| -> Result<Option<u32>> {
        let Some(part) = parts.next().filter(|p| !p.is_empty()) else { return Ok(None) };
        let wrong =
            || place.error(format!("'{}' is not a face corner", super::text::shorten(token)));
        let number: i64 = part.parse().map_err(|_| wrong())?;
        let from_zero = if number > 0 { number - 1 } else { count as i64 + number };
        if number == 0 || from_zero < 0 {
            return Err(place.error(format!(
                "the face index {number} refers to nothing; indices count from 1, or back from -1"
            )));
        }
        u32::try_from(from_zero).map(Some).map_err(|_| wrong())
    };
    let vertex = index(counts[0])?;
    let (texture, normal) = (index(counts[1])?, index(counts[2])?);
    let vertex = vertex.ok_or_else(|| place.error("a face corner names no vertex"))?;
    Ok(ObjCorner { vertex, texture, normal })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<ObjDocument> {
        ObjDocument::parse(text.as_bytes().to_vec(), Path::new("a.obj"))
    }

    #[test]
    fn polygons_negative_indices_and_continued_lines_are_read() {
        let document = parse(
            "\u{feff}# made by hand\r\nmtllib a.mtl\r\ng left\r\nv 0 0 0 1 0 0 # red\r\nv 1 0 0\r\n\
             v 1 1 \\\r\n 0\r\nv 0 1 0\r\nvt 0 0\r\nvn 0 0 1\r\nusemtl skin\r\ns off\r\n\
             f 1/1/1 2//1 3/1 4\r\nf -4 -3 -1\r\nf 1 2\r\nf 1 2 5\r\nv 0 0 1\r\n",
        )
        .unwrap();
        assert_eq!(document.points().len(), 5);
        assert_eq!(document.points()[2], Vec3::new(1.0, 1.0, 0.0));
        let sizes: Vec<usize> = document.polygons().map(<[_]>::len).collect();
        assert_eq!(sizes, [4, 3, 3]);
        let first = document.polygons().next().unwrap();
        assert_eq!(first[1], ObjCorner { vertex: 1, texture: None, normal: Some(0) });
        assert_eq!(first[2], ObjCorner { vertex: 2, texture: Some(0), normal: None });
        let triangles = document.mesh().unwrap().triangles;
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 3], [0, 1, 4]]);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, expected) in [
            ("v 0 0\n", "a.obj, line 1: the line ends before z"),
            ("\nv 0 nan 0\n", "a.obj, line 2: y is nan, not a finite number"),
            (
                "v 0 0 0\nf 1 2 3\n",
                "line 2: the face refers to v 2 but the file has only 1 v lines",
            ),
            ("v 0 0 0\nf 0 1 1\n", "line 2: the face index 0 refers to nothing"),
            ("v 0 0 0\nf -2 1 1\n", "line 2: the face index -2 refers to nothing"),
            ("v 0 0 0\nf 1/1 1 1\n", "refers to vt 1 but the file has only 0 vt lines"),
            ("v 0 0 0\nf 99999999999 1 1\n", "'99999999999' is not a face corner"),
            ("v 0 0 0\nf /1 1 1\n", "a face corner names no vertex"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
