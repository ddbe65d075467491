//! A sphere for tests; those outside the crate include this file, so it names nothing of the crate.

type Vec3 = nalgebra::Vector3<f64>;

/// A closed unit sphere of `rings` latitudes and `sides` longitudes, normals outwards; first vertex above, last below.
pub fn sphere(rings: u32, sides: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut points = vec![Vec3::z()];
    for r in 1..rings {
        let polar = std::f64::consts::PI * f64::from(r) / f64::from(rings);
        for s in 0..sides {
            let turn = 2.0 * std::f64::consts::PI * f64::from(s) / f64::from(sides);
            points.push(Vec3::new(
                libm::sin(polar) * libm::cos(turn),
                libm::sin(polar) * libm::sin(turn),
                libm::cos(polar),
            ));
        }
    }
    let south = points.len() as u32;
    points.push(-Vec3::z());
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
    (points, triangles)
}
