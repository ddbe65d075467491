//! How much the shape of each bone was changed.

use rayon::prelude::*;

use crate::math::{Mat3, Vec3};
use crate::mesh::normals::area_vectors;
use crate::register::pose::BoneMoments;
use crate::register::skeleton::Skeleton;

/// Added to a flat bone's spread, as a share of it, so that an affine map is defined across it.
const FLAT: f64 = 1e-6;

/// The change of one bone against the template.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Distortion {
    /// Cube root of the change of volume.
    pub(super) size: f64,
    /// Root mean square distance from the best affine map, as a share of the bone's own radius.
    pub(super) bend: f64,
    /// Share of the bone's area that is turned by more than 60 degrees against that map.
    pub(super) crumpled: f64,
    /// The bone's root mean square radius, in the result.
    pub(super) radius: f64,
}

/// The change of every bone from `template` to `points`.
pub(super) fn distortions(template: &Skeleton, areas: &[f64], points: &[Vec3]) -> Vec<Distortion> {
    let one = |b| distortion(template, areas, points, b);
    (0..template.bones.len()).into_par_iter().map(one).collect()
}

fn distortion(template: &Skeleton, areas: &[f64], points: &[Vec3], b: usize) -> Distortion {
    let range = template.bones[b].vertices.clone();
    let (from, to, masses) =
        (&template.points[range.clone()], &points[range.clone()], &areas[range]);
    let (before, after) = (BoneMoments::new(from, masses), BoneMoments::new(to, masses));
    let cross: Mat3 = (0..from.len())
        .map(|i| masses[i] * (to[i] - after.centre) * (from[i] - before.centre).transpose())
        .sum();
    let spread = before.spread + Mat3::identity() * (FLAT * before.spread.trace());
    let Some(inverse) = spread.try_inverse() else { return Distortion::default() };
    let affine = cross * inverse;
    let residual: f64 = (0..from.len())
        .map(|i| {
            let there = after.centre + affine * (from[i] - before.centre);
            masses[i] * (to[i] - there).norm_squared()
        })
        .sum();
    let radius = (after.spread.trace() / after.mass).sqrt();
    let surfaces = [template.bone_surface(b, &template.points), template.bone_surface(b, points)];
    let [faces, now] = [0, 1].map(|k| area_vectors(&surfaces[k].points, &surfaces[k].triangles));
    let cofactor = affine.try_inverse().map(|i| i.transpose() * affine.determinant());
    let (mut turned, mut whole) = (0.0, 0.0);
    for (face, now) in faces.iter().zip(&now) {
        let expected = cofactor.map_or(*face, |c| c * face);
        whole += face.norm();
        if expected.dot(now) < 0.5 * expected.norm() * now.norm() {
            turned += face.norm();
        }
    }
    Distortion {
        size: libm::cbrt(affine.determinant().abs()),
        bend: (residual / after.mass).sqrt() / radius,
        crumpled: turned / whole,
        radius,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    #[test]
    fn an_affine_change_has_a_size_and_no_bend() {
        let mesh = block(Vec3::zeros(), Vec3::new(5.0, 2.0, 1.0), 6);
        let skeleton = Skeleton::new(vec![("a".into(), mesh)], vec![]).unwrap();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        let of = |map: &dyn Fn(&Vec3) -> Vec3| {
            let points: Vec<Vec3> = skeleton.points.iter().map(map).collect();
            distortions(&skeleton, &areas, &points)[0]
        };
        let affine = of(&|p| Vec3::new(2.0 * p.x + 0.3 * p.y, 2.0 * p.y, 2.0 * p.z + 1.0));
        assert!((affine.size - 2.0).abs() < 1e-4, "{affine:?}");
        assert!(affine.bend < 1e-4 && affine.crumpled == 0.0, "{affine:?}");
        let bent = of(&|p| p + Vec3::new(0.0, 0.0, 0.1 * p.x * p.x));
        assert!(bent.bend > 0.1, "{bent:?}");
        // Every second strip of its long sides is turned over.
        let to_and_fro = |x: f64| 2.5 * libm::cos(std::f64::consts::PI * (x + 5.0) * 0.6);
        let folded = of(&|p| Vec3::new(p.x + to_and_fro(p.x), p.y, p.z));
        assert!(folded.crumpled > 0.1, "{folded:?}");
    }
}
