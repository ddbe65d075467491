//! `moulage check`: what is in a file, and what is wrong with it.

pub(crate) mod file_check;
pub(crate) mod kinds;
pub(crate) mod skeleton;
