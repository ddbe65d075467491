//! One Gauss-Newton direction for the plastic strain, in the dual form.
//!
//! At an equilibrium (x, s) with rows r = sqrt(c) (A x + b) the step minimises
//!
//!   1/2 u^T R u + 1/2 |Z u + P xi - d|^2,   u = s + ds - anchor,   d = Z (s - anchor) - r,
//!
//! Z = sqrt(c) A J, K J = -G ([W] Eqs. 8-11). Instead of the indefinite Woodbury update of
//! [W] Eq. 13 we solve the equivalent positive definite "smoothing spline" system
//!
//!   [ I + H^T H   P ] [a]   [d]        H^T H = Z R^+ Z^T,
//!   [ P^T         0 ] [y] = [0]        P = [Z N, rigid modes],
//!
//! whose size is the number of rows, not of strains; u = R^+ Z^T a + N y. N are the strains that
//! R leaves free; the rigid modes of a free body are six more unknowns, so that no polar
//! decomposition is constrained ([W] Eqs. 19-24 are not needed). docs/papers.md has the derivation.

use faer::Mat;
use nalgebra::Vector6;
use rayon::prelude::*;

use crate::error::Result;
use crate::fem::{Body, MaterialPoint, Sensitivity, StrainSmoothness, rigid_modes, solve_vectors};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{ColumnBlocks, DenseCholesky, Factor};

/// Relative size of the shift that makes a rank-deficient Schur complement solvable.
const SCHUR_SHIFT: f64 = 1e-12;

/// A set of weighted residuals sqrt(weight) direction . (point - target).
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Points of the body that rows refer to.
    pub points: Vec<MaterialPoint>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// One scalar residual.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index into the points.
    pub point: usize,
    /// Direction in which the residual is measured (unit length).
    pub direction: Vec3,
    /// direction . (point - target) at the present shape.
    pub residual: f64,
    /// c = 1 / sigma^2.
    pub weight: f64,
}

/// What the direction is computed at.
pub struct Linearization<'a, M> {
    /// The body.
    pub body: &'a Body<M>,
    /// Factor of its stiffness at `x`.
    pub stiffness: &'a Factor,
    /// d(gradient)/ds at `x`.
    pub sensitivity: &'a Sensitivity,
    /// Vertex positions.
    pub x: &'a [Vec3],
    /// Centre of the rigid motions.
    pub center: Vec3,
}

/// A change of the plastic strain and, for a free body, a rigid motion (translation, rotation
/// vector about the linearization's centre).
#[derive(Clone, Debug)]
pub struct Direction {
    /// Change of the six numbers of each carrier.
    pub ds: Vec<Sym3>,
    /// Rigid motion, for free bodies.
    pub rigid: Option<Vector6<f64>>,
}

impl Rows {
    /// Adds the rows of one point.
    pub fn add(&mut self, point: MaterialPoint, rows: impl IntoIterator<Item = (Vec3, f64, f64)>) {
        let index = self.points.len();
        self.points.push(point);
        self.rows.extend(rows.into_iter().map(|(direction, residual, weight)| Row {
            point: index,
            direction,
            residual,
            weight,
        }));
    }

    /// 1/2 sum c residual^2.
    pub fn energy(&self) -> f64 {
        0.5 * self.rows.iter().map(|r| r.weight * r.residual * r.residual).sum::<f64>()
    }

    /// sqrt(c) direction . field(point), per row.
    pub(super) fn measure(&self, field: &[Vec3]) -> Vec<f64> {
        self.rows
            .iter()
            .map(|r| r.weight.sqrt() * r.direction.dot(&self.points[r.point].position(field)))
            .collect()
    }

    /// sum over rows of a sqrt(c) direction, spread to the vertices.
    fn spread(&self, a: &[f64], vertices: usize) -> Vec<Vec3> {
        let mut field = vec![Vec3::zeros(); vertices];
        for (row, a) in self.rows.iter().zip(a) {
            let force = row.direction * (row.weight.sqrt() * a);
            for &(v, w) in &self.points[row.point].0 {
                field[v as usize] += force * w;
            }
        }
        field
    }
}

