//! Skeleton files, read and written.

use libc::c_char;
use std::path::Path;
use std::ptr;
use std::sync::Arc;

use super::boundary::{Failure, MlgError, MlgStatus};
use super::mesh::Surface;
use super::skeleton::{MlgSkeleton, SkeletonObject};
use super::{access, buffers};
use crate::error::{Result, Shown};
use crate::io::gltf::write_glb;
use crate::io::{has_extension, write_beside, write_surface};
use crate::job::skeleton_build::{build_skeleton, document_of};
use crate::job::{read_motion, read_osim_skeleton, read_skeleton, read_tissues, write_osim};
use crate::mesh::TriMesh;
use crate::register::animation::Motion;

/// Reads a skeleton from a `.skeleton.json` file (its bones' surfaces lie where it says) or an
/// OpenSim 4 `.osim` model (surfaces beside it or in `Geometry/`). `path`: UTF-8. Free with
/// `mlg_skeleton_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_load(
    path: *const c_char,
    out_skeleton: *mut *mut MlgSkeleton,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_skeleton, "out_skeleton"), error, || {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::path(path, "path")? };
        let object = if has_extension(&path, "osim") { load_osim(&path) } else { load(&path) };
        Ok(object?)
    })
}

fn load(path: &Path) -> Result<SkeletonObject> {
    let files = read_skeleton(path)?;
    let mut surfaces = Vec::new();
    for file in files.surfaces {
        surfaces.push(Arc::new(Surface { mesh: file.mesh()?, file: Some(file) }));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let statistics = files.document.statistics.as_ref().map(|name| folder.join(name));
    let tissues = read_tissues(path, &files.document)?;
    let object = SkeletonObject::new(files.document, files.skeleton, surfaces, &[]);
    Ok(SkeletonObject { tissues, statistics, ..object })
}

fn load_osim(path: &Path) -> Result<SkeletonObject> {
    let (document, meshes, notes) = read_osim_skeleton(path)?;
    let skeleton = build_skeleton(&document, meshes.clone())?;
    let surfaces = meshes.into_iter().map(|mesh| Arc::new(Surface { mesh, file: None })).collect();
    Ok(SkeletonObject::new(document, skeleton, surfaces, &notes))
}

/// What was left out when the skeleton was read, one sentence per line: UTF-8, borrowed until the
/// skeleton is freed; empty if nothing was. NULL for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_notes(skeleton: *const MlgSkeleton) -> *const c_char {
    access::read_or(ptr::null(), skeleton, |skeleton: &SkeletonObject| skeleton.notes.as_ptr())
}

/// Writes a skeleton: a name that ends in `.json` takes the skeleton file, with the bones as `.obj`
/// in `bones/` beside it (texture coordinates and groups of bones that were read as `.obj` are kept);
/// `.glb` takes a scene in which each bone hangs on its joint and the soft tissues that the skeleton's file
/// names bend with the bones; a `.json` leaves them out. `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_save(
    skeleton: *const MlgSkeleton,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((skeleton, "skeleton"), error, |object: &SkeletonObject| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::new_path(path, "path")? };
        if has_extension(&path, "json") {
            return Ok(save_json(object, &path)?);
        }
        if has_extension(&path, "glb") {
            return Ok(write_glb(&path, &object.scene(None, None)?)?);
        }
        Err(Failure {
            status: MlgStatus::Unsupported,
            message: format!("{}: skeletons are written as .skeleton.json or .glb", path.shown()),
        })
    })
}

fn save_json(object: &SkeletonObject, path: &Path) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let known = &object.document;
    let mut document = document_of(&object.skeleton, known);
    document.clusters.clone_from(&known.clusters);
    document.result.clone_from(&known.result);
    document.name_surfaces("bones");
    for ((entry, bone), surface) in
        document.bones.iter().zip(&object.skeleton.bones).zip(&object.surfaces)
    {
        let points = object.skeleton.points[bone.vertices.clone()].to_vec();
        let to = folder.join(&entry.mesh);
        if let Some(file) = &surface.file {
            file.write_with_points(&to, &points)?;
        } else {
            let triangles = surface.mesh.triangles.clone();
            write_surface(&to, &TriMesh { points, triangles })?;
        }
    }
    let text = document.to_text()?;
    write_beside(path, |out| out.write_all(text.as_bytes()))
}

/// Writes a skeleton as a scene `.glb` that moves as a motion file says.
///
/// `motion_path`: a `.mot`, `.sto` or `.bvh` file. `flipped`: `flipped_count` names of angles whose sign is
/// the opposite of the skeleton's; may be NULL if that is 0. `unit_in_metres`: of the skeleton; 0: as
/// its file says, else millimetres.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_save_motion(
    skeleton: *const MlgSkeleton,
    motion_path: *const c_char,
    flipped: *const *const c_char,
    flipped_count: usize,
    unit_in_metres: f64,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((skeleton, "skeleton"), error, |object: &SkeletonObject| {
        // SAFETY: the caller's promise (see the module).
        let motion_path = unsafe { buffers::path(motion_path, "motion_path")? };
        // SAFETY: as above.
        let flipped = unsafe { buffers::texts(flipped, flipped_count, "flipped")? };
        // SAFETY: as above.
        let path = unsafe { buffers::new_path(path, "path")? };
        let unit = match unit_in_metres {
            0.0 => None,
            unit if unit > 0.0 && unit.is_finite() => Some(unit),
            other => {
                return Err(Failure::invalid(format!(
                    "unit_in_metres is {other}; it must be above 0, or 0"
                )));
            }
        };
        let flipped: Vec<String> = flipped.into_iter().flatten().collect();
        let motion: Motion = read_motion(&motion_path, &object.skeleton, &flipped)?;
        Ok(write_glb(&path, &object.scene(Some(&motion), unit)?)?)
    })
}

/// `mlg_skeleton_save_osim_mass` with the template's density.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_save_osim(
    skeleton: *const MlgSkeleton,
    model_path: *const c_char,
    path: *const c_char,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    // SAFETY: the caller's promise (see the module).
    unsafe {
        mlg_skeleton_save_osim_mass(
            skeleton, model_path, 0.0, path, buffer, capacity, out_length, error,
        )
    }
}

/// Writes a person's skeleton into the OpenSim model that its template was converted from: `.osim`, the
/// bones in a folder of its name in `Geometry/` beside it. Joints, default angles, masses, inertias, muscles,
/// wrapping surfaces and markers follow the bones.
///
/// `model_path`: that model. `kilograms`: mass of the person; 0: the bodies keep the template's density.
/// `path`: UTF-8. What was not carried over is written to `buffer`, one sentence per line: UTF-8,
/// zero-terminated, cut to `capacity` bytes. `buffer` may be NULL if `capacity` is 0. `out_length`: bytes of
/// the whole text without the zero; may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_save_osim_mass(
    skeleton: *const MlgSkeleton,
    model_path: *const c_char,
    kilograms: f64,
    path: *const c_char,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((skeleton, "skeleton"), error, |object: &SkeletonObject| {
        // SAFETY: the caller's promise (see the module).
        let model_path = unsafe { buffers::path(model_path, "model_path")? };
        // SAFETY: as above.
        let path = unsafe { buffers::new_path(path, "path")? };
        let mass = Some(kilograms).filter(|kg| *kg != 0.0);
        let notes = write_osim(&model_path, &object.skeleton, &object.document, mass, &path)?;
        // SAFETY: as above.
        unsafe { buffers::write_text(&notes.join("\n"), buffer, capacity, out_length) }
    })
}
