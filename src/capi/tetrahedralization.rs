//! Filling: from a surface to tets that carry it.

use std::ffi::{CString, c_char};
use std::ptr;
use std::sync::Arc;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTetMesh, MlgTriMesh, Surface};
use super::run::{MlgRun, RunObject, result_of};
use super::{access, handles};
use crate::mesh::{TetMesh, TetQuality};
use crate::run::Run;
use crate::tetrahedralize::{
    Method, Options, Tetrahedralization, Used, given_tets, tetrahedralize,
};

/// Tets that carry a surface. Immutable; may be read from many threads.
pub struct MlgTetrahedralization;

/// TetGen where it is found and can fill the surface, else the lattice.
pub const MLG_TETS_AUTO: u32 = 0;
/// The program TetGen, or an error.
pub const MLG_TETS_TETGEN: u32 = 1;
/// The built-in lattice: takes open, self-intersecting and non-manifold surfaces as well.
pub const MLG_TETS_LATTICE: u32 = 2;
/// (Only as an answer.) The tets were given by the caller.
pub const MLG_TETS_GIVEN: u32 = 3;

/// How to make tets. Set with `mlg_tetrahedralization_options_init`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgTetrahedralizationOptions {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// `MLG_TETS_AUTO` (default), `MLG_TETS_TETGEN` or `MLG_TETS_LATTICE`.
    pub method: u32,
    /// About how many tets, 24 to 10 million. Default 15000.
    pub tet_count: u32,
    /// Path of the program TetGen, UTF-8; NULL: the environment variable MOULAGE_TETGEN, else the
    /// search path. Read during the call only.
    pub tetgen_path: *const c_char,
}

// SAFETY: repr(C), plain numbers and a pointer, size first.
unsafe impl Versioned for MlgTetrahedralizationOptions {}

/// Shapes of tets. Volumes in the mesh's own unit, angles in degrees.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgTetQuality {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Number of tets.
    pub tet_count: u32,
    /// Tets of no or negative volume.
    pub inverted_count: u32,
    /// Sum of the signed volumes.
    pub volume: f64,
    /// Smallest dihedral angle.
    pub min_dihedral: f64,
    /// Largest dihedral angle.
    pub max_dihedral: f64,
    /// Smallest radius ratio (3 inner / outer sphere): 1 for regular tets, 0 for flat ones.
    pub min_radius_ratio: f64,
    /// Mean radius ratio.
    pub mean_radius_ratio: f64,
    /// Number of dihedral angles in each 10 degrees from 0 to 180.
    pub dihedral_histogram: [u32; 18],
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgTetQuality {}

impl From<&TetQuality> for MlgTetQuality {
    fn from(quality: &TetQuality) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            tet_count: quality.tets as u32,
            inverted_count: quality.inverted as u32,
            volume: quality.volume,
            min_dihedral: quality.min_dihedral,
            max_dihedral: quality.max_dihedral,
            min_radius_ratio: quality.min_radius_ratio,
            mean_radius_ratio: quality.mean_radius_ratio,
            dihedral_histogram: quality.dihedral_histogram.map(|n| n as u32),
        }
    }
}

/// A surface and what carries it.
pub(super) struct Carried {
    pub surface: Arc<Surface>,
    pub tets: Tetrahedralization,
    /// How they were made, if here.
    pub options: Option<Options>,
    warnings: Vec<CString>,
}

impl Carried {
    fn new(surface: Arc<Surface>, tets: Tetrahedralization, options: Option<Options>) -> Self {
        // The sentences are our own and hold no zero; one that did would be lost, not cut.
        let warnings = tets.warnings.iter().filter_map(|w| CString::new(w.as_str()).ok()).collect();
        Self { surface, tets, options, warnings }
    }
}

const DEFAULTS: MlgTetrahedralizationOptions = MlgTetrahedralizationOptions {
    struct_size: size_of::<MlgTetrahedralizationOptions>(),
    method: MLG_TETS_AUTO,
    tet_count: 15_000,
    tetgen_path: ptr::null(),
};

/// Writes the defaults. `struct_size`: `sizeof *out_options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_options_init(
    out_options: *mut MlgTetrahedralizationOptions,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_options, struct_size, DEFAULTS, "out_options") }
    })
}

unsafe fn options_of(given: *const MlgTetrahedralizationOptions) -> Outcome<Options> {
    // SAFETY: passed on from the caller.
    let given = unsafe { buffers::options(given, DEFAULTS)? };
    let method = match given.method {
        MLG_TETS_AUTO => Method::Auto,
        MLG_TETS_TETGEN => Method::TetGen,
        MLG_TETS_LATTICE => Method::Lattice,
        other => {
            return Err(Failure::invalid(format!(
                "options.method is {other}; 0 (auto), 1 (TetGen) and 2 (lattice) are known"
            )));
        }
    };
    let tetgen_path = if given.tetgen_path.is_null() {
        None
    } else {
        // SAFETY: passed on from the caller.
        Some(unsafe { buffers::path(given.tetgen_path, "options.tetgen_path")? })
    };
    Ok(Options { method, tet_count: given.tet_count as usize, tetgen_path })
}

