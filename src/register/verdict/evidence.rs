//! What a verdict stands on.

use crate::math::Vec3;
use crate::register::correspond::Correspondences;
use crate::register::skeleton::Skeleton;
use crate::register::summary::JointSummary;
use crate::register::target::Target;

/// A result with all that it came from.
pub(in crate::register) struct Evidence<'a> {
    pub(in crate::register) template: &'a Skeleton,
    pub(in crate::register) areas: &'a [f64],
    pub(in crate::register) result: &'a Skeleton,
    /// The shape before its joints were put inside their limits.
    pub(in crate::register) elastic: &'a [Vec3],
    pub(in crate::register) target: &'a Target,
    pub(in crate::register) pairs: &'a Correspondences,
    pub(in crate::register) joints: &'a [JointSummary],
}
