//! Damped Gauss-Newton directions for the plastic strain, in the dual form.
//!
//! At an equilibrium (x, s) with rows r = sqrt(c) (A x + b) the step ds, xi minimises
//!
//!   1/2 u^T R u + lambda/2 ds^T R ds + 1/2 |Z ds + P xi + r|^2,   u = s - anchor + ds,
//!
//! Z = sqrt(c) A J, K J = -G ([W] Eqs. 8-11). Instead of the indefinite Woodbury update of
//! [W] Eq. 13 we solve the equivalent positive definite "smoothing spline" system
//!
//!   [ I + share H^T H   P ] [a]   [d]        H^T H = Z R^+ Z^T,     share = 1 / (1 + lambda),
//!   [ P^T               0 ] [y] = [0]        P = [Z N, rigid modes],
//!
//! whose size is the number of rows, not of strains. N are the strains that R leaves free; the rigid
//! modes of a free body are six more unknowns, so that no polar decomposition is constrained
//! ([W] Eqs. 19-24 are not needed). The damping lambda (Levenberg, Marquardt) holds back what the
//! data hardly determine; H does not depend on it. docs/papers.md has the derivation.
//!
//! With more rows than such a system can have, it stands for a few representatives of them and
//! preconditions conjugate gradients on the normal equations of all rows.

use nalgebra::Vector6;

use super::linearization::Linearization;
use super::rows::Rows;
use crate::error::Result;
use crate::fem::StrainSmoothness;
use crate::material::IsotropicDensity;
use crate::math::Sym3;
use crate::solve::{SaddleFactor, SaddleSystem};

/// Conjugate gradients' steps at most; the sum so far is a direction of descent at any time.
const MAX_STEPS: usize = 40;

/// A change of the plastic strain and, for a free body, a rigid motion (translation, rotation
/// vector about the linearization's centre).
#[derive(Clone, Debug)]
pub struct Direction {
    /// Change of the six numbers of each carrier.
    pub ds: Vec<Sym3>,
    /// Rigid motion, for free bodies.
    pub rigid: Option<Vector6<f64>>,
}

/// Rows that stand for all where these are too many.
#[derive(Clone, Copy)]
pub struct Representatives<'a> {
    /// The rows.
    pub rows: &'a Rows,
    /// Conjugate gradients end when the error, in the preconditioner's norm, has fallen to this share.
    pub reduction: f64,
}

/// The normal equations of one linearization, for any damping.
pub struct NormalEquations<'a, M> {
    at: &'a Linearization<'a, M>,
    rows: &'a Rows,
    representatives: Option<Representatives<'a>>,
    smoothness: &'a StrainSmoothness,
    system: SaddleSystem,
}

impl<'a, M: IsotropicDensity> NormalEquations<'a, M> {
    /// With `representatives`, for too many rows to be solved directly.
    pub fn new(
        at: &'a Linearization<'a, M>,
        rows: &'a Rows,
        representatives: Option<Representatives<'a>>,
        smoothness: &'a StrainSmoothness,
    ) -> Self {
        let few = representatives.map_or(rows, |r| r.rows);
        let (half, constants) = at.half_inverse(few, smoothness);
        let mut free = Vec::new();
        if smoothness.is_singular() {
            free.extend((0..6).map(|p| constants.iter().map(|c| c[p]).collect()));
        }
        if at.body.is_free() {
            free.extend(at.rigid_columns(few));
        }
        let system = SaddleSystem::new(&half, free);
        Self { at, rows, representatives, smoothness, system }
    }

    /// The direction at strain `s` with the prior about `anchor`.
    pub fn direction(&self, s: &[Sym3], anchor: &[Sym3], damping: f64) -> Result<Direction> {
        let offset: Vec<Sym3> = s.iter().zip(anchor).map(|(s, a)| s - a).collect();
        let share = 1.0 / (1.0 + damping);
        let saddle = self.system.factor(share)?;
        Ok(match self.representatives {
            None => self.dual_direction(&saddle, &offset, share),
            Some(few) => self.iterated_direction(&saddle, few, &offset, share),
        })
    }

    /// The objective that the linearization promises for a step.
    pub fn promise(&self, s: &[Sym3], anchor: &[Sym3], direction: &Direction) -> f64 {
        let u: Vec<Sym3> =
            s.iter().zip(anchor).zip(&direction.ds).map(|((s, a), ds)| s - a + ds).collect();
        let change = self.measured(direction);
        let data = self.rows.residuals().into_iter().zip(change).map(|(r, z)| (r + z) * (r + z));
        self.smoothness.energy(&u) + 0.5 * data.sum::<f64>()
    }

    /// In closed form: with v = ds + share (s - anchor), v = share R^+ Z^T a + N y.
    fn dual_direction(&self, saddle: &SaddleFactor, offset: &[Sym3], share: f64) -> Direction {
        let kept: Vec<Sym3> = offset.iter().map(|o| o * share).collect();
        let before = self.rows.measure(&self.at.shape_change(&kept));
        let d: Vec<f64> = before.iter().zip(self.rows.residuals()).map(|(z, r)| z - r).collect();
        let (a, y) = saddle.solve(&d, &vec![0.0; self.system.free_count()]);
        let mut v = self.smoothness.solve(&self.at.transpose_multiply(self.rows, &a));
        for v in &mut v {
            *v *= share;
        }
        let rigid = self.add_free(&mut v, &y);
        Direction { ds: v.iter().zip(&kept).map(|(v, k)| v - k).collect(), rigid }
    }

