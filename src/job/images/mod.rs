//! Slices of images, and results beside them.

pub(crate) mod compare;
pub(crate) mod picture;
pub(crate) mod slice;
