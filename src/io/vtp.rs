//! VTK PolyData (`.vtp`) as OpenSim's bones have it: ASCII points and polygons.

use std::path::Path;

use roxmltree::{Document, Node};

use super::read_bytes;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Reads a `.vtp` surface; polygons become fans of triangles.
pub fn read_vtp(path: &Path) -> Result<TriMesh> {
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes).map_err(|_| {
        Error::parse(path, None, "binary .vtp data is not read; save the file as ASCII or as .obj")
    })?;
    parse_vtp(text, path)
}

/// Reads a `.vtp` surface from its text; `path` is for error messages.
pub fn parse_vtp(text: &str, path: &Path) -> Result<TriMesh> {
    let xml = Document::parse(text)
        .map_err(|e| Error::parse(path, e.pos().row as usize, format!("not valid XML: {e}")))?;
    let section = |name: &str| {
        xml.descendants().find(|n| n.has_tag_name(name)).ok_or_else(|| {
            Error::parse(path, None, format!("no <{name}>; this is not a PolyData file"))
        })
    };
    let fail = |message: String| Error::parse(path, None, message);
    let points = array(&section("Points")?, None).map_err(fail)?;
    if points.len() % 3 != 0 {
        return Err(fail("the points are not triples of numbers".into()));
    }
    let points: Vec<Vec3> = points.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let polygons = section("Polys")?;
    let corners = array(&polygons, Some("connectivity")).map_err(fail)?;
    let ends = array(&polygons, Some("offsets")).map_err(fail)?;
    let mut triangles = Vec::new();
    let mut start = 0;
    for end in ends {
        let end = end as usize;
        let polygon = corners.get(start..end).ok_or_else(|| {
            fail(format!("a polygon ends at corner {end}, but there are {}", corners.len()))
        })?;
        for k in 1..polygon.len().saturating_sub(1) {
            triangles.push([polygon[0], polygon[k], polygon[k + 1]].map(|x| x as u32));
        }
        start = end;
    }
    if triangles.is_empty() {
        return Err(fail("the file has no polygons".into()));
    }
    TriMesh::new(points, triangles).map_err(|e| fail(e.to_string()))
}

/// The numbers of a section's data array, by its name or the first one.
fn array(section: &Node, name: Option<&str>) -> Result<Vec<f64>, String> {
    let what = name.unwrap_or("points");
    let array = section
        .children()
        .filter(|n| n.has_tag_name("DataArray"))
        .find(|n| name.is_none_or(|name| n.attribute("Name") == Some(name)))
        .ok_or_else(|| format!("no <DataArray> with the {what}"))?;
    if array.attribute("format") != Some("ascii") {
        return Err(format!("the {what} are not ASCII; save the file as ASCII or as .obj"));
    }
    let words = array.text().unwrap_or_default().split_whitespace();
    words
        .map(|w| w.parse().map_err(|_| format!("\"{w}\" among the {what} is not a number")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = r#"<VTKFile type="PolyData"><PolyData><Piece>
      <Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>
      <Polys><DataArray Name="connectivity" format="ascii">0 1 2 3</DataArray>
      <DataArray Name="offsets" format="ascii">4</DataArray></Polys></Piece></PolyData></VTKFile>"#;

    #[test]
    fn polygons_become_triangles_and_mistakes_are_named() {
        let path = Path::new("a.vtp");
        let mesh = parse_vtp(SQUARE, path).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let message = |text: &str| parse_vtp(text, path).unwrap_err().to_string();
        assert!(message(&SQUARE.replace(">4<", ">9<")).contains("corner 9"));
        assert!(message(&SQUARE.replace("0 1 2 3", "0 1 2 7")).contains("vertex 7"));
        assert!(message(&SQUARE.replace("ascii", "binary")).contains("ASCII"));
        assert!(message("<a/>").contains("Points"));
    }
}