    /// By conjugate gradients on ((1 + lambda) R + Z^T Z) ds + Z^T P xi = force, P^T (Z ds + P xi) = h.
    fn iterated_direction(
        &self,
        saddle: &SaddleFactor,
        few: Representatives,
        offset: &[Sym3],
        share: f64,
    ) -> Direction {
        let residuals = self.rows.residuals();
        let mut r = self.adjoint(&residuals).minus_of(&self.smoothness.apply(offset));
        let mut z = self.precondition(saddle, few.rows, &r, share);
        let mut p = z.clone();
        let mut sum = z.clone().times(0.0);
        let mut rz = r.dot(&z);
        let goal = few.reduction * few.reduction * rz;
        for _ in 0..MAX_STEPS {
            let ap = self.multiply(&p, share);
            let alpha = rz / p.dot(&ap);
            sum.add(alpha, &p);
            r.add(-alpha, &ap);
            z = self.precondition(saddle, few.rows, &r, share);
            let next = r.dot(&z);
            if next.is_nan() || next <= goal {
                break;
            }
            p = p.times(next / rz);
            p.add(1.0, &z);
            rz = next;
        }
        sum
    }

    /// The matrix of the normal equations times a direction.
    fn multiply(&self, p: &Direction, share: f64) -> Direction {
        let mut product = self.adjoint(&self.measured(p));
        for (product, prior) in product.ds.iter_mut().zip(self.smoothness.apply(&p.ds)) {
            *product += prior / share;
        }
        product
    }

    /// Z ds + P xi, of all rows.
    fn measured(&self, p: &Direction) -> Vec<f64> {
        let mut change = self.rows.measure(&self.at.shape_change(&p.ds));
        if let Some(rigid) = &p.rigid {
            for (column, xi) in self.at.rigid_columns(self.rows).iter().zip(rigid) {
                change.iter_mut().zip(column).for_each(|(z, c)| *z += c * xi);
            }
        }
        change
    }

    /// [Z, P]^T a, of all rows.
    fn adjoint(&self, a: &[f64]) -> Direction {
        let rigid = self.at.body.is_free().then(|| {
            let columns = self.at.rigid_columns(self.rows);
            Vector6::from_fn(|k, _| columns[k].iter().zip(a).map(|(c, a)| c * a).sum())
        });
        Direction { ds: self.at.transpose_multiply(self.rows, a), rigid }
    }

    /// The direction that the representatives answer `force` with:
    /// u = share R^+ (f - Z^T w) + N y, (I + share H^T H) w - P y = share Z R^+ f, P^T w = h.
    fn precondition(
        &self,
        saddle: &SaddleFactor,
        few: &Rows,
        force: &Direction,
        share: f64,
    ) -> Direction {
        let mut h: Vec<f64> = Vec::new();
        if self.smoothness.is_singular() {
            h.extend(force.ds.iter().sum::<Sym3>().iter());
        }
        h.extend(force.rigid.iter().flat_map(|rigid| rigid.iter().copied()));
        let mut u = self.smoothness.solve(&force.ds);
        for u in &mut u {
            *u *= share;
        }
        let (w, y) = saddle.solve(&few.measure(&self.at.shape_change(&u)), &h);
        let back = self.smoothness.solve(&self.at.transpose_multiply(few, &w));
        u.iter_mut().zip(back).for_each(|(u, back)| *u -= back * share);
        let y: Vec<f64> = y.iter().map(|y| -y).collect();
        let rigid = self.add_free(&mut u, &y);
        Direction { ds: u, rigid }
    }

    /// Adds the constant strains among the free unknowns to `u`; the others are the rigid motion.
    fn add_free(&self, u: &mut [Sym3], free: &[f64]) -> Option<Vector6<f64>> {
        let constants = if self.smoothness.is_singular() { 6 } else { 0 };
        if constants > 0 {
            let constant = Sym3::from_column_slice(&free[..constants]);
            for u in u.iter_mut() {
                *u += constant;
            }
        }
        self.at.body.is_free().then(|| Vector6::from_column_slice(&free[constants..]))
    }
}

impl Direction {
    fn dot(&self, other: &Self) -> f64 {
        let rigid = self.rigid.iter().zip(&other.rigid).map(|(a, b)| a.dot(b));
        self.ds.iter().zip(&other.ds).map(|(a, b)| a.dot(b)).chain(rigid).sum()
    }

    fn times(mut self, factor: f64) -> Self {
        for ds in &mut self.ds {
            *ds *= factor;
        }
        self.rigid = self.rigid.map(|rigid| rigid * factor);
        self
    }

    /// self += factor other
    fn add(&mut self, factor: f64, other: &Self) {
        self.ds.iter_mut().zip(&other.ds).for_each(|(a, b)| *a += b * factor);
        if let (Some(a), Some(b)) = (&mut self.rigid, &other.rigid) {
            *a += b * factor;
        }
    }

    /// -(self + prior)
    fn minus_of(mut self, prior: &[Sym3]) -> Self {
        self.ds.iter_mut().zip(prior).for_each(|(a, b)| *a += b);
        self.times(-1.0)
    }
}
