//! Skeletons and motions from one format to another.

pub(crate) mod conversion;
pub(crate) mod osim_read;
pub(crate) mod osim_write;
