//! Registrations, trackings and shape models of a skeleton's bones, from files to files.

pub(crate) mod bone_landmarks;
pub(crate) mod bvh_motion;
pub(crate) mod image_target;
pub(crate) mod model;
pub(crate) mod model_file;
pub(crate) mod motion_files;
pub(crate) mod output;
pub(crate) mod pictures;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod scene;
pub mod skeleton_build;
pub(crate) mod skeleton_files;
pub(crate) mod skeleton_paths;
pub(crate) mod spec;
pub(crate) mod target;
pub(crate) mod track;