impl<M: IsotropicDensity> Linearization<'_, M> {
    /// J ds = -K^-1 G ds: how the shape answers a change of strain, to first order.
    pub fn shape_change(&self, ds: &[Sym3]) -> Vec<Vec3> {
        let forces = self.sensitivity.multiply(ds);
        solve_vectors(self.stiffness, &forces).into_iter().map(|x| -x).collect()
    }

    /// The Gauss-Newton direction at strain `s` with prior `smoothness` about `anchor`.
    pub fn direction(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
        s: &[Sym3],
        anchor: &[Sym3],
    ) -> Result<Direction> {
        let offset: Vec<Sym3> = s.iter().zip(anchor).map(|(s, a)| s - a).collect();
        let d: Vec<f64> = rows
            .measure(&self.shape_change(&offset))
            .into_iter()
            .zip(&rows.rows)
            .map(|(z, row)| z - row.weight.sqrt() * row.residual)
            .collect();
        let (half, constants) = self.half_inverse(rows, smoothness);
        let free = self.free_columns(rows, smoothness, &constants);
        let (a, y) = solve_saddle(&half, &free, &d)?;
        let mut u = smoothness.solve(&self.transpose_multiply(rows, &a));
        let mut rigid = y.as_slice();
        if smoothness.is_singular() {
            let constant = Sym3::from_column_slice(&y[..6]);
            for u in &mut u {
                *u += constant;
            }
            rigid = &y[6..];
        }
        let ds = u.iter().zip(&offset).map(|(u, o)| u - o).collect();
        Ok(Direction { ds, rigid: self.body.is_free().then(|| Vector6::from_column_slice(rigid)) })
    }

    /// Z^T a = -G^T K^-1 A^T sqrt(c) a.
    pub(super) fn transpose_multiply(&self, rows: &Rows, a: &[f64]) -> Vec<Sym3> {
        let y = solve_vectors(self.stiffness, &rows.spread(a, self.x.len()));
        let flat: Vec<f64> = y.iter().flat_map(|v| [-v.x, -v.y, -v.z]).collect();
        let mut z = vec![0.0; 6 * self.sensitivity.carriers()];
        self.sensitivity.transpose_multiply(&flat, 1, &mut z);
        z.chunks_exact(6).map(Sym3::from_column_slice).collect()
    }

    /// H with H^T H = Z R^+ Z^T in blocks of columns, one column per row of data, and the sums of
    /// Z^T over all carriers: Z times each constant strain.
    pub(super) fn half_inverse(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
    ) -> (ColumnBlocks, Vec<Vector6<f64>>) {
        let mut half = ColumnBlocks::zeros(6 * self.sensitivity.carriers(), rows.rows.len());
        let constants: Vec<Vec<Vector6<f64>>> = half
            .blocks
            .par_iter_mut()
            .zip(rows.rows.par_chunks(ColumnBlocks::WIDTH))
            .map_init(Vec::new, |y: &mut Vec<f64>, (z, part)| {
                let width = part.len();
                y.clear();
                y.resize(3 * self.x.len() * width, 0.0);
                for (c, row) in part.iter().enumerate() {
                    let scaled = row.direction * -row.weight.sqrt();
                    for &(v, w) in &rows.points[row.point].0 {
                        for axis in 0..3 {
                            y[(3 * v as usize + axis) * width + c] += scaled[axis] * w;
                        }
                    }
                }
                self.stiffness.solve_rows(y, width);
                self.sensitivity.transpose_multiply(y, width, z);
                let mut sums = vec![Vector6::zeros(); width];
                for carrier in z.chunks_exact(6 * width) {
                    for (p, row) in carrier.chunks_exact(width).enumerate() {
                        sums.iter_mut().zip(row).for_each(|(sum, z)| sum[p] += z);
                    }
                }
                smoothness.half_inverse(z, width);
                sums
            })
            .collect();
        (half, constants.into_iter().flatten().collect())
    }

    /// P: the directions that cost nothing, one column each.
    fn free_columns(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
        constants: &[Vector6<f64>],
    ) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        if smoothness.is_singular() {
            columns.extend((0..6).map(|p| constants.iter().map(|c| c[p]).collect()));
        }
        if self.body.is_free() {
            let modes: Vec<[Vec3; 6]> =
                self.x.iter().map(|x| rigid_modes(x, &self.center)).collect();
            for k in 0..6 {
                let field: Vec<Vec3> = modes.iter().map(|m| m[k]).collect();
                columns.push(rows.measure(&field));
            }
        }
        columns
    }
}

/// Solves (I + H^T H) a + P y = d, P^T a = 0.
fn solve_saddle(half: &ColumnBlocks, free: &[Vec<f64>], d: &[f64]) -> Result<(Vec<f64>, Vec<f64>)> {
    let q = d.len();
    let mut capacity = Mat::<f64>::identity(q, q);
    half.add_gram_lower(&mut capacity);
    let factor = DenseCholesky::new(capacity)?;
    let p = free.len();
    // Columns: C^-1 P, then C^-1 d.
    let mut solved = Mat::from_fn(q, p + 1, |i, j| if j < p { free[j][i] } else { d[i] });
    factor.solve(solved.as_mut());
    let mut y = vec![0.0; p];
    if p > 0 {
        let dot = |j: usize, k: usize| (0..q).map(|i| free[j][i] * solved[(i, k)]).sum::<f64>();
        let mut schur = Mat::from_fn(p, p, &dot);
        for j in 0..p {
            schur[(j, j)] *= 1.0 + SCHUR_SHIFT;
            schur[(j, j)] += f64::MIN_POSITIVE;
        }
        let mut right = Mat::from_fn(p, 1, |j, _| dot(j, p));
        DenseCholesky::new(schur)?.solve(right.as_mut());
        y = (0..p).map(|j| right[(j, 0)]).collect();
    }
    let a = (0..q)
        .map(|i| solved[(i, p)] - (0..p).map(|j| solved[(i, j)] * y[j]).sum::<f64>())
        .collect();
    Ok((a, y))
}
