//! Histogram moments in balls: mean, standard deviation and skewness at three sizes.
//!
//! \[G\] 3.2.2 uses the mean and central moments of order 1 and 2. The first of them is 0 whatever
//! the image; the cube root of the third is used in its place, as it has the unit of intensities.

use rayon::prelude::*;

use super::profiles::Match;
use super::{Volume, grid};
use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};

/// Balls of the given radius, twice and four times that.
const SCALES: [f64; 3] = [1.0, 2.0, 4.0];
/// Features: three of each ball.
const FEATURES: usize = 9;
/// Samples on each side of a vertex. [G] 3.2.2.
const SAMPLES: i32 = 20;
/// Features are divided by the range between these shares of their values.
const RANGE: [f64; 2] = [0.01, 0.99];
/// A ball may not have more rows of voxels.
const MOST_ROWS: usize = 20_000;

/// Features of a reference image at many points.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    radius: f64,
    /// Lowest value and range of each feature in the reference image.
    scale: [[f32; 2]; FEATURES],
    /// Scaled features of each point; NaN outside the image.
    values: Vec<[f32; FEATURES]>,
}

/// The features of a whole image.
#[derive(Clone, Debug)]
pub struct FeatureGrids(Vec<Volume>);

impl Moments {
    /// Features of `reference` at `points`, in balls from `radius` mm.
    pub fn new(reference: &Volume, points: &[Vec3], radius: f64) -> Result<Self> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(Error::invalid(format!(
                "the balls' radius is {radius}; it must be above 0"
            )));
        }
        let grids = feature_grids(reference, radius)?;
        let scale = std::array::from_fn(|f| range(&grids[f]));
        let grids = FeatureGrids(grids);
        let values = points.par_iter().map(|p| grids.at(p, &scale)).collect();
        Ok(Self { radius, scale, values })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The features of another image, for [`Self::find`].
    pub fn grids(&self, volume: &Volume) -> Result<FeatureGrids> {
        feature_grids(volume, self.radius).map(FeatureGrids)
    }

    /// Looks for each point's features along its normal, up to `range` mm to each side: the best of 41
    /// samples.
    pub fn find(
        &self,
        grids: &FeatureGrids,
        points: &[Vec3],
        normals: &[Vec3],
        range: f64,
    ) -> Vec<Option<Match>> {
        let step = range / f64::from(SAMPLES);
        (0..points.len())
            .into_par_iter()
            .map(|i| {
                let scores: Vec<f64> = (-SAMPLES..=SAMPLES)
                    .map(|s| points[i] + normals[i] * (f64::from(s) * step))
                    .map(|at| self.alike(i, grids, &at).unwrap_or(0.0))
                    .collect();
                let best = (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]))?;
                let shift = (best as f64 - f64::from(SAMPLES)) * step;
                (scores[best] > 0.0).then_some(Match { shift, score: scores[best] })
            })
            .collect()
    }

    /// How like its features another image is at each point, 0 to 1; none outside the image.
    pub fn likeness(&self, grids: &FeatureGrids, points: &[Vec3]) -> Vec<Option<f64>> {
        points.par_iter().enumerate().map(|(i, at)| self.alike(i, grids, at)).collect()
    }

    /// [G] 3.2.2: the product of the likenesses of all features.
    fn alike(&self, i: usize, grids: &FeatureGrids, at: &Vec3) -> Option<f64> {
        let seen = grids.at(at, &self.scale);
        let alike = |(a, b): (&f32, &f32)| f64::from(1.0 - (a - b).abs());
        let each = self.values[i].iter().zip(&seen).map(alike);
        // `max` would take a value that is no number for 0.
        let product: f64 = each.map(|alike| if alike < 0.0 { 0.0 } else { alike }).product();
        (!product.is_nan()).then_some(product)
    }
}

impl FeatureGrids {
    fn at(&self, point: &Vec3, scale: &[[f32; 2]; FEATURES]) -> [f32; FEATURES] {
        std::array::from_fn(|f| {
            let value = self.0[f].sample(point).unwrap_or(f32::NAN);
            (value - scale[f][0]) / scale[f][1]
        })
    }
}

/// The range of all but the outermost values: lowest one and width.
fn range(grid: &Volume) -> [f32; 2] {
    let mut sorted = grid.values().to_vec();
    sorted.sort_by(f32::total_cmp);
    let [low, high] = RANGE.map(|share| sorted[((sorted.len() - 1) as f64 * share) as usize]);
    [low, (high - low).max(1e-6)]
}

/// Mean, standard deviation and cube root of the third moment, for each ball size.
fn feature_grids(volume: &Volume, radius: f64) -> Result<Vec<Volume>> {
    let mut grids = Vec::new();
    for scale in SCALES {
        grids.extend(ball_moments(volume, radius * scale)?);
    }
    Ok(grids)
}

/// One row of a ball's voxels: offsets along the second and third index, and the stretch of the first.
struct Row {
    across: [isize; 2],
    from: isize,
    to: isize,
}

