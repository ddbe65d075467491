//! Statistics of bone shapes: one principal component analysis over all bones, pose removed.
//!
//! [G] section 3.3: every bone of every sample is aligned rigidly (no scale: size is a mode) with
//! the mean bone, all bones are stacked to one vector per subject, so that correlations between
//! bones are kept.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::areas::vertex_areas;
use super::bone_scales::put_in_place;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Rounds of aligning the samples with their mean.
const ALIGNMENT_ROUNDS: usize = 4;
/// Modes with less than this share of the largest variance are dropped.
const SMALLEST_VARIANCE: f64 = 1e-10;
/// Coefficients are held within this many standard deviations.
const MAX_DEVIATIONS: f64 = 3.0;

/// Mean shape and modes of all bones together.
#[derive(Clone, Debug)]
pub struct ShapeModel {
    mean: Vec<Vec3>,
    /// 3N x k, columns orthonormal under the vertex areas.
    modes: DMatrix<f64>,
    deviations: Vec<f64>,
}

impl ShapeModel {
    /// Learns from samples in vertex correspondence with `template`, two or more, in any pose.
    pub fn fit(template: &Skeleton, samples: &[Vec<Vec3>]) -> Result<Self> {
        let n = template.points.len();
        if samples.len() < 2 {
            return Err(Error::invalid("a shape model needs two or more samples"));
        }
        if let Some(k) = samples.iter().position(|s| s.len() != n) {
            return Err(Error::invalid(format!(
                "sample {k} has {} vertices, the template {n}",
                samples[k].len()
            )));
        }
        let areas = vertex_areas(&template.points, &template.triangles);
        let mut mean = template.points.clone();
        let mut aligned = Vec::new();
        for _ in 0..ALIGNMENT_ROUNDS {
            aligned = samples
                .iter()
                .map(|s| put_in_place(template, s, &mean, &areas))
                .collect::<Vec<_>>();
            let share = 1.0 / samples.len() as f64;
            mean = (0..n).map(|i| aligned.iter().map(|s| s[i]).sum::<Vec3>() * share).collect();
        }
        let roots: Vec<f64> = areas.iter().map(|a| a.sqrt()).collect();
        let weighted = DMatrix::from_fn(3 * n, samples.len(), |row, s| {
            let i = row / 3;
            roots[i] * (aligned[s][i] - mean[i])[row % 3]
        });
        let factor = weighted / ((samples.len() - 1) as f64).sqrt();
        let (modes, deviations) = principal(&factor, &roots);
        Ok(Self { mean, modes, deviations })
    }

    /// The model whose shapes are `mean` + `factor` x (coefficients in standard deviations), as read
    /// from a file. `factor`: 3N x k, the coordinates of a vertex one after the other.
    pub fn from_factor(
        template: &Skeleton,
        mean: Vec<Vec3>,
        factor: &DMatrix<f64>,
    ) -> Result<Self> {
        let n = template.points.len();
        if mean.len() != n || factor.nrows() != 3 * n {
            return Err(Error::invalid(format!(
                "the shape model has {} vertices, the skeleton {n}",
                mean.len()
            )));
        }
        let areas = vertex_areas(&template.points, &template.triangles);
        let roots: Vec<f64> = areas.iter().map(|a| a.sqrt()).collect();
        let mut weighted = factor.clone();
        for (row, mut values) in weighted.row_iter_mut().enumerate() {
            values *= roots[row / 3];
        }
        let (modes, deviations) = principal(&weighted, &roots);
        Ok(Self { mean, modes, deviations })
    }

    /// The shapes' deviations: 3N x k, one column per mode, at one standard deviation.
    pub fn factor(&self) -> DMatrix<f64> {
        let mut factor = self.modes.clone();
        for (mut column, deviation) in factor.column_iter_mut().zip(&self.deviations) {
            column *= *deviation;
        }
        factor
    }

    /// Standard deviation of each mode, as a length: root mean square over the surface, areas in the
    /// square of the template's unit.
    pub fn deviations(&self, template: &Skeleton) -> Vec<f64> {
        let areas = vertex_areas(&template.points, &template.triangles);
        let total: f64 = areas.iter().sum();
        self.deviations.iter().map(|d| d / total.sqrt()).collect()
    }

    /// Number of modes.
    pub fn mode_count(&self) -> usize {
        self.deviations.len()
    }

    /// Mean shape, bones as they lie in the template.
    pub fn mean(&self) -> &[Vec3] {
        &self.mean
    }

    /// Share of the variance in the first modes: one number per mode, rising to 1.
    pub fn explained(&self) -> Vec<f64> {
        let total: f64 = self.deviations.iter().map(|d| d * d).sum();
        let mut sum = 0.0;
        let part = |d: &f64| {
            sum += d * d;
            sum / total
        };
        self.deviations.iter().map(part).collect()
    }

    /// The shape at the given coefficients, in standard deviations; missing ones are 0.
    pub fn synthesize(&self, coefficients: &[f64]) -> Vec<Vec3> {
        let mut shape = self.mean.clone();
        for ((&c, &deviation), mode) in
            coefficients.iter().zip(&self.deviations).zip(self.modes.column_iter())
        {
            for (i, p) in shape.iter_mut().enumerate() {
                *p += c * deviation * Vec3::new(mode[3 * i], mode[3 * i + 1], mode[3 * i + 2]);
            }
        }
        shape
    }

