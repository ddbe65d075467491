//! Intensity profiles along normals, and where along a line another image shows the same.
//!
//! Profiles are compared by their normalized cross-correlation (NCC), which does not care about
//! gain and offset of the intensities.

use rayon::prelude::*;

use super::Volume;
use crate::error::{Error, Result};
use crate::math::{Vec3, median};

/// A profile whose values vary less than this share of the usual variation shows nothing.
const FLAT: f64 = 0.1;
/// No one asks for more samples in one profile.
const MOST_SAMPLES: f64 = 1000.0;

/// Intensities along the normal of each of many points, in an image that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiles {
    /// Millimetres between samples.
    step: f64,
    /// Samples on each side of the point.
    half: usize,
    /// `2 * half + 1` values for each point, from inside (against the normal) outwards.
    values: Vec<f32>,
    /// Standard deviation below which a profile shows nothing.
    floor: f64,
}

/// Where a profile was found again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Millimetres along the normal from where it was looked for.
    pub shift: f64,
    /// Normalized cross-correlation, -1 to 1.
    pub score: f64,
}

impl Profiles {
    /// Samples `volume` at `points` (world) along unit `normals`, `reach` mm to each side, `step` mm
    /// apart.
    pub fn new(
        volume: &Volume,
        points: &[Vec3],
        normals: &[Vec3],
        reach: f64,
        step: f64,
    ) -> Result<Self> {
        let half = reach / step;
        if !(half.is_finite() && step > 0.0 && (1.0..MOST_SAMPLES).contains(&half)) {
            return Err(Error::invalid(format!(
                "profiles of {reach} mm with samples each {step} mm cannot be made"
            )));
        }
        let half = half.round() as usize;
        let lines = points.par_iter().zip(normals);
        let values = lines.flat_map_iter(|(p, n)| line(volume, p, n, half, step)).collect();
        Ok(Self::with_floor(step, half, values))
    }