/// Rows of the ball of `radius` mm. The grid may be oblique and anisotropic.
fn ball_rows(map: &Mat3, radius: f64) -> Result<Vec<Row>> {
    let metric = map.transpose() * map;
    let inverse = map.try_inverse().unwrap_or_default();
    // The box around the ball, in indices.
    let reach = [0, 1, 2].map(|axis| (radius * inverse.row(axis).norm()).floor() as isize);
    let mut rows = Vec::new();
    for k in -reach[2]..=reach[2] {
        for j in -reach[1]..=reach[1] {
            let across = Vec3::new(0.0, j as f64, k as f64);
            // |map (i, j, k)| <= radius is a quadratic inequality in i.
            let (a, b) = (metric[(0, 0)], (metric * across)[0]);
            let c = across.dot(&(metric * across)) - radius * radius;
            let root = b * b - a * c;
            if root < 0.0 {
                continue;
            }
            let (from, to) = ((-b - root.sqrt()) / a, (-b + root.sqrt()) / a);
            let (from, to) = (from.ceil() as isize, to.floor() as isize);
            if from <= to {
                rows.push(Row { across: [j, k], from, to });
            }
        }
    }
    if rows.len() > MOST_ROWS {
        return Err(Error::invalid(format!(
            "a ball of {radius} mm has too many voxels; take a smaller radius"
        )));
    }
    Ok(rows)
}

fn ball_moments(volume: &Volume, radius: f64) -> Result<[Volume; 3]> {
    let size = volume.size();
    let rows = ball_rows(volume.world_from_voxel(), radius)?;
    let count = grid::voxel_count(size)?;
    // Powers are summed around the mean, so that large offsets lose no digits.
    let mean = volume.values().iter().map(|v| f64::from(*v)).sum::<f64>() / count as f64;
    let sums = running_sums(volume, mean);
    let width = size[0] + 1;
    let moments = |v: usize| -> [f32; 3] {
        let at = [v % size[0], v / size[0] % size[1], v / (size[0] * size[1])].map(|i| i as isize);
        let (mut total, mut n) = ([0.0_f64; 3], 0.0);
        for row in &rows {
            let (j, k) = (at[1] + row.across[0], at[2] + row.across[1]);
            if j < 0 || k < 0 || j >= size[1] as isize || k >= size[2] as isize {
                continue;
            }
            let from = (at[0] + row.from).max(0) as usize;
            let to = (at[0] + row.to + 1).clamp(0, size[0] as isize) as usize;
            if from >= to {
                continue;
            }
            let line = (k as usize * size[1] + j as usize) * width;
            n += (to - from) as f64;
            for p in 0..3 {
                total[p] += sums[line + to][p] - sums[line + from][p];
            }
        }
        let [m1, m2, m3] = total.map(|t| t / n);
        let variance = (m2 - m1 * m1).max(0.0);
        let third = m3 - 3.0 * m1 * m2 + 2.0 * m1.powi(3);
        [(m1 + mean) as f32, variance.sqrt() as f32, libm::cbrt(third) as f32]
    };
    let all: Vec<[f32; 3]> = (0..count).into_par_iter().map(moments).collect();
    let grid = |p: usize| {
        let values = all.iter().map(|m| m[p]).collect();
        Volume::new(size, values, *volume.world_from_voxel(), volume.origin())
    };
    Ok([grid(0)?, grid(1)?, grid(2)?])
}

/// Sums of the first three powers of (value - mean) along each line of the first index.
fn running_sums(volume: &Volume, mean: f64) -> Vec<[f64; 3]> {
    let width = volume.size()[0];
    let mut sums = Vec::with_capacity(volume.values().len() / width * (width + 1));
    for line in volume.values().chunks_exact(width) {
        let mut sum = [0.0; 3];
        sums.push(sum);
        for value in line {
            let v = f64::from(*value) - mean;
            sum = [sum[0] + v, sum[1] + v * v, sum[2] + v * v * v];
            sums.push(sum);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::super::grid::tests::oblique;
    use super::*;

    #[test]
    fn moments_of_a_ball_are_those_of_its_voxels() {
        let volume = oblique(|p| libm::sin(p.x * 1.3) * 100.0 + 1000.0);
        let radius = 2.6;
        let [mean, deviation, third] = ball_moments(&volume, radius).unwrap();
        let centre = volume.world(&Vec3::new(6.0, 4.0, 3.0));
        let mut inside = Vec::new();
        for v in 0..volume.values().len() {
            let index = Vec3::new((v % 12) as f64, (v / 12 % 9) as f64, (v / 108) as f64);
            if (volume.world(&index) - centre).norm() <= radius {
                inside.push(f64::from(volume.values()[v]));
            }
        }
        assert!(inside.len() > 20);
        let n = inside.len() as f64;
        let m = inside.iter().sum::<f64>() / n;
        let central = |p: i32| inside.iter().map(|v| (v - m).powi(p)).sum::<f64>() / n;
        let at = [6, 4, 3];
        assert!((f64::from(mean.at(at)) - m).abs() < 1e-3);
        assert!((f64::from(deviation.at(at)) - central(2).sqrt()).abs() < 1e-3);
        assert!((f64::from(third.at(at)) - libm::cbrt(central(3))).abs() < 1e-2);
    }

    #[test]
    fn a_bright_ball_is_found_again_where_it_moved() {
        let ball = |at: f64| {
            let value = move |v: usize| {
                let p = Vec3::new((v % 40) as f64, (v / 40 % 12) as f64, (v / 480) as f64);
                100.0 * libm::exp(-(p - Vec3::new(at, 6.0, 6.0)).norm_squared() / 9.0) as f32
            };
            let values = (0..40 * 12 * 12).map(value).collect();
            Volume::new([40, 12, 12], values, Mat3::identity(), Vec3::zeros()).unwrap()
        };
        let at = [Vec3::new(20.0, 6.0, 6.0)];
        let moments = Moments::new(&ball(20.0), &at, 1.2).unwrap();
        let seen = moments.grids(&ball(23.0)).unwrap();
        let found = moments.find(&seen, &at, &[Vec3::x()], 6.0)[0].unwrap();
        assert!((found.shift - 3.0).abs() < 0.31 && found.score > 0.8, "{found:?}");
    }
}
