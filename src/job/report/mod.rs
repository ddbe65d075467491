//! What all reports share.

pub(crate) mod files;
pub(crate) mod html;
pub(crate) mod picture;
pub(crate) mod png_file;
pub(crate) mod ramp;
pub(crate) mod stages;
pub(crate) mod view3d;
