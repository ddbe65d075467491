//! Any surface file, by its extension.

use std::path::Path;

use super::obj::ObjDocument;
use super::ply::{PlyDocument, write_ply};
use super::stl::{StlDocument, write_stl};
use super::{read_bytes, write_beside};
use crate::error::{Error, Result, Shown};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// A surface file that can be written back in its own format with moved points.
#[derive(Clone, Debug)]
pub enum SurfaceFile {
    /// Wavefront OBJ.
    Obj(ObjDocument),
    /// Stanford PLY.
    Ply(PlyDocument),
    /// STL.
    Stl(StlDocument),
}

/// Reads `.obj`, `.ply` or `.stl`; a surface without triangles is an error.
pub fn read_surface(path: &Path) -> Result<SurfaceFile> {
    known_extension(path)?;
    parse_surface(read_bytes(path)?, path)
}

/// Reads a surface from bytes; the extension of `path` tells the format.
pub fn parse_surface(bytes: Vec<u8>, path: &Path) -> Result<SurfaceFile> {
    let file = match known_extension(path)? {
        "obj" => SurfaceFile::Obj(ObjDocument::parse(bytes, path)?),
        "ply" => SurfaceFile::Ply(PlyDocument::parse(&bytes, path)?),
        _ => SurfaceFile::Stl(StlDocument::parse(bytes, path)?),
    };
    if file.mesh()?.triangles.is_empty() {
        let message = "the file has no faces; a surface made of triangles or polygons is needed";
        return Err(Error::parse(path, None, message));
    }
    Ok(file)
}

impl SurfaceFile {
    /// The surface; polygons as fans of triangles, vertices in file order.
    pub fn mesh(&self) -> Result<TriMesh> {
        match self {
            Self::Obj(document) => document.mesh(),
            Self::Ply(document) => document.mesh(),
            Self::Stl(document) => Ok(document.mesh().clone()),
        }
    }

    /// Writes the surface with moved points. If the extension of `path` is the file's own format,
    /// everything but positions and normals is kept (see the documents); another surface format
    /// gets points and triangles.
    pub fn write_with_points(&self, path: &Path, points: &[Vec3]) -> Result<()> {
        let mut mesh = self.mesh()?;
        if points.len() != mesh.points.len() {
            return Err(Error::invalid(format!(
                "{} points are to be written into a surface of {} vertices",
                points.len(),
                mesh.points.len()
            )));
        }
        mesh.points = points.to_vec();
        match (self, known_extension(path)?) {
            (Self::Obj(document), "obj") => document.write_with_points(path, points),
            (Self::Ply(document), "ply") => document.write_with_points(path, points),
            _ => write_surface(path, &mesh),
        }
    }
}

/// Writes points and triangles as `.obj`, `.ply` or `.stl`.
pub fn write_surface(path: &Path, mesh: &TriMesh) -> Result<()> {
    match known_extension(path)? {
        "obj" => write_beside(path, |out| {
            for p in &mesh.points {
                writeln!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
            }
            for [a, b, c] in &mesh.triangles {
                writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1)?;
            }
            Ok(())
        }),
        "ply" => write_ply(path, mesh, &[]),
        _ => write_stl(path, mesh),
    }
}

fn known_extension(path: &Path) -> Result<&'static str> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    ["obj", "ply", "stl"].into_iter().find(|known| extension.as_deref() == Some(known)).ok_or_else(
        || {
            Error::Unsupported(format!(
                "{} is not a surface file: .obj, .ply and .stl are",
                path.shown()
            ))
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    #[test]
    fn every_format_writes_every_other() {
        let folder = std::env::temp_dir().join(format!("moulage_surface_{}", std::process::id()));
        let first = parse_surface(TRIANGLE.to_vec(), Path::new("a.OBJ")).unwrap();
        let mut points = first.mesh().unwrap().points;
        points[2].z = 0.5;
        for (name, next) in [("a.obj", "b.ply"), ("a.ply", "b.stl"), ("a.stl", "b.obj")] {
            let path = folder.join(name);
            first.write_with_points(&path, &points).unwrap();
            let file = read_surface(&path).unwrap();
            assert_eq!(file.mesh().unwrap().points, points);
            let path = folder.join(next);
            file.write_with_points(&path, &points).unwrap();
            assert_eq!(read_surface(&path).unwrap().mesh().unwrap().points, points);
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn other_files_and_empty_surfaces_are_refused() {
        let error = parse_surface(TRIANGLE.to_vec(), Path::new("a.glb")).unwrap_err();
        assert_eq!(error.to_string(), "a.glb is not a surface file: .obj, .ply and .stl are");
        let error = parse_surface(TRIANGLE[..24].to_vec(), Path::new("a.obj")).unwrap_err();
        assert!(error.to_string().contains("no faces"), "{error}");
    }
}
