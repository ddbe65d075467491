//! Following a known person through images of other poses: rigid bones, joints with their limits.
//!
//! [G] 3.2.2 and 5.1: "the pose in other, low resolution, stacks". The person's own model is the
//! template, the stack it was made from is the reference image; each frame starts from the pose of
//! the one before.

use super::attempts::Attempt;
use super::bone_scales::ScaleFreedom;
use super::options::{Levels, Options};
use super::registration::{Registration, State};
use super::skeleton::Skeleton;
use super::summary::Registered;
use super::target::Target;
use crate::error::{Error, Result};
use crate::run::Run;

/// Passes with rigid bones, each searching a shorter way.
const PASSES: usize = 4;

impl Options {
    /// Settings for [`Registration::track`]: bones keep their shape.
    pub fn tracking() -> Self {
        Self {
            levels: Levels::Radii(vec![f64::INFINITY; PASSES]),
            refine_bones: false,
            scale_freedom: ScaleFreedom::Fixed,
            align: false,
            springs: Vec::new(),
            seat_factor: 1.0,
            image_reach: [0.08, 0.005],
            ..Self::default()
        }
    }
}

impl Registration {
    /// The pose in one frame, searched from the pose `from`: the template, or the result of the frame
    /// before. The registration must have been made with [`Options::tracking`] (or others that keep
    /// shapes).
    pub fn track(&self, from: &Skeleton, frame: &Target, run: &Run) -> Result<Registered> {
        let whole = self.levels.iter().all(|l| l.radius.is_infinite());
        if !whole || self.options.scale_freedom != ScaleFreedom::Fixed {
            return Err(Error::invalid("tracking needs rigid bones; start from Options::tracking"));
        }
        if from.points.len() != self.template.points.len() {
            return Err(Error::invalid("the starting pose is of another skeleton"));
        }
        let mut state = State::at(from.clone());
        let mut trace = Vec::new();
        let attempt = Attempt::first(frame);
        for level in &self.levels {
            let mut search = self.search(frame, level.spacing);
            trace.push(self.go_through(level, attempt, &mut search, &mut state, run));
        }
        Ok(self.finish(state, frame, trace, run.is_cancelled()))
    }
}
