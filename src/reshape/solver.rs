//! The outer loop: correspond, linearise, step, until the markers are met.

use crate::error::Result;
use crate::fem::{
    Chart, Equilibrium, EquilibriumOptions, Outcome, PlasticState, RigidMotion, Sensitivity,
    StrainSmoothness, StrainSpace,
};
use crate::locate::ClosestPoints;
use crate::math::symmetric3::{eigen, exp, log, to_matrix};
use crate::math::{Mat3, Sym3, Vec3};
use crate::run::Run;

use super::affine_start::affine_start;
use super::evidence::{Contact, Weights, rows};
use super::gauss_newton::{Direction, Linearization};
use super::options::Options;
use super::problem::Problem;
use super::scene::Scene;
use super::summary::{IterationRecord, Stop, Summary};

/// Largest change of a tet's logarithmic strain in one step.
const MAX_STRAIN_STEP: f64 = 0.9;

/// The markers' weight starts at this share of its final value and grows by the factor below.
const FIRST_DATA_SCALE: f64 = 1e-4;
const DATA_SCALE_GROWTH: f64 = 4.0;

/// The markers' weight grows when the last step lowered the objective by less than this share.
/// Raising it sooner leaves markers caught in wrong matches.
const LEVEL_DECREASE: f64 = 0.2;

/// Two relative decreases of the objective below this, one after the other, end the run.
const SMALL_DECREASE: f64 = 0.01;

/// Step halvings before a direction is given up.
const MAX_HALVINGS: usize = 6;

/// Fraction of the predicted decrease that a step must achieve.
const ARMIJO: f64 = 1e-4;

/// Newton steps and residual (relative to E l^2) of a trial's static solve.
const TRIAL: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-7, max_steps: 15 };

/// The same for the start, which may be far from equilibrium.
const START: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-7, max_steps: 200 };

/// A reshaped template.
#[derive(Clone, Debug)]
pub struct Reshaped {
    /// The surface's vertices, in the template's order.
    pub surface_points: Vec<Vec3>,
    /// The tet mesh's vertices.
    pub tet_points: Vec<Vec3>,
    /// Plastic strain Fp of each tet (symmetric positive definite).
    pub plastic_strain: Vec<Mat3>,
    /// What happened.
    pub summary: Summary,
}

/// A plastic strain and the shape in equilibrium with it.
#[derive(Clone)]
struct State {
    s: Vec<Sym3>,
    x: Vec<Vec3>,
}

/// One reshaping under way.
struct Solver<'a> {
    scene: Scene,
    options: &'a Options,
    run: &'a Run,
    tree: ClosestPoints,
    space: StrainSpace,
    smoothness: StrainSmoothness,
    anchor: Vec<Sym3>,
    summary: Summary,
}

/// Reshapes the template. A cancelled run returns its best shape so far.
pub fn reshape(problem: &Problem, options: &Options, run: &Run) -> Result<Reshaped> {
    problem.check()?;
    options.check()?;
    run.enter("preparing", 0.0);
    let (mut solver, state) = Solver::start(problem, options, run)?;
    let state = solver.minimize(state)?;
    Ok(solver.finish(&state))
}

impl<'a> Solver<'a> {
    /// The first state: constant strain for a free body, statics for a held one.
    fn start(problem: &Problem, options: &'a Options, run: &'a Run) -> Result<(Self, State)> {
        let scene = Scene::new(problem, options)?;
        let mut tree =
            ClosestPoints::new(&scene.embedding.apply(&scene.body.mesh.points), &scene.triangles);
        let space = if options.paper { StrainSpace::PAPER } else { StrainSpace::NODAL_LOGARITHM };
        let carriers = space.carriers(scene.body.mesh.points.len(), scene.body.mesh.tets.len());
        let (strain, x) = if scene.body.is_free() {
            let start = affine_start(&scene, &mut tree);
            (start.strain, start.x)
        } else {
            (Sym3::zeros(), scene.body.mesh.points.clone())
        };
        let anchor = vec![space.from_logarithm(&strain); carriers];
        let screening = options.screening.unwrap_or_else(|| scene.default_screening(&x));
        let floor = |fraction: &f64| fraction.max(SMALLEST_TET_WEIGHT);
        let tet_weight: Vec<f64> = problem.inside_fraction.iter().map(floor).collect();
        let smoothness = StrainSmoothness::new(
            &scene.body,
            &space,
            if options.paper { PAPER_SMOOTHNESS } else { options.smoothness },
            (screening.is_finite() && !options.paper).then_some(screening),
            &tet_weight,
        )?;
        let mut solver = Self {
            scene,
            options,
            run,
            tree,
            space,
            smoothness,
            anchor,
            summary: Summary::default(),
        };
        let s = solver.anchor.clone();
        let plastic = solver.plastic(&s);
        let equilibrium = solver.scene.body.equilibrate(x, &plastic, &START)?;
        solver.summary.newton_steps += equilibrium.steps;
        Ok((solver, State { s, x: equilibrium.x }))
    }

