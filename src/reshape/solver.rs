//! The algorithm: correspond, linearise, step, until the markers are met.

use std::sync::Arc;

use crate::error::Result;
use crate::fem::EquilibriumOptions;
use crate::run::Run;

use super::damping::Damping;
use super::data_terms::DataTerms;
use super::earlier::{Earlier, State};
use super::objective::{Evaluation, Objective, Shape};
use super::options::Options;
use super::problem::Problem;
use super::reshaped::Reshaped;
use super::schedule::Schedule;
use super::summary::{IterationRecord, Stop, Summary};

/// Newton steps and residual (relative to E l^2) of the start, which may be far from equilibrium.
const START: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-7, max_steps: 200 };

/// Share of the objective that following all markers must gain to be tried once more.
const WORTH_ANOTHER: f64 = 0.02;

/// An attachment that lags gains this factor in weight, so often at most.
const ATTACHMENT_GAIN: f64 = 2.0;
const ATTACHMENT_ROUNDS: usize = 8;

/// One reshaping under way.
struct Solver<'a> {
    objective: Objective<'a>,
    max_iterations: usize,
    run: &'a Run,
    damping: Damping,
    records: Vec<IterationRecord>,
    newton_steps: usize,
}

/// Where a run of steps ended, and why.
struct Ended {
    at: Evaluation,
    stop: Stop,
}

/// Reshapes the template on the tets it has.
pub fn solve(
    problem: &Problem,
    options: &Options,
    max_iterations: usize,
    run: &Run,
) -> Result<Reshaped> {
    run.enter("preparing", run.progress().fraction);
    let (objective, start) = Objective::new(problem, options)?;
    let schedule = Schedule::growing(objective.scene.body.is_free());
    let mut solver = Solver::new(objective, max_iterations, run);
    let start = solver.equilibrium(start)?;
    let mut ended = solver.minimize(start, schedule)?;
    if solver.objective.formulation.second_chances {
        ended = solver.reconsider_far_markers(ended)?;
        ended = solver.pull_lagging_attachments(ended)?;
    }
    Ok(solver.finish(ended, problem))
}

/// Reshapes from where an earlier run ended.
pub fn solve_again(earlier: &Earlier, problem: &Problem, run: &Run) -> Result<Reshaped> {
    run.enter("preparing", 0.0);
    let (objective, state) = Objective::again(problem, earlier)?;
    let schedule = Schedule::again();
    let mut solver = Solver::new(objective, earlier.options.max_iterations, run);
    let start = solver.equilibrium(state)?;
    let mut ended = solver.minimize(start, schedule)?;
    if ended.stop == Stop::NoStep {
        // The earlier shape had settled: that there is no better step is no failure.
        ended.stop = Stop::Settled;
    }
    Ok(solver.finish(ended, problem))
}

impl<'a> Solver<'a> {
    fn new(objective: Objective<'a>, max_iterations: usize, run: &'a Run) -> Self {
        let (damping, records) = (Damping::default(), Vec::new());
        Self { objective, max_iterations, run, damping, records, newton_steps: 0 }
    }

    /// The shape in equilibrium with a strain, from a shape near by.
    fn equilibrium(&mut self, near: State) -> Result<Shape> {
        let State { s, x } = near;
        let plastic = self.objective.plastic(&s);
        let equilibrium = self.objective.scene.body.equilibrate(x, &plastic, &START)?;
        self.newton_steps += equilibrium.steps;
        Ok(self.objective.shape(State { s, x: equilibrium.x }))
    }

    /// Gauss-Newton steps, for as long as the schedule has them.
    fn minimize(&mut self, start: Shape, mut schedule: Schedule) -> Result<Ended> {
        let mut at = self.objective.evaluate(start, schedule.weighting);
        if self.records.is_empty() {
            self.record(&at);
        }
        loop {
            if let Some(stop) = self.interruption() {
                return Ok(Ended { at, stop });
            }
            let step = self.objective.step(&at, self.damping, self.run)?;
            self.damping = step.damping;
            self.newton_steps += step.newton_steps;
            let shape = step.reached.unwrap_or(at.shape);
            let goes_on = schedule.goes_on(step.gain, self.data().pins.any_lags(&shape.state.x));
            at = self.objective.evaluate(shape, schedule.weighting);
            self.record(&at);
            if !goes_on && !self.run.is_cancelled() {
                let stop = self.reason(&at, schedule.is_settled());
                return Ok(Ended { at, stop });
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
        (self.records.len() > self.max_iterations).then_some(Stop::IterationLimit)
    }

    /// The result, in the template's units and order.
    fn finish(self, ended: Ended, problem: &Problem) -> Reshaped {
        let Objective { scene, options, smoothness, .. } = &self.objective;
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
                remeshes: Vec::new(),
                warnings: Vec::new(),
            },
            problem: problem.clone(),
            legs: Vec::new(),
            before: Vec::new(),
            earlier: Arc::new(Earlier {
                options: (*options).clone(),
                numbering: scene.numbering.clone(),
                body: scene.body.clone(),
                smoothness: smoothness.clone(),
                state,
                attachment_gains: scene.data.attachments.gains.clone(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reshape::test_problems::ball_to_ellipsoid;

    #[test]
    fn each_iteration_is_recorded_once() {
        let (problem, run) = (ball_to_ellipsoid(), Run::new());
        let options = Options::default();
        let (objective, start) = Objective::new(&problem, &options).unwrap();
        let mut solver = Solver::new(objective, options.max_iterations, &run);
        let start = solver.equilibrium(start).unwrap();
        let settled = solver.minimize(start, Schedule::growing(true)).unwrap();
        let iterations = solver.records.len();
        // Nothing is left to gain: one more step, and it is the last.
        let more = solver.minimize(settled.at.shape, Schedule::follow()).unwrap();
        assert_eq!(solver.records.len(), iterations + 1);
        // What led nowhere is an iteration all the same, but the last record is the end.
        solver.take_back(&more.at);
        assert_eq!(solver.records.len(), iterations + 1);
        let end = solver.records.last().unwrap();
        assert!((end.objective - more.at.objective).abs() < 1e-15);
    }
}
