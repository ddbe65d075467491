//! Where the published formulation and ours differ.

use super::options::Options;
use crate::fem::StrainSpace;

/// Prior standard deviation of a free body's mean logarithmic strain. What holds a body says where it
/// stays as it was: there the mean is zero.
pub const MEAN_SIGMA: f64 = 0.5;

/// How a step is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// One direction, found by the Woodbury identity, halved until it leads downhill.
    Halved,
    /// Directions of more and more damping.
    Damped,
}

/// The parts of the method that there are two of.
#[derive(Clone, Copy, Debug)]
pub struct Formulation {
    /// The strain's unknowns.
    pub space: StrainSpace,
    /// Weight of their smoothness.
    pub smoothness: f64,
    /// Whether the strain returns to its mean away from data.
    pub screened: bool,
    /// Whether the surface's edges are kept from folding over.
    pub hinges: bool,
    /// How a held body looks for a step.
    pub held_steps: Steps,
    /// Whether far markers and lagging attachments get another chance when the run has settled, and flat
    /// tets are replaced.
    pub second_chances: bool,
}

impl Formulation {
    /// The one that the options ask for.
    pub fn of(options: &Options) -> Self {
        if options.paper { Self::PAPER } else { Self::nodal_logarithm(options.smoothness) }
    }

    /// \[W\]: a symmetric Fp per tet, smoothed by the graph Laplacian.
    const PAPER: Self = Self {
        space: StrainSpace::PAPER,
        smoothness: 1.0,
        screened: false,
        hinges: false,
        held_steps: Steps::Halved,
        second_chances: false,
    };

    /// The logarithm of Fp at the vertices; docs/papers.md has the reasons.
    fn nodal_logarithm(smoothness: f64) -> Self {
        Self {
            space: StrainSpace::NODAL_LOGARITHM,
            smoothness,
            screened: true,
            hinges: true,
            held_steps: Steps::Damped,
            second_chances: true,
        }
    }
}
