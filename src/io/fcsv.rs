//! 3D Slicer's older fiducial files, `.fcsv`.

use std::path::Path;

use super::marker::Marker;
use super::markups::ras_from;
use super::text::{Place, decode};
use super::write_beside;
use crate::error::{Error, Result};

/// Columns of a file that does not name them.
const COLUMNS: &str = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// Reads fiducials in RAS. The header line `# CoordinateSystem = LPS` (or RAS, or 1 for LPS and 0
/// for RAS in older files) must be there.
pub fn parse_fcsv(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    let text = decode(bytes);
    let to_ras = ras_from(header(&text, "coordinatesystem"))
        .map_err(|what| Error::parse(path, None, format!("'# CoordinateSystem = ...': {what}")))?;
    let columns = header(&text, "columns").unwrap_or(COLUMNS);
    let columns: Vec<&str> = columns.split(',').map(str::trim).collect();
    let column = |name: &str| columns.iter().position(|c| *c == name);
    let (Some(x), Some(y), Some(z)) = (column("x"), column("y"), column("z")) else {
        return Err(Error::parse(path, None, "'# columns = ...' does not name x, y and z"));
    };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut markers = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| {
            Error::parse(path, e.position().map(|p| p.line() as usize), e.to_string())
        })?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        let mut cells = [x, y, z].into_iter().map_while(|c| record.get(c));
        let position = Place { path, line }.position(&mut cells)?;
        let label = column("label").and_then(|c| record.get(c)).filter(|l| !l.is_empty());
        markers.push(Marker {
            label: label.map(str::to_owned),
            ..Marker::at(position.component_mul(&to_ras))
        });
    }
    Ok(markers)
}

/// The value of a header line `# name = value`; `name` in lower case.
fn header<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.lines()
        .filter_map(|line| line.trim().strip_prefix('#')?.split_once('='))
        .find_map(|(own, value)| (own.trim().to_lowercase() == name).then_some(value.trim()))
}

/// Writes fiducials in RAS.
pub fn write_fcsv(path: &Path, markers: &[Marker]) -> Result<()> {
    write_beside(path, |out| {
        writeln!(out, "# Markups fiducial file version = 4.11")?;
        writeln!(out, "# CoordinateSystem = RAS")?;
        writeln!(out, "# columns = {COLUMNS}")?;
        let mut writer = csv::Writer::from_writer(out);
        for (m, marker) in markers.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| format!("{:?}", marker.position[axis]));
            let id = (m + 1).to_string();
            let label = marker.label.as_deref().unwrap_or_default();
            writer.write_record([
                &id, &x, &y, &z, "0", "0", "0", "1", "1", "1", "0", label, "", "",
            ])?;
        }
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    const FILE: &str = "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n\
        # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n\
        vtkMRMLMarkupsFiducialNode_0,1,2,3,0,0,0,1,1,1,0,tip,,,2,0\n\
        1,4,5,6,0,0,0,1,1,1,0,\"a, b\",,\n";

    fn parse(text: &str) -> Result<Vec<Marker>> {
        parse_fcsv(text.as_bytes(), Path::new("a.fcsv"))
    }

    #[test]
    fn every_form_of_the_frame_is_understood() {
        for (frame, sign) in [("LPS", -1.0), ("1", -1.0), ("RAS", 1.0), ("0", 1.0)] {
            let markers = parse(&FILE.replace("LPS", frame)).unwrap();
            assert_eq!(markers[0].position, Vec3::new(sign, 2.0 * sign, 3.0));
            assert_eq!(markers[1].label.as_deref(), Some("a, b"));
        }
    }

    #[test]
    fn errors_name_the_line() {
        for (from, to, expected) in [
            ("# CoordinateSystem = LPS\n", "", "no coordinate system is given"),
            ("LPS", "2", "the coordinate system is '2'"),
            ("1,4,5,6", "1,4,5,six", "line 5: z is 'six', not a number"),
            ("1,4,5,6,0,0,0,1,1,1,0,\"a, b\",,\n", "1,4\n", "line 5: the line ends before y"),
            ("id,x,y", "id,u,v", "does not name x, y and z"),
        ] {
            let message = parse(&FILE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
