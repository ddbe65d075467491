//! In which direction the vertices of one surface leave another one.
//!
//! Deep inside, the nearest point of the other surface may be on its far side, and neighbours would
//! be pushed different ways. Two surfaces part soonest along the other's normals, summed over the part
//! of it that lies inside the first (the volume that both share falls fastest that way); each vertex
//! sums over what lies about as near as the overlap is deep. Where no vertex of the other surface is
//! inside, the vertices at the rim ask the other surface, and from there the direction spreads over the
//! vertices inside (B. Heidelberger, M. Teschner et al., Consistent penetration depth estimation for
//! deformable collision response, 2004).

use rayon::prelude::*;

use super::scene::Skin;
use crate::math::Vec3;
use crate::mesh::adjacency::Lists;

/// Sources are summed over this many depths of the overlap.
const REACH: f64 = 2.0;

/// What two surfaces shared when their overlap was first seen. Directions found again in each round would
/// send a wall that has half left back to where it came from.
pub(super) struct Shared {
    /// Points of the other surface inside, with their share of its area as outward vectors.
    sources: Vec<(Vec3, Vec3)>,
    /// Distance over which sources are summed.
    reach: f64,
}

impl Shared {
    /// `inside`: the vertices of `skin` in `other`, and those of `other` in `skin`.
    pub fn new(skin: &Skin, other: &Skin, (inside, other_inside): (&[bool], &[bool])) -> Self {
        let depths = (0..inside.len()).into_par_iter().filter(|&v| inside[v]);
        let depth = depths
            .filter_map(|v| other.solid.closest.closest(&skin.points[v]).map(|hit| hit.distance))
            .reduce(|| 0.0, f64::max);
        // A third of each triangle's area for each of its vertices inside.
        let mut sources: Vec<(Vec3, Vec3)> = Vec::new();
        for triangle in other.triangles {
            let [a, b, c] = triangle.map(|v| other.points[v as usize]);
            let share = (b - a).cross(&(c - a)) / 6.0;
            let within = triangle.iter().filter(|&&v| other_inside[v as usize]);
            sources.extend(within.map(|&v| (other.points[v as usize], share)));
        }
        Self { sources, reach: REACH * depth }
    }

    /// The direction in which a point leaves; zero where no source is.
    fn way(&self, p: &Vec3) -> Vec3 {
        let falloff = 1.0 / (2.0 * self.reach * self.reach).max(f64::MIN_POSITIVE);
        let squares = self.sources.iter().map(|(s, _)| (s - p).norm_squared());
        let nearest = squares.fold(f64::INFINITY, f64::min);
        let sum: Vec3 = self
            .sources
            .iter()
            .map(|(s, area)| area * libm::exp(falloff * (nearest - (s - p).norm_squared())))
            .sum();
        sum.try_normalize(0.0).unwrap_or_default()
    }
}

/// A unit direction for each vertex that `inside` marks; zero for the others and for pieces that lie
/// inside as a whole. `graph`: neighbours of each vertex of `skin`.
pub(super) fn escape_directions(
    skin: &Skin,
    other: &Skin,
    inside: &[bool],
    shared: &Shared,
    graph: &Lists,
) -> Vec<Vec3> {
    let way = |v: usize| if inside[v] { shared.way(&skin.points[v]) } else { Vec3::zeros() };
    let ways: Vec<Vec3> = (0..inside.len()).into_par_iter().map(way).collect();
    let is_known = |v: usize| !inside[v] || ways[v] != Vec3::zeros();
    if (0..inside.len()).all(is_known) { ways } else { rim_ways(skin, other, inside, graph) }
}

/// Directions found at the rim and spread from there.
fn rim_ways(skin: &Skin, other: &Skin, inside: &[bool], graph: &Lists) -> Vec<Vec3> {
    let mut ways = vec![Vec3::zeros(); inside.len()];
    let mut front: Vec<u32> = Vec::new();
    for v in (0..inside.len()).filter(|&v| inside[v]) {
        let outside = graph.of(v).iter().filter(|&&w| !inside[w as usize]);
        let normals = outside.filter_map(|&w| rim_normal(skin, other, v, w as usize));
        if let Some(way) = normals.sum::<Vec3>().try_normalize(1e-9) {
            ways[v] = way;
            front.push(v as u32);
        }
    }
    while !front.is_empty() {
        let mut next: Vec<u32> = front
            .iter()
            .flat_map(|&v| graph.of(v as usize))
            .copied()
            .filter(|&w| inside[w as usize] && ways[w as usize] == Vec3::zeros())
            .collect();
        next.sort_unstable();
        next.dedup();
        let found: Vec<Vec3> = next
            .iter()
            .map(|&v| {
                let known = graph.of(v as usize).iter().map(|&w| {
                    let edge = skin.points[w as usize] - skin.points[v as usize];
                    ways[w as usize] / edge.norm_squared().max(f64::MIN_POSITIVE)
                });
                known.sum::<Vec3>().try_normalize(0.0).unwrap_or_default()
            })
            .collect();
        next.iter().zip(found).for_each(|(&v, way)| ways[v as usize] = way);
        front = next;
        front.retain(|&v| ways[v as usize] != Vec3::zeros());
    }
    ways
}

/// The other surface's normal about where the edge from `inner` to `outer` passes it, weighted by
/// how near that is to `inner`.
fn rim_normal(skin: &Skin, other: &Skin, inner: usize, outer: usize) -> Option<Vec3> {
    let (p, q) = (skin.points[inner], skin.points[outer]);
    let distance = |x: &Vec3| other.solid.closest.closest(x).map(|hit| hit.distance);
    let (below, above) = (distance(&p)?, distance(&q)?);
    let share = below / (below + above).max(f64::MIN_POSITIVE);
    let passage = p + (q - p) * share;
    let hit = other.solid.closest.closest(&passage)?;
    let weight = 1.0 / (passage - p).norm_squared().max(1e-6 * (q - p).norm_squared());
    Some(other.normal(hit.triangle) * weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::mesh::adjacency::vertex_neighbours;

    #[test]
    fn a_finger_stuck_through_the_middle_leaves_the_way_it_came() {
        let (ball, triangles) = sphere(24, 32);
        let (finger, finger_triangles) = sphere(24, 32);
        // A long ellipsoid from above, its tip beyond the ball's centre.
        let finger: Vec<Vec3> =
            finger.iter().map(|p| Vec3::new(0.3 * p.x, 0.3 * p.y, 1.2 * p.z + 0.8)).collect();
        let ball = Skin::new(ball, &triangles, None);
        let finger = Skin::new(finger, &finger_triangles, None);
        let inside: Vec<bool> = finger.points.iter().map(|p| ball.solid.holds(p)).collect();
        let graph = vertex_neighbours(finger.points.len(), &finger_triangles);
        let ball_inside: Vec<bool> = ball.points.iter().map(|p| finger.solid.holds(p)).collect();
        let shared = Shared::new(&finger, &ball, (&inside, &ball_inside));
        let ways = escape_directions(&finger, &ball, &inside, &shared, &graph);
        let tip = (0..finger.points.len())
            .min_by(|&a, &b| finger.points[a].z.total_cmp(&finger.points[b].z));
        let tip = tip.unwrap();
        assert!(inside[tip] && finger.points[tip].z < -0.3);
        assert!(ball.solid.closest.closest(&finger.points[tip]).unwrap().position.z < 0.0);
        assert!(ways[tip].z > 0.9, "{}", ways[tip]);
        assert!(inside.iter().zip(&ways).all(|(&i, w)| i == (w.norm() > 0.5)));
    }
}
