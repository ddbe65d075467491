//! How far surfaces overlap, and whether they do at all.

use std::collections::BTreeSet;

use super::scene::{Body, Obstacle, Skin, near_pairs};
use crate::locate::{crossing_triangles, winding_number};
use crate::math::Vec3;
use crate::mesh::adjacency::components;

/// Two surfaces that have something in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// Name of the first.
    pub first: String,
    /// Name of the second.
    pub second: String,
    /// Vertices of either that lie inside the other.
    pub vertices_inside: usize,
    /// Pairs of triangles that cross or touch, decided exactly.
    pub crossings: usize,
    /// Largest distance of a vertex inside to the other's surface.
    pub depth: f64,
}

/// All overlaps of bodies with each other and with obstacles, the bodies' tets being at `points`.
/// An empty list is a proof: no triangles cross, and no piece of a surface lies inside another one.
pub fn overlaps(bodies: &[Body], points: &[Vec<Vec3>], obstacles: &[Obstacle]) -> Vec<Overlap> {
    let skins = Skin::all(bodies, points, obstacles);
    let name = |i: usize| {
        let obstacle = || obstacles[i - bodies.len()].name.clone();
        bodies.get(i).map_or_else(obstacle, |body| body.name.clone())
    };
    let measured = near_pairs(&skins, 0.0).into_iter().map(|(i, j)| {
        let (first, second) = (&skins[i], &skins[j]);
        let crossings = crossings(first, second).len();
        let (count, depth) = [inside(first, second), inside(second, first)]
            .into_iter()
            .fold((0, 0.0), |(n, d), (more, deeper)| (n + more, f64::max(d, deeper)));
        Overlap { first: name(i), second: name(j), vertices_inside: count, crossings, depth }
    });
    measured.filter(|o| o.crossings > 0 || o.vertices_inside > 0).collect()
}

pub(super) fn crossings(first: &Skin, second: &Skin) -> Vec<(u32, u32)> {
    crossing_triangles((&first.points, first.triangles), (&second.points, second.triangles))
}

/// Vertices of `first` inside `second`, and the depth of the deepest. A connected piece that crosses
/// nothing lies inside as a whole or not at all, so that one vertex of each piece is asked exactly.
fn inside(first: &Skin, second: &Skin) -> (usize, f64) {
    let deep = second.solid.depths(&first.points);
    if !deep.is_empty() {
        return (deep.len(), deep.iter().copied().fold(0.0, f64::max));
    }
    let pieces = components(first.points.len(), first.triangles);
    let mut seen = BTreeSet::new();
    let firsts = (0..pieces.len()).filter(|&t| seen.insert(pieces[t]));
    let hidden = firsts.map(|t| first.points[first.triangles[t][0] as usize]).filter(|p| {
        second.solid.box_holds(p, 0.0)
            && winding_number(&second.points, second.triangles, p).abs() > 0.5
    });
    (hidden.count(), 0.0)
}
