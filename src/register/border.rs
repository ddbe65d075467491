//! Where a scan ends: beyond its open edges nothing was seen.
//!
//! A template place whose nearest place of the target lies on such an edge has no counterpart there
//! (Turk and Levoy 1994): it neither pulls nor is pulled.

use crate::locate::SurfacePoint;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::first_at_place;

/// The open edge of a surface.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// Whether each vertex lies on it.
    holds: Vec<bool>,
}

impl Border {
    /// Edges that only one triangle has, where vertices of the same place are one.
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let first = first_at_place(&mesh.points);
        let joined = |a: u32, b: u32| {
            let (a, b) = (first[a as usize], first[b as usize]);
            [a.min(b), a.max(b)]
        };
        let around = |t: &[u32; 3]| [joined(t[0], t[1]), joined(t[1], t[2]), joined(t[2], t[0])];
        let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(around).collect();
        edges.sort_unstable();
        let mut holds = vec![false; mesh.points.len()];
        for open in edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
            for v in open[0] {
                holds[v as usize] = true;
            }
        }
        Self { holds: first.iter().map(|&v| holds[v as usize]).collect() }
    }

    /// Whether a place of the surface lies on it.
    pub(super) fn has(&self, mesh: &TriMesh, place: &SurfacePoint) -> bool {
        let corners = mesh.triangles[place.triangle as usize].iter().zip(&place.barycentric);
        let mut within = corners.filter(|(_, share)| **share > 0.0);
        !place.barycentric.iter().all(|share| *share > 0.0)
            && within.all(|(&v, _)| self.holds[v as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::ClosestPoints;
    use crate::math::Vec3;
    use crate::register::skeleton::tests::block;

    #[test]
    fn only_places_on_an_open_edge_are_on_the_border() {
        let closed = block(Vec3::zeros(), Vec3::new(4.0, 1.0, 1.0), 4);
        let mut open = closed.clone();
        open.triangles.retain(|t| t.iter().any(|&v| open.points[v as usize].x < 3.99));
        assert!(open.triangles.len() < closed.triangles.len());
        let on_border = |mesh: &TriMesh, p: Vec3| {
            let search = ClosestPoints::new(&mesh.points, &mesh.triangles);
            Border::new(mesh).has(mesh, &search.closest(&p).unwrap())
        };
        let beyond = Vec3::new(6.0, 0.3, 1.2);
        assert!(on_border(&open, beyond) && !on_border(&closed, beyond));
        assert!(!on_border(&open, Vec3::new(1.0, 0.3, 1.2)));
    }
}