    /// Gauss-Newton with a growing weight of the markers.
    fn minimize(&mut self, mut state: State) -> Result<State> {
        let (mut scale, mut small_decreases) = (FIRST_DATA_SCALE, 0);
        loop {
            self.record(&state, scale);
            if let Some(stop) = self.interruption() {
                self.summary.stop = stop;
                return Ok(state);
            }
            let accepted = self.step(&state, scale)?;
            let decrease = accepted.as_ref().map(|(_, decrease)| *decrease);
            if let Some((next, _)) = accepted {
                state = next;
            }
            let small = decrease.unwrap_or(0.0) < SMALL_DECREASE;
            small_decreases = if small { small_decreases + 1 } else { 0 };
            if scale >= 1.0 && (small_decreases == 2 || decrease.is_none()) {
                self.record(&state, scale);
                self.summary.stop = self.verdict(decrease.is_some());
                return Ok(state);
            }
            if decrease.unwrap_or(0.0) < LEVEL_DECREASE {
                scale = (scale * DATA_SCALE_GROWTH).min(1.0);
            }
        }
    }

    /// Why the iteration ended by itself.
    fn verdict(&self, stepped: bool) -> Stop {
        let tolerance = self.scene.marker_sigma * self.scene.length;
        let met =
            self.summary.iterations.last().is_some_and(|r| r.max_marker_distance <= tolerance);
        match (met, stepped) {
            (true, _) => Stop::ToleranceMet,
            (false, true) => Stop::Settled,
            (false, false) => Stop::NoStep,
        }
    }

    /// One Gauss-Newton step; `None` when no step lowers the objective. With it the relative
    /// decrease.
    fn step(&mut self, state: &State, scale: f64) -> Result<Option<(State, f64)>> {
        let contact = Contact::new(&self.scene, &mut self.tree, &state.x);
        let weights =
            Weights::new(&self.scene, &contact, &state.x, scale, self.options.hard_attachments);
        let rows = rows(&self.scene, &contact, &weights, &state.x);
        let objective = rows.energy() + self.prior(&state.s);
        let plastic = self.plastic(&state.s);
        let stiffness = self.scene.body.factor_stiffness(&state.x, &plastic)?;
        let sensitivity = Sensitivity::new(&self.scene.body, &self.space, &state.x, &plastic);
        let center = state.x.iter().sum::<Vec3>() / state.x.len() as f64;
        let at = Linearization {
            body: &self.scene.body,
            stiffness: &stiffness,
            sensitivity: &sensitivity,
            x: &state.x,
            center,
        };
        let direction = if self.options.paper && !self.scene.body.is_free() {
            at.woodbury_direction(&rows, &self.smoothness, &state.s, &self.anchor)
        } else {
            at.direction(&rows, &self.smoothness, &state.s, &self.anchor)?
        };
        let dx = at.shape_change(&direction.ds);
        let mut eta = self.largest_step(&state.s, &direction);
        for _ in 0..MAX_HALVINGS {
            if self.run.is_cancelled() {
                return Ok(None);
            }
            if let Some(trial) = self.trial(state, &direction, &dx, eta, center)? {
                let value = self.objective(&trial, &weights);
                if value <= objective * (1.0 - ARMIJO * eta) {
                    return Ok(Some((trial, 1.0 - value / objective)));
                }
            }
            eta *= 0.5;
        }
        Ok(None)
    }

