//! How much each bone carries the vertices of a soft tissue in an animation.
//!
//! Heat flows from the nearest bone into each vertex and along the tissue's surface until it rests (Baran
//! and Popović 2007, section 4). With L the Laplacian of cotangents, M the vertices' areas, d the distance
//! to the nearest bone's axis and p whether that bone is b: `(L + M / d^2) w_b = M / d^2 p_b`. Each row of
//! weights sums to one.

use super::areas::vertex_areas;
use super::skeleton::Skeleton;
use crate::error::Result;
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::first_at_place;
use crate::solve::{BlockMatrix, BlockPattern, SymbolicFactor};

/// Bones of a vertex at most: what viewers draw.
pub const BONES_OF_VERTEX: usize = 4;
/// Area of a vertex without any, as a share of the mean one.
const LEAST_AREA: f64 = 1e-6;

/// Bones and weights of one vertex: positive, heaviest first, sum 1.
pub type VertexWeights = Vec<(usize, f64)>;

/// The bones of a skeleton, ready to carry tissues.
pub struct Carriers {
    search: ClosestPoints,
    /// The bone of each triangle, and half of each bone's thickness.
    bone_of: Vec<usize>,
    radii: Vec<f64>,
}

impl Carriers {
    /// The bones where they lie.
    pub fn new(skeleton: &Skeleton) -> Self {
        let bones = skeleton.bones.iter().enumerate();
        let bone_of = bones.flat_map(|(b, bone)| bone.triangles.clone().map(move |_| b)).collect();
        let surface = |b: usize| skeleton.bone_surface(b, &skeleton.points);
        Self {
            search: ClosestPoints::new(&skeleton.points, &skeleton.triangles),
            bone_of,
            radii: (0..skeleton.bones.len()).map(|b| radius(&surface(b))).collect(),
        }
    }

    fn nearest(&self, points: &[Vec3]) -> Vec<Nearest> {
        let hits = self.search.closest_many(points).into_iter();
        let nearest = hits.map(|hit| {
            let (bone, distance) =
                hit.map_or((0, 0.0), |hit| (self.bone_of[hit.triangle as usize], hit.distance));
            Nearest { bone, to_axis: distance + self.radii[bone] }
        });
        nearest.collect()
    }
}

/// The weights of every vertex of `tissue`, a surface in the pose of the skeleton.
pub fn skin_weights(carriers: &Carriers, tissue: &TriMesh) -> Result<Vec<VertexWeights>> {
    if tissue.points.is_empty() {
        return Ok(Vec::new());
    }
    // Vertices that only texture or normals keep apart move together.
    let place = first_at_place(&tissue.points);
    let welded = tissue.triangles.iter().map(|t| t.map(|v| place[v as usize]));
    let triangles: Vec<[u32; 3]> =
        welded.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]).collect();
    let nearest = carriers.nearest(&tissue.points);
    let mut bones: Vec<usize> = nearest.iter().map(|n| n.bone).collect();
    bones.sort_unstable();
    bones.dedup();

    let mut areas = vertex_areas(&tissue.points, &triangles);
    let least = LEAST_AREA * areas.iter().sum::<f64>() / areas.len() as f64;
    for area in &mut areas {
        *area = area.max(least).max(f64::MIN_POSITIVE);
    }
    let inflow: Vec<f64> = areas.iter().zip(&nearest).map(|(a, n)| a / n.to_axis.powi(2)).collect();

    let mut heat = vec![0.0; nearest.len() * bones.len()];
    for (v, near) in nearest.iter().enumerate() {
        let b = bones.partition_point(|&bone| bone < near.bone);
        heat[v * bones.len() + b] = inflow[v];
    }
    let (pattern, matrix) = system(&tissue.points, &triangles, &inflow);
    SymbolicFactor::new(&pattern)?.factor(&matrix)?.solve_rows(&mut heat, bones.len());
    let rows: Vec<VertexWeights> = heat.chunks(bones.len()).map(|w| heaviest(&bones, w)).collect();
    Ok(place.iter().map(|&first| rows[first as usize].clone()).collect())
}

/// The bone whose surface is nearest.
struct Nearest {
    bone: usize,
    /// Distance to that surface and half the bone's thickness, which is how far its axis is.
    to_axis: f64,
}

/// Radius of the long rod with this ratio of volume to area; for a surface that is not closed what its
/// area says.
fn radius(bone: &TriMesh) -> f64 {
    let area = bone.area().max(f64::MIN_POSITIVE);
    let rod = 2.0 * bone.volume().abs() / area;
    let ball = (area / (4.0 * std::f64::consts::PI)).sqrt();
    // A rod of this area, ten times as long as thick.
    let thinnest = ball / 10_f64.sqrt();
    rod.clamp(thinnest, ball).max(f64::MIN_POSITIVE)
}

