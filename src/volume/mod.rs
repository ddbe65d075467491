//! Medical images: grids of numbers in space, slices through them, outlines on slices.
//!
//! **One convention.** World coordinates are millimetres in RAS (x to the person's right, y to the
//! front, z to the head), as in NIfTI and in all marker files that moulage writes. A voxel's
//! integer index is its centre. Grids may be oblique, sheared, anisotropic and left-handed: a full
//! affine map leads from indices to the world, never a spacing alone.

mod grid;
mod label_surface;
pub mod moments;
pub mod outline;
pub mod profiles;
pub mod slice;

pub(crate) use grid::voxel_count;
pub use grid::{MAX_VOXELS, Volume};
pub use label_surface::label_surface;
pub use moments::Moments;
pub use outline::{Clicks, label_markers, outlines};
pub use profiles::{Match, Profiles};
pub use slice::{SlicePlane, View, Window};
