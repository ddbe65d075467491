//! DICOM series: a folder of files, one slice each. The crates `dicom-object` and
//! `dicom-pixeldata` read each file; here the slices are put in order and in place.

use std::path::{Path, PathBuf};

use dicom_object::file::ReadPreamble;
use dicom_object::{DefaultDicomObject, OpenFileOptions, Tag};
use dicom_pixeldata::PixelDecoder;

use super::{dicom_lengths, read_bytes};
use crate::error::{Error, Result, Shown};
use crate::math::{Mat3, Vec3, median};
use crate::volume::{MAX_VOXELS, Volume};

const SERIES: Tag = Tag(0x0020, 0x000e);
const SERIES_DESCRIPTION: Tag = Tag(0x0008, 0x103e);
const POSITION: Tag = Tag(0x0020, 0x0032);
const ORIENTATION: Tag = Tag(0x0020, 0x0037);
const PIXEL_SPACING: Tag = Tag(0x0028, 0x0030);
const THICKNESS: Tag = Tag(0x0018, 0x0050);
const ROWS: Tag = Tag(0x0028, 0x0010);
const COLUMNS: Tag = Tag(0x0028, 0x0011);
const SAMPLES: Tag = Tag(0x0028, 0x0002);
const FRAMES: Tag = Tag(0x0028, 0x0008);
const SLOPE: Tag = Tag(0x0028, 0x1053);
const INTERCEPT: Tag = Tag(0x0028, 0x1052);
const PIXELS: Tag = Tag(0x7fe0, 0x0010);

/// Pixels on a side at most.
const MOST_PIXELS: usize = 8192;
/// Distances between slices may differ by this share of one: the rounding of scanners.
const UNEVEN: f64 = 0.02;
/// A step from slice to slice that leans by more than this (as a sine) is a tilted gantry.
const TILT: f64 = 0.002;

/// One file's slice.
struct Slice {
    path: PathBuf,
    series: String,
    description: String,
    position: Vec3,
    /// Unit vectors along a row (to the next column) and down a column, LPS.
    directions: [Vec3; 2],
    /// Millimetres from column to column and from row to row.
    spacing: [f64; 2],
    thickness: Option<f64>,
    columns: usize,
    rows: usize,
    /// Slice's values, once they are read.
    values: Vec<f32>,
}

/// Reads one series: `path` is its folder, or one of its files where the folder holds several
/// series. Returns notes for the user, such as a tilted gantry.
pub fn read_dicom(path: &Path) -> Result<(Volume, Vec<String>)> {
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut slices = Vec::new();
    let mut notes = Vec::new();
    let mut others = 0;
    for file in files(folder)? {
        // Only the head tells whether it is of the series; the pixels come later.
        match head(&file)? {
            Some(slice) => slices.push(slice),
            None => others += 1,
        }
    }
    let wanted = slices.iter().find(|s| s.path == path).map(|s| s.series.clone());
    if let Some(series) = &wanted {
        slices.retain(|s| s.series == *series);
    }
    one_series(&slices, folder)?;
    if others > 0 {
        notes.push(format!("{}: {others} files are not slices and were skipped", folder.shown()));
    }
    for slice in &mut slices {
        let bytes = read_bytes(&slice.path)?;
        *slice = parse_slice(&bytes, &slice.path)?;
    }
    let volume = stack(slices, folder, &mut notes)?;
    Ok((volume, notes))
}

/// One series from the bytes of its files, in any order.
pub fn parse_dicom(files: &[(Vec<u8>, PathBuf)], folder: &Path) -> Result<(Volume, Vec<String>)> {
    let parsed: Result<Vec<Slice>> =
        files.iter().map(|(bytes, path)| parse_slice(bytes, path)).collect();
    let slices = parsed?;
    one_series(&slices, folder)?;
    let mut notes = Vec::new();
    let volume = stack(slices, folder, &mut notes)?;
    Ok((volume, notes))
}

/// The files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// What the file says about its slice, without the pixels; none for files that are no slices.
fn head(path: &Path) -> Result<Option<Slice>> {
    let bytes = read_bytes(path)?;
    if !dicom_lengths::looks_like_dicom(&bytes) {
        return Ok(None);
    }
    let object = object(&bytes, path)?;
    if [PIXELS, ROWS, POSITION].iter().any(|tag| object.get(*tag).is_none()) {
        return Ok(None);
    }
    slice(&object, path).map(Some)
}

fn object(bytes: &[u8], path: &Path) -> Result<DefaultDicomObject> {
    let wrong = |message: String| Error::parse(path, None, message);
    dicom_lengths::check(bytes).map_err(wrong)?;
    OpenFileOptions::new()
        .read_preamble(ReadPreamble::Always)
        .from_reader(bytes)
        .map_err(|e| wrong(format!("no readable DICOM file: {}", one_line(&e))))
}

/// An error of the crates with its causes, in one line.
fn one_line(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(deeper) = cause {
        text = format!("{text}: {deeper}");
        cause = deeper.source();
    }
    let text: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    text.chars().take(200).collect()
}

