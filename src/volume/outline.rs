//! Outlines of a label on slices, and markers along them as a person would click them.

use std::collections::HashMap;

use super::slice::{SlicePlane, View};
use super::{Volume, grid};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::polyline::{Polyline, chain};

/// Where an outline runs between a voxel of the label and one outside.
const HALF: f32 = 0.5;
/// Outlines shorter than this many voxels around are specks of a segmentation, not organs.
const SPECK: f64 = 8.0;
/// Standard deviation, in half pixels, of the smoothing that turns voxel stairs into what a hand
/// draws.
const SMOOTHING: f64 = 2.0;

/// How markers are put on outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clicks {
    /// Millimetres between slices.
    pub every: f64,
    /// Millimetres between markers along an outline.
    pub spacing: f64,
    /// Standard deviation (mm) of a hand's error, across and along the outline; 0 for none.
    pub jitter: f64,
    /// Another number gives other errors; the same number the same ones.
    pub seed: u64,
}

impl Default for Clicks {
    fn default() -> Self {
        Self { every: 9.0, spacing: 8.0, jitter: 0.0, seed: 1 }
    }
}

/// The outlines of one label on a plane, smooth over the voxels' stairs. They end where the image
/// ends: the cut face of an organ that the scan does not hold to its end is no outline.
pub fn outlines(labels: &Volume, label: u32, plane: &SlicePlane) -> Vec<Polyline> {
    let inside = plane.sample_mapped(labels, |v| f32::from(u8::from(is_label(v, label))));
    let pixel = plane.right.norm();
    let lines = level_lines(&inside, plane);
    let long = lines.into_iter().filter(|line| line.length() >= SPECK * pixel);
    long.map(|line| smooth(&even(&line, pixel / 2.0), SMOOTHING)).collect()
}

/// Markers on the outlines of one label: on planes of each view that are `every` mm apart, along
/// each outline every `spacing` mm. Planes lie on the image's own slices where the view follows
/// them.
pub fn label_markers(
    labels: &Volume,
    label: u32,
    views: &[View],
    clicks: &Clicks,
) -> Result<Vec<Vec3>> {
    for (value, name) in [(clicks.every, "between slices"), (clicks.spacing, "between markers")] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::invalid(format!(
                "the distance {name} is {value}; it must be above 0"
            )));
        }
    }
    if !(clicks.jitter.is_finite() && clicks.jitter >= 0.0) {
        return Err(Error::invalid(format!(
            "the jitter is {}; it must be 0 or more",
            clicks.jitter
        )));
    }
    let Some(part) = crop(labels, label)? else {
        let known = labels.labels().unwrap_or_default();
        let known: Vec<String> = known.iter().take(20).map(|(l, _)| l.to_string()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        return Err(Error::invalid(format!(
            "the image has no voxel of label {label}; it has {known}"
        )));
    };
    let mut hand = Hand(clicks.seed);
    let mut markers = Vec::new();
    for view in views {
        for position in positions(&part, *view, clicks.every) {
            let Ok(plane) = SlicePlane::of(&part, *view, position, None) else { continue };
            for line in outlines(&part, label, &plane) {
                for (point, along) in spaced(&line, clicks.spacing, hand.share()) {
                    let across = along.cross(&plane.normal());
                    let (a, b) = hand.normal_pair();
                    markers.push(point + (across * a + along * b) * clicks.jitter);
                }
            }
        }
    }
    if markers.is_empty() {
        return Err(Error::invalid(format!(
            "no slice {} mm apart shows an outline of label {label}; take them closer",
            clicks.every
        )));
    }
    Ok(markers)
}

/// Labels are whole numbers; images may store them as real ones.
pub fn is_label(value: f32, label: u32) -> bool {
    (value - label as f32).abs() < HALF
}

/// The part of the image around a label with some voxels beyond it, where the image has them.
fn crop(labels: &Volume, label: u32) -> Result<Option<Volume>> {
    const BEYOND: usize = 2;
    let size = labels.size();
    let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
    let of_label = |value: &f32| is_label(*value, label);
    for (v, _) in labels.values().iter().enumerate().filter(|(_, value)| of_label(value)) {
        let index = [v % size[0], v / size[0] % size[1], v / (size[0] * size[1])];
        for axis in 0..3 {
            low[axis] = low[axis].min(index[axis]);
            high[axis] = high[axis].max(index[axis]);
        }
    }
    if low[0] == usize::MAX {
        return Ok(None);
    }
    for axis in 0..3 {
        low[axis] = low[axis].saturating_sub(BEYOND);
        high[axis] = (high[axis] + 1 + BEYOND).min(size[axis]);
    }
    let part = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let mut values = Vec::with_capacity(grid::voxel_count(part)?);
    for k in low[2]..high[2] {
        for j in low[1]..high[1] {
            values.extend((low[0]..high[0]).map(|i| labels.at([i, j, k])));
        }
    }
    let origin = labels.world(&Vec3::from(low.map(|l| l as f64)));
    Volume::new(part, values, *labels.world_from_voxel(), origin).map(Some)
}