/// L + M / d^2.
fn system(points: &[Vec3], triangles: &[[u32; 3]], inflow: &[f64]) -> (BlockPattern, BlockMatrix) {
    let links: Vec<(u32, u32)> =
        triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    let pattern = BlockPattern::of_links(points, &links, 1);
    let mut matrix = BlockMatrix { values: vec![0.0; pattern.row_idx.len()] };
    let mut add = |i: u32, j: u32, value: f64| {
        matrix.values[pattern.entry(i.max(j), i.min(j), 0, 0)] += value;
    };
    for triangle in triangles {
        for k in 0..3 {
            let [apex, i, j] = [0, 1, 2].map(|n| triangle[(k + n) % 3]);
            let [p, q, r] = [apex, i, j].map(|v| points[v as usize]);
            let double_area = (q - p).cross(&(r - p)).norm();
            // Nothing flows through a sliver.
            if double_area <= 1e-9 * (q - r).norm_squared() {
                continue;
            }
            let half_cotangent = (q - p).dot(&(r - p)) / double_area / 2.0;
            add(i, i, half_cotangent);
            add(j, j, half_cotangent);
            add(i, j, -half_cotangent);
        }
    }
    for (v, value) in inflow.iter().enumerate() {
        add(v as u32, v as u32, *value);
    }
    (pattern, matrix)
}

fn heaviest(bones: &[usize], weights: &[f64]) -> VertexWeights {
    // Where triangles are obtuse, heat overshoots a little.
    let mut row: VertexWeights =
        bones.iter().copied().zip(weights.iter().copied()).filter(|(_, w)| *w > 1e-3).collect();
    row.sort_by(|a, b| b.1.total_cmp(&a.1));
    row.truncate(BONES_OF_VERTEX);
    let sum: f64 = row.iter().map(|(_, w)| w).sum();
    for (_, weight) in &mut row {
        *weight /= sum;
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;

    #[test]
    fn a_sleeve_goes_over_from_one_bone_to_the_next() {
        let bone = |x: f64| block(Vec3::new(x, 0.0, 0.0), Vec3::new(9.0, 1.0, 1.0), 6);
        let bones = vec![("a".into(), bone(0.0)), ("b".into(), bone(20.0))];
        let skeleton = Skeleton::new(bones, vec![]).unwrap();
        let mut sleeve = block(Vec3::new(10.0, 0.0, 0.0), Vec3::new(20.0, 3.0, 3.0), 40);
        let lonely = sleeve.points.len();
        sleeve.points.push(Vec3::new(25.0, 4.0, 0.0));
        let carriers = Carriers::new(&skeleton);
        let weights = skin_weights(&carriers, &sleeve).unwrap();
        let of_b = |row: &VertexWeights| row.iter().find(|(b, _)| *b == 1).map_or(0.0, |(_, w)| *w);
        for (p, row) in sleeve.points.iter().zip(&weights) {
            assert!((row.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(row.iter().all(|(_, w)| *w > 0.0));
            // The heat of the other bone falls by e over about the distance to an axis, 3 to 5.
            match p.x {
                x if x < -5.0 => assert!(of_b(row) < 0.06, "{p}: {row:?}"),
                x if x > 25.0 => assert!(of_b(row) > 0.94, "{p}: {row:?}"),
                10.0 => assert!((of_b(row) - 0.5).abs() < 0.1, "{p}: {row:?}"),
                _ => {}
            }
        }
        assert_eq!(weights[lonely], [(1, 1.0)]);
        // The edges of the block are double vertices, which stay together.
        let place = first_at_place(&sleeve.points);
        assert!(place.iter().enumerate().any(|(v, &first)| v != first as usize));
        assert!(place.iter().enumerate().all(|(v, &first)| weights[v] == weights[first as usize]));
        let on_a_line = |p: &Vec3| (p.y - 3.0).abs() < 1e-9 && p.z.abs() < 1e-9;
        let line: Vec<_> =
            sleeve.points.iter().zip(&weights).filter(|(p, _)| on_a_line(p)).collect();
        assert!(line.len() > 30);
        for (p, row) in &line {
            let further = line.iter().filter(|(q, _)| q.x > p.x);
            assert!(further.clone().all(|(_, other)| of_b(other) >= of_b(row) - 1e-9), "{p}");
        }
        assert!(skin_weights(&carriers, &TriMesh::default()).unwrap().is_empty());
    }
}
