//! Elastic energy densities. A new isotropic material is one more file that implements
//! [`IsotropicDensity`].

mod elastic;
mod inversion_barrier;
mod stable_neo_hookean;

pub use elastic::{Density, IsotropicDensity, Mat9, stiffness, stiffness_spd, stress};
pub use inversion_barrier::InversionBarrier;
pub use stable_neo_hookean::StableNeoHookean;