/// Positions along a view: on the image's own slices if the view follows them, else evenly.
fn positions(part: &Volume, view: View, every: f64) -> Vec<f64> {
    let (axis, [low, high]) = (view.axis(), SlicePlane::reach(part, view));
    let own = (0..3).find_map(|k| {
        let step = part.world_from_voxel().column(k).dot(&axis);
        let others = (0..3).filter(|&o| o != k);
        let across =
            others.map(|o| part.world_from_voxel().column(o).dot(&axis).abs()).sum::<f64>();
        (across < 1e-3 * step.abs()).then_some(step.abs())
    });
    let first = own.map_or(low + every / 2.0, |slice| low + slice / 2.0);
    let step = own.map_or(every, |slice| slice * (every / slice).round().max(1.0));
    // Start such that both ends are left out equally.
    let count = ((high - first) / step).floor().max(0.0) as usize;
    let rest = (high - low) - 2.0 * (first - low) - count as f64 * step;
    let shift = own.map_or(rest / 2.0, |slice| (rest / 2.0 / slice).floor().max(0.0) * slice);
    (0..=count).map(|n| first + shift + n as f64 * step).filter(|p| *p <= high).collect()
}

/// Marching squares at one half. Pixels outside the image (NaN) have no lines.
fn level_lines(values: &[f32], plane: &SlicePlane) -> Vec<Polyline> {
    let (width, height) = (plane.width, plane.height);
    let mut pieces: Vec<[u64; 2]> = Vec::new();
    let mut crossings: HashMap<u64, Vec3> = HashMap::new();
    for row in 0..height.saturating_sub(1) {
        for column in 0..width.saturating_sub(1) {
            // Corners once around; the edge k goes from corner k to the next one.
            let at = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)];
            let value = at.map(|(c, r)| values[r * width + c]);
            if value.iter().any(|v| v.is_nan()) {
                continue;
            }
            let above = value.map(|v| v >= HALF);
            let mut cut = [0; 4];
            let mut count = 0;
            for k in 0..4 {
                let next = (k + 1) % 4;
                if above[k] == above[next] {
                    continue;
                }
                let name = edge_name(at[k], at[next], width);
                crossings.entry(name).or_insert_with(|| {
                    // From the lower corner, so that both cells agree to the last bit.
                    let (a, b) = if at[k] < at[next] { (k, next) } else { (next, k) };
                    let share = f64::from((HALF - value[a]) / (value[b] - value[a]));
                    let mix = |p: usize, q: usize| p as f64 + share * (q as f64 - p as f64);
                    plane.world(mix(at[a].0, at[b].0), mix(at[a].1, at[b].1))
                });
                cut[count] = name;
                count += 1;
            }
            match count {
                2 => pieces.push([cut[0], cut[1]]),
                // A saddle: the mean of the corners tells what is joined across the middle.
                4 if (value.iter().sum::<f32>() / 4.0 >= HALF) == above[0] => {
                    pieces.extend([[cut[0], cut[1]], [cut[2], cut[3]]]);
                }
                4 => pieces.extend([[cut[3], cut[0]], [cut[1], cut[2]]]),
                _ => {}
            }
        }
    }
    let line = |(names, closed): (Vec<u64>, bool)| {
        let points = names.iter().map(|name| crossings[name]).collect();
        Polyline { points, closed }
    };
    chain(&pieces).into_iter().map(line).collect()
}

/// Twice the index of the lower corner, plus 1 for edges downwards.
fn edge_name(a: (usize, usize), b: (usize, usize), width: usize) -> u64 {
    let (low, downwards) = (a.min(b), a.0 == b.0);
    2 * (low.1 * width + low.0) as u64 + u64::from(downwards)
}

/// The line with points at even distances, nearest to `step`; open ones keep their ends.
fn even(line: &Polyline, step: f64) -> Polyline {
    let mut points: Vec<Vec3> = spaced(line, step, 0.0).into_iter().map(|(p, _)| p).collect();
    if !line.closed {
        points.extend(line.points.last().copied());
    }
    Polyline { points, closed: line.closed }
}

/// Gaussian smoothing along a line, `sigma` in mean steps, applied so that curves keep their
/// radius: what a second pass takes away is given back beforehand.
fn smooth(line: &Polyline, sigma: f64) -> Polyline {
    let once = gaussian(line, sigma);
    let twice = gaussian(&once, sigma);
    let points = once.points.iter().zip(&twice.points).map(|(a, b)| 2.0 * a - b).collect();
    Polyline { points, closed: line.closed }
}

fn gaussian(line: &Polyline, sigma: f64) -> Polyline {
    let (count, reach) = (line.points.len() as i64, (3.0 * sigma).ceil() as i64);
    let at = |i: i64| {
        let index = if line.closed { i.rem_euclid(count) } else { i.clamp(0, count - 1) };
        line.points[index as usize]
    };
    let weight = |d: i64| libm::exp(-((d * d) as f64) / (2.0 * sigma * sigma));
    let sum: f64 = (-reach..=reach).map(weight).sum();
    let mean =
        |i: i64| (-reach..=reach).fold(Vec3::zeros(), |m, d| m + at(i + d) * weight(d)) / sum;
    Polyline { points: (0..count).map(mean).collect(), closed: line.closed }
}

