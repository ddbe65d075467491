//! How sure a reshaped template is: plausible shapes, and how far they differ.

use super::access;
use super::boundary::{Failure, MlgError, MlgStatus};
use super::buffers::{self, Versioned};
use super::handles;
use super::result::{MlgReshapingResult, ReshapingResult};
use crate::mesh::{SurfaceCheck, TriMesh};
use crate::reshape::{Uncertainty, uncertainty};
use crate::run::Run;

/// Shapes that explain the data about as well as the result. Immutable; may be read from many threads.
pub struct MlgUncertainty;

/// Size of the result and how sure it is. In the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgUncertaintySummary {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Plausible shapes.
    pub shapes: usize,
    /// Volume inside the surface; NaN for one that is not closed.
    pub volume: f64,
    /// Its standard deviation.
    pub volume_sd: f64,
    /// Surface area.
    pub area: f64,
    /// Its standard deviation.
    pub area_sd: f64,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgUncertaintySummary {}

struct Sureness {
    uncertainty: Uncertainty,
    summary: MlgUncertaintySummary,
}

impl Sureness {
    fn new(uncertainty: Uncertainty) -> Self {
        let best = uncertainty.surface();
        let closed = SurfaceCheck::new(best).is_closed();
        let of_closed = |value: f64| if closed { value } else { f64::NAN };
        let summary = MlgUncertaintySummary {
            struct_size: size_of::<MlgUncertaintySummary>(),
            shapes: uncertainty.count(),
            volume: of_closed(best.volume()),
            volume_sd: of_closed(uncertainty.deviation_of(TriMesh::volume)),
            area: best.area(),
            area_sd: uncertainty.deviation_of(TriMesh::area),
        };
        Self { uncertainty, summary }
    }
}

/// Finds plausible shapes beside a result: samples of the posterior, linearized about it. Takes about as
/// long as one iteration.
///
/// `shapes`: how many, at least 2; 64 give a standard deviation to a tenth of itself. The first ones are the
/// same whatever their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_new(
    result: *const MlgReshapingResult,
    shapes: usize,
    out_uncertainty: *mut *mut MlgUncertainty,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_uncertainty, "out_uncertainty"), error, || {
        let result = handles::get::<ReshapingResult, _>(result, "result")?;
        Ok(Sureness::new(uncertainty(result.reshaped(), shapes, &Run::new())?))
    })
}

/// Standard deviation of each vertex of the surface across it: `*out_count` numbers, borrowed until the object
/// is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_sd_normal(
    uncertainty: *const MlgUncertainty,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(uncertainty, out_count, |sureness: &Sureness| &sureness.uncertainty.sd_normal)
}

/// Standard deviation of each vertex of the surface in all directions, the root of the mean squared distance,
/// as `mlg_uncertainty_sd_normal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_sd(
    uncertainty: *const MlgUncertainty,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(uncertainty, out_count, |sureness: &Sureness| &sureness.uncertainty.sd)
}

/// Gives the surface's points of one plausible shape, in the template's order.
///
/// `number`: from 0. `out_points`: room for `3 * count` coordinates, `count` the number of the template's
/// vertices.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_shape(
    uncertainty: *const MlgUncertainty,
    number: usize,
    out_points: *mut f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((uncertainty, "uncertainty"), error, |sureness: &Sureness| {
        let found = &sureness.uncertainty;
        let missing =
            || Failure::invalid(format!("there is no shape {number}: there are {}", found.count()));
        let points = found.shape(number).ok_or_else(missing)?;
        if count != points.len() {
            let vertices = points.len();
            return Err(Failure::invalid(format!(
                "out_points has room for {count} points, the template has {vertices} vertices"
            )));
        }
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::copy_points(&points, out_points, count) }
    })
}

/// Tells the result's size and how sure it is. `out_summary`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_summary(
    uncertainty: *const MlgUncertainty,
    out_summary: *mut MlgUncertaintySummary,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (uncertainty, "uncertainty"),
        (out_summary, "out_summary"),
        error,
        |sureness: &Sureness| Ok(sureness.summary),
    )
}

/// Frees plausible shapes. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_uncertainty_free(uncertainty: *mut MlgUncertainty) {
    access::free::<Sureness, _>(uncertainty);
}
