//! A run described as data: read, check, run, write, report.

mod attach;
mod check_files;
mod convert;
mod fill;
mod inputs;
mod inspect;
mod measure;
mod output;
mod register_job;
mod register_output;
mod register_report;
mod report;
mod reshape_job;
mod result;
pub mod skeleton_build;
mod spec;

pub use attach::{AttachmentPair, attach_to_bone, read_attachment_pairs};
pub use check_files::{FileCheck, check_file};
pub use convert::{convert_skeleton, metres_per_unit, read_osim_skeleton};
pub use fill::{Filling, fill, fill_with};
pub use inputs::{Inputs, Pair, read_fixed_vertices, read_landmark_pairs};
pub use inspect::{Data, inspect, inspect_data};
pub use measure::{Spread, distance_to_markers, marker_distances, vertex_stretches};
pub use output::write_deformed_tets;
pub use register_job::{
    RegisterJob, RegisterResult, SkeletonFiles, read_motion, read_skeleton, run_register,
};
pub use register_output::{file_name, result_document, scene};
pub use register_report::{RegisterReport, warnings as registration_warnings};
pub use report::{Change, Ending, Iteration, PairLine, Report, Shapes, Stage};
pub use reshape_job::{JobResult, run_reshape};
pub use spec::{Align, Gap, ReshapeJob};
