//! Elastic forces and stiffness of tet meshes with plastic strain.

mod body;
mod element;
mod equilibrium;
mod plastic;
mod rigid_modes;
mod sensitivity;
mod strain_laplacian;
mod strain_mean;
mod stretches;

pub use body::{Body, MaterialPoint, Spring};
pub use element::{Curvature, RestElement};
pub use equilibrium::{Equilibrium, EquilibriumOptions, Outcome, solve_vectors};
pub use plastic::{Carrier, Chart, PlasticState, StrainSpace};
pub use rigid_modes::{RigidMotion, isostatic_gauge, rigid_modes};
pub use sensitivity::Sensitivity;
pub use strain_laplacian::{HalfInverse, Screening, StrainSmoothness};
pub use strain_mean::StrainMean;
pub use stretches::{deformation_gradients, principal_stretches, stretches_of};
