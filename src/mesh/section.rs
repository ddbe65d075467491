//! Where a plane cuts a surface.

use std::collections::HashMap;

use super::TriMesh;
use crate::math::Vec3;
use crate::math::polyline::{Polyline, chain};

/// The lines along which a plane cuts a surface: closed for closed surfaces, open where the surface
/// has holes. `point` and `normal` (any length but 0) describe the plane.
pub fn plane_section(mesh: &TriMesh, point: &Vec3, normal: &Vec3) -> Vec<Polyline> {
    let heights: Vec<f64> = mesh.points.iter().map(|p| (p - point).dot(normal)).collect();
    // A vertex on the plane counts as above, so that every triangle is cut at two edges or at none.
    let above = |v: u32| heights[v as usize] >= 0.0;
    let mut pieces = Vec::new();
    let mut crossings = HashMap::new();
    for triangle in &mesh.triangles {
        let mut ends = [0; 2];
        let mut count = 0;
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            if above(a) == above(b) {
                continue;
            }
            let name = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
            crossings.entry(name).or_insert_with(|| crossing(mesh, &heights, a.min(b), a.max(b)));
            ends[count] = name;
            count += 1;
        }
        if count == 2 {
            pieces.push(ends);
        }
    }
    let line = |(names, closed): (Vec<u64>, bool)| {
        let points = names.iter().map(|name| crossings[name]).collect();
        Polyline { points, closed }
    };
    chain(&pieces).into_iter().map(line).collect()
}

fn crossing(mesh: &TriMesh, heights: &[f64], a: u32, b: u32) -> Vec3 {
    let (low, high) = (heights[a as usize], heights[b as usize]);
    let share = low / (low - high);
    let (p, q) = (mesh.points[a as usize], mesh.points[b as usize]);
    p + share.clamp(0.0, 1.0) * (q - p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_shapes::cube;

    #[test]
    fn a_cube_is_cut_in_a_square_also_through_its_corners() {
        let half = Vec3::repeat(0.5);
        let lines = plane_section(&cube(), &half, &Vec3::new(0.0, 0.0, 3.0));
        assert!(lines.len() == 1 && lines[0].closed);
        assert!((lines[0].length() - 4.0).abs() < 1e-12);
        // Through four corners and two edges' middles at once.
        let lines = plane_section(&cube(), &half, &Vec3::new(1.0, -1.0, 0.0));
        assert!(lines.len() == 1 && lines[0].closed);
        assert!((lines[0].length() - (2.0 + 2.0 * 2.0_f64.sqrt())).abs() < 1e-12);
        assert!(plane_section(&cube(), &Vec3::repeat(2.0), &Vec3::x()).is_empty());
    }

    #[test]
    fn an_open_box_gives_an_open_line() {
        let mut open = cube();
        open.triangles.truncate(10);
        let lines = plane_section(&open, &Vec3::repeat(0.5), &Vec3::z());
        assert!(lines.len() == 1 && !lines[0].closed);
        assert!((lines[0].length() - 3.0).abs() < 1e-12);
    }
}
