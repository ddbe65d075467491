//! The algorithm: correspond, linearise, step, until the markers are met.

use std::sync::Arc;

use crate::error::Result;
use crate::fem::EquilibriumOptions;
use crate::math::{Mat3, Vec3};
use crate::run::Run;

use super::damping::Damping;
use super::data_terms::DataTerms;
use super::earlier::{Earlier, State};
use super::objective::{Evaluation, Objective, Shape};
use super::options::Options;
use super::problem::Problem;
use super::schedule::Schedule;
use super::summary::{IterationRecord, Stop, Summary};
use super::term::Weighting;

/// Newton steps and residual (relative to E l^2) of the start, which may be far from equilibrium.
const START: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-7, max_steps: 200 };

/// Share of the objective that following all markers must gain to be tried once more.
const WORTH_ANOTHER: f64 = 0.02;

/// An attachment that lags gains this factor in weight, so often at most.
const ATTACHMENT_GAIN: f64 = 2.0;
const ATTACHMENT_ROUNDS: usize = 8;

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
    objective: Objective<'a>,
    run: &'a Run,
    damping: Damping,
    records: Vec<IterationRecord>,
    newton_steps: usize,
}

/// Where a run of steps ended, and why.
pub struct Ended {
    pub at: Evaluation,
    pub stop: Stop,
    /// Whether no step was found from there.
    pub stuck: bool,
}

/// Reshapes the template. A cancelled run returns its best shape so far.
pub fn reshape(problem: &Problem, options: &Options, run: &Run) -> Result<Reshaped> {
    problem.check()?;
    options.check()?;
    run.enter("preparing", 0.0);
    let (objective, start) = Objective::new(problem, options)?;
    let schedule = Schedule::growing(objective.scene.body.is_free());
    let mut solver = Solver::new(objective, run);
    let start = solver.start(start, schedule.weighting)?;
    let mut ended = solver.minimize(start, schedule)?;
    if solver.objective.formulation.second_chances {
        ended = solver.reconsider_far_markers(ended)?;
        ended = solver.pull_lagging_attachments(ended)?;
    }
    Ok(solver.finish(ended, problem))
}

impl<'a> Solver<'a> {
    pub fn new(objective: Objective<'a>, run: &'a Run) -> Self {
        let (damping, records) = (Damping::default(), Vec::new());
        Self { objective, run, damping, records, newton_steps: 0 }
    }

    /// The shape in equilibrium with a strain, from a shape near by.
    pub fn start(&mut self, near: State, weighting: Weighting) -> Result<Shape> {
        let State { s, x } = near;
        let plastic = self.objective.plastic(&s);
        let equilibrium = self.objective.scene.body.equilibrate(x, &plastic, &START)?;
        self.newton_steps += equilibrium.steps;
        let shape = self.objective.shape(State { s, x: equilibrium.x });
        let start = self.objective.evaluate(shape, weighting);
        self.record(&start);
        Ok(start.shape)
    }

    /// Gauss-Newton steps, for as long as the schedule has them.
    pub fn minimize(&mut self, start: Shape, mut schedule: Schedule) -> Result<Ended> {
        let mut at = self.objective.evaluate(start, schedule.weighting);
        loop {
            if let Some(stop) = self.interruption() {
                return Ok(Ended { at, stop, stuck: false });
            }
            let step = self.objective.step(&at, self.damping, self.run)?;
            self.damping = step.damping;
            self.newton_steps += step.newton_steps;
            let stuck = step.gain.is_none();
            let goes_on = schedule.goes_on(step.gain);
            at = self.objective.evaluate(step.reached.unwrap_or(at.shape), schedule.weighting);
            self.record(&at);
            if !goes_on && !self.run.is_cancelled() {
                let stop = self.reason(&at, schedule.is_settled());
                return Ok(Ended { at, stop, stuck });
            }
        }
    }

    /// Markers that lie far off when the run has settled get another chance: in a narrow cleft that is
    /// half closed they match the wrong sheet and, as outliers, have too little weight to change that.
    /// After some steps towards every marker, a right one lies on its own sheet and a wrong one is
    /// given up as before. The lower objective is kept.
    fn reconsider_far_markers(&mut self, mut best: Ended) -> Result<Ended> {
        while best.stop == Stop::Settled
            && self.interruption().is_none()
            && self.has_far_markers(&best.at)
        {
            self.damping = Damping::default();
            let towards_all = self.minimize(best.at.shape.clone(), Schedule::literal())?;
            self.damping = Damping::default();
            let other = self.minimize(towards_all.at.shape, Schedule::full_weight())?;
            let gain = 1.0 - other.at.objective / best.at.objective;
            let stop = other.stop.after_settling();
            if gain > 0.0 {
                best = Ended { stop, ..other };
            } else {
                self.take_back(&best.at);
                best.stop = stop;
            }
            if gain < WORTH_ANOTHER {
                break;
            }
        }
        Ok(best)
    }

