//! A template skeleton follows a surface of one person (Gilles, Reveret, Pai 2010).
//!
//! Citation: B. Gilles, L. Reveret, D. K. Pai, "Creating and animating subject-specific anatomical
//! models", Computer Graphics Forum 29(8), 2010; [G] below and in `docs/papers.md`.
//!
//! The template is a [`Skeleton`]: separate bones, joints with limits. The method moves its
//! vertices on the target in a loop of closest points, an as-rigid-as-possible filter over
//! overlapping clusters (elastic), and a projection on plausible bone shapes and joint poses
//! (plastic).

pub mod areas;
pub mod joint_limits;
pub mod pose;
pub mod rotation;
pub mod skeleton;

pub use joint_limits::JointLimits;
pub use skeleton::{Bone, Coordinate, Joint, Skeleton};
