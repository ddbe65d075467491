//! The C ABI. `include/moulage.h` is made from these files and is the manual for C callers.
//!
//! Safety, once for all functions: the caller promises what the header says about each pointer
//! (element counts, NULL rules, UTF-8). Handles are tickets, not addresses ([`handles`]): nothing is
//! read through them, so a stale, foreign or freed one is refused. Every function runs inside
//! [`boundary::guard`], so that no panic crosses into C.
#![allow(unsafe_code)]
#![allow(clippy::missing_safety_doc)]

mod access;
mod boundary;
mod buffers;
mod distances;
mod findings;
mod handles;
mod markers;
mod mesh;
mod motion;
mod pairs;
mod placing;
mod registration;
mod registration_result;
mod reshaping;
mod reshaping_run;
mod result;
mod result_distances;
mod run;
mod separation;
mod separation_result;
mod shape_model;
mod skeleton;
mod skeleton_files;
mod skeleton_parts;
mod tetrahedralization;
mod uncertainty;
mod version;
mod volume;
mod volume_labels;
mod volume_voxels;

pub use boundary::*;
pub use distances::*;
pub use findings::*;
pub use markers::*;
pub use mesh::*;
pub use motion::*;
pub use pairs::*;
pub use placing::*;
pub use registration::*;
pub use registration_result::*;
pub use reshaping::*;
pub use reshaping_run::*;
pub use result::*;
pub use result_distances::*;
pub use run::*;
pub use separation::*;
pub use separation_result::*;
pub use shape_model::*;
pub use skeleton::*;
pub use skeleton_files::*;
pub use skeleton_parts::*;
pub use tetrahedralization::*;
pub use uncertainty::*;
pub use version::*;
pub use volume::*;
pub use volume_labels::*;
pub use volume_voxels::*;
