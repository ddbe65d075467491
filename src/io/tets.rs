//! Any tet mesh file, by its extension.

use std::path::Path;

use super::gmsh::parse_gmsh;
use super::read_bytes;
use super::tetgen_files::parse_tetgen;
use super::veg::parse_veg;
use super::vtu_read::parse_vtu;
use crate::error::{Error, Result, Shown};
use crate::mesh::TetMesh;

/// Reads TetGen `.node`/`.ele` (either name; the other file stands beside it), `.vtu`, VegaFEM
/// `.veg` or Gmsh `.msh`. Points that no tet uses are left out.
pub fn read_tets(path: &Path) -> Result<TetMesh> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("node" | "ele") => {
            let (nodes, elements) = (path.with_extension("node"), path.with_extension("ele"));
            parse_tetgen(&read_bytes(&nodes)?, &nodes, &read_bytes(&elements)?, &elements)
        }
        Some("vtu") => parse_vtu(&read_bytes(path)?, path),
        Some("veg") => parse_veg(&read_bytes(path)?, path),
        Some("msh") => parse_gmsh(&read_bytes(path)?, path),
        _ => Err(Error::Unsupported(format!(
            "{} is not a tet mesh file: .node/.ele, .vtu, .veg and .msh are",
            path.shown()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_refused() {
        let error = read_tets(Path::new("a.stl")).unwrap_err();
        assert!(error.to_string().starts_with("a.stl is not a tet mesh file"), "{error}");
    }
}