/// Points at even distances (nearest to `spacing`) along a line with the direction of the line,
/// the first after `share` of a distance; at least three on a closed line.
fn spaced(line: &Polyline, spacing: f64, share: f64) -> Vec<(Vec3, Vec3)> {
    let length = line.length();
    let count = ((length / spacing).round() as usize).max(if line.closed { 3 } else { 1 });
    let step = length / count as f64;
    let closing = if line.closed { line.points.first() } else { None };
    let all: Vec<Vec3> = line.points.iter().chain(closing).copied().collect();
    let mut found = Vec::with_capacity(count);
    let (mut next, mut passed) = (share * step, 0.0);
    for ends in all.windows(2) {
        let piece = (ends[1] - ends[0]).norm();
        while piece > 0.0 && found.len() < count && next <= passed + piece {
            let along = (ends[1] - ends[0]) / piece;
            found.push((ends[0] + along * (next - passed), along));
            next += step;
        }
        passed += piece;
    }
    found
}

/// Errors of a hand: SplitMix64 and the Box-Muller transform.
struct Hand(u64);

impl Hand {
    /// Evenly from 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Two numbers with mean 0 and standard deviation 1.
    fn normal_pair(&mut self) -> (f64, f64) {
        let (radius, angle) = (self.share(), self.share() * std::f64::consts::TAU);
        let radius = (-2.0 * libm::log(1.0 - radius)).sqrt();
        (radius * libm::cos(angle), radius * libm::sin(angle))
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::tests::oblique;
    use super::*;
    use crate::math::Mat3;

    /// Label 5 inside a ball of this radius (mm) around (0, 0, 0); 2 mm voxels.
    fn ball(radius: f64, size: [usize; 3]) -> Volume {
        let origin = -Vec3::from(size.map(|s| s as f64 - 1.0));
        let mut values = Vec::new();
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let world = origin + 2.0 * Vec3::new(i as f64, j as f64, k as f64);
                    values.push(if world.norm() < radius { 5.0 } else { 0.0 });
                }
            }
        }
        Volume::new(size, values, Mat3::identity() * 2.0, origin).unwrap()
    }

    fn markers(volume: &Volume, views: &[View], clicks: &Clicks) -> Vec<Vec3> {
        label_markers(volume, 5, views, clicks).unwrap()
    }

    #[test]
    fn markers_of_a_ball_lie_on_its_sphere_within_a_part_of_a_voxel() {
        let volume = ball(20.0, [26, 26, 26]);
        let found = markers(&volume, &[View::Axial, View::Coronal], &Clicks::default());
        assert!(found.len() > 60, "{}", found.len());
        let off: Vec<f64> = found.iter().map(|p| (p.norm() - 20.0).abs()).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        assert!(mean < 0.4, "{mean}");
        let oblique_view = View::Along(Vec3::new(1.0, 2.0, 3.0));
        let tilted = markers(&volume, &[oblique_view], &Clicks::default());
        assert!(tilted.iter().all(|p| (p.norm() - 20.0).abs() < 1.7));
    }

    #[test]
    fn the_cut_face_of_an_organ_gets_no_markers() {
        let volume = ball(20.0, [26, 26, 13]);
        let top = volume.corners()[7].z;
        let clicks = Clicks { every: 4.0, ..Clicks::default() };
        for view in [View::Coronal, View::Sagittal] {
            let found = markers(&volume, &[view], &clicks);
            assert!(found.iter().all(|p| p.norm() > 18.0 && p.z < top), "{view:?}");
        }
    }

    #[test]
    fn jitter_is_as_large_as_asked_and_the_same_every_time() {
        let volume = ball(20.0, [26, 26, 26]);
        let clicks = Clicks { every: 2.0, spacing: 3.0, ..Clicks::default() };
        let shaky = Clicks { jitter: 0.5, ..clicks };
        let exact = markers(&volume, &[View::Axial], &clicks);
        let one = markers(&volume, &[View::Axial], &shaky);
        assert_eq!(one, markers(&volume, &[View::Axial], &shaky));
        let squares = one.iter().zip(&exact).map(|(a, b)| (a - b).norm_squared()).sum::<f64>();
        let deviation = (squares / (2.0 * one.len() as f64)).sqrt();
        assert!((0.4..0.6).contains(&deviation), "{deviation}");
        assert_ne!(one, markers(&volume, &[View::Axial], &Clicks { seed: 2, ..shaky }));
    }

    #[test]
    fn missing_labels_and_bad_distances_are_errors() {
        let volume = ball(20.0, [26, 26, 26]);
        let error = label_markers(&volume, 3, &[View::Axial], &Clicks::default()).unwrap_err();
        assert!(error.to_string().ends_with("no voxel of label 3; it has 5"), "{error}");
        let clicks = Clicks { every: 0.0, ..Clicks::default() };
        assert!(label_markers(&volume, 5, &[View::Axial], &clicks).is_err());
        assert!(label_markers(&oblique(|_| 1.0), 1, &[View::Axial], &clicks).is_err());
    }
}
