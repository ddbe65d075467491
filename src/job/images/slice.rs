//! `moulage slice` and `moulage markers`: pictures of slices, markers from labels.

use std::path::PathBuf;

use super::picture::{Overlay, Rgb, slice_picture};
use crate::error::{Error, Result};
use crate::io::{
    self, Marker, read_markers, read_surface, read_volume, write_beside, write_markers,
};
use crate::math::Vec3;
use crate::mesh::plane_section;
use crate::volume::{Clicks, SlicePlane, View, Window, label_markers, outlines};

/// Colours of the lines of meshes, one after the other.
const MESHES: [Rgb; 5] =
    [[90, 220, 90], [255, 150, 40], [90, 170, 255], [240, 110, 220], [240, 230, 80]];
const LABEL: Rgb = [70, 200, 255];
const MARKERS: Rgb = [255, 70, 70];
/// Pixels on the longer side of a picture.
const PICTURE: f64 = 800.0;
/// Markers are shown on slices at most so far away, mm, unless the image's own slices are thicker.
const NEAR: f64 = 1.5;

/// A picture of one slice.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SliceJob {
    /// Image: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, or a folder of DICOM slices
    #[cfg_attr(feature = "cli", arg(value_name = "VOLUME"))]
    pub volume: PathBuf,
    /// axial, coronal, sagittal, or a direction to look along such as 0,1,1 [default: axial]
    #[cfg_attr(feature = "cli", arg(long, value_name = "PLANE", allow_hyphen_values = true))]
    pub plane: Option<View>,
    /// Where, in mm along the plane's axis (z, y, x, or the direction) [default: the middle]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", allow_negative_numbers = true))]
    pub at: Option<f64>,
    /// Width and level of the values shown [default: 400,40 for CT, else what the values need]
    #[cfg_attr(feature = "cli", arg(long, value_name = "W,L", allow_hyphen_values = true))]
    pub window: Option<Window>,
    /// Surfaces whose cut is drawn: green, orange, blue, ...
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub mesh: Vec<PathBuf>,
    /// Markers to draw where they lie near the slice (red)
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub markers: Vec<PathBuf>,
    /// Label map whose outline is drawn (light blue), with --label
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", requires = "label"))]
    pub labels: Option<PathBuf>,
    /// The label to outline
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", requires = "labels"))]
    pub label: Option<u32>,
    /// Millimetres per pixel [default: 800 pixels on the longer side]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM"))]
    pub pixel: Option<f64>,
    /// The picture
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FILE.png"))]
    pub out: PathBuf,
}

/// Draws the slice; returns a sentence about it and the reader's notes.
pub fn run_slice(job: &SliceJob) -> Result<Vec<String>> {
    let file = read_volume(&job.volume)?;
    let volume = &file.volume;
    let view = job.plane.unwrap_or(View::Axial);
    let [low, high] = SlicePlane::reach(volume, view);
    let at = job.at.unwrap_or(f64::midpoint(low, high));
    let coarse = SlicePlane::of(volume, view, at, None)?;
    let millimetres = coarse.right.norm() * coarse.width.max(coarse.height) as f64;
    let plane = SlicePlane::of(volume, view, at, Some(job.pixel.unwrap_or(millimetres / PICTURE)))?;
    let mut overlay = Overlay::default();
    if let (Some(path), Some(label)) = (&job.labels, job.label) {
        let labels = read_volume(path)?.volume;
        let own = SlicePlane::covering(&volume.corners(), view, at, labels.spacing().min())?;
        overlay.lines.extend(outlines(&labels, label, &own).into_iter().map(|l| (l, LABEL)));
    }
    for (path, colour) in job.mesh.iter().zip(MESHES.into_iter().cycle()) {
        let lines = plane_section(&read_surface(path)?.mesh()?, &plane.corner, &plane.normal());
        overlay.lines.extend(lines.into_iter().map(|line| (line, colour)));
    }
    let near = NEAR.max(volume.spacing().min() / 2.0);
    for path in &job.markers {
        let on_slice = |p: &Vec3| plane.pixel(p).z.abs() <= near;
        let points = read_markers(path)?.into_iter().map(|m| m.position);
        overlay.dots.extend(points.filter(on_slice).map(|p| (p, MARKERS)));
    }
    let window = job.window.unwrap_or_else(|| Window::fitting(volume));
    let picture = slice_picture(volume, &plane, &window, &overlay);
    write_beside(&job.out, |out| out.write_all(&picture))?;
    let mut said = file.notes;
    said.push(format!(
        "slice at {at:.2} mm, {} x {} pixels of {:.3} mm, window {:.0},{:.0}; it can be cut from {low:.1} to {high:.1}",
        plane.width,
        plane.height,
        plane.right.norm(),
        window.width,
        window.level
    ));
    Ok(said)
}

/// Markers from one label.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct MarkersJob {
    /// Label map: .nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd
    #[cfg_attr(feature = "cli", arg(value_name = "LABELS"))]
    pub labels: Option<PathBuf>,
    /// The label map, as a flag
    #[cfg_attr(
        feature = "cli",
        arg(long = "labels", value_name = "LABELS", conflicts_with = "labels")
    )]
    pub labels_flag: Option<PathBuf>,
    /// Which label [default: the only one]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    pub label: Option<u32>,
    /// Slices to mark on: axial, coronal, sagittal, or directions [default: axial]
    #[cfg_attr(feature = "cli", arg(long, value_name = "PLANE", num_args = 1..))]
    pub plane: Vec<View>,
    /// Millimetres between slices [default: 9]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM"))]
    pub every: Option<f64>,
    /// Millimetres between markers along an outline [default: 8]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM"))]
    pub spacing: Option<f64>,
    /// A hand's error: its standard deviation in mm [default: 0]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM"))]
    pub jitter: Option<f64>,
    /// Another number gives other errors [default: 1]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    pub seed: Option<u64>,
    /// Markers, RAS mm: .csv, .mrk.json, .fcsv or .pp
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FILE"))]
    pub out: PathBuf,
}

/// Marks the label's outlines and writes the markers; returns how many.
pub fn run_markers(job: &MarkersJob) -> Result<usize> {
    let path = job.labels.as_ref().or(job.labels_flag.as_ref());
    let path = path.ok_or_else(|| Error::invalid("no label map is given"))?;
    io::check_writable(&job.out)?;
    let labels = read_volume(path)?.volume;
    let views = if job.plane.is_empty() { vec![View::Axial] } else { job.plane.clone() };
    let usual = Clicks::default();
    let clicks = Clicks {
        every: job.every.unwrap_or(usual.every),
        spacing: job.spacing.unwrap_or(usual.spacing),
        jitter: job.jitter.unwrap_or(usual.jitter),
        seed: job.seed.unwrap_or(usual.seed),
    };
    let label = job.label.map_or_else(|| labels.only_label(), Ok);
    let points = label
        .and_then(|label| label_markers(&labels, label, &views, &clicks))
        .map_err(|e| Error::parse(path, None, e.to_string()))?;
    let markers: Vec<Marker> = points.into_iter().map(Marker::at).collect();
    write_markers(&job.out, &markers)?;
    Ok(markers.len())
}
