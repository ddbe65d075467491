//! A small problem for unit tests.

use super::problem::{Marker, Problem};
use crate::locate::test_shapes::sphere;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::tetrahedralize::{Method, Options, tetrahedralize};

/// Half axes of the person's ellipsoid.
pub const AXES: Vec3 = Vec3::new(1.5, 1.0, 0.8);

/// A unit ball with a marker for each vertex, where the ellipsoid has it.
pub fn ball_to_ellipsoid() -> Problem {
    let (points, triangles) = sphere(10, 16);
    let surface = TriMesh::new(points, triangles).unwrap();
    let how = Options { method: Method::Lattice, tet_count: 800, ..Options::default() };
    let filled = tetrahedralize(&surface, &how, &Run::new()).unwrap();
    let markers = surface.points.iter().map(|p| Marker::at(p.component_mul(&AXES))).collect();
    Problem { markers, new_tets: how, ..Problem::new(surface, filled) }
}
