//! Everything that can be tuned, with its meaning and default.

use crate::error::{Error, Result};

/// Options of a separation. Lengths are in the bodies' unit.
#[derive(Clone, Debug)]
pub struct Options {
    /// Distance to leave between surfaces. Default: the median diagonal of the bodies / 2000.
    pub gap: Option<f64>,
    /// Vertices up to this many edges away from an overlap may move. [W] 4.1.4: 5.
    pub rings: usize,
    /// Poisson's ratio of the tissue.
    pub poisson: f64,
    /// Rounds of finding contacts and solving allowed.
    pub max_rounds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { gap: None, rings: 5, poisson: 0.3, max_rounds: 80 }
    }
}

impl Options {
    /// Checks ranges.
    pub fn check(&self) -> Result<()> {
        if self.gap.is_some_and(|gap| !(gap.is_finite() && gap > 0.0)) {
            return Err(Error::invalid("the gap between surfaces must be above 0"));
        }
        if !(self.poisson > 0.0 && self.poisson < 0.5) {
            return Err(Error::invalid("Poisson's ratio must lie between 0 and 0.5"));
        }
        if self.rings == 0 || self.max_rounds == 0 {
            return Err(Error::invalid("at least one ring of vertices and one round are needed"));
        }
        Ok(())
    }
}
