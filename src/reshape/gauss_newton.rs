//! Damped Gauss-Newton directions for the plastic strain, in the dual form.
//!
//! At an equilibrium (x, s) with rows r = sqrt(c) (A x + b) the step ds, xi minimises
//!
//!   1/2 u^T R u + lambda/2 ds^T R ds + 1/2 |Z ds + P xi + r|^2,   u = s + ds,
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
//! The system is made in single precision and what it misses is solved for again, in double precision.
//! With more rows than such a system can have, it stands for a few representatives of them and
//! preconditions conjugate gradients on the normal equations of all rows.

use nalgebra::Vector6;

use super::linearization::Linearization;
use super::rows::Rows;
use crate::error::Result;
use crate::fem::StrainSmoothness;
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{Goal, SaddleFactor, SaddleSystem, Unknowns, conjugate_gradients};

/// Steps of conjugate gradients at most; the sum so far is a direction of descent at any time.
const MAX_STEPS: usize = 40;

/// A change of the plastic strain and, for a free body, a rigid motion (translation, rotation
/// vector about the linearization's centre).
#[derive(Clone, Debug)]
pub struct Direction {
    /// Change of the six numbers of each carrier.
    pub ds: Vec<Sym3>,
    /// How the shape answers `ds`, to first order.
    pub dx: Vec<Vec3>,
    /// Rigid motion, for free bodies.
    pub rigid: Option<Vector6<f64>>,
}

/// Numbers for the unknowns: values, or what the equations say of them.
#[derive(Clone)]
struct Change {
    strain: Vec<Sym3>,
    rigid: Option<Vector6<f64>>,
}

/// The normal equations of one linearization, for any damping.
pub struct NormalEquations<'a, M> {
    at: &'a Linearization<'a, M>,
    rows: &'a Rows,
    representatives: Option<&'a Rows>,
    smoothness: &'a StrainSmoothness,
    system: SaddleSystem,
}

impl<'a, M: IsotropicDensity> NormalEquations<'a, M> {
    /// With `representatives` of rows that are too many to be solved directly.
    pub fn new(
        at: &'a Linearization<'a, M>,
        rows: &'a Rows,
        representatives: Option<&'a Rows>,
        smoothness: &'a StrainSmoothness,
    ) -> Self {
        let few = representatives.unwrap_or(rows);
        let (gram, constants) = at.prior_gram(few, smoothness);
        let mut free: Vec<Vec<f64>> = Vec::new();
        if smoothness.is_singular() {
            free.extend((0..6).map(|p| constants.iter().map(|c| c[p]).collect()));
        }
        if at.body.is_free() {
            free.extend(at.rigid_columns(few));
        }
        let system = SaddleSystem::new(gram, free);
        Self { at, rows, representatives, smoothness, system }
    }

    /// Whether directions are found by conjugate gradients over representatives.
    pub fn is_iterated(&self) -> bool {
        self.representatives.is_some()
    }

    /// The direction at strain `s`; its error, in the norm of the equations, is at most about the share
    /// `reduction`.
    pub fn direction(&self, s: &[Sym3], damping: f64, reduction: f64) -> Result<Direction> {
        let share = 1.0 / (1.0 + damping);
        let saddle = self.system.factor(share)?;
        Ok(match self.representatives {
            None => self.dual_direction(&saddle, s, share, reduction),
            Some(few) => {
                let sum = self.iterated_direction(&saddle, few, s, share, reduction);
                Direction {
                    dx: self.at.shape_change(&sum.strain),
                    ds: sum.strain,
                    rigid: sum.rigid,
                }
            }
        })
    }

    /// The objective that the linearization promises for a step.
    pub fn promise(&self, s: &[Sym3], direction: &Direction) -> f64 {
        let u: Vec<Sym3> = s.iter().zip(&direction.ds).map(|(s, ds)| s + ds).collect();
        let change = self.measured(&direction.dx, direction.rigid.as_ref());
        let data = self.rows.residuals().into_iter().zip(change).map(|(r, z)| (r + z) * (r + z));
        self.smoothness.energy(&u) + 0.5 * data.sum::<f64>()
    }

    /// In closed form: with v = ds + share s, v = share R^+ Z^T a + N y.
    fn dual_direction(
        &self,
        saddle: &SaddleFactor,
        s: &[Sym3],
        share: f64,
        reduction: f64,
    ) -> Direction {
        let ds: Vec<Sym3> = s.iter().map(|s| s * -share).collect();
        let dx = self.at.shape_change(&ds);
        let rigid = self.at.body.is_free().then(Vector6::zeros);
        let mut sum = Direction { ds, dx, rigid };
        let before = self.measured(&sum.dx, None);
        let mut missing: Vec<f64> =
            before.iter().zip(self.rows.residuals()).map(|(z, r)| -z - r).collect();
        let mut missing_free = vec![0.0; self.system.free_count()];
        let mut corrections = Corrections::new(reduction);
        for _ in 0..Corrections::MAX {
            let (a, y) = saddle.solve(&missing, &missing_free);
            if !corrections.is_needed(missing.iter().zip(&a).map(|(d, a)| d * a).sum()) {
                break;
            }
            let force = self.adjoint(&a);
            let mut strain = self.smoothness.solve(&force.strain);
            for v in &mut strain {
                *v *= share;
            }
            let rigid = self.add_free(&mut strain, &y);
            let dx = self.at.shape_change(&strain);
            let change = self.measured(&dx, rigid.as_ref());
            missing.iter_mut().zip(&a).zip(change).for_each(|((d, a), z)| *d -= a + z);
            missing_free.iter_mut().zip(self.free_part(&force)).for_each(|(h, f)| *h -= f);
            sum.ds.iter_mut().zip(&strain).for_each(|(sum, v)| *sum += v);
            sum.dx.iter_mut().zip(&dx).for_each(|(sum, dx)| *sum += dx);
            if let (Some(sum), Some(rigid)) = (&mut sum.rigid, rigid) {
                *sum += rigid;
            }
        }
        sum
    }

