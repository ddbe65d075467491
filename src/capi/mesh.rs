//! Surfaces and tet meshes, from arrays and files.

use libc::c_char;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome};
use super::{access, buffers};
use crate::io::{SurfaceFile, read_surface, read_tets, write_surface, write_vtu};
use crate::mesh::{SurfaceCheck, TetMesh, TriMesh};

/// A triangle surface. Immutable; may be read from many threads.
pub struct MlgTriMesh;

/// A tet mesh. Immutable; may be read from many threads.
pub struct MlgTetMesh;

/// A surface, with the file it came from so that texture coordinates and groups survive.
pub(super) struct Surface {
    pub mesh: TriMesh,
    pub file: Option<SurfaceFile>,
}

impl Surface {
    /// Refuses a bare cloud of points where a surface is needed.
    pub fn check_triangles(&self, name: &str) -> Outcome<()> {
        if self.mesh.triangles.is_empty() {
            return Err(Failure::invalid(format!("{name} has no triangles")));
        }
        Ok(())
    }
}

/// Numbers of vertices, all of them there.
pub(super) unsafe fn vertices_of(
    mesh: &TriMesh,
    vertices: *const u32,
    count: usize,
    name: &str,
) -> Outcome<Vec<u32>> {
    // SAFETY: passed on from the caller.
    let vertices = unsafe { buffers::list(vertices, count, name)? };
    for &vertex in &vertices {
        buffers::entry(&mesh.points, vertex as usize, "vertex")?;
    }
    Ok(vertices)
}

/// Makes a surface from arrays, which are copied.
///
/// `points`: `3 * point_count` coordinates (x, y, z of each), finite, in any unit.
/// `triangles`: `3 * triangle_count` vertex indices from 0, counter-clockwise seen from outside.
/// Neither may be NULL unless its count is 0. Free with `mlg_tri_mesh_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_new(
    points: *const f64,
    point_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    out_mesh: *mut *mut MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_mesh, "out_mesh"), error, || {
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::points(points, point_count, "points")? };
        // SAFETY: as above.
        let triangles =
            unsafe { buffers::index_rows::<3>(triangles, triangle_count, "triangles")? };
        let mesh = TriMesh::new(points, triangles)?;
        Ok(Surface { mesh, file: None })
    })
}

/// Reads a surface from a `.obj`, `.ply` or `.stl` file. `path`: UTF-8. Free with
/// `mlg_tri_mesh_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_load(
    path: *const c_char,
    out_mesh: *mut *mut MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_mesh, "out_mesh"), error, || {
        // SAFETY: the caller's promise (see the module).
        let file = read_surface(&unsafe { buffers::path(path, "path")? })?;
        let surface = Surface { mesh: file.mesh()?, file: Some(file) };
        Ok(surface)
    })
}

/// Writes a surface with moved points to a `.obj`, `.ply` or `.stl` file. Where the mesh was loaded
/// from a file of that format, all but points and normals stays as it was: texture coordinates,
/// groups, materials.
///
/// `points`: `3 * point_count` coordinates, or NULL for the mesh's own; `point_count` must be that
/// of the mesh (ignored for NULL).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_save(
    mesh: *const MlgTriMesh,
    points: *const f64,
    point_count: usize,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((mesh, "mesh"), error, |surface: &Surface| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::new_path(path, "path")? };
        let points = if points.is_null() {
            surface.mesh.points.clone()
        } else {
            // SAFETY: as above.
            unsafe { buffers::points(points, point_count, "points")? }
        };
        if points.len() != surface.mesh.points.len() {
            return Err(Failure::invalid(format!(
                "points: {} given, but the mesh has {}",
                points.len(),
                surface.mesh.points.len()
            )));
        }
        if let Some(file) = &surface.file {
            file.write_with_points(&path, &points)?;
        } else {
            let triangles = surface.mesh.triangles.clone();
            write_surface(&path, &TriMesh { points, triangles })?;
        }
        Ok(())
    })
}

/// The points: `3 * *out_count` coordinates, borrowed until the mesh is freed. NULL for a mesh
/// without points or a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_points(
    mesh: *const MlgTriMesh,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(mesh, out_count, |surface: &Surface| &surface.mesh.points)
}

/// The triangles: `3 * *out_count` vertex indices, borrowed until the mesh is freed. NULL for a
/// mesh without triangles or a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_triangles(
    mesh: *const MlgTriMesh,
    out_count: *mut usize,
) -> *const u32 {
    access::lend(mesh, out_count, |surface: &Surface| &surface.mesh.triangles)
}

/// Looks for holes, crowded and flipped edges, empty triangles, double and unused vertices, and
/// writes what it finds, one sentence per line, into `buffer`: UTF-8, zero-terminated, cut to
/// `capacity` bytes. An empty text means a clean, closed surface. `buffer` may be NULL if
/// `capacity` is 0. `out_length`: bytes of the whole text without the zero; may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_check(
    mesh: *const MlgTriMesh,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((mesh, "mesh"), error, |surface: &Surface| {
        let text = SurfaceCheck::new(&surface.mesh).sentences(&surface.mesh).join("\n");
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(&text, buffer, capacity, out_length) }
    })
}

/// Frees a surface. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_free(mesh: *mut MlgTriMesh) {
    access::free::<Surface, _>(mesh);
}

/// Makes a tet mesh from arrays, which are copied. Tets of negative volume are turned around.
///
/// `points`: `3 * point_count` coordinates, finite. `tets`: `4 * tet_count` vertex indices from 0.
/// Neither may be NULL unless its count is 0. Free with `mlg_tet_mesh_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_new(
    points: *const f64,
    point_count: usize,
    tets: *const u32,
    tet_count: usize,
    out_mesh: *mut *mut MlgTetMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_mesh, "out_mesh"), error, || {
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::points(points, point_count, "points")? };
        // SAFETY: as above.
        let tets = unsafe { buffers::index_rows::<4>(tets, tet_count, "tets")? };
        Ok(TetMesh::new(points, tets)?)
    })
}

/// Reads a tet mesh from a TetGen `.node` or `.ele`, `.vtu`, VegaFEM `.veg` or Gmsh `.msh` file.
/// `path`: UTF-8. Free with `mlg_tet_mesh_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_load(
    path: *const c_char,
    out_mesh: *mut *mut MlgTetMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_mesh, "out_mesh"), error, || {
        // SAFETY: the caller's promise (see the module).
        Ok(read_tets(&unsafe { buffers::path(path, "path")? })?)
    })
}

/// Writes a tet mesh as `.vtu` (VTK, for ParaView). `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_save(
    mesh: *const MlgTetMesh,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((mesh, "mesh"), error, |mesh: &TetMesh| {
        // SAFETY: the caller's promise (see the module).
        Ok(write_vtu(&unsafe { buffers::new_path(path, "path")? }, mesh, &[], &[])?)
    })
}

/// The points: `3 * *out_count` coordinates, borrowed until the mesh is freed. NULL for a mesh
/// without points or a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_points(
    mesh: *const MlgTetMesh,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(mesh, out_count, |mesh: &TetMesh| &mesh.points)
}

/// The tets: `4 * *out_count` vertex indices, borrowed until the mesh is freed. NULL for a mesh
/// without tets or a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_tets(
    mesh: *const MlgTetMesh,
    out_count: *mut usize,
) -> *const u32 {
    access::lend(mesh, out_count, |mesh: &TetMesh| &mesh.tets)
}

/// Frees a tet mesh. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tet_mesh_free(mesh: *mut MlgTetMesh) {
    access::free::<TetMesh, _>(mesh);
}