fn parse_slice(bytes: &[u8], path: &Path) -> Result<Slice> {
    let wrong = |message: String| Error::parse(path, None, message);
    let object = object(bytes, path)?;
    let mut slice = slice(&object, path)?;
    dicom_lengths::check_jpeg(&object, PIXELS, slice.rows, slice.columns).map_err(wrong)?;
    let pixels = object.decode_pixel_data().map_err(|e| {
        wrong(format!(
            "the pixels cannot be read ({}); save the series uncompressed, e.g. with gdcmconv --raw",
            one_line(&e)
        ))
    })?;
    let bits = pixels.bits_allocated();
    let signed =
        u16::from(pixels.pixel_representation() == dicom_pixeldata::PixelRepresentation::Signed);
    let size = usize::from(bits / 8);
    if ![8, 16, 32].contains(&bits) {
        return Err(wrong(format!("pixels of {bits} bits are not read")));
    }
    let needed = slice.rows * slice.columns * size;
    let data = pixels.data();
    // An odd number of bytes is padded by one.
    if data.len() != needed && data.len() != needed + 1 {
        return Err(wrong(format!(
            "the file has {} bytes of pixels, but {} x {} pixels need {needed}; it is cut short or its header is wrong",
            data.len(),
            slice.columns,
            slice.rows
        )));
    }
    let number = |tag: Tag, otherwise: f64| one_number(&object, tag).unwrap_or(otherwise);
    let (slope, intercept) = (number(SLOPE, 1.0), number(INTERCEPT, 0.0));
    let stored = u32::from(pixels.bits_stored().clamp(1, bits));
    slice.values = data[..needed]
        .chunks_exact(size)
        .map(|chunk| {
            // Decoded pixels are in this machine's order, little endian first as in the standard.
            let raw = chunk.iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
            let kept = raw & ((1 << stored) - 1);
            let negative = signed == 1 && kept >> (stored - 1) & 1 == 1;
            let value = if negative { kept as f64 - (1_u64 << stored) as f64 } else { kept as f64 };
            (value * slope + intercept) as f32
        })
        .collect();
    Ok(slice)
}

fn slice(object: &DefaultDicomObject, path: &Path) -> Result<Slice> {
    let wrong = |message: String| Error::parse(path, None, message);
    let list = |tag: Tag, count: usize, name: &str| {
        let numbers =
            numbers(object, tag).filter(|n| n.len() == count && n.iter().all(|x| x.is_finite()));
        numbers.ok_or_else(|| wrong(format!("the slice has no {name} of {count} numbers")))
    };
    let count = |tag: Tag, name: &str| {
        let count = one_number(object, tag).filter(|n| *n >= 1.0 && *n <= MOST_PIXELS as f64);
        count.map(|n| n as usize).ok_or_else(|| {
            wrong(format!("the number of {name} is missing, or not from 1 to {MOST_PIXELS}"))
        })
    };
    if one_number(object, FRAMES).is_some_and(|frames| frames > 1.0) {
        return Err(wrong(
            "the file holds many frames (enhanced DICOM); convert it to one slice per file, or to NIfTI with dcm2niix"
                .to_owned(),
        ));
    }
    if one_number(object, SAMPLES).is_some_and(|samples| samples > 1.0) {
        return Err(wrong("the slice is in colour; a grey one is needed".to_owned()));
    }
    let orientation = list(ORIENTATION, 6, "ImageOrientationPatient")?;
    let across = Vec3::new(orientation[0], orientation[1], orientation[2]);
    let down = Vec3::new(orientation[3], orientation[4], orientation[5]);
    let position = list(POSITION, 3, "ImagePositionPatient")?;
    let spacing = list(PIXEL_SPACING, 2, "PixelSpacing")?;
    if spacing.iter().any(|s| *s <= 0.0) || across.cross(&down).norm() < 0.9 {
        return Err(wrong("PixelSpacing or ImageOrientationPatient make no sense".to_owned()));
    }
    let word =
        |tag: Tag| object.get(tag).and_then(|e| e.to_str().ok()).map(|t| t.trim().to_owned());
    Ok(Slice {
        path: path.to_owned(),
        series: word(SERIES).unwrap_or_default(),
        description: word(SERIES_DESCRIPTION).unwrap_or_default(),
        position: Vec3::new(position[0], position[1], position[2]),
        directions: [across, down],
        // The standard gives the distance of rows first.
        spacing: [spacing[1], spacing[0]],
        thickness: one_number(object, THICKNESS).filter(|t| *t > 0.0),
        columns: count(COLUMNS, "columns")?,
        rows: count(ROWS, "rows")?,
        values: Vec::new(),
    })
}

fn numbers(object: &DefaultDicomObject, tag: Tag) -> Option<Vec<f64>> {
    object.get(tag)?.to_multi_float64().ok()
}

fn one_number(object: &DefaultDicomObject, tag: Tag) -> Option<f64> {
    numbers(object, tag)?.first().copied().filter(|n| n.is_finite())
}

