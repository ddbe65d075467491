//! Elastic energy densities. A new isotropic material is one more file that implements
//! [`IsotropicDensity`].

mod elastic;
mod inversion_barrier;
mod stable_neo_hookean;

pub use elastic::{
    Density, IsotropicDensity, Mat9, cofactor, stiffness_spd, stress, stress_change,
};
pub use inversion_barrier::InversionBarrier;
pub use stable_neo_hookean::StableNeoHookean;
