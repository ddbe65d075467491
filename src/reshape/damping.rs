//! How strongly steps are damped, from how well the last one kept its promise.

/// The first damping where there was none.
const FIRST: f64 = 0.3;

/// Between the two of a pair.
const FACTOR: f64 = 4.0;

/// Less is none.
const LEAST: f64 = 0.02;

/// A step that achieves less than this share of what was promised asks for more damping.
const POOR: f64 = 0.25;

/// The damping lambda of the next step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Damping(f64);

impl Damping {
    /// The two values tried side by side: less and as before first, then ever more.
    pub fn pair(self, round: i32) -> [f64; 2] {
        match (round, self.0) {
            (0, 0.0) => [0.0, FIRST],
            (0, last) => {
                let less = last / FACTOR;
                [if less < LEAST { 0.0 } else { less }, last]
            }
            (_, last) => {
                let more = last.max(FIRST) * FACTOR.powi(2 * round - 1);
                [more, more * FACTOR]
            }
        }
    }

    /// After a step with damping `used` that achieved `gain_ratio` of the decrease it promised.
    pub fn after(used: f64, gain_ratio: f64) -> Self {
        Self(if gain_ratio < POOR { (2.0 * used).max(FIRST / FACTOR) } else { used })
    }
}
