//! Mean and modes of shapes that share their vertices.

use nalgebra::{DMatrix, SymmetricEigen};

use super::rigid::best_rigid;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Rounds of aligning the shapes with their mean.
const ALIGNMENT_ROUNDS: usize = 5;
/// Modes of less than this share of the largest variance are rounding.
const SMALLEST_VARIANCE: f64 = 1e-10;

/// Principal components of shapes, pose removed (rotation and shift, not size).
#[derive(Clone, Debug)]
pub struct ShapeStatistics {
    /// Mean shape.
    pub mean: Vec<Vec3>,
    /// Moves of all vertices for one standard deviation of each mode, most important first.
    pub modes: Vec<Vec<Vec3>>,
    /// Share of the whole variance that each mode explains.
    pub shares: Vec<f64>,
    /// Position of each shape along each mode, in standard deviations.
    pub scores: Vec<Vec<f64>>,
}

impl ShapeStatistics {
    /// Of two or more shapes with the same vertices.
    pub fn of(shapes: &[Vec<Vec3>]) -> Result<Self> {
        let (count, n) = (shapes.len(), shapes.first().map_or(0, Vec::len));
        if count < 2 || shapes.iter().any(|s| s.len() != n) {
            return Err(Error::invalid(
                "statistics need two or more shapes with the same vertices",
            ));
        }
        let mut mean = shapes[0].clone();
        let mut aligned = shapes.to_vec();
        for _ in 0..ALIGNMENT_ROUNDS {
            for (own, shape) in aligned.iter_mut().zip(shapes) {
                let motion = best_rigid(shape, &mean, None)?;
                *own = shape.iter().map(|p| motion.apply(p)).collect();
            }
            mean =
                (0..n).map(|i| aligned.iter().map(|s| s[i]).sum::<Vec3>() / count as f64).collect();
        }
        let offsets =
            DMatrix::from_fn(3 * n, count, |row, s| (aligned[s][row / 3] - mean[row / 3])[row % 3]);
        let eigen = SymmetricEigen::new(offsets.tr_mul(&offsets) / (count - 1) as f64);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let largest = eigen.eigenvalues[order[0]];
        order.retain(|&k| eigen.eigenvalues[k] > SMALLEST_VARIANCE * largest);
        let total: f64 = order.iter().map(|&k| eigen.eigenvalues[k]).sum();
        let scale = ((count - 1) as f64).sqrt();
        // The first shape that counts lies on the positive side, so that signs do not depend on
        // the eigensolver.
        let column = |k: usize| {
            let v = eigen.eigenvectors.column(k).into_owned();
            let leading = v[v.iamax()];
            if leading < 0.0 { -v } else { v }
        };
        let modes = order.iter().map(|&k| {
            let moves = &offsets * column(k) / scale;
            (0..n).map(|i| Vec3::new(moves[3 * i], moves[3 * i + 1], moves[3 * i + 2])).collect()
        });
        let scores =
            (0..count).map(|s| order.iter().map(|&k| column(k)[s] * scale).collect()).collect();
        Ok(Self {
            modes: modes.collect(),
            shares: order.iter().map(|&k| eigen.eigenvalues[k] / total).collect(),
            scores,
            mean,
        })
    }

    /// The mean moved along one mode by so many standard deviations.
    pub fn along(&self, mode: usize, deviations: f64) -> Vec<Vec3> {
        self.mean.iter().zip(&self.modes[mode]).map(|(p, m)| p + m * deviations).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::Rigid;
    use crate::math::Mat3;

    #[test]
    fn one_way_to_differ_is_one_mode_whatever_the_pose() {
        let corners = [[0., 0., 0.], [3., 0., 0.], [0., 2., 0.], [0., 0., 1.], [3., 2., 1.]];
        let quarter = Mat3::new(0., -1., 0., 1., 0., 0., 0., 0., 1.);
        let stretched = |s: f64| -> Vec<Vec3> {
            corners.map(|[x, y, z]| Vec3::new(x * (1.0 + s), y, z)).to_vec()
        };
        let turn = Rigid { rotation: quarter, translation: Vec3::new(9.0, 1.0, 2.0) };
        let mut shapes = [-0.02, -0.01, 0.0, 0.03].map(stretched).to_vec();
        shapes[1] = shapes[1].iter().map(|p| turn.apply(p)).collect();
        let found = ShapeStatistics::of(&shapes).unwrap();
        assert!(found.shares[0] > 0.999, "{:?}", found.shares);
        let scores: Vec<f64> = found.scores.iter().map(|s| s[0]).collect();
        let ratio = (scores[3] - scores[0]) / (scores[1] - scores[0]);
        assert!((ratio - 5.0).abs() < 0.05, "{scores:?}");
        let variance: f64 = scores.iter().map(|s| s * s).sum::<f64>() / 3.0;
        assert!((variance - 1.0).abs() < 1e-9);
        let length = |shape: &[Vec3]| (shape[1] - shape[0]).norm();
        let reached = length(&found.along(0, scores[3]));
        assert!((reached - 3.09).abs() < 1e-3, "{reached}");
        assert!(ShapeStatistics::of(&shapes[..1]).is_err());
    }
}
