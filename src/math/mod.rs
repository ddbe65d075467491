//! Small dense kernels and sparse wrappers: polar decomposition, signed SVD, symmetric functions.

/// A point or vector in space.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
