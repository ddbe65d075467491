//! How deep bones of a result lie in each other.

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
    let bones = 0..skeleton.bones.len();
    let solid = |b| {
        let surface = skeleton.bone_surface(b, &skeleton.points);
        Solid::new(&surface.points, &surface.triangles)
    };
    let solids: Vec<Solid> = bones.clone().into_par_iter().map(solid).collect();
    let deepest = |b: usize| {
        let points = &skeleton.points[skeleton.bones[b].vertices.clone()];
        let near = |other: &usize| *other != b && solids[*other].boxes_meet(&solids[b], 0.0);
        let depth = |other: usize| solids[other].depths(points).into_iter().fold(0.0, f64::max);
        bones
            .clone()
            .filter(near)
            .map(|into| Penetration { depth: depth(into), into })
            .filter(|p| p.depth > 0.0)
            .max_by(|p, q| p.depth.total_cmp(&q.depth))
    };
    bones.clone().into_par_iter().map(deepest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::skeleton::tests::block;

    #[test]
    fn the_deepest_vertex_counts() {
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
    }
}
