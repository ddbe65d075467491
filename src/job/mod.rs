//! A run described as data: read, check, run, write, report.

mod attach;
mod check_files;
mod fill;
mod inputs;
mod inspect;
mod measure;
mod output;
mod report;
mod reshape_job;
mod result;
pub mod skeleton_build;
mod spec;

pub use attach::AttachmentPair;
pub use check_files::{FileCheck, check_file};
pub use fill::{Filling, fill};
pub use inputs::{Inputs, Pair};
pub use inspect::inspect;
pub use measure::Spread;
pub use report::{Change, Ending, Iteration, PairLine, Report, Shapes, Stage};
pub use reshape_job::{JobResult, run_reshape};
pub use spec::{Align, Gap, ReshapeJob};
