//! MeshLab's picked points, `.pp`, read through the `roxmltree` crate.

use std::path::Path;

use roxmltree::{Document, ParsingOptions};

use super::marker::Marker;
use super::markup::escaped;
use super::text::{Place, decode};
use super::write_beside;
use crate::error::{Error, Result};

/// Reads the active points; positions are taken as they are.
pub fn parse_picked_points(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    let text = decode(bytes);
    // MeshLab writes a document type line.
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| {
        let line = e.pos().row as usize;
        Error::parse(path, line, format!("not a good MeshLab picked-points file: {e}"))
    })?;
    if !document.root_element().has_tag_name("PickedPoints") {
        let message = "not a MeshLab picked-points file: it has no <PickedPoints>";
        return Err(Error::parse(path, None, message));
    }
    let points = document.descendants().filter(|node| node.has_tag_name("point"));
    points
        .filter(|point| !matches!(point.attribute("active"), Some("0" | "false")))
        .map(|point| {
            let line = document.text_pos_at(point.range().start).row as usize;
            let mut cells = ["x", "y", "z"].into_iter().map_while(|axis| point.attribute(axis));
            let label = point.attribute("name").filter(|name| !name.is_empty());
            Ok(Marker {
                label: label.map(str::to_owned),
                ..Marker::at(Place { path, line }.position(&mut cells)?)
            })
        })
        .collect()
}

/// Writes all markers as active points; nameless ones are named by their number.
pub fn write_picked_points(path: &Path, markers: &[Marker]) -> Result<()> {
    write_beside(path, |out| {
        writeln!(out, "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData/>")?;
        for (m, marker) in markers.iter().enumerate() {
            let name = marker.label.as_deref().map_or_else(|| m.to_string(), escaped);
            let p = marker.position;
            writeln!(
                out,
                r#" <point x="{:?}" y="{:?}" z="{:?}" active="1" name="{name}"/>"#,
                p.x, p.y, p.z
            )?;
        }
        writeln!(out, "</PickedPoints>")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    const FILE: &str = "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData>\n  \
        <DateTime time=\"10:00:00\" date=\"2020-01-01\"/>\n </DocumentData>\n \
        <point x=\"1\" y=\"2\" z=\"3\" active=\"1\" name=\"tip\"/>\n \
        <point x=\"4\" y=\"5\" z=\"6\" active=\"0\" name=\"1\"/>\n</PickedPoints>\n";

    fn parse(text: &str) -> Result<Vec<Marker>> {
        parse_picked_points(text.as_bytes(), Path::new("a.pp"))
    }

    #[test]
    fn inactive_points_are_left_out() {
        let markers = parse(FILE).unwrap();
        assert_eq!(markers.len(), 1);
        assert_eq!(markers[0].label.as_deref(), Some("tip"));
        assert_eq!(markers[0].position, Vec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn errors_name_the_line() {
        for (from, to, expected) in [
            ("y=\"2\"", "y=\"two\"", "line 6: y is 'two', not a number"),
            ("y=\"2\"", "", "line 6: the line ends before y"),
            ("</PickedPoints>", "", "not a good MeshLab picked-points file"),
            ("PickedPoints>", "Points>", "it has no <PickedPoints>"),
        ] {
            let message = parse(&FILE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
