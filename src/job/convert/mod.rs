//! Skeletons and motions from one format to another.

pub(crate) mod conversion;
mod osim_person;
mod osim_pose;
pub(crate) mod osim_read;
mod osim_shape;
mod osim_skeleton;
pub(crate) mod osim_write;
