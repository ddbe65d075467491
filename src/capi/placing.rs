//! Before a reshaping: where the template is to lie.

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::mesh::{MlgTriMesh, Surface};
use super::{buffers, handles};
use crate::align::{Freedom, Similarity, best_rigid, best_similarity, pre_align};

/// Turn and move only.
pub const MLG_ALIGN_RIGID: u32 = 0;
/// Turn, move and scale.
pub const MLG_ALIGN_SIMILARITY: u32 = 1;

/// Finds where to put a template so that the markers lie on its surface. Three or more landmarks
/// that are not on one line decide alone; otherwise at least three markers are needed.
///
/// `freedom`: `MLG_ALIGN_RIGID` or `MLG_ALIGN_SIMILARITY`. `markers`: `3 * marker_count`
/// coordinates. `landmarks` and `landmark_targets`: `3 * landmark_count` coordinates each, places on
/// the template and where they are on the person. Either may be NULL if its count is 0.
/// `out_person_from_template`: room for 16 numbers, a 4x4 matrix, row by row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_align(
    template_surface: *const MlgTriMesh,
    freedom: u32,
    markers: *const f64,
    marker_count: usize,
    landmarks: *const f64,
    landmark_targets: *const f64,
    landmark_count: usize,
    out_person_from_template: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_person_from_template, "out_person_from_template")?;
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        surface.check_triangles("template_surface")?;
        let freedom = freedom_of(freedom)?;
        // SAFETY: the caller's promise (see the module).
        let markers = unsafe { buffers::points(markers, marker_count, "markers")? };
        // SAFETY: as above.
        let from = unsafe { buffers::points(landmarks, landmark_count, "landmarks")? };
        // SAFETY: as above.
        let to = unsafe { buffers::points(landmark_targets, landmark_count, "landmark_targets")? };
        let motion = pre_align(&surface.mesh, &markers, Some((&from, &to)), freedom)?;
        // SAFETY: as above.
        unsafe { buffers::copy_out(&buffers::rows_of(&motion.matrix()), out_person_from_template) };
        Ok(())
    })
}

/// Finds the motion that brings points nearest to their targets, in the sense of least squares (Horn 1987,
/// Umeyama 1991). One pair gives a translation; where pairs leave the rotation open it is the smallest.
///
/// `freedom`: `MLG_ALIGN_RIGID` or `MLG_ALIGN_SIMILARITY`. `points` and `targets`: `3 * count`
/// coordinates each, at least one pair. `out_targets_from_points`: room for 16 numbers, a 4x4 matrix,
/// row by row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_points_align(
    freedom: u32,
    points: *const f64,
    targets: *const f64,
    count: usize,
    out_targets_from_points: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_targets_from_points, "out_targets_from_points")?;
        // SAFETY: the caller's promise (see the module).
        let from = unsafe { buffers::some_points(points, count, "points")? };
        // SAFETY: as above.
        let to = unsafe { buffers::points(targets, count, "targets")? };
        let motion = match freedom_of(freedom)? {
            Freedom::Rigid => Similarity::from(best_rigid(&from, &to, None)?),
            Freedom::Similarity => best_similarity(&from, &to, None)?,
        };
        // SAFETY: as above.
        unsafe { buffers::copy_out(&buffers::rows_of(&motion.matrix()), out_targets_from_points) };
        Ok(())
    })
}

fn freedom_of(code: u32) -> Outcome<Freedom> {
    match code {
        MLG_ALIGN_RIGID => Ok(Freedom::Rigid),
        MLG_ALIGN_SIMILARITY => Ok(Freedom::Similarity),
        other => Err(Failure::invalid(format!(
            "freedom is {other}; 0 (rigid) and 1 (similarity) are known"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::Similarity;
    use crate::math::{Mat3, Vec3};

    #[test]
    fn a_motion_is_its_matrix() {
        let turn = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let motion =
            Similarity { scale: 2.0, rotation: turn, translation: Vec3::new(5.0, 6.0, 7.0) };
        let m = buffers::rows_of(&motion.matrix());
        let p = Vec3::new(1.0, 2.0, 3.0);
        let row = |r: usize| (0..3).map(|c| m[4 * r + c] * p[c]).sum::<f64>() + m[4 * r + 3];
        assert_eq!(Vec3::new(row(0), row(1), row(2)), motion.apply(&p));
        assert_eq!(m[12..], [0.0, 0.0, 0.0, 1.0]);
    }
}
