//! A run described as data: read, check, run, write, report.

mod anatomy_job;
mod anatomy_page;
mod anatomy_report;
mod anatomy_spec;
mod attach;
mod batch;
mod batch_summary;
mod bone_landmarks;
mod bvh_motion;
mod case;
mod check_files;
mod convert;
mod fill;
mod image_target;
mod inputs;
mod inspect;
mod label_fit;
mod measure;
mod model_file;
mod model_job;
mod osim_write;
mod output;
mod overlay;
mod png_file;
mod provenance;
mod refine;
mod register_job;
mod register_output;
mod register_report;
mod remesh;
mod report;
mod reshape_job;
mod result;
mod separate_job;
pub mod skeleton_build;
mod slice_job;
mod slice_picture;
mod spec;
mod statistics;
mod threads;
mod track_job;

pub use anatomy_job::run_anatomy;
pub use anatomy_report::{AnatomyReport, ObjectLine};
pub use anatomy_spec::{AnatomyJob, Object};
pub use attach::{AttachmentPair, attach_to_bone, read_attachment_pairs};
pub use batch::{BatchJob, run_batch};
pub use bone_landmarks::{BoneLandmarks, read_bone_landmarks};
pub use bvh_motion::{bvh_of_motion, motion_of_bvh};
pub use case::{Case, CaseRecord, Status};
pub use check_files::{FileCheck, check_file};
pub use convert::{
    Conversion, convert, metres_per_unit, read_osim_skeleton, unknown_angles, write_motion_file,
};
pub use fill::{Filling, fill, fill_with};
pub use image_target::Measure;
pub use inputs::{Inputs, Pair, read_fixed_vertices, read_landmark_pairs};
pub use inspect::{Data, inspect, inspect_data};
pub use label_fit::LabelFit;
pub use measure::{Spread, distance_to_markers, marker_distances, vertex_stretches};
pub use model_file::{parse_shape_model, read_shape_model, write_shape_model};
pub use model_job::{
    ModelFitJob, ModelReport, ModelShapeJob, left_out, run_model_fit, run_model_shape, same_bones,
    shape_in_place,
};
pub use osim_write::write_osim;
pub use output::write_deformed_tets;
pub use overlay::{CompareJob, SliceFigure, run_compare};
pub use provenance::InputFile;
pub use refine::Refinement;
pub use register_job::{
    RegisterJob, RegisterResult, SkeletonFiles, read_motion, read_skeleton, run_register,
};
pub use register_output::{file_name, result_document, scene};
pub use register_report::{LandmarkSummary, RegisterReport, warnings as registration_warnings};
pub use remesh::{Remesh, Shapeliness};
pub use report::{Change, Ending, Iteration, PairLine, Report, Shapes, Stage};
pub use reshape_job::{JobResult, run_reshape};
pub use separate_job::{
    ContradictingMarker, MovedBody, OverlapLine, SeparateJob, SeparationReport, run_separate,
};
pub use slice_job::{MarkersJob, SliceJob, run_markers, run_slice};
pub use spec::{Align, Gap, ReshapeJob};
pub use threads::thread_pool;
pub use track_job::{TrackJob, TrackedFrame, run_track};
