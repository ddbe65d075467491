//! Markers in CSV files.

use std::path::Path;

use super::marker::Marker;
use super::table::Table;
use super::write_beside;
use crate::error::Result;

/// Reads columns `x_mm,y_mm,z_mm`, `x,y,z` or `target_x,target_y,target_z`, and where they are
/// there `label` (else `id`), `weight` and `sigma`. Lines beginning with `#` are left out; positions
/// are taken as they are.
pub fn parse_csv_markers(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    let table = Table::parse(bytes, path)?;
    let position =
        table.point_columns(&["", "target_"]).ok_or_else(|| table.missing("x, y and z"))?;
    let label = table.column(&["label", "name", "id"]);
    let (weight, sigma) = (table.column(&["weight"]), table.column(&["sigma"]));
    table
        .rows()
        .map(|row| {
            let noise = row.size(sigma)?;
            if noise == Some(0.0) {
                return Err(row.place().error("sigma is 0; it must be above 0, or be left empty"));
            }
            Ok(Marker {
                label: row.label(label),
                position: row.point(position)?,
                weight: row.size(weight)?,
                sigma: noise,
            })
        })
        .collect()
}

/// Writes columns `label,x,y,z,weight,sigma`; what a marker does not have stays empty.
pub fn write_csv_markers(path: &Path, markers: &[Marker]) -> Result<()> {
    write_beside(path, |out| {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(["label", "x", "y", "z", "weight", "sigma"])?;
        for marker in markers {
            let [x, y, z] = [0, 1, 2].map(|axis| format!("{:?}", marker.position[axis]));
            let optional = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
            let label = marker.label.clone().unwrap_or_default();
            let cells = [label, x, y, z, optional(marker.weight), optional(marker.sigma)];
            writer.write_record(cells)?;
        }
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn parse(text: &str) -> Result<Vec<Marker>> {
        parse_csv_markers(text.as_bytes(), Path::new("a.csv"))
    }

    #[test]
    fn columns_are_found_by_name_in_any_order() {
        let markers = parse(
            "\u{feff}# clicked on a CT\r\nid, Z_mm ,x_mm,y_mm,slice,weight\r\n7,3,1,2,0,0.5\r\n\r\n8,6,4,5,0,\r\n",
        )
        .unwrap();
        assert_eq!(markers[0].label.as_deref(), Some("7"));
        assert_eq!(markers[0].position, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!((markers[0].weight, markers[1].weight), (Some(0.5), None));
        assert_eq!(parse("1;2;3\n4;5;6").unwrap().len(), 2);
        assert_eq!(parse("x,y,z,how\n1,2,3,by eye, twice\n").unwrap().len(), 1);
    }

    #[test]
    fn errors_name_line_and_column() {
        for (text, expected) in [
            ("", "a.csv: the file is empty"),
            ("a,b\n1,2\n", "line 1: columns x, y and z are needed, but the file has a, b"),
            ("x,y,z\n1,2,3\n1,inf,3\n", "line 3: y is inf, not a finite number"),
            ("x,y,z\n1,2\n", "line 2: the line has 2 columns, the line with the names 3"),
            ("x,y,z\n1,5,2,3\n", "line 2: the line has 4 columns"),
            ("x,y,z\n1,,3\n", "line 2: y is empty"),
            ("x,y,z,weight\n1,2,3,-1\n", "line 2: weight is -1; it must not be negative"),
            ("x,y,z,sigma\n1,2,3,0\n", "line 2: sigma is 0; it must be above 0, or be left empty"),
            ("1,2,3,4\n", "must name the columns"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
