//! Elastic energy densities. A new isotropic material is one more file that implements
//! [`IsotropicDensity`].

mod elastic;
mod stable_neo_hookean;

pub use elastic::{Density, IsotropicDensity, Mat9, stiffness, stiffness_spd, stress};
pub use stable_neo_hookean::StableNeoHookean;
