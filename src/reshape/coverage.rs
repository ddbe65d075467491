//! Where the markers cover the person, and so where the template has no business to be.
//!
//! Markers say where the surface is, not where it is not: a free part of the template may stick
//! out without any marker objecting. The reverse term pulls template points that are farther from
//! every marker than markers are from each other back to that distance. Where a scan ends inside
//! the organ nobody knows, so points beyond such an end are left alone.

use super::rows::Rows;
use super::term::{Place, Term};
use crate::fem::MaterialPoint;
use crate::locate::NearestPoints;
use crate::math::{Vec3, median};
use crate::mesh::bounding_box;

/// Template points that are watched.
const SAMPLES: usize = 300;

/// The spacing of markers is the median distance to this neighbour.
const NEIGHBOUR: usize = 4;

/// So many of them are asked.
const SPACING_SAMPLES: usize = 1000;

/// Markers lie on slices when they have at most this many different coordinates per marker.
const PLANES_PER_MARKER: f64 = 0.34;

/// A slice at the end of a scan whose contour is this large beside the largest was cut there; an
/// organ that ends by itself tapers off.
const CUT: f64 = 0.6;

/// The markers' extent.
pub struct Coverage {
    nearest: NearestPoints,
    markers: Vec<Vec3>,
    /// Usual distance between markers.
    spacing: f64,
    /// Half-spaces (axis, sign, coordinate) beyond which the scan saw nothing.
    unseen: Vec<(usize, f64, f64)>,
    samples: Vec<MaterialPoint>,
}

impl Coverage {
    /// Of markers that lie on parallel axis-aligned slices; `None` for others, of which nobody
    /// knows where the scan ends.
    pub fn of_slices(markers: &[Vec3], surface: &[(MaterialPoint, Vec3)]) -> Option<Self> {
        let (axis, planes) = slices(markers)?;
        let nearest = NearestPoints::new(markers);
        let spacing = spacing(markers);
        let extents: Vec<f64> = planes.iter().map(|plane| diameter(plane)).collect();
        let largest = extents.iter().copied().fold(0.0, f64::max);
        let mut unseen = Vec::new();
        for (k, sign) in [(0, -1.0), (planes.len() - 1, 1.0)] {
            if extents[k] > CUT * largest {
                unseen.push((axis, sign, planes[k][0][axis]));
            }
        }
        let samples = spread(surface, SAMPLES);
        Some(Self { nearest, markers: markers.to_vec(), spacing, unseen, samples })
    }
}

impl Term for Coverage {
    /// One row for each watched point that sticks out: its distance beyond the markers' spacing.
    fn add_rows(&self, place: &Place, _: &[f64], rows: &mut Rows) {
        for point in &self.samples {
            let p = point.position(place.x);
            if self.unseen.iter().any(|&(axis, sign, end)| sign * (p[axis] - end) > 0.0) {
                continue;
            }
            if let Some((marker, distance)) = self.nearest.nearest(&p)
                && distance > self.spacing
            {
                let direction = (p - self.markers[marker as usize]) / distance;
                let residual = distance - self.spacing;
                rows.add(point, [(direction, residual, self.spacing.powi(-2))]);
            }
        }
    }
}

/// The axis along which the markers lie on planes, and the markers of each plane in order.
fn slices(markers: &[Vec3]) -> Option<(usize, Vec<Vec<Vec3>>)> {
    let (low, high) = bounding_box(markers)?;
    let resolution = 1e-4 * (high - low).norm();
    (0..3)
        .map(|axis| {
            let mut sorted = markers.to_vec();
            sorted.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
            let planes =
                sorted.chunk_by(|a, b| b[axis] - a[axis] < resolution).map(<[Vec3]>::to_vec);
            (axis, planes.collect::<Vec<_>>())
        })
        .min_by_key(|(_, planes)| planes.len())
        .filter(|(_, planes)| {
            planes.len() >= 3 && planes.len() as f64 <= PLANES_PER_MARKER * markers.len() as f64
        })
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

/// Points spread evenly over the surface: each next one is farthest from those before.
fn spread(surface: &[(MaterialPoint, Vec3)], count: usize) -> Vec<MaterialPoint> {
    let mut distance = vec![f64::INFINITY; surface.len()];
    let mut chosen = Vec::new();
    let mut next = 0;
    while chosen.len() < count.min(surface.len()) {
        chosen.push(surface[next].0.clone());
        let from = surface[next].1;
        for (d, (_, p)) in distance.iter_mut().zip(surface) {
            *d = d.min((p - from).norm_squared());
        }
        let far = |&a: &usize, &b: &usize| distance[a].total_cmp(&distance[b]).then(b.cmp(&a));
        next = (0..surface.len()).max_by(far).unwrap_or(0);
    }
    chosen
}
