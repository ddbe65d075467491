//! A sphere to reshape, to separate and to fill.

#[path = "../../src/locate/test_shapes/sphere.rs"]
mod unit;

use moulage::math::Vec3;
use moulage::mesh::TriMesh;

/// A closed sphere of `rings` latitudes and `sides` longitudes, normals outwards.
pub fn sphere(centre: Vec3, radius: f64, rings: u32, sides: u32) -> TriMesh {
    let (mut points, triangles) = unit::sphere(rings, sides);
    for p in &mut points {
        *p = centre + radius * *p;
    }
    TriMesh::new(points, triangles).unwrap()
}
