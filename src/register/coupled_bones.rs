//! Matrices in the rigid motions of all bones, with a block for each bone and each joint.

use std::sync::Arc;

use super::skeleton::Skeleton;
use crate::error::Result;
use crate::math::Vec3;
use crate::solve::{BlockPattern, SymbolicFactor};

/// Where their entries stand, six rows a bone, and how they are factored.
pub(super) struct CoupledBones {
    pub(super) pattern: BlockPattern,
    pub(super) symbolic: Arc<SymbolicFactor>,
}

impl CoupledBones {
    /// `centres`: a place for each bone, for the order of elimination.
    pub(super) fn new(centres: &[Vec3], skeleton: &Skeleton) -> Result<Self> {
        let links: Vec<(u32, u32)> =
            skeleton.joints.iter().map(|j| (j.parent as u32, j.child as u32)).collect();
        let pattern = BlockPattern::of_links(centres, &links, 6);
        let symbolic = SymbolicFactor::new(&pattern)?;
        Ok(Self { pattern, symbolic })
    }
}