    /// Attachments that are still farther off than allowed when the run has settled gain weight, until all
    /// but outliers are within the tolerance.
    fn pull_lagging_attachments(&mut self, mut best: Ended) -> Result<Ended> {
        let has_settled = matches!(best.stop, Stop::Settled | Stop::ToleranceMet);
        if !has_settled || self.objective.options.hard_attachments {
            return Ok(best);
        }
        for _ in 0..ATTACHMENT_ROUNDS {
            let lagging = self.data().attachments.lagging(&best.at.shape.state.x);
            if self.interruption().is_some() || lagging.is_empty() {
                break;
            }
            for i in lagging {
                self.objective.scene.data.attachments.gains[i] *= ATTACHMENT_GAIN;
            }
            best = self.minimize(best.at.shape, Schedule::follow())?;
            best.stop = best.stop.after_settling();
        }
        Ok(best)
    }

    fn data(&self) -> &DataTerms {
        &self.objective.scene.data
    }

    fn has_far_markers(&self, at: &Evaluation) -> bool {
        self.data().markers.any_is_far(&at.shape.correspondences)
    }

    /// Why steps ended by themselves.
    fn reason(&self, at: &Evaluation, is_settled: bool) -> Stop {
        if self.data().markers.are_within_noise(&at.shape.correspondences) {
            Stop::ToleranceMet
        } else if is_settled {
            Stop::Settled
        } else {
            Stop::NoStep
        }
    }

    /// Notes where the run stands and tells those who watch.
    fn record(&mut self, at: &Evaluation) {
        let record = self.record_of(at);
        self.records.push(record);
        let iteration = self.records.len() - 1;
        self.run.update(|p| {
            p.iteration = iteration;
            p.energy = record.objective;
            p.mean_error = record.mean_marker_distance;
            p.max_error = record.max_marker_distance;
            p.fraction = 1.0 - 0.85_f64.powi(iteration as i32);
            "fitting".clone_into(&mut p.stage);
        });
        let scene = &self.objective.scene;
        self.run.publish_preview(&scene.outward(&at.shape.correspondences.points));
    }

    /// The last iteration led nowhere: the run stands where it did before.
    fn take_back(&mut self, at: &Evaluation) {
        let record = self.record_of(at);
        if let Some(last) = self.records.last_mut() {
            *last = record;
        }
    }

    fn record_of(&self, at: &Evaluation) -> IterationRecord {
        let distances = at.shape.correspondences.distances();
        let length = self.objective.scene.length;
        let mean = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
        IterationRecord {
            data_scale: at.weighting.scale,
            objective: at.objective,
            mean_marker_distance: mean * length,
            max_marker_distance: distances.iter().copied().fold(0.0, f64::max) * length,
            newton_steps: self.newton_steps,
            seconds: self.run.progress().seconds,
        }
    }

    /// Why to stop before the end, if so.
    fn interruption(&self) -> Option<Stop> {
        if self.run.is_cancelled() {
            return Some(Stop::Cancelled);
        }
        (self.records.len() > self.objective.options.max_iterations).then_some(Stop::IterationLimit)
    }

    /// The result, in the template's units and order.
    pub fn finish(self, ended: Ended, problem: &Problem) -> Reshaped {
        let Objective { scene, options, smoothness, anchor, .. } = &self.objective;
        let state = ended.at.shape.state;
        let tet_points = scene.outward(&state.x);
        let plastic_strain = self.objective.plastic_strain(&state.s);
        Reshaped {
            surface_points: scene.data.surface.embedding.apply(&tet_points),
            tet_points: scene.numbering.restore(&tet_points),
            plastic_strain: scene.numbering.restore_tets(&plastic_strain),
            summary: Summary {
                iterations: self.records,
                newton_steps: self.newton_steps,
                stop: ended.stop,
                stuck: ended.stuck,
            },
            earlier: Arc::new(Earlier {
                options: (*options).clone(),
                rest_surface: problem.surface.points.clone(),
                rest_tets: problem.tets.clone(),
                numbering: scene.numbering.clone(),
                body: scene.body.clone(),
                smoothness: smoothness.clone(),
                anchor: anchor.clone(),
                state,
                attachment_gains: scene.data.attachments.gains.clone(),
            }),
        }
    }
}