    /// By conjugate gradients on ((1 + lambda) R + Z^T Z) ds + Z^T P xi = force, P^T (Z ds + P xi) = h.
    fn iterated_direction(
        &self,
        saddle: &SaddleFactor,
        few: &Rows,
        s: &[Sym3],
        share: f64,
        reduction: f64,
    ) -> Change {
        let residuals = self.rows.residuals();
        let force = self.adjoint(&residuals).minus_of(&self.smoothness.apply(s));
        let precondition = |r: &Change| self.precondition(saddle, few, r, share);
        let goal = Goal { reduction, max_steps: MAX_STEPS };
        conjugate_gradients(|p| self.multiply(p, share), precondition, force, goal).x
    }

    /// The matrix of the normal equations times `p`.
    fn multiply(&self, p: &Change, share: f64) -> Change {
        let change = self.measured(&self.at.shape_change(&p.strain), p.rigid.as_ref());
        let mut product = self.adjoint(&change);
        for (product, prior) in product.strain.iter_mut().zip(self.smoothness.apply(&p.strain)) {
            *product += prior / share;
        }
        product
    }

    /// Z ds + P xi of all rows, for the shape's answer dx to ds.
    fn measured(&self, dx: &[Vec3], rigid: Option<&Vector6<f64>>) -> Vec<f64> {
        let mut change = self.rows.measure(dx);
        if let Some(rigid) = rigid {
            for (column, xi) in self.at.rigid_columns(self.rows).iter().zip(rigid) {
                change.iter_mut().zip(column).for_each(|(z, c)| *z += c * xi);
            }
        }
        change
    }

    /// [Z, P]^T a, of all rows.
    fn adjoint(&self, a: &[f64]) -> Change {
        let rigid = self.at.body.is_free().then(|| {
            let columns = self.at.rigid_columns(self.rows);
            Vector6::from_fn(|k, _| columns[k].iter().zip(a).map(|(c, a)| c * a).sum())
        });
        Change { strain: self.at.transpose_multiply(self.rows, a), rigid }
    }

    /// What a force says of the constant strains that R leaves free and of the rigid motion.
    fn free_part(&self, force: &Change) -> Vec<f64> {
        let mut h: Vec<f64> = Vec::new();
        if self.smoothness.is_singular() {
            h.extend(force.strain.iter().sum::<Sym3>().iter());
        }
        h.extend(force.rigid.iter().flat_map(|rigid| rigid.iter().copied()));
        h
    }

    /// The direction that the representatives answer `force` with:
    /// u = share R^+ (f - Z^T w) + N y, (I + share H^T H) w - P y = share Z R^+ f, P^T w = h.
    fn precondition(
        &self,
        saddle: &SaddleFactor,
        few: &Rows,
        force: &Change,
        share: f64,
    ) -> Change {
        let h = self.free_part(force);
        let mut u = self.smoothness.solve(&force.strain);
        for u in &mut u {
            *u *= share;
        }
        let (w, y) = saddle.solve(&few.measure(&self.at.shape_change(&u)), &h);
        let back = self.smoothness.solve(&self.at.transpose_multiply(few, &w));
        u.iter_mut().zip(back).for_each(|(u, back)| *u -= back * share);
        let y: Vec<f64> = y.iter().map(|y| -y).collect();
        let rigid = self.add_free(&mut u, &y);
        Change { strain: u, rigid }
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

/// Ends corrections that are made until the error is a share of what it was.
pub(super) struct Corrections {
    reduction: f64,
    /// The size of the error to be reached, and the last one.
    goal_and_last: Option<(f64, f64)>,
}

impl Corrections {
    /// At most this many; what was summed so far is a direction of descent at any time.
    pub const MAX: usize = 40;

    pub fn new(reduction: f64) -> Self {
        Self { reduction, goal_and_last: None }
    }

    /// Whether a correction of this size, squared in the norm of the equations, is to be added: the
    /// first is; later ones while they shrink and are above the goal.
    pub fn is_needed(&mut self, size: f64) -> bool {
        let Some((goal, last)) = self.goal_and_last else {
            self.goal_and_last = Some((self.reduction * self.reduction * size, size));
            return true;
        };
        self.goal_and_last = Some((goal, size));
        size > goal && size <= last
    }
}

impl Unknowns for Change {
    fn dot(&self, other: &Self) -> f64 {
        let rigid = self.rigid.iter().zip(&other.rigid).map(|(a, b)| a.dot(b));
        self.strain.iter().zip(&other.strain).map(|(a, b)| a.dot(b)).chain(rigid).sum()
    }

    fn add(&mut self, factor: f64, other: &Self) {
        self.strain.iter_mut().zip(&other.strain).for_each(|(a, b)| *a += b * factor);
        if let (Some(a), Some(b)) = (&mut self.rigid, &other.rigid) {
            *a += b * factor;
        }
    }

    fn scale(&mut self, factor: f64) {
        for s in &mut self.strain {
            *s *= factor;
        }
        if let Some(rigid) = &mut self.rigid {
            *rigid *= factor;
        }
    }
}

impl Change {
    /// -(self + prior)
    fn minus_of(mut self, prior: &[Sym3]) -> Self {
        self.strain.iter_mut().zip(prior).for_each(|(a, b)| *a += b);
        self.scale(-1.0);
        self
    }
}