    /// The state a step of length `eta` leads to, if its equilibrium is found.
    fn trial(
        &mut self,
        state: &State,
        direction: &Direction,
        dx: &[Vec3],
        eta: f64,
        center: Vec3,
    ) -> Result<Option<State>> {
        let s: Vec<Sym3> = state.s.iter().zip(&direction.ds).map(|(s, ds)| s + ds * eta).collect();
        let plastic = self.plastic(&s);
        let rigid = direction.rigid.map(|modes| RigidMotion::new(&(modes * eta), center));
        let predicted = self.predict(&state.x, dx, eta, rigid.as_ref(), &plastic);
        let Equilibrium { x, outcome, steps } =
            self.scene.body.equilibrate(predicted, &plastic, &TRIAL)?;
        self.summary.newton_steps += steps;
        Ok((outcome == Outcome::Converged).then_some(State { s, x }))
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
    fn largest_step(&self, s: &[Sym3], direction: &Direction) -> f64 {
        let limit = |(s, ds): (&Sym3, &Sym3)| match self.space.chart {
            Chart::Logarithm => MAX_STRAIN_STEP / to_matrix(ds).norm().max(f64::MIN_POSITIVE),
            Chart::Matrix => to_boundary(&to_matrix(s), &to_matrix(ds)),
        };
        s.iter().zip(&direction.ds).map(limit).fold(1.0, f64::min)
    }

    fn objective(&mut self, state: &State, weights: &Weights) -> f64 {
        let contact = Contact::new(&self.scene, &mut self.tree, &state.x);
        rows(&self.scene, &contact, weights, &state.x).energy() + self.prior(&state.s)
    }

    fn prior(&self, s: &[Sym3]) -> f64 {
        let u: Vec<Sym3> = s.iter().zip(&self.anchor).map(|(s, a)| s - a).collect();
        self.smoothness.energy(&u)
    }

    fn plastic(&self, s: &[Sym3]) -> Vec<PlasticState> {
        self.space.states(s, &self.scene.body.mesh.tets)
    }

    /// Fp of every tet.
    fn plastic_strain(&self, s: &[Sym3]) -> Vec<Mat3> {
        let tets = self.scene.body.mesh.tets.iter().enumerate();
        tets.map(|(t, tet)| self.space.plastic_strain(s, t, tet)).collect()
    }

    /// Notes where the run stands and tells those who watch.
    fn record(&mut self, state: &State, scale: f64) {
        let contact = Contact::new(&self.scene, &mut self.tree, &state.x);
        let distances = contact.distances();
        let mean =
            distances.iter().sum::<f64>() / distances.len().max(1) as f64 * self.scene.length;
        let max = distances.iter().copied().fold(0.0, f64::max) * self.scene.length;
        let weights =
            Weights::new(&self.scene, &contact, &state.x, scale, self.options.hard_attachments);
        let data = rows(&self.scene, &contact, &weights, &state.x).energy();
        let record = IterationRecord {
            data_scale: scale,
            objective: data + self.prior(&state.s),
            mean_marker_distance: mean,
            max_marker_distance: max,
            newton_steps: self.summary.newton_steps,
            seconds: self.run.progress().seconds,
        };
        self.summary.iterations.push(record);
        let iteration = self.summary.iterations.len() - 1;
        self.run.update(|p| {
            p.iteration = iteration;
            p.energy = record.objective;
            p.mean_error = mean;
            p.max_error = max;
            p.fraction = 1.0 - 0.85_f64.powi(iteration as i32);
            "fitting".clone_into(&mut p.stage);
        });
        self.run.publish_preview(&self.scene.outward(&self.scene.embedding.apply(&state.x)));
    }

    /// Why to stop before the end, if so.
    fn interruption(&self) -> Option<Stop> {
        if self.run.is_cancelled() {
            return Some(Stop::Cancelled);
        }
        (self.summary.iterations.len() > self.options.max_iterations)
            .then_some(Stop::IterationLimit)
    }

    fn finish(self, state: &State) -> Reshaped {
        let tet_points = self.scene.outward(&state.x);
        Reshaped {
            surface_points: self.scene.embedding.apply(&tet_points),
            tet_points: self.scene.numbering.restore(&tet_points),
            plastic_strain: self.plastic_strain(&state.s),
            summary: self.summary,
        }
    }
}

/// Smallest share of a tet's volume that counts for the smoothness: nearly empty boundary tets
/// of a lattice would otherwise be free to invert.
const SMALLEST_TET_WEIGHT: f64 = 0.1;

/// Weight of the graph Laplacian in the published formulation.
const PAPER_SMOOTHNESS: f64 = 1.0;

/// How far along `step` the matrix `fp` may go: 60 % of the way to a zero eigenvalue, and at most
/// 1.2 times its own size.
fn to_boundary(fp: &Mat3, step: &Mat3) -> f64 {
    let root = exp(&(log(fp) * -0.5));
    let (relative, _) = eigen(&(root * step * root));
    let inward = 0.6 / (-relative.min()).max(f64::MIN_POSITIVE);
    inward.min(1.2 / relative.max().max(f64::MIN_POSITIVE))
}
