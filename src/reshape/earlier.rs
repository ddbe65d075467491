//! What a result keeps for the next one.

use std::fmt;
use std::sync::Arc;

use super::numbering::Numbering;
use super::options::Options;
use crate::fem::{Body, StrainSmoothness};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::{Sym3, Vec3};

/// The body with its material.
pub type Tissue = Body<InversionBarrier<StableNeoHookean>>;

/// A plastic strain and the shape in equilibrium with it.
#[derive(Clone)]
pub struct State {
    pub s: Vec<Sym3>,
    pub x: Vec<Vec3>,
}

/// What does not change as long as template and options stay, and where the run ended.
pub struct Earlier {
    pub(super) options: Options,
    pub(super) numbering: Arc<Numbering>,
    pub(super) body: Arc<Tissue>,
    pub(super) smoothness: Arc<StrainSmoothness>,
    pub(super) state: State,
    pub(super) attachment_gains: Vec<f64>,
}

impl Earlier {
    /// The smoothness of the strain where the run ended.
    pub(super) fn strain_energy(&self) -> f64 {
        self.smoothness.energy(&self.state.s)
    }
}

impl fmt::Debug for Earlier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Earlier").field("options", &self.options).finish_non_exhaustive()
    }
}
