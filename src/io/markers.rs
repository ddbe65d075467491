//! Marker files: points on the person's surface, in any of the supported formats.

use std::path::Path;

use super::ascii_points::parse_xyz;
use super::csv_points::{parse_csv_markers, write_csv_markers};
use super::fcsv::{parse_fcsv, write_fcsv};
use super::marker::Marker;
use super::markups::{parse_markups, write_markups};
use super::picked_points::{parse_picked_points, write_picked_points};
use super::ply::PlyDocument;
use super::read_bytes;
use crate::error::{Error, Result, Shown};
use crate::math::Vec3;

/// Reads markers from `.csv`, `.txt`/`.xyz`/`.pts`, `.ply`, `.mrk.json`/`.json`, `.fcsv` or `.pp`.
/// A file without any marker is an error.
pub fn read_markers(path: &Path) -> Result<Vec<Marker>> {
    extension(path)?;
    parse_markers(&read_bytes(path)?, path)
}

/// Reads markers from bytes; the extension of `path` tells the format.
pub fn parse_markers(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    let markers = match extension(path)? {
        "csv" | "tsv" => parse_csv_markers(bytes, path)?,
        "ply" => ply_markers(&PlyDocument::parse(bytes, path)?),
        "json" => parse_markups(bytes, path)?,
        "fcsv" => parse_fcsv(bytes, path)?,
        "pp" => parse_picked_points(bytes, path)?,
        _ => parse_xyz(bytes, path)?,
    };
    if markers.is_empty() {
        return Err(Error::parse(path, None, "the file holds no markers"));
    }
    Ok(markers)
}

/// Writes markers as `.csv`, `.mrk.json`, `.fcsv` or `.pp`, in the frame they are in (Slicer files
/// say RAS).
pub fn write_markers(path: &Path, markers: &[Marker]) -> Result<()> {
    match extension(path)? {
        "csv" => write_csv_markers(path, markers),
        "json" => write_markups(path, markers),
        "fcsv" => write_fcsv(path, markers),
        "pp" => write_picked_points(path, markers),
        other => Err(Error::Unsupported(format!(
            "markers are written as .csv, .mrk.json, .fcsv or .pp, not as .{other}"
        ))),
    }
}

fn ply_markers(document: &PlyDocument) -> Vec<Marker> {
    let weights = document.vertex_scalars("weight");
    let marker = |(v, &position): (usize, &Vec3)| Marker {
        weight: weights.as_ref().map(|w| w[v]).filter(|w| w.is_finite() && *w >= 0.0),
        ..Marker::at(position)
    };
    document.points().iter().enumerate().map(marker).collect()
}

const EXTENSIONS: [&str; 9] = ["csv", "tsv", "txt", "xyz", "pts", "ply", "json", "fcsv", "pp"];

fn extension(path: &Path) -> Result<&'static str> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    EXTENSIONS.into_iter().find(|known| extension.as_deref() == Some(known)).ok_or_else(|| {
        Error::Unsupported(format!(
            "{} is not a marker file: .csv, .txt, .xyz, .ply, .mrk.json, .fcsv and .pp are",
            path.shown()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_the_same() {
        let markers: Vec<Marker> = (0..5)
            .map(|i| Marker {
                label: Some(format!("point, \"{i}\" <&>")),
                ..Marker::at(Vec3::new(0.1, -1.0 / 3.0, 1e-7) * f64::from(i))
            })
            .collect();
        for name in ["a.csv", "a.mrk.json", "a.pp", "a.fcsv"] {
            let name = format!("moulage_{}_{name}", std::process::id());
            let path = std::env::temp_dir().join(name);
            write_markers(&path, &markers).unwrap();
            let again = read_markers(&path).unwrap();
            std::fs::remove_file(&path).unwrap();
            assert_eq!(again, markers, "{}", path.shown());
        }
    }

    #[test]
    fn ply_points_and_their_weights_are_markers() {
        let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                   property float z\nproperty float weight\nend_header\n1 2 3 0.5\n4 5 6 -1\n";
        let markers = parse_markers(ply.as_bytes(), Path::new("a.ply")).unwrap();
        assert_eq!(markers[0].weight, Some(0.5));
        assert_eq!(markers[1], Marker::at(Vec3::new(4.0, 5.0, 6.0)));
    }

    #[test]
    fn unknown_and_empty_files_are_refused() {
        let error = parse_markers(b"", Path::new("a.doc")).unwrap_err().to_string();
        assert!(error.starts_with("a.doc is not a marker file"), "{error}");
        let error = parse_markers(b"x,y,z\n", Path::new("a.csv")).unwrap_err().to_string();
        assert_eq!(error, "a.csv: the file holds no markers");
    }
}
