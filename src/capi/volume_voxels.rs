//! Medical images from memory, and their voxels.

use std::ptr;

use super::access;
use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::volume::MlgVolume;
use crate::io::{LabelNames, VolumeFile};
use crate::math::{Mat3, Vec3};
use crate::volume::{Volume, voxel_count};

/// How voxels lie in the world. Set with `mlg_volume_grid_init`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgVolumeGrid {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Voxels along each index.
    pub size: [usize; 3],
    /// Millimetres between voxels along each index. Default: 1.
    pub spacing: [f64; 3],
    /// Centre of the first voxel. Default: 0.
    pub origin: [f64; 3],
    /// A 3x3 matrix, row by row, whose columns are the directions of the indices. Default: the world's
    /// own axes.
    pub directions: [f64; 9],
    /// 1: origin and directions are in LPS, as those of ITK and DICOM. 0 (default): in RAS.
    pub lps: u32,
    /// Leave at 0.
    pub reserved: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgVolumeGrid {}

const DEFAULTS: MlgVolumeGrid = MlgVolumeGrid {
    struct_size: size_of::<MlgVolumeGrid>(),
    size: [0; 3],
    spacing: [1.0; 3],
    origin: [0.0; 3],
    directions: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    lps: 0,
    reserved: 0,
};

impl MlgVolumeGrid {
    /// The steps of one voxel along each index as columns, and the centre of the first voxel: RAS.
    fn placed(&self) -> Outcome<(Mat3, Vec3)> {
        if let Some(axis) = self.spacing.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
            return Err(Failure::invalid(format!(
                "grid.spacing[{axis}] is {}; it must be above 0",
                self.spacing[axis]
            )));
        }
        let flip = if buffers::switch(self.lps, "grid.lps")? { -1.0 } else { 1.0 };
        let ras = Mat3::from_diagonal(&Vec3::new(flip, flip, 1.0));
        let directions = Mat3::from_row_slice(&self.directions);
        let steps = ras * directions * Mat3::from_diagonal(&self.spacing.into());
        Ok((steps, ras * Vec3::from(self.origin)))
    }
}

/// Writes the defaults. `struct_size`: `sizeof *out_grid`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_grid_init(
    out_grid: *mut MlgVolumeGrid,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_grid, struct_size, DEFAULTS, "out_grid") }
    })
}

/// Makes an image from an array, which is copied.
///
/// `values`: `size[0] * size[1] * size[2]` of `grid`, the first index fastest; those that are not
/// finite become 0. Labels are whole numbers. Free with `mlg_volume_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_new(
    values: *const f32,
    grid: *const MlgVolumeGrid,
    out_volume: *mut *mut MlgVolume,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_volume, "out_volume"), error, || {
        buffers::check_out(grid, "grid")?;
        // SAFETY: the caller's promise (see the module).
        let grid = unsafe { buffers::options(grid, DEFAULTS)? };
        let (steps, origin) = grid.placed()?;
        // SAFETY: as above.
        let values = unsafe { buffers::list(values, voxel_count(grid.size)?, "values")? };
        let volume = Volume::new(grid.size, values, steps, origin)?;
        Ok(VolumeFile {
            volume,
            format: "memory",
            notes: Vec::new(),
            label_names: LabelNames::new(),
        })
    })
}

/// The values of all voxels, the first index fastest: `*out_count` numbers, borrowed until the image
/// is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_values(
    volume: *const MlgVolume,
    out_count: *mut usize,
) -> *const f32 {
    access::lend(volume, out_count, |file: &VolumeFile| file.volume.values())
}
