//! A result on slices of the person's image: what it meets and what it misses.

use std::path::PathBuf;

use super::picture::{Overlay, Rgb, slice_picture};
use crate::error::{Error, Result};
use crate::io::{read_surface, read_volume, write_beside};
use crate::math::Vec3;
use crate::measure::LabelFit;
use crate::mesh::{TriMesh, bounding_box, plane_section};
use crate::volume::{SlicePlane, View, Volume, Window, outlines};

/// The template, the result, the label, markers.
const TEMPLATE: Rgb = [255, 160, 40];
const RESULT: Rgb = [80, 230, 80];
const LABEL: Rgb = [70, 200, 255];
const MARKER: Rgb = [255, 70, 70];
/// Slices of each view lie at these shares of the result's extent.
const SHARES: [f64; 3] = [0.3, 0.5, 0.7];
/// Free share of the extent around the result.
const MARGIN: f64 = 0.15;
/// Pixels on the longer side.
const PIXELS: f64 = 420.0;

/// A picture of one slice.
#[derive(Clone, Debug)]
pub struct SliceFigure {
    /// Where it is, in words.
    pub caption: String,
    /// Part of a file name.
    pub name: String,
    /// A PNG file.
    pub png: Vec<u8>,
}

/// The person's image, and perhaps a label map with the organ's label.
#[derive(Clone, Debug, Default)]
pub struct Person {
    /// The image.
    pub volume: Option<Volume>,
    /// The label map and the label.
    pub labels: Option<(Volume, u32)>,
}

impl Person {
    /// Reads the files that are named; without a label, the map's only one is taken.
    pub fn read(
        volume: Option<&PathBuf>,
        labels: Option<&PathBuf>,
        label: Option<u32>,
    ) -> Result<Self> {
        let volume = volume.map(|path| read_volume(path)).transpose()?.map(|file| file.volume);
        let Some(path) = labels else { return Ok(Self { volume, labels: None }) };
        let map = read_volume(path)?.volume;
        let label = match label {
            Some(label) => label,
            None => map.only_label().map_err(|e| Error::parse(path, None, e.to_string()))?,
        };
        Ok(Self { volume, labels: Some((map, label)) })
    }

    /// How well a surface meets the label, where there is one.
    pub fn fit(&self, mesh: &TriMesh) -> Result<Option<LabelFit>> {
        self.labels.as_ref().map(|(map, label)| LabelFit::new(mesh, map, *label)).transpose()
    }

    /// Slices through `result`, with the template's cut, the label's outline and markers near by. The
    /// label map serves as the image where there is no other.
    pub fn figures(
        &self,
        result: &TriMesh,
        template: Option<&TriMesh>,
        markers: &[Vec3],
    ) -> Result<Vec<SliceFigure>> {
        let image = self.volume.as_ref().or(self.labels.as_ref().map(|(map, _)| map));
        let (Some(image), Some((low, high))) = (image, bounding_box(&result.points)) else {
            return Ok(Vec::new());
        };
        let window = Window::fitting(image);
        let extent = high - low;
        let around = [low - extent * MARGIN, high + extent * MARGIN];
        let pixel = (around[1] - around[0]).max() / PIXELS;
        let corners: Vec<Vec3> =
            (0..8).map(|c| Vec3::from_fn(|axis, _| around[c >> axis & 1][axis])).collect();
        let mut figures = Vec::new();
        let views =
            [("axial", View::Axial), ("coronal", View::Coronal), ("sagittal", View::Sagittal)];
        for (name, view) in views {
            let (axis, reach) = (view.axis(), SlicePlane::reach(image, view));
            for share in SHARES {
                let position = (low + extent * share).dot(&axis);
                if position < reach[0] || position > reach[1] {
                    continue;
                }
                let plane = SlicePlane::covering(&corners, view, position, pixel)?;
                let overlay = self.overlay(&plane, result, template, markers, view)?;
                figures.push(SliceFigure {
                    caption: format!(
                        "{name}, {} = {position:.1} mm",
                        ["x", "y", "z"][axis.iamax()]
                    ),
                    name: format!("{name}_{position:.0}"),
                    png: slice_picture(image, &plane, &window, &overlay),
                });
            }
        }
        Ok(figures)
    }

    fn overlay(
        &self,
        plane: &SlicePlane,
        result: &TriMesh,
        template: Option<&TriMesh>,
        markers: &[Vec3],
        view: View,
    ) -> Result<Overlay> {
        let mut overlay = Overlay::default();
        let mut near = plane.right.norm();
        if let Some((map, label)) = &self.labels {
            let position = plane.corner.dot(&view.axis());
            let own = SlicePlane::covering(&map.corners(), view, position, map.spacing().min())?;
            overlay.lines.extend(outlines(map, *label, &own).into_iter().map(|l| (l, LABEL)));
            near = near.max(map.spacing().min() / 2.0);
        }
        let cut = |mesh: &TriMesh| plane_section(mesh, &plane.corner, &plane.normal());
        overlay
            .lines
            .extend(template.map(cut).unwrap_or_default().into_iter().map(|l| (l, TEMPLATE)));
        overlay.lines.extend(cut(result).into_iter().map(|l| (l, RESULT)));
        let volume_near = self.volume.as_ref().map_or(0.0, |v| v.spacing().min() / 2.0);
        let near = near.max(volume_near);
        let close = markers.iter().filter(|m| plane.pixel(m).z.abs() <= near);
        overlay.dots.extend(close.map(|m| (*m, MARKER)));
        Ok(overlay)
    }
}

/// A surface beside a label map or an image.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct CompareJob {
    /// Surface, such as the result of a reshaping
    #[cfg_attr(feature = "cli", arg(value_name = "SURFACE"))]
    pub surface: PathBuf,
    /// Label map
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME"))]
    pub labels: Option<PathBuf>,
    /// The label [default: the only one]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", requires = "labels"))]
    pub label: Option<u32>,
    /// Image to draw slices of
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME"))]
    pub volume: Option<PathBuf>,
    /// The template, drawn in orange
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    pub template: Option<PathBuf>,
    /// Folder for pictures of slices: surface green, label blue
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER"))]
    pub out: Option<PathBuf>,
}

/// Compares; returns the figures and the pictures written.
pub fn run_compare(job: &CompareJob) -> Result<(Option<LabelFit>, Vec<PathBuf>)> {
    if job.labels.is_none() && job.volume.is_none() {
        return Err(Error::invalid("give a label map with --labels or an image with --volume"));
    }
    let mesh = read_surface(&job.surface)?.mesh()?;
    let template = job.template.as_ref().map(|path| read_surface(path)?.mesh()).transpose()?;
    let person = Person::read(job.volume.as_ref(), job.labels.as_ref(), job.label)?;
    let fit = person.fit(&mesh)?;
    let mut written = Vec::new();
    if let Some(folder) = &job.out {
        for figure in person.figures(&mesh, template.as_ref(), &[])? {
            let path = folder.join(format!("{}.png", figure.name));
            write_beside(&path, |out| out.write_all(&figure.png))?;
            written.push(path);
        }
    }
    Ok((fit, written))
}
