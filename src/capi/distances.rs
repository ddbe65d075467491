//! Between a surface and points: distances, nearest places, values.

use super::boundary::{MlgError, MlgStatus, guard};
use super::mesh::{MlgTriMesh, Surface};
use super::{buffers, handles};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::measure::{distance_to_markers, interpolate, marker_distances};

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

/// The place on a surface that is nearest to each of some points.
///
/// `points`: `3 * count` coordinates, finite, at least one point. `out_places`: room for `3 * count`
/// numbers. The mesh needs triangles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_closest_points(
    mesh: *const MlgTriMesh,
    points: *const f64,
    count: usize,
    out_places: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_places, "out_places")?;
        let surface = handles::get::<Surface, _>(mesh, "mesh")?;
        surface.check_triangles("mesh")?;
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::some_points(points, count, "points")? };
        let closest = ClosestPoints::new(&surface.mesh.points, &surface.mesh.triangles);
        let nowhere = Vec3::repeat(f64::NAN);
        let hits = closest.closest_many(&points).into_iter();
        let places: Vec<Vec3> = hits.map(|hit| hit.map_or(nowhere, |h| h.position)).collect();
        // SAFETY: as above.
        unsafe { buffers::copy_points(&places, out_places, count) }
    })
}

/// Values that are known at some points, such as the distances of markers, at each vertex of a surface: the mean
/// of the four nearest points, weighted by nearness.
///
/// `points`: `3 * count` coordinates, finite, at least one point. `values`: `count` numbers.
/// `out_values`: room for one number per vertex of `mesh`; NaN for a vertex that is farther from its
/// nearest point than three times the points' usual spacing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_interpolate(
    mesh: *const MlgTriMesh,
    points: *const f64,
    values: *const f64,
    count: usize,
    out_values: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_values, "out_values")?;
        let surface = handles::get::<Surface, _>(mesh, "mesh")?;
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::some_points(points, count, "points")? };
        // SAFETY: as above.
        let values = unsafe { buffers::numbers(values, count, "values")? };
        let found = interpolate(&points, &values, &surface.mesh.points);
        // SAFETY: as above.
        unsafe { buffers::copy_out(&found, out_values) };
        Ok(())
    })
}
