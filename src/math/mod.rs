//! Small dense kernels: signed SVD, symmetric 3x3 functions, derivative check, polylines, robust figures.

pub mod derivative_check;
pub mod polyline;
pub mod robust;
pub mod svd3;
pub mod symmetric3;

pub use robust::{median, robust_deviation};
pub use svd3::{SignedSvd, nearest_rotation, signed_svd};
pub use symmetric3::Sym3;

/// A point or vector in space.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
