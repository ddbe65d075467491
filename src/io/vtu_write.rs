//! Writing tets with data as a VTK unstructured grid, for ParaView and meshio.

use std::io::{self, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::write_beside;
use crate::error::{Error, Result};
use crate::mesh::TetMesh;

/// VTK's number of the tet.
const TET: u8 = 10;

/// Named values per tet or per point.
#[derive(Clone, Copy, Debug)]
pub struct DataArray<'a> {
    /// What ParaView lists.
    pub name: &'a str,
    /// Numbers per tet or point: 1 scalar, 3 vector, 9 matrix (row after row).
    pub components: usize,
    /// All numbers, one tet or point after the other.
    pub values: &'a [f64],
}

/// Writes `mesh` with data per tet and per point. The numbers are inline base64, not compressed.
/// Fails if an array does not fit the mesh.
pub fn write_vtu(
    path: &Path,
    mesh: &TetMesh,
    tet_data: &[DataArray],
    point_data: &[DataArray],
) -> Result<()> {
    let per_kind = [(tet_data, mesh.tets.len(), "tets"), (point_data, mesh.points.len(), "points")];
    for (arrays, count, what) in per_kind {
        if let Some(array) = arrays.iter().find(|a| a.values.len() != a.components * count) {
            return Err(Error::invalid(format!(
                "'{}' has {} numbers, but {count} {what} with {} each are to be written",
                array.name,
                array.values.len(),
                array.components
            )));
        }
    }
    write_beside(path, |out| {
        writeln!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
            mesh.points.len(),
            mesh.tets.len()
        )?;
        write_data(out, "PointData", point_data)?;
        write_data(out, "CellData", tet_data)?;
        writeln!(out, "<Points>")?;
        let points = mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]);
        write_array(out, "Points", "Float64", 3, points.flat_map(f64::to_le_bytes).collect())?;
        writeln!(out, "</Points>\n<Cells>")?;
        let corners = mesh.tets.iter().flatten().map(|&v| i64::from(v));
        write_array(out, "connectivity", "Int64", 1, corners.flat_map(i64::to_le_bytes).collect())?;
        let ends = (1..=mesh.tets.len()).map(|t| 4 * t as i64);
        write_array(out, "offsets", "Int64", 1, ends.flat_map(i64::to_le_bytes).collect())?;
        write_array(out, "types", "UInt8", 1, vec![TET; mesh.tets.len()])?;
        writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
    })
}

fn write_data(out: &mut dyn Write, group: &str, arrays: &[DataArray]) -> io::Result<()> {
    writeln!(out, "<{group}>")?;
    for array in arrays {
        let bytes = array.values.iter().flat_map(|v| v.to_le_bytes()).collect();
        write_array(out, array.name, "Float64", array.components, bytes)?;
    }
    writeln!(out, "</{group}>")
}

fn write_array(
    out: &mut dyn Write,
    name: &str,
    kind: &str,
    components: usize,
    mut data: Vec<u8>,
) -> io::Result<()> {
    data.splice(0..0, (data.len() as u64).to_le_bytes());
    writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
         format=\"binary\">\n{}\n</DataArray>",
        STANDARD.encode(data)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::parse_vtu;
    use crate::math::Vec3;

    #[test]
    fn what_is_written_reads_back_to_the_same_bits() {
        let points = [[0.0, 0.0, 0.1], [1.0 / 3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let points = points.map(Vec3::from).to_vec();
        let mesh = TetMesh::new(points, vec![[0, 1, 2, 3]]).unwrap();
        let name = format!("moulage_{}.vtu", std::process::id());
        let path = std::env::temp_dir().join(name);
        let ratio = DataArray { name: "ratio", components: 1, values: &[1.5] };
        write_vtu(&path, &mesh, &[ratio], &[]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(parse_vtu(&bytes, &path).unwrap(), mesh);
        let error = write_vtu(&path, &mesh, &[], &[ratio]).unwrap_err().to_string();
        assert!(error.contains("'ratio' has 1 numbers, but 4 points with 1 each"), "{error}");
    }
}
