//! The outer loop: correspond, linearise, step, until the markers are met.

use std::sync::Arc;

use crate::error::Result;
use crate::fem::{EquilibriumOptions, PlasticState, StrainSmoothness, StrainSpace};
use crate::math::{Mat3, Sym3, Vec3};
use crate::run::Run;

use super::affine_start::affine_start;
use super::damping::Damping;
use super::earlier::{Earlier, State};
use super::evidence::{Belief, Contact, Weights, rows};
use super::options::Options;
use super::problem::Problem;
use super::scene::Scene;
use super::summary::{IterationRecord, Stop, Summary};

/// The markers' weight starts at this share of its final value and grows by the factor below.
const FIRST_DATA_SCALE: f64 = 1e-4;
const DATA_SCALE_GROWTH: f64 = 8.0;

/// A free body's markers gain weight when the last step lowered the objective by less than this share.
/// Raising it sooner leaves them caught in wrong matches. A held body starts near and slides along
/// itself for as long as the markers are weak: there they gain weight with every step.
const LEVEL_DECREASE: f64 = 0.2;

/// After a smaller relative decrease at the full weight, no better step is a good end.
const SETTLING_DECREASE: f64 = 0.05;

/// Two relative decreases of the objective below this, one after the other, end the run.
const SMALL_DECREASE: f64 = 0.01;

/// Newton steps and residual (relative to E l^2) of the start, which may be far from equilibrium.
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
    /// For [`super::reshape_again`].
    pub(super) earlier: Arc<Earlier>,
}

/// One reshaping under way.
pub struct Solver<'a> {
    pub scene: Scene,
    pub space: StrainSpace,
    pub options: &'a Options,
    pub run: &'a Run,
    pub smoothness: Arc<StrainSmoothness>,
    pub anchor: Arc<Vec<Sym3>>,
    pub damping: Damping,
    pub summary: Summary,
    /// What each attachment's weight was multiplied by.
    pub attachment_gains: Vec<f64>,
}

/// Reshapes the template. A cancelled run returns its best shape so far.
pub fn reshape(problem: &Problem, options: &Options, run: &Run) -> Result<Reshaped> {
    problem.check()?;
    options.check()?;
    run.enter("preparing", 0.0);
    let (mut solver, state) = Solver::start(problem, options, run)?;
    let state = solver.minimize(state, FIRST_DATA_SCALE)?;
    let state = solver.reconsider_far_markers(state)?;
    let state = solver.pull_lagging_attachments(state)?;
    Ok(solver.finish(state, problem))
}

impl<'a> Solver<'a> {
    /// The first state: constant strain for a free body, statics for a held one.
    fn start(problem: &Problem, options: &'a Options, run: &'a Run) -> Result<(Self, State)> {
        let scene = Scene::new(problem, options, None)?;
        let space = strain_space(options);
        let carriers = space.carriers(scene.body.mesh.points.len(), scene.body.mesh.tets.len());
        let (strain, x) = if scene.body.is_free() {
            let start = affine_start(&scene);
            (start.strain, start.x)
        } else {
            (Sym3::zeros(), scene.body.mesh.points.clone())
        };
        let anchor = vec![space.from_logarithm(&strain); carriers];
        let screening = options.screening.unwrap_or_else(|| scene.default_screening(&x));
        let floor = |fraction: &f64| fraction.max(SMALLEST_TET_WEIGHT);
        let tet_weight: Vec<f64> =
            scene.numbering.tets(&problem.inside_fraction).iter().map(floor).collect();
        let smoothness = StrainSmoothness::new(
            &scene.body,
            &space,
            if options.paper { PAPER_SMOOTHNESS } else { options.smoothness },
            (screening.is_finite() && !options.paper).then_some(screening),
            &tet_weight,
        )?;
        let mut solver = Self {
            attachment_gains: vec![1.0; scene.attachments.len()],
            scene,
            space,
            options,
            run,
            smoothness: smoothness.into(),
            anchor: anchor.into(),
            damping: Damping::default(),
            summary: Summary::default(),
        };
        let s = solver.anchor.to_vec();
        let state = solver.equilibrium(s, x)?;
        Ok((solver, state))
    }

    /// The state of an earlier run.
    pub(super) fn again(
        problem: &Problem,
        earlier: &'a Earlier,
        run: &'a Run,
    ) -> Result<(Self, State)> {
        let options = &earlier.options;
        let mut solver = Self {
            attachment_gains: vec![1.0; problem.attachments.len()],
            scene: Scene::new(problem, options, Some(earlier))?,
            space: strain_space(options),
            options,
            run,
            smoothness: earlier.smoothness.clone(),
            anchor: earlier.anchor.clone(),
            damping: Damping::default(),
            summary: Summary::default(),
        };
        solver.keep_attachment_gains(&earlier.attachment_gains);
        let State { s, x } = earlier.state.clone();
        let state = solver.equilibrium(s, x)?;
        Ok((solver, state))
    }

    /// The shape in equilibrium with the strain `s`, from a shape near by.
    fn equilibrium(&mut self, s: Vec<Sym3>, x: Vec<Vec3>) -> Result<State> {
        let plastic = self.plastic(&s);
        let equilibrium = self.scene.body.equilibrate(x, &plastic, &START)?;
        self.summary.newton_steps += equilibrium.steps;
        Ok(State { s, x: equilibrium.x })
    }

