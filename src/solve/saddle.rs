//! The dual system of a damped least-squares problem with free directions.

use faer::Mat;

use super::dense::DenseCholesky;
use crate::error::Result;

/// Relative size of the shift that makes a rank-deficient Schur complement solvable.
const SCHUR_SHIFT: f64 = 1e-12;

/// Share of its trace by which H^T H may be off when its products were rounded to single precision.
const ROUNDING: f64 = f32::EPSILON as f64;

/// The matrix [ I + share H^T H, P; P^T, 0 ], for any share.
pub struct SaddleSystem {
    /// H^T H in the lower triangle.
    gram: Mat<f64>,
    /// P, one column each.
    free: Vec<Vec<f64>>,
}

/// Its factor for one share.
pub struct SaddleFactor<'a> {
    free: &'a [Vec<f64>],
    capacity: DenseCholesky,
    /// (I + share H^T H)^-1 P.
    solved: Mat<f64>,
    /// P^T (I + share H^T H)^-1 P.
    schur: Option<DenseCholesky>,
}

impl SaddleSystem {
    /// From H^T H in its lower triangle and the columns of P.
    pub fn new(gram: Mat<f64>, free: Vec<Vec<f64>>) -> Self {
        Self { gram, free }
    }

    /// Number of columns of P.
    pub fn free_count(&self) -> usize {
        self.free.len()
    }

    /// Factors. Where the rounding of H^T H outweighs the identity, it is shifted by as much; what that
    /// costs the solution, corrections find.
    pub fn factor(&self, share: f64) -> Result<SaddleFactor<'_>> {
        let (q, p) = (self.gram.nrows(), self.free.len());
        let shifted = |shift: f64| {
            let diagonal = |i, j| if i == j { 1.0 + shift } else { 0.0 };
            DenseCholesky::new(Mat::from_fn(q, q, |i, j| {
                share * self.gram[(i, j)] + diagonal(i, j)
            }))
        };
        let trace: f64 = (0..q).map(|i| self.gram[(i, i)]).sum();
        let capacity = shifted(0.0).or_else(|_| shifted(share * ROUNDING * trace))?;
        let mut solved = Mat::from_fn(q, p, |i, j| self.free[j][i]);
        capacity.solve(solved.as_mut());
        let mut schur = Mat::from_fn(p, p, |j, k| {
            (0..q).map(|i| self.free[j][i] * solved[(i, k)]).sum::<f64>()
        });
        for j in 0..p {
            schur[(j, j)] *= 1.0 + SCHUR_SHIFT;
            schur[(j, j)] += f64::MIN_POSITIVE;
        }
        let schur = if p == 0 { None } else { Some(DenseCholesky::new(schur)?) };
        Ok(SaddleFactor { free: &self.free, capacity, solved, schur })
    }
}

impl SaddleFactor<'_> {
    /// a and y with (I + share H^T H) a + P y = d, P^T a = h.
    pub fn solve(&self, d: &[f64], h: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let q = d.len();
        let mut a = Mat::from_fn(q, 1, |i, _| d[i]);
        self.capacity.solve(a.as_mut());
        let mut y = Mat::from_fn(h.len(), 1, |j, _| {
            (0..q).map(|i| self.free[j][i] * a[(i, 0)]).sum::<f64>() - h[j]
        });
        if let Some(schur) = &self.schur {
            schur.solve(y.as_mut());
        }
        let y: Vec<f64> = (0..h.len()).map(|j| y[(j, 0)]).collect();
        let taken = |i: usize| (0..y.len()).map(|j| self.solved[(i, j)] * y[j]).sum::<f64>();
        ((0..q).map(|i| a[(i, 0)] - taken(i)).collect(), y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_rounding_made_indefinite_is_still_solved() {
        let gram = Mat::from_fn(2, 2, |i, j| if (i, j) == (1, 1) { 1e8 - 5.0 } else { 1e8 });
        let system = SaddleSystem::new(gram, Vec::new());
        let (a, _) = system.factor(1.0).unwrap().solve(&[1e8, 1e8], &[]);
        assert!((a[0] + a[1] - 1.0).abs() < 1e-6, "{a:?}");
    }
}