    /// From stored values, `2 * half + 1` for each point.
    pub fn from_values(step: f64, half: usize, values: Vec<f32>) -> Result<Self> {
        let length = half.checked_mul(2).and_then(|n| n.checked_add(1));
        let whole = length.is_some_and(|length| values.len().is_multiple_of(length));
        if !(step.is_finite() && step > 0.0 && half >= 1 && whole) {
            return Err(Error::invalid("the stored profiles are not a whole number of profiles"));
        }
        Ok(Self::with_floor(step, half, values))
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len() / (2 * self.half + 1)
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Millimetres between samples.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Samples on each side.
    pub fn half(&self) -> usize {
        self.half
    }

    /// All values, point by point.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The profile of point `i`.
    pub fn of(&self, i: usize) -> &[f32] {
        &self.values[i * (2 * self.half + 1)..(i + 1) * (2 * self.half + 1)]
    }

    /// Looks for each profile in `volume` along the line through its point, up to `range` mm to each
    /// side: the best of all shifts, between samples too. None where the profile shows nothing, or
    /// the line leaves the image.
    pub fn find(
        &self,
        volume: &Volume,
        points: &[Vec3],
        normals: &[Vec3],
        range: f64,
    ) -> Vec<Option<Match>> {
        let shifts = (range / self.step).round().clamp(1.0, MOST_SAMPLES) as usize;
        points
            .par_iter()
            .zip(normals)
            .enumerate()
            .map(|(i, (point, normal))| {
                let wanted = centred(self.of(i))?;
                if wanted.1 < self.floor {
                    return None;
                }
                let seen = line(volume, point, normal, self.half + shifts, self.step);
                best_shift(&wanted.0, &seen, self.floor).map(|(shift, score)| Match {
                    shift: (shift - shifts as f64) * self.step,
                    score,
                })
            })
            .collect()
    }

    /// How like its profile the image is at each point: their correlation. None where the profile shows
    /// nothing, or the line leaves the image.
    pub fn likeness(&self, volume: &Volume, points: &[Vec3], normals: &[Vec3]) -> Vec<Option<f64>> {
        let lines = points.par_iter().zip(normals).enumerate();
        let likeness = |(i, (point, normal))| {
            let (wanted, deviation) = centred(self.of(i))?;
            let seen = line(volume, point, normal, self.half, self.step);
            let found =
                (deviation >= self.floor).then(|| best_shift(&wanted, &seen, self.floor))?;
            found.map(|(_, score)| score)
        };
        lines.map(likeness).collect()
    }

    fn with_floor(step: f64, half: usize, values: Vec<f32>) -> Self {
        let profiles = values.chunks_exact(2 * half + 1);
        let usual = median(profiles.filter_map(centred).map(|(_, deviation)| deviation));
        Self { step, half, values, floor: FLAT * usual.unwrap_or(0.0) }
    }
}

/// Samples from `half` steps inside to `half` steps outside; NaN beyond the image.
fn line(volume: &Volume, point: &Vec3, normal: &Vec3, half: usize, step: f64) -> Vec<f32> {
    let (middle, along) = (volume.voxel(point), volume.voxel_from_world() * normal * step);
    (0..=2 * half)
        .map(|s| middle + along * (s as f64 - half as f64))
        .map(|voxel| volume.sample_voxel(&voxel, |v| v).unwrap_or(f32::NAN))
        .collect()
}

/// Values less their mean, scaled to length 1, and their standard deviation; none with gaps or if
/// all values are the same.
fn centred(values: &[f32]) -> Option<(Vec<f64>, f64)> {
    let count = values.len() as f64;
    let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / count;
    let around: Vec<f64> = values.iter().map(|v| f64::from(*v) - mean).collect();
    let length = around.iter().map(|v| v * v).sum::<f64>().sqrt();
    (length.is_finite() && length > 1e-9 * (1.0 + mean.abs()))
        .then(|| (around.iter().map(|v| v / length).collect(), length / count.sqrt()))
}

/// The start of the window of `seen` that correlates best with `wanted` (length 1, mean 0), refined
/// by a parabola through its neighbours, and the correlation. Windows flatter than `floor` count
/// as their correlation times their share of it: noise has no shape.
fn best_shift(wanted: &[f64], seen: &[f32], floor: f64) -> Option<(f64, f64)> {
    let count = wanted.len() as f64;
    let score = |start: usize| {
        // As `wanted` has no mean, that of the window plays no part in the product.
        let (mut product, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for (value, w) in seen[start..start + wanted.len()].iter().zip(wanted) {
            let value = f64::from(*value);
            product += value * w;
            sum += value;
            squares += value * value;
        }
        let around = squares - sum * sum / count;
        let usable = around > 1e-12 * squares && around.is_finite();
        usable.then(|| product / around.sqrt() * ((around / count).sqrt() / floor).min(1.0))
    };
    let scores: Vec<Option<f64>> = (0..=seen.len() - wanted.len()).map(score).collect();
    let best = (0..scores.len())
        .filter(|&s| scores[s].is_some())
        .max_by(|&a, &b| scores[a].unwrap_or(-1.0).total_cmp(&scores[b].unwrap_or(-1.0)))?;
    let top = scores[best]?;
    let beside = |s: Option<usize>| s.and_then(|s| scores.get(s).copied().flatten());
    let refined = match (beside(best.checked_sub(1)), beside(Some(best + 1))) {
        (Some(before), Some(after)) if before + after - 2.0 * top < 0.0 => {
            0.5 * (before - after) / (before + after - 2.0 * top)
        }
        _ => 0.0,
    };
    Some((best as f64 + refined.clamp(-0.5, 0.5), top))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;

    /// A bright shell at x = `edge` in a darker surrounding, 0.5 mm voxels.
    fn wall(edge: f64, gain: f64, offset: f64) -> Volume {
        let value =
            |x: f64| 100.0 * libm::exp(-((x - edge) / 1.5).powi(2)) + 20.0 * libm::tanh(x - edge);
        let values = (0..4 * 4 * 120)
            .map(|v| (value(f64::from(v % 120) * 0.5) * gain + offset) as f32)
            .collect();
        let map = Mat3::identity() * 0.5;
        Volume::new([120, 4, 4], values, map, Vec3::zeros()).unwrap()
    }

    #[test]
    fn a_shifted_profile_is_found_whatever_gain_and_offset() {
        let points = [Vec3::new(30.0, 0.7, 0.7)];
        let normals = [Vec3::x()];
        let profiles = Profiles::new(&wall(30.0, 1.0, 0.0), &points, &normals, 4.0, 0.4).unwrap();
        for (edge, gain) in [(30.0, 1.0), (33.3, 0.8), (26.15, 2.0)] {
            let seen = wall(edge, gain, 50.0);
            let found = profiles.find(&seen, &points, &normals, 5.0)[0].unwrap();
            assert!((found.shift - (edge - 30.0)).abs() < 0.05, "{found:?}");
            assert!(found.score > 0.99, "{found:?}");
        }
        let kept = Profiles::from_values(0.4, profiles.half(), profiles.values().to_vec()).unwrap();
        assert_eq!((kept.len(), &kept), (1, &profiles));
    }

    #[test]
    fn nothing_is_found_beyond_the_image_and_in_flat_places() {
        let points = [Vec3::new(30.0, 0.7, 0.7), Vec3::new(50.0, 0.7, 0.7)];
        let normals = [Vec3::x(); 2];
        let wall = wall(30.0, 1.0, 0.0);
        let profiles = Profiles::new(&wall, &points, &normals, 4.0, 0.4).unwrap();
        let found = profiles.find(&wall, &[points[0] + Vec3::y() * 9.0, points[1]], &normals, 5.0);
        assert_eq!(found, [None, None]);
        assert!(Profiles::new(&wall, &points, &normals, 4.0, 0.0).is_err());
        assert!(Profiles::from_values(0.4, usize::MAX, vec![0.0; 3]).is_err());
        assert!(Profiles::from_values(0.4, 2, vec![0.0; 6]).is_err());
    }
}
