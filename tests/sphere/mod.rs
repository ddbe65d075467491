//! A sphere to reshape, to separate and to fill.

use moulage::math::Vec3;
use moulage::mesh::TriMesh;

/// A closed sphere of `rings` latitudes and `sides` longitudes, normals outwards; first vertex above, last below.
pub fn sphere(centre: Vec3, radius: f64, rings: u32, sides: u32) -> TriMesh {
    let mut points = vec![centre + radius * Vec3::z()];
    for r in 1..rings {
        let polar = std::f64::consts::PI * f64::from(r) / f64::from(rings);
        for s in 0..sides {
            let turn = std::f64::consts::TAU * f64::from(s) / f64::from(sides);
            let out = Vec3::new(
                libm::sin(polar) * libm::cos(turn),
                libm::sin(polar) * libm::sin(turn),
                libm::cos(polar),
            );
            points.push(centre + radius * out);
        }
    }
    let south = points.len() as u32;
    points.push(centre - radius * Vec3::z());
    let at = |r: u32, s: u32| 1 + (r - 1) * sides + s % sides;
    let mut triangles = Vec::new();
    for s in 0..sides {
        triangles.push([0, at(1, s), at(1, s + 1)]);
        for r in 1..rings - 1 {
            triangles.push([at(r, s), at(r + 1, s), at(r + 1, s + 1)]);
            triangles.push([at(r, s), at(r + 1, s + 1), at(r, s + 1)]);
        }
        triangles.push([south, at(rings - 1, s + 1), at(rings - 1, s)]);
    }
    TriMesh::new(points, triangles).unwrap()
}
