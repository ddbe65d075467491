//! One trial step: strain, shape in equilibrium, objective.

use crate::error::Result;
use crate::fem::{Chart, Equilibrium, EquilibriumOptions, Outcome, PlasticState, RigidMotion};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::symmetric3::{eigen, exp, log, to_matrix};
use crate::math::{Mat3, Sym3, Vec3};

use super::earlier::State;
use super::gauss_newton::Direction;
use super::linearization::Linearization;
use super::objective::{Evaluation, Objective, Shape};

/// Largest change of a tet's logarithmic strain in one step.
const MAX_STRAIN_STEP: f64 = 0.9;

/// Newton steps and residual (relative to E l^2) of a trial's static solve.
const STATICS: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-7, max_steps: 15 };

/// A trial is given up when its objective, one Newton step from equilibrium, is this many times
/// what it was.
const HOPELESS: f64 = 1.3;

/// Where a trial starts.
pub struct Origin<'a> {
    pub at: &'a Evaluation,
    pub linearized: &'a Linearization<'a, InversionBarrier<StableNeoHookean>>,
}

/// A shape that a trial led to.
pub struct Candidate {
    pub shape: Shape,
    /// The objective at the origin's weights.
    pub majorizer: f64,
}

/// What a trial led to.
pub struct Trial {
    /// `None` where no equilibrium was found or the search for it was given up.
    pub candidate: Option<Candidate>,
    /// Newton steps taken.
    pub newton_steps: usize,
}

impl Objective<'_> {
    /// Takes `eta` times a direction.
    pub fn trial(&self, from: &Origin, direction: &Direction, eta: f64) -> Result<Trial> {
        let Origin { at, linearized } = from;
        let state = &at.shape.state;
        let s: Vec<Sym3> = state.s.iter().zip(&direction.ds).map(|(s, ds)| s + ds * eta).collect();
        let plastic = self.plastic(&s);
        let prior = self.prior(&s);
        let rigid =
            direction.rigid.map(|modes| RigidMotion::new(&(modes * eta), linearized.center));
        let predicted = self.predict(&state.x, &direction.dx, eta, rigid.as_ref(), &plastic);
        let (body, data) = (&self.scene.body, &self.scene.data);
        let evaluate = |x: &[Vec3]| {
            let correspondences = data.correspondences(x);
            let majorizer = data.rows(x, &correspondences, &at.data.weights).energy() + prior;
            (correspondences, majorizer)
        };
        let hopeless = |x: &[Vec3]| evaluate(x).1 > HOPELESS * at.majorizer;
        let Equilibrium { x, outcome, steps } =
            body.equilibrate_near(predicted, &plastic, &STATICS, &linearized.single, &hopeless)?;
        let candidate = (outcome == Outcome::Converged).then(|| {
            let (correspondences, majorizer) = evaluate(&x);
            Candidate { shape: Shape { state: State { s, x }, correspondences }, majorizer }
        });
        Ok(Trial { candidate, newton_steps: steps })
    }

    /// First-order guess of the shape after a step, held back where it would invert a tet.
    fn predict(
        &self,
        x: &[Vec3],
        dx: &[Vec3],
        eta: f64,
        rigid: Option<&RigidMotion>,
        plastic: &[PlasticState],
    ) -> Vec<Vec3> {
        let mut share = eta;
        loop {
            let moved = x.iter().zip(dx).map(|(x, dx)| x + dx * share);
            let guess: Vec<Vec3> =
                moved.map(|x| rigid.map_or(x, |motion| motion.apply(&x))).collect();
            if share == 0.0 || self.scene.body.energy(&guess, plastic).is_finite() {
                return guess;
            }
            share = if share < 0.1 * eta { 0.0 } else { 0.5 * share };
        }
    }

    /// Keeps the strain of every carrier from changing too much at once and, where the field is Fp
    /// itself, from coming near to singular.
    pub fn largest_step(&self, s: &[Sym3], direction: &Direction) -> f64 {
        let limit = |(s, ds): (&Sym3, &Sym3)| match self.formulation.space.chart {
            Chart::Logarithm => MAX_STRAIN_STEP / to_matrix(ds).norm().max(f64::MIN_POSITIVE),
            Chart::Matrix => to_boundary(&to_matrix(s), &to_matrix(ds)),
        };
        s.iter().zip(&direction.ds).map(limit).fold(1.0, f64::min)
    }
}

/// How far along `step` the matrix `fp` may go: 60 % of the way to a zero eigenvalue, and at most
/// 1.2 times its own size.
fn to_boundary(fp: &Mat3, step: &Mat3) -> f64 {
    let root = exp(&(log(fp) * -0.5));
    let (relative, _) = eigen(&(root * step * root));
    let inward = 0.6 / (-relative.min()).max(f64::MIN_POSITIVE);
    inward.min(1.2 / relative.max().max(f64::MIN_POSITIVE))
}
