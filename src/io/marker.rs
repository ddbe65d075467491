//! What all marker files hold.

use crate::math::Vec3;

/// A point that somebody marked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marker {
    /// Its name, where the file gives one.
    pub label: Option<String>,
    /// Where it is (the module's text says in which frame).
    pub position: Vec3,
    /// Relative weight, zero or more.
    pub weight: Option<f64>,
    /// Standard deviation of its noise, in the file's length unit.
    pub sigma: Option<f64>,
}

impl Marker {
    /// A marker without a name.
    pub fn at(position: Vec3) -> Self {
        Self { position, ..Self::default() }
    }
}
