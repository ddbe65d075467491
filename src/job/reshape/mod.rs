//! One reshaping from files to files.

pub(crate) mod attach;
pub(crate) mod fill;
pub(crate) mod inputs;
pub(crate) mod output;
pub(crate) mod page;
pub(crate) mod pictures;
pub(crate) mod plots;
pub(crate) mod report;
pub(crate) mod result;
pub(crate) mod run;
pub(crate) mod spec;
