//! Parts of a target that lie apart from each other, and those that lie far from all bones.

use std::collections::BTreeMap;

use super::surface::SearchedSurface;
use super::target::Target;
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::DisjointSets;

/// Parts of the target further apart, as a share of the template's diagonal, may not belong together.
const GAP: f64 = 0.015;
/// A part whose middle place lies further from all bones than this share of the diagonal, after the
/// rigid start, does not belong to them.
const FAR: f64 = 0.2;

/// The part of the surface with the largest area; none where it is in one part.
pub(super) fn main_part(surface: &SearchedSurface, diagonal: f64) -> Option<SearchedSurface> {
    let cluster = clusters(&surface.mesh, GAP * diagonal);
    let count = cluster.iter().max().map_or(0, |&c| c as usize + 1);
    let mut area = vec![0.0; count];
    for (&cluster, a) in cluster.iter().zip(&surface.areas) {
        area[cluster as usize] += a;
    }
    let main = (0..count).max_by(|&a, &b| area[a].total_cmp(&area[b]))?;
    (count > 1).then(|| surface.part(|v| cluster[v as usize] as usize == main))
}

/// The target without the parts that lie far from all bones of a template with the triangles
/// `triangles` placed at `points`; none where there are no such parts.
pub(super) fn without_far_parts(
    target: &Target,
    points: &[Vec3],
    triangles: &[[u32; 3]],
    diagonal: f64,
) -> Option<Target> {
    let search = ClosestPoints::new(points, triangles);
    let mut kept = target.clone();
    let mut left_out = 0.0;
    for surface in kept.surfaces.iter_mut().flatten() {
        let cluster = clusters(&surface.mesh, GAP * diagonal);
        let count = cluster.iter().max().map_or(0, |&c| c as usize + 1);
        // Areas far from the bones, and near.
        let mut areas = vec![[0.0; 2]; count];
        for (v, &c) in cluster.iter().enumerate() {
            let near = search.closest_within(&surface.mesh.points[v], FAR * diagonal).is_some();
            areas[c as usize][usize::from(near)] += surface.areas[v];
        }
        let far: Vec<bool> = areas.iter().map(|[far, near]| far > near).collect();
        if far.contains(&true) && far.contains(&false) {
            let gone = areas.iter().zip(&far).filter(|(_, far)| **far);
            left_out += gone.map(|(areas, _)| areas.iter().sum::<f64>()).sum::<f64>();
            *surface = surface.part(|v| !far[cluster[v as usize] as usize]);
        }
    }
    let whole: f64 = target.surfaces.iter().flatten().flat_map(|s| &s.areas).sum();
    kept.left_out = left_out / whole;
    (left_out > 0.0).then_some(kept)
}

/// The number of its cluster for each vertex, from 0: connected surfaces belong together, and what
/// comes nearer than `gap` does. (Vertices are compared by cells of that size, so gaps up to three
/// and a half times as wide may be bridged.)
fn clusters(mesh: &TriMesh, gap: f64) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.points.len());
    for triangle in &mesh.triangles {
        sets.join(triangle[0], triangle[1]);
        sets.join(triangle[0], triangle[2]);
    }
    let mut first_in: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    for (v, p) in mesh.points.iter().enumerate() {
        let cell = [p.x, p.y, p.z].map(|x| (x / gap).floor() as i64);
        let first = *first_in.entry(cell).or_insert(v as u32);
        sets.join(first, v as u32);
    }
    for (&[i, j, k], &v) in &first_in {
        for n in 0..27 {
            let near = [i + n / 9 - 1, j + n / 3 % 3 - 1, k + n % 3 - 1];
            if let Some(&other) = first_in.get(&near) {
                sets.join(v, other);
            }
        }
    }
    let mut number: BTreeMap<u32, u32> = BTreeMap::new();
    (0..mesh.points.len() as u32)
        .map(|v| {
            let next = number.len() as u32;
            *number.entry(sets.root(v)).or_insert(next)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::skeleton::tests::block;

    #[test]
    fn what_lies_near_belongs_together() {
        let mut mesh = block(Vec3::zeros(), Vec3::repeat(1.0), 4);
        for x in [2.3, 9.0] {
            mesh.append(&block(Vec3::new(x, 0.0, 0.0), Vec3::repeat(1.0), 4));
        }
        let clusters = clusters(&mesh, 0.5);
        let of = |k: usize| &clusters[k * clusters.len() / 3..(k + 1) * clusters.len() / 3];
        assert!(of(0).iter().chain(of(1)).all(|&c| c == 0) && of(2).iter().all(|&c| c == 1));
    }
}
