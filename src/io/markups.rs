//! 3D Slicer markups, `.mrk.json`.

use std::path::Path;

use serde::Deserialize;
use serde_json::{Value, json};

use super::marker::Marker;
use super::write_beside;
use crate::error::{Error, Result};
use crate::math::Vec3;

#[derive(Deserialize)]
struct File {
    markups: Vec<Markup>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Markup {
    coordinate_system: Option<String>,
    coordinate_units: Option<Value>,
    #[serde(default)]
    control_points: Vec<ControlPoint>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ControlPoint {
    label: Option<String>,
    position: Option<Value>,
    position_status: Option<String>,
}

/// Reads the control points of all markups, in RAS: markups whose `coordinateSystem` is LPS are
/// turned around. Points that were not placed yet (`positionStatus` other than "defined") are left
/// out. A missing frame, or another length unit than mm, is an error.
pub fn parse_markups(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    let wrong = |message: String| Error::parse(path, None, message);
    let file: File = serde_json::from_slice(bytes).map_err(|e| {
        Error::parse(path, e.line(), format!("not a good Slicer markups file: {e}"))
    })?;
    let mut markers = Vec::new();
    for (m, markup) in file.markups.iter().enumerate() {
        let to_ras = ras_from(markup.coordinate_system.as_deref())
            .map_err(|what| wrong(format!("markup {m}: {what}")))?;
        check_units(markup.coordinate_units.as_ref())
            .map_err(|what| wrong(format!("markup {m}: {what}")))?;
        for (p, point) in markup.control_points.iter().enumerate() {
            if point.position_status.as_deref().is_some_and(|status| status != "defined") {
                continue;
            }
            let position = point.position.as_ref().and_then(position).ok_or_else(|| {
                wrong(format!("markup {m}, control point {p}: 'position' is not three numbers"))
            })?;
            let label = point.label.clone().filter(|label| !label.is_empty());
            let position = position.component_mul(&to_ras);
            markers.push(Marker { label, ..Marker::at(position) });
        }
    }
    Ok(markers)
}

/// The factors per axis that lead to RAS.
pub(super) fn ras_from(frame: Option<&str>) -> Result<Vec3, String> {
    match frame.map(str::trim) {
        Some("RAS" | "0") => Ok(Vec3::new(1.0, 1.0, 1.0)),
        Some("LPS" | "1") => Ok(Vec3::new(-1.0, -1.0, 1.0)),
        Some(other) => Err(format!("the coordinate system is '{other}'; RAS or LPS is needed")),
        None => Err("no coordinate system is given; add RAS or LPS to the file".to_owned()),
    }
}

/// `coordinateUnits` is a name, or in newer files a code with a name. Old files have none: mm.
fn check_units(units: Option<&Value>) -> Result<(), String> {
    match units {
        None | Some(Value::Null) => Ok(()),
        Some(units) if units.as_str() == Some("mm") || units.as_str() == Some("") => Ok(()),
        Some(Value::Array(list)) if list.iter().any(|unit| unit == "mm") => Ok(()),
        Some(other) => Err(format!("the length unit is {other}; save the file in mm")),
    }
}

fn position(value: &Value) -> Option<Vec3> {
    let list = value.as_array().filter(|list| list.len() == 3)?;
    let numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
    (numbers.len() == 3).then(|| Vec3::new(numbers[0], numbers[1], numbers[2]))
}

/// Writes one fiducial markup in RAS, mm.
pub fn write_markups(path: &Path, markers: &[Marker]) -> Result<()> {
    let points: Vec<Value> = markers
        .iter()
        .enumerate()
        .map(|(m, marker)| {
            json!({
                "id": (m + 1).to_string(),
                "label": marker.label.clone().unwrap_or_default(),
                "position": [marker.position.x, marker.position.y, marker.position.z],
                "selected": true,
                "locked": false,
                "visibility": true,
                "positionStatus": "defined"
            })
        })
        .collect();
    let file = json!({
        "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/\
                    Markups/Resources/Schema/markups-schema-v1.0.3.json#",
        "markups": [{
            "type": "Fiducial",
            "coordinateSystem": "RAS",
            "coordinateUnits": "mm",
            "controlPoints": points
        }]
    });
    write_beside(path, |out| Ok(serde_json::to_writer_pretty(out, &file)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"markups": [
        {"coordinateSystem": "LPS", "coordinateUnits": "mm", "controlPoints": [
            {"label": "a", "position": [1, 2, 3], "positionStatus": "defined"},
            {"label": "b", "position": [0, 0, 0], "positionStatus": "undefined"}]},
        {"coordinateSystem": "RAS", "controlPoints": [{"label": "", "position": [1, 2, 3]}]}]}"#;

    fn parse(text: &str) -> Result<Vec<Marker>> {
        parse_markups(text.as_bytes(), Path::new("a.mrk.json"))
    }

    #[test]
    fn each_markup_is_turned_into_ras_by_its_own_frame() {
        let markers = parse(FILE).unwrap();
        assert_eq!(markers.len(), 2);
        assert_eq!(markers[0].position, Vec3::new(-1.0, -2.0, 3.0));
        assert_eq!(markers[0].label.as_deref(), Some("a"));
        assert_eq!(markers[1], Marker::at(Vec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn frames_units_and_positions_are_never_guessed() {
        for (from, to, expected) in [
            (r#""coordinateSystem": "LPS", "#, "", "markup 0: no coordinate system is given"),
            ("LPS", "IJK", "the coordinate system is 'IJK'"),
            (r#""mm""#, r#""m""#, "the length unit is \"m\"; save the file in mm"),
            ("[1, 2, 3], \"positionS", "[1, 2], \"positionS", "control point 0: 'position' is not"),
            ("[1, 2, 3], \"positionS", "[1, 2, \"x\"], \"positionS", "'position' is not three"),
            ("]}]}", "", "not a good Slicer markups file"),
        ] {
            let message = parse(&FILE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
