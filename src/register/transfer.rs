//! Soft tissue carried along with the bones.
//!
//! [G] section 3.5: clusters over bones and soft tissue together; the bones are held at the
//! person's places and the tissue follows as rigidly as possible, from large clusters to small
//! ones. Where quality matters, `reshape` with the bones as attachments is the better way.

use super::areas::{mean_edge, vertex_areas};
use super::elastic::{Elastic, whole_motion};
use super::pose::moved;
use super::sampled_clusters::SampledClusters;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::{TriMesh, bounding_box, diagonal};

/// Rounds for each cluster size at most.
const MAX_ROUNDS: usize = 60;
/// At rest when the tissue moves less than this on average, as a share of its diagonal.
const TOLERANCE: f64 = 5e-5;
/// Smallest cluster radius in mean edge lengths of the tissue.
const SMALLEST_IN_EDGES: f64 = 4.0;
/// Distance of cluster centres as a share of the radius.
const SPACING: f64 = 0.5;
/// Weight of the tissue's own present place against bones of the same area.
const OWN_WEIGHT: f64 = 0.05;

/// Where the vertices of `soft`, a surface in the template's pose, lie on the person whose bone
/// vertices are `bones_after` (in the order of [`Skeleton::points`]).
pub fn carry_soft_tissue(
    template: &Skeleton,
    bones_after: &[Vec3],
    soft: &TriMesh,
) -> Result<Vec<Vec3>> {
    if bones_after.len() != template.points.len() {
        return Err(Error::invalid(format!(
            "{} bone points are given for a skeleton with {} vertices",
            bones_after.len(),
            template.points.len()
        )));
    }
    let reference: Vec<Vec3> = template.points.iter().chain(&soft.points).copied().collect();
    let Some((low, high)) = bounding_box(&reference) else { return Ok(Vec::new()) };
    let diagonal = (high - low).norm();
    let mut masses = vertex_areas(&template.points, &template.triangles);
    let whole = whole_motion(&template.points, bones_after, &masses);
    masses.extend(vertex_areas(&soft.points, &soft.triangles).iter().map(|a| OWN_WEIGHT * a));
    let mut wanted = bones_after.to_vec();
    wanted.extend(soft.points.iter().map(|p| moved(&whole, p)));
    let smallest = SMALLEST_IN_EDGES * mean_edge(&soft.points, &soft.triangles);
    let mut radius = diagonal / 3.0;
    loop {
        let clusters = Elastic::Sampled(SampledClusters::new(&reference, radius, SPACING, None));
        settle(&clusters, &reference, &mut wanted, &masses, bones_after);
        radius /= 2.0;
        if radius < smallest || radius <= 0.0 {
            break;
        }
    }
    Ok(wanted.split_off(bones_after.len()))
}

/// Repeats the filter with the bones put back each time, until the tissue rests.
fn settle(
    clusters: &Elastic,
    reference: &[Vec3],
    wanted: &mut Vec<Vec3>,
    masses: &[f64],
    bones_after: &[Vec3],
) {
    let size = diagonal(reference);
    let soft = bones_after.len()..reference.len();
    for _ in 0..MAX_ROUNDS {
        let mut next = clusters.apply(reference, wanted, masses);
        next[..bones_after.len()].copy_from_slice(bones_after);
        let moves = soft.clone().map(|i| (next[i] - wanted[i]).norm()).sum::<f64>();
        *wanted = next;
        if moves <= TOLERANCE * size * soft.len() as f64 {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;
    use nalgebra::Isometry3;

    #[test]
    fn tissue_follows_a_rigid_motion_exactly_and_a_growing_bone_roughly() {
        let bone = block(Vec3::zeros(), Vec3::new(10.0, 2.0, 2.0), 8);
        let skin = block(Vec3::zeros(), Vec3::new(11.0, 3.0, 3.0), 10);
        let template = Skeleton::new(vec![("a".into(), bone)], vec![]).unwrap();
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let turned: Vec<Vec3> = template.points.iter().map(|p| moved(&motion, p)).collect();
        let carried = carry_soft_tissue(&template, &turned, &skin).unwrap();
        let far = carried.iter().zip(&skin.points).map(|(c, p)| (c - moved(&motion, p)).norm());
        assert!(far.fold(0.0, f64::max) < 1e-6);

        let grow = |p: &Vec3| Vec3::new(p.x * 1.2, p.y, p.z);
        let grown: Vec<Vec3> = template.points.iter().map(grow).collect();
        let carried = carry_soft_tissue(&template, &grown, &skin).unwrap();
        let misses = carried.iter().zip(&skin.points).map(|(c, p)| (c - grow(p)).norm());
        let mean = misses.sum::<f64>() / skin.points.len() as f64;
        // Standing still would miss by 1.2 on average.
        assert!(mean < 0.5, "{mean}");
        assert!(carry_soft_tissue(&template, &grown[1..], &skin).is_err());
    }
}