    /// Gauss-Newton with the markers' weight growing from a share of it, until nothing is gained.
    pub(super) fn minimize(&mut self, mut state: State, mut scale: f64) -> Result<State> {
        let mut small_decreases = 0;
        // Whether the last step, at the full weight, gained little: where markers change their
        // matches, the objective has kinks, and then no better step is no fault.
        let mut settling = scale >= 1.0;
        loop {
            let belief = Belief { scale, robust: true };
            self.record(&state, belief);
            if let Some(stop) = self.interruption() {
                self.summary.stop = stop;
                return Ok(state);
            }
            let accepted = self.step(&state, belief)?;
            let decrease = accepted.as_ref().map(|(_, decrease)| *decrease);
            if let Some((next, _)) = accepted {
                state = next;
            }
            let small = decrease.unwrap_or(0.0) < SMALL_DECREASE;
            small_decreases = if small { small_decreases + 1 } else { 0 };
            if let Some(decrease) = decrease {
                settling = scale >= 1.0 && decrease < SETTLING_DECREASE;
            }
            if scale >= 1.0 && (small_decreases == 2 || decrease.is_none()) {
                self.record(&state, belief);
                self.summary.stop = self.verdict(settling);
                return Ok(state);
            }
            scale = self.next_data_scale(scale, decrease.unwrap_or(0.0));
        }
    }

    fn next_data_scale(&self, scale: f64, decrease: f64) -> f64 {
        if self.scene.markers.is_empty() {
            1.0
        } else if self.scene.body.is_free() && decrease >= LEVEL_DECREASE {
            scale
        } else {
            (scale * DATA_SCALE_GROWTH).min(1.0)
        }
    }

    /// Gauss-Newton at the full weight of the data, until a step gains less than the share `least`.
    pub(super) fn settle(&mut self, mut state: State, least: f64) -> Result<State> {
        loop {
            self.record(&state, Belief::ROBUST);
            if let Some(stop) = self.interruption() {
                self.summary.stop = stop;
                return Ok(state);
            }
            let accepted = self.step(&state, Belief::ROBUST)?;
            let decrease = accepted.as_ref().map(|(_, decrease)| *decrease);
            if let Some((next, _)) = accepted {
                state = next;
            }
            if decrease.is_none_or(|decrease| decrease < least) {
                self.record(&state, Belief::ROBUST);
                // A settled start has no better step, and that is no fault.
                self.summary.stop = self.verdict(true);
                return Ok(state);
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

    /// What the data say about the shape `x`.
    pub fn data(&self, x: &[Vec3], weights: &Weights) -> f64 {
        rows(&self.scene, &Contact::new(&self.scene, x), weights, x).energy()
    }

    pub fn prior(&self, s: &[Sym3]) -> f64 {
        let u: Vec<Sym3> = s.iter().zip(self.anchor.iter()).map(|(s, a)| s - a).collect();
        self.smoothness.energy(&u)
    }

    pub fn plastic(&self, s: &[Sym3]) -> Vec<PlasticState> {
        self.space.states(s, &self.scene.body.mesh.tets)
    }

    /// Fp of every tet.
    fn plastic_strain(&self, s: &[Sym3]) -> Vec<Mat3> {
        let tets = self.scene.body.mesh.tets.iter().enumerate();
        tets.map(|(t, tet)| self.space.plastic_strain(s, t, tet)).collect()
    }

    /// Notes where the run stands and tells those who watch.
    pub(super) fn record(&mut self, state: &State, belief: Belief) {
        let contact = Contact::new(&self.scene, &state.x);
        let distances = contact.distances();
        let mean =
            distances.iter().sum::<f64>() / distances.len().max(1) as f64 * self.scene.length;
        let max = distances.iter().copied().fold(0.0, f64::max) * self.scene.length;
        let weights =
            Weights::new(&self.scene, &contact, &state.x, belief, self.options.hard_attachments);
        let data = rows(&self.scene, &contact, &weights, &state.x).energy();
        let record = IterationRecord {
            data_scale: belief.scale,
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
    pub(super) fn interruption(&self) -> Option<Stop> {
        if self.run.is_cancelled() {
            return Some(Stop::Cancelled);
        }
        (self.summary.iterations.len() > self.options.max_iterations)
            .then_some(Stop::IterationLimit)
    }

    pub(super) fn finish(self, state: State, problem: &Problem) -> Reshaped {
        let tet_points = self.scene.outward(&state.x);
        Reshaped {
            surface_points: self.scene.embedding.apply(&tet_points),
            tet_points: self.scene.numbering.restore(&tet_points),
            plastic_strain: self.scene.numbering.restore_tets(&self.plastic_strain(&state.s)),
            summary: self.summary,
            earlier: Arc::new(Earlier {
                options: self.options.clone(),
                rest_surface: problem.surface.points.clone(),
                rest_tets: problem.tets.clone(),
                numbering: self.scene.numbering,
                body: self.scene.body,
                smoothness: self.smoothness,
                anchor: self.anchor,
                state,
                attachment_gains: self.attachment_gains,
            }),
        }
    }
}

fn strain_space(options: &Options) -> StrainSpace {
    if options.paper { StrainSpace::PAPER } else { StrainSpace::NODAL_LOGARITHM }
}

/// Smallest share of a tet's volume that counts for the smoothness: nearly empty boundary tets
/// of a lattice would otherwise be free to invert.
const SMALLEST_TET_WEIGHT: f64 = 0.1;

/// Weight of the graph Laplacian in the published formulation.
const PAPER_SMOOTHNESS: f64 = 1.0;