    /// The coefficients, in standard deviations and at most three of them, of the shape nearest to
    /// `wanted` under vertex `masses`, whatever the pose of its bones.
    pub fn project(&self, template: &Skeleton, wanted: &[Vec3], masses: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.mode_count()];
        // The second round aligns with the shape found in the first, not with the mean.
        for _ in 0..2 {
            let near = self.synthesize(&coefficients);
            let aligned = put_in_place(template, wanted, &near, masses);
            let difference = DVector::from_fn(3 * self.mean.len(), |row, _| {
                masses[row / 3] * (aligned[row / 3] - self.mean[row / 3])[row % 3]
            });
            let mut weighted = self.modes.clone();
            for (row, mut values) in weighted.row_iter_mut().enumerate() {
                values *= masses[row / 3];
            }
            let normal = self.modes.tr_mul(&weighted);
            let floor = 1e-9 * normal.diagonal().max();
            let normal = normal + DMatrix::identity(self.mode_count(), self.mode_count()) * floor;
            let Some(solved) = normal.lu().solve(&self.modes.tr_mul(&difference)) else { break };
            for ((c, x), deviation) in
                coefficients.iter_mut().zip(solved.iter()).zip(&self.deviations)
            {
                *c = (x / deviation).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS);
            }
        }
        coefficients
    }
}

/// The principal directions of `weighted` x its transpose, in falling order, with the weights `roots`
/// of the vertices taken out again, and their standard deviations.
fn principal(weighted: &DMatrix<f64>, roots: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
    let eigen = SymmetricEigen::new(weighted.tr_mul(weighted));
    let mut order: Vec<usize> = (0..weighted.ncols()).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let largest = order.first().map_or(0.0, |&k| eigen.eigenvalues[k]);
    order.retain(|&k| eigen.eigenvalues[k] > SMALLEST_VARIANCE * largest);
    let mut modes = DMatrix::zeros(weighted.nrows(), order.len());
    for (column, &k) in order.iter().enumerate() {
        let mut mode = weighted * eigen.eigenvectors.column(k);
        let norm = mode.norm();
        for (row, x) in mode.iter_mut().enumerate() {
            // A vertex without area takes no part in the analysis and keeps its mean.
            *x = if roots[row / 3] > 0.0 { *x / (norm * roots[row / 3]) } else { 0.0 };
        }
        modes.set_column(column, &mode);
    }
    let deviations = order.iter().map(|&k| eigen.eigenvalues[k].sqrt()).collect();
    (modes, deviations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::pose::moved;
    use crate::register::skeleton::tests::block;
    use nalgebra::Isometry3;

    #[test]
    fn a_model_finds_its_own_shapes_in_any_pose_and_holds_the_rest_back() {
        let a = block(Vec3::zeros(), Vec3::new(10.0, 2.0, 1.5), 5);
        let b = block(Vec3::new(15.0, 0.0, 0.0), Vec3::new(4.0, 2.0, 1.0), 5);
        let template = Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![]).unwrap();
        // Two causes: the bones grow together in length, and thicken together.
        let person = |length: f64, width: f64| -> Vec<Vec3> {
            template.points.iter().map(|p| Vec3::new(p.x * length, p.y * width, p.z)).collect()
        };
        let samples: Vec<Vec<Vec3>> =
            [(0.9, 1.0), (1.1, 1.05), (1.0, 0.9), (1.0, 1.1), (1.05, 0.95)]
                .map(|(l, w)| person(l, w))
                .to_vec();
        let model = ShapeModel::fit(&template, &samples).unwrap();
        assert!(model.explained()[1] > 0.999, "{:?}", model.explained());

        let areas = vertex_areas(&template.points, &template.triangles);
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let shape = person(1.07, 0.97);
        let turned: Vec<Vec3> = shape.iter().map(|p| moved(&motion, p)).collect();
        let found = model.synthesize(&model.project(&template, &turned, &areas));
        let placed = put_in_place(&template, &found, &turned, &areas);
        let worst = placed.iter().zip(&turned).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        assert!(worst < 0.05, "{worst}");
        let giant = model.project(&template, &person(3.0, 1.0), &areas);
        assert!(giant.iter().all(|c| c.abs() <= 3.0));
        assert!(ShapeModel::fit(&template, &samples[..1]).is_err());

        let again =
            ShapeModel::from_factor(&template, model.mean().to_vec(), &model.factor()).unwrap();
        let sizes = model.deviations(&template).into_iter().zip(again.deviations(&template));
        assert!(sizes.into_iter().all(|(a, b)| (a - b).abs() < 1e-9 * a));
        let apart = model.project(&template, &turned, &areas);
        let shapes = [
            model.synthesize(&apart),
            again.synthesize(&again.project(&template, &turned, &areas)),
        ];
        let worst =
            shapes[0].iter().zip(&shapes[1]).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
    }
}
