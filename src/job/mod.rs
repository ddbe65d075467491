//! A run described as data: read, check, run, write, report.

mod check;
mod convert;
mod images;
mod job_file;
mod many;
mod register;
mod report;
mod reshape;
mod separate;

pub use check::file_check::FileCheck;
pub use check::kinds::check_file;
pub use convert::conversion::{Conversion, convert};
pub use convert::osim_read::read_osim_skeleton;
pub use convert::osim_write::write_osim;
pub use images::compare::{CompareJob, SliceFigure, run_compare};
pub use images::slice::{MarkersJob, SliceJob, run_markers, run_slice};
pub use many::anatomy::run_anatomy;
pub use many::anatomy_report::{AnatomyReport, ObjectLine};
pub use many::anatomy_spec::{AnatomyJob, Object};
pub use many::batch::{BatchJob, run_batch};
pub use many::case::{Case, CaseRecord, Status};
pub use many::provenance::InputFile;
pub use register::bone_landmarks::{BoneLandmarks, read_bone_landmarks};
pub use register::bvh_motion::{bvh_of_motion, motion_of_bvh};
pub use register::image_target::Measure;
pub use register::model::{
    ModelFitJob, ModelReport, ModelShapeJob, run_model_fit, run_model_shape,
};
pub use register::model_file::{parse_shape_model, read_shape_model, write_shape_model};
pub use register::motion_files::{read_motion, write_motion_file};
pub use register::output::result_document;
pub use register::report::{LandmarkSummary, RegisterReport};
pub use register::run::{RegisterResult, run_register};
pub use register::scene::{Tissue, metres_per_unit, scene};
pub use register::skeleton_build;
pub use register::skeleton_files::{SkeletonFiles, read_skeleton, read_tissues};
pub use register::skeleton_paths::settle_paths;
pub use register::spec::RegisterJob;
pub use register::track::{TrackJob, TrackedFrame, run_track};
pub use report::stages::Stage;
pub use reshape::attach::read_attachment_pairs;
pub use reshape::fill::fill;
pub use reshape::inputs::{Inputs, read_fixed_vertices, read_landmark_pairs};
pub use reshape::output::write_deformed_tets;
pub use reshape::report::{Change, Ending, PairLine, Report, Shapes};
pub use reshape::run::{JobResult, run_reshape};
pub use reshape::spec::{Align, Gap, ReshapeJob};
pub use separate::{SeparateJob, SeparationReport, run_separate};
