//! What all reports share.

pub(crate) mod files;
pub(crate) mod html;
pub(crate) mod picture;
pub(crate) mod png_file;
pub(crate) mod stages;
