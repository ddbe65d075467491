//! What is said about a file.

use crate::math::Vec3;
use crate::mesh::bounding_box;

/// What a file holds and what is wrong with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileCheck {
    /// What it is, one sentence.
    pub content: String,
    /// What is wrong, one sentence each.
    pub findings: Vec<String>,
}

/// The size of what has these points, in words.
pub(super) fn extent(points: &[Vec3]) -> String {
    let (low, high) = bounding_box(points).unwrap_or_default();
    let size = high - low;
    format!("{:.4} x {:.4} x {:.4} in size", size.x, size.y, size.z)
}
