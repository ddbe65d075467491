//! Distances between a surface and points.

use super::boundary::{MlgError, MlgStatus, guard};
use super::mesh::{MlgTriMesh, Surface};
use super::{buffers, handles};
use crate::measure::{distance_to_markers, marker_distances};

/// The distance of each vertex of a surface to the nearest of some points: how well each place of a
/// result is supported by markers.
///
/// `points`: `3 * count` coordinates, finite, at least one point. `out_distances`: room for one number
/// per vertex of `mesh`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_distances_to_points(
    mesh: *const MlgTriMesh,
    points: *const f64,
    count: usize,
    out_distances: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_distances, "out_distances")?;
        let surface = handles::get::<Surface, _>(mesh, "mesh")?;
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::some_points(points, count, "points")? };
        let distances = distance_to_markers(&surface.mesh.points, &points);
        // SAFETY: as above.
        unsafe { buffers::copy_out(&distances, out_distances) };
        Ok(())
    })
}

/// The distance of each of some points to the nearest place on a surface: how well a result meets its
/// markers.
///
/// `points`: `3 * count` coordinates, finite, at least one point. `out_distances`: room for `count`
/// numbers. The mesh needs triangles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_distances_of_points(
    mesh: *const MlgTriMesh,
    points: *const f64,
    count: usize,
    out_distances: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_distances, "out_distances")?;
        let surface = handles::get::<Surface, _>(mesh, "mesh")?;
        surface.check_triangles("mesh")?;
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::some_points(points, count, "points")? };
        let distances = marker_distances(&surface.mesh.points, &surface.mesh.triangles, &points);
        // SAFETY: as above.
        unsafe { buffers::copy_out(&distances, out_distances) };
        Ok(())
    })
}
