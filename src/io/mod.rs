//! Files in and out. Only `job` and the doors above it use this module; algorithms see plain data.
//!
//! Every reader has two forms: `read_*(path)` and `parse_*(bytes, path)`, where `path` serves the
//! error sentences only. Readers check all counts and indices against the bytes that are there, so
//! a broken file gives an error that names its line or element.
//!
//! **Frames and units.** Positions are returned as the file has them, with one exception: files
//! that state an LPS frame (3D Slicer `.mrk.json` and `.fcsv`) are turned into RAS, the frame of
//! NIfTI, and volumes that state LPS (DICOM, MetaImage, most NRRD files). CSV, XYZ, PLY, OBJ, STL and `.pp` files state no frame and are taken as they are. A
//! Slicer file without a frame is an error, because guessing would mirror the person.

mod anchor;
mod ascii_points;
pub mod bvh;
mod bytes;
mod csv_points;
mod dicom;
mod dicom_lengths;
mod fcsv;
pub mod gltf;
mod gltf_buffer;
mod gmsh;
pub mod h5_json;
mod label_names;
mod marker;
mod markers;
pub mod markup;
mod markups;
mod meta_image;
pub mod mot;
mod nifti;
mod nrrd;
mod obj;
mod obj_write;
pub mod osim;
mod pairs;
mod picked_points;
mod ply;
mod profiles;
pub mod skeleton;
mod skeleton_document;
mod skeleton_hinges;
mod stl;
mod surface;
mod table;
mod tet_cells;
mod tetgen_files;
mod tets;
mod text;
mod veg;
mod volumes;
mod voxels;
pub mod vtp;
mod vtu_read;
mod vtu_write;
mod write;

pub use anchor::{Anchor, ResolvedAnchor};
pub use ascii_points::parse_xyz;
pub use csv_points::{parse_csv_markers, write_csv_markers};
pub use dicom::{parse_dicom, read_dicom};
pub use fcsv::{parse_fcsv, write_fcsv};
pub use gmsh::parse_gmsh;
pub use label_names::LabelNames;
pub use marker::Marker;
pub use markers::{parse_markers, read_markers, write_markers};
pub use markups::{parse_markups, write_markups};
pub use meta_image::parse_meta_image;
pub use nifti::parse_nifti;
pub use nrrd::parse_nrrd;
pub use obj::{ObjCorner, ObjDocument};
pub use pairs::{
    Attachment, Landmark, PairedLandmarks, pair_by_label, parse_attachments, parse_fixed,
    parse_landmarks, read_attachments, read_fixed, read_landmark_files, read_landmarks,
};
pub use picked_points::{parse_picked_points, write_picked_points};
pub use ply::{PlyDocument, write_ply};
pub use profiles::{parse_profiles, read_profiles, write_profiles};
pub use stl::{StlDocument, write_stl};
pub use surface::{SurfaceFile, parse_surface, read_surface, write_surface};
pub use tetgen_files::parse_tetgen;
pub use tets::read_tets;
pub use veg::parse_veg;
pub use volumes::{VolumeFile, is_volume, read_volume};
pub use vtu_read::parse_vtu;
pub use vtu_write::{DataArray, write_vtu};
pub use write::{
    check_output, check_writable, file_name, file_names, has_extension, read_bytes, read_text,
    stem, write_beside, write_json,
};
