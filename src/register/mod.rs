//! A template skeleton follows a surface of one person (Gilles, Reveret, Pai 2010).
//!
//! Citation: B. Gilles, L. Reveret, D. K. Pai, "Creating and animating subject-specific anatomical
//! models", Computer Graphics Forum 29(8), 2010; [G] below and in `docs/papers.md`.
//!
//! The template is a [`Skeleton`]: separate bones, joints with limits. The method moves its
//! vertices on the target in a loop of closest points, an as-rigid-as-possible filter over
//! overlapping clusters (elastic), and a projection on plausible bone shapes and joint poses
//! (plastic).

pub mod animation;
pub mod areas;
mod attempts;
pub mod bone_scales;
mod border;
pub mod correspond;
mod coupled_bones;
mod detail;
pub mod elastic;
pub mod fast_sums;
pub mod few;
mod finish;
pub mod glide;
mod image;
mod image_levels;
pub mod joint_frames;
pub mod joint_limits;
pub mod joint_path;
mod landmarks;
mod level;
mod levels;
mod lids;
mod main_loop;
mod model_shapes;
mod neighbours;
mod on_springs;
pub mod options;
mod owners;
mod pairs;
mod penetration;
mod piece_match;
mod pieces;
mod plausible;
pub mod pose;
pub mod pose_at_once;
mod pose_rows;
mod pose_starts;
mod prealign;
mod prepared;
pub mod registration;
mod riders;
pub mod rotation;
pub mod sampled_clusters;
mod samples;
mod scaled_bone;
pub mod shape_model;
pub mod skeleton;
pub mod skin;
mod soft_limits;
mod spring_pose;
mod springs;
mod start;
mod summarize;
pub mod summary;
mod surface;
mod target;
mod track;
pub mod transfer;
mod update;
pub mod verdict;
mod warnings;

pub use image::Appearance;
pub use joint_limits::{JointLimits, Limits};
pub use joint_path::JointPath;
pub use landmarks::Landmark;
pub use main_loop::register;
pub use model_shapes::{left_out, same_bones, shape_in_place};
pub use options::Options;
pub use registration::Registration;
pub use shape_model::ShapeModel;
pub use skeleton::{Bone, Coordinate, Joint, Skeleton};
pub use summary::Registered;
pub use target::Target;
pub use verdict::{Judgement, Verdict};
