//! Where the markers cover the person, and so where the template has no business to be.
//!
//! Markers say where the surface is, not where it is not: a free part of the template may stick
//! out without any marker objecting. The reverse term pulls template points that are farther from
//! every marker than markers are from each other back to that distance. Where a scan ends inside
//! the organ, or an outline was left open, nobody knows; points beyond are left alone.

use super::rows::Rows;
use super::slices::{HalfSpace, open_sides, slices};
use super::term::{Place, Term};
use crate::fem::MaterialPoint;
use crate::locate::{NearestPoints, spread_evenly};
use crate::math::{Vec3, median};

/// Template points that are watched.
const SAMPLES: usize = 300;

/// The spacing of markers is the median distance to this neighbour.
const NEIGHBOUR: usize = 4;

/// So many of them are asked.
const SPACING_SAMPLES: usize = 1000;

/// A slice at the end of a scan whose contour is this large beside the largest was cut there; an
/// organ that ends by itself tapers off.
const CUT: f64 = 0.6;

/// Two ends of an outline farther apart than this multiple of the usual spacing are not joined.
const GAP: f64 = 2.5;

/// The markers' extent.
pub struct Coverage {
    nearest: NearestPoints,
    markers: Vec<Vec3>,
    /// By marker: the open side of its outline.
    open: Vec<Option<HalfSpace>>,
    /// Usual distance between markers.
    spacing: f64,
    /// Where the scan ends inside the organ.
    ends: Vec<HalfSpace>,
    samples: Vec<MaterialPoint>,
}

impl Coverage {
    /// Of markers that lie on parallel axis-aligned slices; `None` for others, of which nobody
    /// knows where the scan ends.
    pub fn of_slices(markers: &[Vec3], surface: &[(MaterialPoint, Vec3)]) -> Option<Self> {
        let (axis, planes) = slices(markers)?;
        let spacing = spacing(markers);
        let extents: Vec<f64> = planes.iter().map(|plane| diameter(plane)).collect();
        let largest = extents.iter().copied().fold(0.0, f64::max);
        let end = |(k, sign): (usize, f64)| HalfSpace {
            border: planes[k][0],
            outward: sign * Vec3::ith(axis, 1.0),
        };
        let ends = [(0, -1.0), (planes.len() - 1, 1.0)]
            .into_iter()
            .filter(|&(k, _)| extents[k] > CUT * largest)
            .map(end)
            .collect();
        let open = planes.iter().flat_map(|plane| open_sides(plane, axis, GAP * spacing)).collect();
        let markers = planes.concat();
        let nearest = NearestPoints::new(&markers);
        let rest: Vec<Vec3> = surface.iter().map(|(_, rest)| *rest).collect();
        let watched = spread_evenly(&rest, SAMPLES);
        let samples = watched.into_iter().map(|v| surface[v].0.clone()).collect();
        Some(Self { nearest, markers, open, spacing, ends, samples })
    }
}

impl Term for Coverage {
    /// One row for each watched point that sticks out: its distance beyond the markers' spacing.
    fn add_rows(&self, place: &Place, _: &[f64], rows: &mut Rows) {
        for point in &self.samples {
            let p = point.position(place.x);
            let Some((marker, distance)) = self.nearest.nearest(&p) else { continue };
            let marker = marker as usize;
            let mut unseen = self.ends.iter().chain(&self.open[marker]);
            if distance > self.spacing && !unseen.any(|part| part.holds(&p)) {
                let direction = (p - self.markers[marker]) / distance;
                let residual = distance - self.spacing;
                rows.add(point, [(direction, residual, self.spacing.powi(-2))]);
            }
        }
    }
}

fn diameter(points: &[Vec3]) -> f64 {
    points.iter().flat_map(|a| points.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

fn spacing(markers: &[Vec3]) -> f64 {
    let to_neighbour = |p: &Vec3| {
        let mut distances: Vec<f64> = markers.iter().map(|q| (p - q).norm()).collect();
        let place = NEIGHBOUR.min(distances.len() - 1);
        *distances.select_nth_unstable_by(place, f64::total_cmp).1
    };
    let every = markers.len().div_ceil(SPACING_SAMPLES);
    median(markers.iter().step_by(every).map(to_neighbour)).unwrap_or(0.0)
}
