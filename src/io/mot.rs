//! OpenSim motion tables (`.mot`, `.sto`): joint angles over time.

use std::path::Path;

use super::text::Place;
use super::{read_bytes, write_beside};
use crate::error::{Error, Result};

/// Rows at most that are taken from a file.
const MAX_ROWS: usize = 10_000_000;

/// A table of named columns over time. Angles are in radians; columns whose names end in `_tx`,
/// `_ty` or `_tz` are lengths as in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionTable {
    /// Column names without `time`.
    pub names: Vec<String>,
    /// Seconds.
    pub times: Vec<f64>,
    /// One row per time, in the order of the names.
    pub rows: Vec<Vec<f64>>,
}

/// Whether a column is a length, by its name.
fn is_length(name: &str) -> bool {
    ["_tx", "_ty", "_tz"].iter().any(|end| name.ends_with(end))
}

/// Reads a motion file.
pub fn read_motion(path: &Path) -> Result<MotionTable> {
    parse_motion(&read_bytes(path)?, path)
}

/// Reads a motion from bytes; `path` is for error messages.
pub fn parse_motion(bytes: &[u8], path: &Path) -> Result<MotionTable> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().enumerate().map(|(k, l)| (k + 1, l.trim()));
    let mut in_degrees = None;
    let ended = lines.by_ref().any(|(_, line)| {
        if let Some((key, value)) = line.split_once('=')
            && key.trim().eq_ignore_ascii_case("indegrees")
        {
            in_degrees = Some(value.trim().eq_ignore_ascii_case("yes"));
        }
        line.eq_ignore_ascii_case("endheader")
    });
    if !ended {
        return Err(Error::parse(
            path,
            None,
            "no line \"endheader\"; this is not an OpenSim motion file",
        ));
    }
    let in_degrees = in_degrees.ok_or_else(|| {
        Error::parse(path, None, "the header must say inDegrees=yes or inDegrees=no")
    })?;
    let header = lines.by_ref().find(|(_, line)| !line.is_empty());
    let (line, labels) =
        header.ok_or_else(|| Error::parse(path, None, "no line with column names"))?;
    let mut labels = labels.split_whitespace();
    if !labels.next().is_some_and(|l| l.eq_ignore_ascii_case("time")) {
        return Err(Error::parse(path, line, "the first column must be \"time\""));
    }
    let names: Vec<String> = labels.map(String::from).collect();
    let mut table = MotionTable { names, ..MotionTable::default() };
    for (line, row) in lines.filter(|(_, row)| !row.is_empty()).take(MAX_ROWS) {
        let (time, row) = parse_row(row, &table.names, in_degrees, Place { path, line })?;
        table.times.push(time);
        table.rows.push(row);
    }
    Ok(table)
}

fn parse_row(
    row: &str,
    names: &[String],
    in_degrees: bool,
    place: Place,
) -> Result<(f64, Vec<f64>)> {
    let values: Vec<f64> =
        row.split_whitespace().map(|word| place.number(word, "a value")).collect::<Result<_>>()?;
    let columns = names.len() + 1;
    if values.len() != columns {
        return Err(place.error(format!("{} numbers in a row of {columns} columns", values.len())));
    }
    let angles = values[1..].iter().zip(names).map(|(&value, name)| {
        if in_degrees && !is_length(name) { value.to_radians() } else { value }
    });
    Ok((values[0], angles.collect()))
}

/// Writes a motion file, angles in degrees.
pub fn write_motion(path: &Path, table: &MotionTable) -> Result<()> {
    write_beside(path, |out| {
        writeln!(out, "motion\nversion=1\nnRows={}", table.rows.len())?;
        writeln!(out, "nColumns={}\ninDegrees=yes\nendheader", table.names.len() + 1)?;
        writeln!(out, "time\t{}", table.names.join("\t"))?;
        for (time, row) in table.times.iter().zip(&table.rows) {
            write!(out, "{time:?}")?;
            for (value, name) in row.iter().zip(&table.names) {
                let value = if is_length(name) { *value } else { value.to_degrees() };
                write!(out, "\t{value:?}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALK: &str = "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\nendheader\ntime\thip\tpelvis_tx\n 0.5\t 90\t 1.5\n0.6 -45 1.6\n";

    #[test]
    fn a_motion_survives_the_way_there_and_back() {
        let table = parse_motion(WALK.as_bytes(), Path::new("a.mot")).unwrap();
        assert_eq!(table.names, ["hip", "pelvis_tx"]);
        assert!((table.rows[0][0] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((table.rows[1][1] - 1.6).abs() < 1e-12);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.mot");
        write_motion(&path, &table).unwrap();
        let again = read_motion(&path).unwrap();
        assert!((again.rows[1][0] - table.rows[1][0]).abs() < 1e-12);
        assert_eq!(again.times, table.times);
    }

    #[test]
    fn mistakes_name_their_line() {
        let message =
            |text: &str| parse_motion(text.as_bytes(), Path::new("a.mot")).unwrap_err().to_string();
        assert!(message("time a\n0 1").contains("endheader"));
        assert!(message(&WALK.replace("inDegrees=yes", "")).contains("inDegrees"));
        assert!(message(&WALK.replace("-45 1.6", "-45")).contains("line 10"));
        assert!(message(&WALK.replace("-45", "x")).contains("'x'"));
        assert!(message(&WALK.replace("-45", "nan")).contains("finite"));
    }
}
