//! STL surfaces, through the `stl_io` crate. Positions in STL files have single precision.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use super::write_beside;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Bytes before the triangle count of a binary STL file.
const HEADER: usize = 80;
/// Bytes per triangle of a binary STL file.
const RECORD: usize = 50;

/// An STL surface; identical corner positions are one vertex, in the order of their first use.
#[derive(Clone, Debug)]
pub struct StlDocument {
    mesh: TriMesh,
}

impl StlDocument {
    /// Reads a text or binary STL file.
    pub fn parse(mut bytes: Vec<u8>, path: &Path) -> Result<Self> {
        mark_binary(&mut bytes, path)?;
        let wrong =
            |e: std::io::Error| Error::parse(path, None, format!("not a good STL file: {e}"));
        let mut cursor = Cursor::new(bytes);
        let mut mesh = TriMesh::default();
        let mut ids = HashMap::new();
        for (t, triangle) in stl_io::create_stl_reader(&mut cursor).map_err(wrong)?.enumerate() {
            let corners = triangle.map_err(wrong)?.vertices.map(|v| v.0);
            if corners.iter().flatten().any(|c| !c.is_finite()) {
                let message = format!("triangle {t} has a corner that is not a finite number");
                return Err(Error::parse(path, None, message));
            }
            mesh.triangles.push(corners.map(|corner| {
                // Adding zero makes -0 and 0 the same bits.
                *ids.entry(corner.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                    mesh.points.push(Vec3::from(corner.map(f64::from)));
                    mesh.points.len() as u32 - 1
                })
            }));
        }
        Ok(Self { mesh })
    }

    /// The surface.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }
}

/// Some programs write binary files whose header says "solid": the length tells them apart from
/// text. A binary file that is shorter than its count says is refused here.
fn mark_binary(bytes: &mut [u8], path: &Path) -> Result<()> {
    let count = bytes
        .get(HEADER..HEADER + 4)
        .and_then(|c| c.try_into().ok())
        .map_or(0, |c| u32::from_le_bytes(c) as usize);
    let expected = HEADER + 4 + RECORD * count;
    if bytes.len() == expected {
        bytes[..HEADER].fill(0);
    } else if !bytes.starts_with(b"solid") && bytes.len() < expected {
        return Err(Error::parse(
            path,
            None,
            format!(
                "the header promises {count} triangles, but the file has only {} bytes; it was cut off",
                bytes.len()
            ),
        ));
    }
    Ok(())
}

/// Writes a binary STL file (single precision; vertices are not shared in this format).
pub fn write_stl(path: &Path, mesh: &TriMesh) -> Result<()> {
    let triangles: Vec<stl_io::Triangle> = (0..mesh.triangles.len())
        .map(|t| {
            let corners = mesh.corners(t);
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE);
            stl_io::Triangle {
                normal: stl_io::Normal::new(single(normal.unwrap_or_default())),
                vertices: corners.map(|corner| stl_io::Vertex::new(single(corner))),
            }
        })
        .collect();
    write_beside(path, |mut out| stl_io::write_stl(&mut out, triangles.iter()))
}

fn single(p: Vec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriMesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        TriMesh::new(points.map(Vec3::from).to_vec(), triangles).unwrap()
    }

    fn written(name: &str) -> Vec<u8> {
        let name = format!("moulage_{name}_{}.stl", std::process::id());
        let path = std::env::temp_dir().join(name);
        write_stl(&path, &tetrahedron()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        bytes
    }

    #[test]
    fn a_written_file_reads_back_welded_even_if_its_header_says_solid() {
        let mut bytes = written("welded");
        bytes[..6].copy_from_slice(b"solid ");
        let mesh = StlDocument::parse(bytes, Path::new("a.stl")).unwrap().mesh().clone();
        assert_eq!(mesh.points.len(), 4);
        assert!((mesh.volume() - 0.25).abs() < 1e-7);
    }

    #[test]
    fn text_is_read_and_broken_files_are_refused() {
        let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 -0\n\
                    vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let parse = |bytes: &[u8]| StlDocument::parse(bytes.to_vec(), Path::new("a.stl"));
        assert_eq!(parse(text.as_bytes()).unwrap().mesh().triangles, [[0, 1, 2]]);
        let cut = written("cut");
        let error = parse(&cut[..cut.len() - 20]).unwrap_err().to_string();
        assert!(error.contains("promises 4 triangles"), "{error}");
        let error = parse(&text.as_bytes()[..60]).unwrap_err().to_string();
        assert!(error.starts_with("a.stl: not a good STL file"), "{error}");
        let error = parse(text.replace("-0", "nan").as_bytes()).unwrap_err().to_string();
        assert!(error.contains("expected finite"), "{error}");
    }
}
