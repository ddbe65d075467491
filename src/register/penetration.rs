//! Bones that lie in each other: how deep, and how much of them.

use rayon::prelude::*;

use super::skeleton::Skeleton;
use crate::locate::Solid;

/// The deepest place of a bone inside another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Penetration {
    /// Distance of the deepest vertex to the other bone's surface.
    pub(super) depth: f64,
    /// The other bone.
    pub(super) into: usize,
}

/// For every bone where one of its vertices lies deepest inside another bone, if any does.
pub(super) fn penetrations(skeleton: &Skeleton) -> Vec<Option<Penetration>> {
    let solids = solids(skeleton);
    let deepest = |b: usize| {
        let points = &skeleton.points[skeleton.bones[b].vertices.clone()];
        let depth = |other: usize| solids[other].depths(points).into_iter().fold(0.0, f64::max);
        meeting(&solids, b)
            .map(|into| Penetration { depth: depth(into), into })
            .filter(|p| p.depth > 0.0)
            .max_by(|p, q| p.depth.total_cmp(&q.depth))
    };
    (0..solids.len()).into_par_iter().map(deepest).collect()
}

/// The share of each bone's area that lies inside other bones.
pub(super) fn shares_inside_others(skeleton: &Skeleton, areas: &[f64]) -> Vec<f64> {
    let solids = solids(skeleton);
    let share = |b: usize| {
        let others: Vec<&Solid> = meeting(&solids, b).map(|other| &solids[other]).collect();
        let (mut inside, mut whole) = (0.0, 0.0);
        for i in skeleton.bones[b].vertices.clone() {
            whole += areas[i];
            if others.iter().any(|other| other.holds(&skeleton.points[i])) {
                inside += areas[i];
            }
        }
        inside / whole
    };
    (0..solids.len()).into_par_iter().map(share).collect()
}

fn solids(skeleton: &Skeleton) -> Vec<Solid> {
    let solid = |b| {
        let surface = skeleton.bone_surface(b, &skeleton.points);
        Solid::new(&surface.points, &surface.triangles)
    };
    (0..skeleton.bones.len()).into_par_iter().map(solid).collect()
}

/// The bones whose boxes meet that of bone `b`.
fn meeting(solids: &[Solid], b: usize) -> impl Iterator<Item = usize> {
    (0..solids.len()).filter(move |&other| other != b && solids[other].boxes_meet(&solids[b], 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    #[test]
    fn the_deepest_vertex_counts_and_the_share_inside() {
        let a = block(Vec3::zeros(), Vec3::new(4.0, 2.0, 2.0), 8);
        let b = block(Vec3::new(5.5, 0.0, 0.0), Vec3::new(2.0, 1.0, 1.0), 8);
        let far = block(Vec3::new(50.0, 0.0, 0.0), Vec3::repeat(1.0), 2);
        let skeleton =
            Skeleton::new(vec![("a".into(), a), ("b".into(), b), ("c".into(), far)], vec![])
                .unwrap();
        let found = penetrations(&skeleton);
        let of_b = found[1].as_ref().unwrap();
        assert!(of_b.into == 0 && (of_b.depth - 0.5).abs() < 0.05, "{of_b:?}");
        assert_eq!(found[2], None);
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        let shares = shares_inside_others(&skeleton, &areas);
        // One end of the small block (2 x 2) and .5 of its sides (4 x 2 x 4), to the nearest row of vertices.
        assert!((shares[1] - 8.0 / 40.0).abs() < 0.06 && shares[2] == 0.0, "{shares:?}");
    }
}
