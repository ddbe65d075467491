//! Where the markers touch a shape.

use crate::locate::SurfacePoint;
use crate::math::Vec3;
use crate::mesh::TriMesh;

use super::carried_surface::CarriedSurface;

/// The surface of a shape and where the markers touch it.
#[derive(Clone)]
pub struct Correspondences {
    /// Closest surface point of each marker.
    pub hits: Vec<SurfacePoint>,
    /// Direction of the distance: towards the marker while it is far, the surface normal when it
    /// is near. At edges and tips the two differ, and only the first leads there.
    pub directions: Vec<Vec3>,
    /// The surface's vertices.
    pub points: Vec<Vec3>,
}

impl Correspondences {
    /// Finds the closest points of all markers on the surface of the shape `x`.
    pub fn new(carried: &CarriedSurface, markers: &[Vec3], sigma: f64, x: &[Vec3]) -> Self {
        let points = carried.embedding.apply(x);
        let mut tree = carried.search.clone();
        tree.refit(&points);
        let hits: Vec<SurfacePoint> = tree
            .closest_many(markers)
            .into_iter()
            .map(|hit| hit.expect("the surface has triangles and the markers are finite"))
            .collect();
        let surface = TriMesh { points, triangles: carried.triangles.clone() };
        let vertex_normals = surface.vertex_normals();
        let directions = hits
            .iter()
            .zip(markers)
            .map(|(hit, position)| {
                let corners = surface.triangles[hit.triangle as usize];
                let blend: Vec3 =
                    (0..3).map(|k| vertex_normals[corners[k] as usize] * hit.barycentric[k]).sum();
                let gap = position - hit.position;
                let side = if gap.dot(&blend) < 0.0 { -1.0 } else { 1.0 };
                (blend * sigma + gap * side).try_normalize(1e-12).unwrap_or_else(Vec3::z)
            })
            .collect();
        Self { hits, directions, points: surface.points }
    }

    /// Distances of the markers to the surface.
    pub fn distances(&self) -> Vec<f64> {
        self.hits.iter().map(|hit| hit.distance).collect()
    }
}