/// Fills a surface with tets; takes seconds (to wait without blocking: `_start`). `options`: NULL for the defaults. Free with
/// `mlg_tetrahedralization_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_run(
    surface: *const MlgTriMesh,
    options: *const MlgTetrahedralizationOptions,
    out_tets: *mut *mut MlgTetrahedralization,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_tets, "out_tets"), error, || {
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        // SAFETY: the caller's promise (see the module).
        let options = unsafe { options_of(options)? };
        let made = tetrahedralize(&surface.mesh, &options, &Run::new())?;
        Ok(Carried::new(surface, made, Some(options)))
    })
}

/// Starts filling a surface with tets on a thread of its own and returns at once. `options`: NULL for
/// the defaults, read during the call only. Free the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_start(
    surface: *const MlgTriMesh,
    options: *const MlgTetrahedralizationOptions,
    out_run: *mut *mut MlgRun,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_run, "out_run"), error, || {
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        // SAFETY: the caller's promise (see the module).
        let options = unsafe { options_of(options)? };
        let run = RunObject::start("a tetrahedralization", 0, move |run| {
            let made = tetrahedralize(&surface.mesh, &options, run)?;
            Ok(Carried::new(surface, made, Some(options)))
        })?;
        Ok(run)
    })
}

/// Waits for the end of a tetrahedralization and hands the tets over, once; `MLG_STATUS_CANCELLED`
/// if it was cancelled. Free them with `mlg_tetrahedralization_free`, and the run with
/// `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_tetrahedralization(
    run: *mut MlgRun,
    out_tets: *mut *mut MlgTetrahedralization,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_tets, "out_tets"), error, || result_of::<Carried>(run))
}

/// Takes tets made elsewhere; each vertex of the surface is carried by the tet that holds it, or
/// the nearest one. Tets of another surface, or in another unit, are refused. Free with
/// `mlg_tetrahedralization_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_from_tets(
    surface: *const MlgTriMesh,
    tets: *const MlgTetMesh,
    out_tets: *mut *mut MlgTetrahedralization,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_tets, "out_tets"), error, || {
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        let tets = TetMesh::clone(&*handles::get::<TetMesh, _>(tets, "tets")?);
        let given = given_tets(tets, &surface.mesh, "the caller".into())?;
        let carried = Carried::new(surface, given, None);
        Ok(carried)
    })
}

/// The tets' points: `3 * *out_count` coordinates, borrowed until the object is freed. NULL for a
/// handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_points(
    tets: *const MlgTetrahedralization,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(tets, out_count, |carried: &Carried| &carried.tets.mesh.points)
}

/// The tets: `4 * *out_count` vertex indices, borrowed until the object is freed. NULL for a handle
/// that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_tets(
    tets: *const MlgTetrahedralization,
    out_count: *mut usize,
) -> *const u32 {
    access::lend(tets, out_count, |carried: &Carried| &carried.tets.mesh.tets)
}

/// The share of each tet that is inside the surface, 0 to 1: `*out_count` numbers, one per tet,
/// borrowed until the object is freed. NULL for a handle that is not valid. `out_count`: may be
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_inside_fractions(
    tets: *const MlgTetrahedralization,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(tets, out_count, |carried: &Carried| &carried.tets.inside_fraction)
}

/// What made the tets: `MLG_TETS_TETGEN`, `MLG_TETS_LATTICE` or `MLG_TETS_GIVEN`; UINT32_MAX for a
/// handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_method(tets: *const MlgTetrahedralization) -> u32 {
    access::read_or(u32::MAX, tets, |carried: &Carried| match carried.tets.used {
        Used::TetGen => MLG_TETS_TETGEN,
        Used::Lattice => MLG_TETS_LATTICE,
        Used::Given(_) => MLG_TETS_GIVEN,
    })
}

/// 1 if the surface's own triangles are the boundary of the tets, else 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_boundary_kept(
    tets: *const MlgTetrahedralization,
) -> u32 {
    access::read_or(0, tets, |carried: &Carried| u32::from(carried.tets.boundary_kept))
}

/// Number of warnings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_warning_count(
    tets: *const MlgTetrahedralization,
) -> usize {
    access::read_or(0, tets, |carried: &Carried| carried.warnings.len())
}

/// One warning: a sentence in UTF-8, borrowed until the object is freed. NULL if `index` is not
/// below the count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_warning(
    tets: *const MlgTetrahedralization,
    index: usize,
) -> *const c_char {
    access::read_or(ptr::null(), tets, |carried: &Carried| {
        carried.warnings.get(index).map_or(ptr::null(), |w| w.as_ptr())
    })
}

/// Measures the tets. `out_quality`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_quality(
    tets: *const MlgTetrahedralization,
    out_quality: *mut MlgTetQuality,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((tets, "tets"), (out_quality, "out_quality"), error, |carried: &Carried| {
        let quality = TetQuality::of_mesh(&carried.tets.mesh);
        Ok((&quality).into())
    })
}

/// Frees tets. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tetrahedralization_free(tets: *mut MlgTetrahedralization) {
    access::free::<Carried, _>(tets);
}
