//! What all reports share.

pub(crate) mod picture;
pub(crate) mod png_file;