/// Fails unless all slices are of one series, with the way to choose one.
fn one_series(slices: &[Slice], folder: &Path) -> Result<()> {
    let Some(first) = slices.first() else {
        return Err(Error::parse(folder, None, "the folder holds no DICOM slice"));
    };
    let mut found: Vec<(&Slice, usize)> = Vec::new();
    for slice in slices {
        match found.iter_mut().find(|(s, _)| s.series == slice.series) {
            Some((_, count)) => *count += 1,
            None => found.push((slice, 1)),
        }
    }
    if found.len() > 1 {
        let name = |(s, count): &(&Slice, usize)| {
            let file = s.path.file_name().unwrap_or_default().to_string_lossy();
            format!("{file} ('{}', {count} slices)", s.description)
        };
        let list: Vec<String> = found.iter().take(5).map(name).collect();
        return Err(Error::parse(
            folder,
            None,
            format!(
                "the folder holds {} series; give a file of the one you want: {}",
                found.len(),
                list.join(", ")
            ),
        ));
    }
    let differs = |s: &&Slice| {
        (s.columns, s.rows) != (first.columns, first.rows)
            || (0..2).any(|k| (s.spacing[k] - first.spacing[k]).abs() > 1e-3 * first.spacing[k])
            || (0..2).any(|k| (s.directions[k] - first.directions[k]).norm() > 1e-3)
    };
    match slices.iter().find(differs) {
        Some(other) => Err(Error::parse(
            &other.path,
            None,
            format!(
                "size, spacing or orientation differ from {}; a localizer? take it out of the folder",
                first.path.shown()
            ),
        )),
        None => Ok(()),
    }
}

/// Slices in order of their position along the normal, as one volume.
fn stack(mut slices: Vec<Slice>, folder: &Path, notes: &mut Vec<String>) -> Result<Volume> {
    let wrong = |message: String| Error::parse(folder, None, message);
    let [across, down] = slices[0].directions;
    let normal = across.cross(&down).normalize();
    slices.sort_by(|a, b| a.position.dot(&normal).total_cmp(&b.position.dot(&normal)));
    let count = slices.len();
    let first = &slices[0];
    if first.rows * first.columns * count > MAX_VOXELS {
        return Err(wrong(format!("{count} slices are more than {MAX_VOXELS} voxels")));
    }
    let step = if count == 1 {
        let thickness = first
            .thickness
            .ok_or_else(|| wrong("there is only one slice, without SliceThickness".to_owned()))?;
        normal * thickness
    } else {
        (slices[count - 1].position - first.position) / (count - 1) as f64
    };
    check_steps(&slices, &normal, step.dot(&normal)).map_err(wrong)?;
    let lean = (step - normal * step.dot(&normal)).norm() / step.norm();
    if lean > TILT {
        notes.push(format!(
            "the slices are shifted against each other (tilted gantry, {:.1} degrees); this is taken into account",
            libm::asin(lean).to_degrees()
        ));
    }
    let to_ras = Vec3::new(-1.0, -1.0, 1.0);
    let columns = [across * first.spacing[0], down * first.spacing[1], step];
    let map = Mat3::from_columns(&columns.map(|c| c.component_mul(&to_ras)));
    let origin = first.position.component_mul(&to_ras);
    let size = [first.columns, first.rows, count];
    let values: Vec<f32> = slices.into_iter().flat_map(|s| s.values).collect();
    Volume::new(size, values, map, origin).map_err(|e| wrong(e.to_string()))
}

/// Even steps, no slice twice, none missing.
fn check_steps(slices: &[Slice], normal: &Vec3, mean: f64) -> Result<(), String> {
    let height = |s: &Slice| s.position.dot(normal);
    let steps: Vec<f64> = slices.windows(2).map(|s| height(&s[1]) - height(&s[0])).collect();
    let usual = median(steps.iter().copied()).unwrap_or(mean);
    let name = |s: &Slice| s.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    for (k, &step) in steps.iter().enumerate() {
        let (a, b) = (name(&slices[k]), name(&slices[k + 1]));
        if step <= UNEVEN * usual.abs() {
            return Err(format!(
                "{a} and {b} lie at the same place; the series has several images of each slice (phases, echoes): keep one"
            ));
        }
        if (step - usual).abs() > UNEVEN * usual {
            return Err(format!(
                "{a} and {b} are {step:.3} mm apart, other slices {usual:.3} mm: slices are missing or unevenly spaced"
            ));
        }
    }
    // Steps that are even but drift sideways would not be on one line.
    let sideways = (slices.len() > 1).then(|| {
        let last = slices.len() - 1;
        let step = (slices[last].position - slices[0].position) / last as f64;
        slices
            .iter()
            .enumerate()
            .map(move |(k, s)| (s.position - slices[0].position - step * k as f64).norm())
    });
    match sideways.into_iter().flatten().fold(0.0, f64::max) {
        drift if drift > (0.5 * usual.abs()).max(0.1) => Err(format!(
            "the slices' positions are up to {drift:.2} mm off a straight line; the series is not a regular grid"
        )),
        _ => Ok(()),
    }
}
