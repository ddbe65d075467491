//! What keeps bodies where they are while contacts push them: markers that were met, and a weak pull.

use super::scene::{Body, Obstacle, surface_point};
use crate::fem::{MaterialPoint, Spring};
use crate::locate::{ClosestPoints, Solid};
use crate::math::Vec3;

/// Stiffness of a marker's hold in units of Young's modulus times the mean edge.
const MARKER_STIFFNESS: f64 = 1.0;

/// The pull back fades within this share of the cube root of a body's volume.
const FADING: f64 = 0.5;

/// The surface points nearest to the markers are held where they are. Markers inside an obstacle
/// hold nothing: the obstacle is right.
pub fn marker_springs(
    bodies: &[Body],
    obstacles: &[Obstacle],
    first_vertex: &[u32],
    mean_edge: f64,
) -> Vec<Spring> {
    let mut springs = Vec::new();
    let wall = |o: &Obstacle| Solid::new(&o.surface.points, &o.surface.triangles);
    let walls: Vec<Solid> = obstacles.iter().map(wall).collect();
    for (body, &first) in bodies.iter().zip(first_vertex) {
        let surface = body.surface_points(&body.tets.points);
        let closest = ClosestPoints::new(&surface, &body.triangles);
        let in_wall = |p: &&Vec3| walls.iter().any(|wall| wall.holds(p));
        let markers: Vec<Vec3> = body.markers.iter().filter(|p| !in_wall(p)).copied().collect();
        for hit in closest.closest_many(&markers).into_iter().flatten() {
            let MaterialPoint(mut entries) = surface_point(body, hit.triangle, &hit.barycentric);
            for entry in &mut entries {
                entry.0 += first;
            }
            springs.push(Spring {
                point: MaterialPoint(entries),
                target: hit.position,
                stiffness: MARKER_STIFFNESS * mean_edge,
            });
        }
    }
    springs
}

/// Stiffness of each vertex' pull back to its place: its share of the volume over the squared
/// distance within which a displacement fades.
pub fn pull(body: &Body) -> Vec<f64> {
    let mut pull = vec![0.0; body.tets.points.len()];
    let fading = FADING * libm::cbrt(body.tets.total_volume());
    for (t, tet) in body.tets.tets.iter().enumerate() {
        for &v in tet {
            pull[v as usize] += body.tets.volume(t) / 4.0 / (fading * fading);
        }
    }
    pull
}
