//! How the markers' weight grows from step to step, and when steps are no longer worth taking. All
//! thresholds are shares of the objective that one step takes away.

use super::term::Weighting;

/// The markers' weight starts at this share of its final value and grows by the factor below.
const FIRST_SCALE: f64 = 1e-4;
const GROWTH: f64 = 8.0;

/// A free body's markers gain weight when the last step gained less than this. Raising it sooner
/// leaves them caught in wrong matches. A held body starts near and slides along itself for as long
/// as the markers are weak: there they gain weight with every step.
const LEVEL: f64 = 0.2;

/// Two steps below this, one after the other, end the run.
const SMALL: f64 = 0.01;

/// A step below this is the last of a run that began at an earlier result.
const SMALL_AGAIN: f64 = 0.15;

/// After a smaller gain at the full weight, no better step is a good end: where markers change their
/// matches, the objective has kinks.
const SETTLING: f64 = 0.05;

/// Steps at every marker's full weight, however far off.
const LITERAL_STEPS: usize = 4;

/// The weighting of the next step, and whether there is one.
pub struct Schedule {
    /// Of the next step.
    pub weighting: Weighting,
    /// Whether the weight waits at a level that still gains much.
    waits: bool,
    /// So many steps in a row, each with a smaller gain than `least`, are the last ones.
    patience: usize,
    least: f64,
    small: usize,
    settling: bool,
}

impl Schedule {
    /// Growing weights, for a start that may be far off.
    pub fn growing(is_free: bool) -> Self {
        let weighting = Weighting { scale: FIRST_SCALE, robust: true };
        Self { weighting, waits: is_free, settling: false, ..Self::full_weight() }
    }

    /// The full weight, until nothing is gained.
    pub fn full_weight() -> Self {
        let weighting = Weighting::ROBUST;
        Self { weighting, waits: false, patience: 2, least: SMALL, small: 0, settling: true }
    }

    /// The full weight, until one step gains little: the shape follows a change of some weights.
    pub fn follow() -> Self {
        Self { patience: 1, ..Self::full_weight() }
    }

    /// The full weight for a few steps, for a shape that is shown while landmarks move.
    pub fn again() -> Self {
        Self { least: SMALL_AGAIN, ..Self::follow() }
    }

    /// Some steps towards every marker, however far off.
    pub fn literal() -> Self {
        let weighting = Weighting::LITERAL;
        Self { weighting, patience: LITERAL_STEPS, least: f64::INFINITY, ..Self::full_weight() }
    }

    /// Takes note of a step's gain, `None` where no step was found; whether there is another step. A pin that
    /// lags is worth steps of little gain.
    pub fn goes_on(&mut self, gain: Option<f64>, pins_lag: bool) -> bool {
        let follows_pins = pins_lag && self.weighting.robust;
        let least = if follows_pins { self.least.min(SMALL) } else { self.least };
        let small = gain.unwrap_or(0.0) < least;
        self.small = if small { self.small + 1 } else { 0 };
        if self.weighting.scale < 1.0 {
            if !(self.waits && gain.is_some_and(|gain| gain >= LEVEL)) {
                self.weighting.scale = (self.weighting.scale * GROWTH).min(1.0);
            }
            return true;
        }
        if let Some(gain) = gain {
            self.settling = gain < SETTLING;
        }
        gain.is_some() && self.small != self.patience
    }

    /// Whether the steps so far led to where no better one is to be expected.
    pub fn is_settled(&self) -> bool {
        self.settling
    }
}
