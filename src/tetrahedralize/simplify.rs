//! Fewer triangles for a closed surface, volume kept.
//!
//! M. Garland, P. Heckbert, Surface simplification using quadric error metrics (1997): edges are
//! collapsed in the order of the error this makes. P. Lindstrom, G. Turk (1998): the new vertex is
//! placed so that the volume stays. A collapse that would change the topology (link condition) or
//! turn a triangle over is left out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Matrix4, Vector4};

use crate::math::{Mat3, Vec3};
use crate::mesh::TriMesh;
use crate::mesh::adjacency::edges;

/// Pull to the edge's middle, relative to the quadric: decides where a flat surface leaves the
/// place open.
const MIDDLE_PULL: f64 = 1e-3;
/// Cosine of the largest turn of a triangle's normal in one collapse.
const SMALLEST_TURN_COSINE: f64 = 0.2;
/// Twice the area over the squared longest edge, of the thinnest triangle a collapse may leave.
const THINNEST: f64 = 0.05;

/// Reduces a closed manifold surface to about `triangle_count` triangles; stops earlier when no
/// edge can be collapsed. Vertices are renumbered.
pub fn simplify(surface: &TriMesh, triangle_count: usize) -> TriMesh {
    let mut work = Simplifier::new(surface);
    let mut queue = BinaryHeap::new();
    for [a, b] in edges(&surface.triangles) {
        queue.push(work.candidate(a, b));
    }
    while work.alive > triangle_count {
        let Some(Reverse(Candidate { a, b, stamps, .. })) = queue.pop() else { break };
        if stamps != [work.stamp[a as usize], work.stamp[b as usize]] {
            continue;
        }
        let position = work.best_position(a, b);
        if !work.keeps_topology(a, b) || work.turns_over(a, b, &position) {
            continue;
        }
        work.collapse(a, b, position);
        for other in work.neighbours(a) {
            queue.push(work.candidate(a.min(other), a.max(other)));
        }
    }
    work.finish()
}

/// An edge and what its collapse costs; out of date when a stamp has changed.
#[derive(PartialEq)]
struct Candidate {
    cost: f64,
    a: u32,
    b: u32,
    stamps: [u32; 2],
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let key = |c: &Self| (c.a, c.b, c.stamps);
        self.cost.total_cmp(&other.cost).then_with(|| key(self).cmp(&key(other)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Sum of squared distances to planes, weighted by area: x.A x - 2 b.x + c.
#[derive(Clone, Copy)]
struct Quadric {
    a: Mat3,
    b: Vec3,
    c: f64,
}

impl Quadric {
    fn of_triangle([p, q, r]: [Vec3; 3]) -> Self {
        let normal = (q - p).cross(&(r - p));
        let area = normal.norm() / 2.0;
        let n = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
        let offset = n.dot(&p);
        Self { a: n * n.transpose() * area, b: n * offset * area, c: offset * offset * area }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn at(&self, x: &Vec3) -> f64 {
        x.dot(&(self.a * x)) - 2.0 * self.b.dot(x) + self.c
    }
}

struct Simplifier {
    points: Vec<Vec3>,
    triangles: Vec<Option<[u32; 3]>>,
    at_vertex: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    stamp: Vec<u32>,
    alive: usize,
}

impl Simplifier {
    fn new(surface: &TriMesh) -> Self {
        let n = surface.points.len();
        let mut at_vertex = vec![Vec::new(); n];
        let zero = Quadric { a: Mat3::zeros(), b: Vec3::zeros(), c: 0.0 };
        let mut quadrics = vec![zero; n];
        for (t, triangle) in surface.triangles.iter().enumerate() {
            let quadric = Quadric::of_triangle(surface.corners(t));
            for &v in triangle {
                at_vertex[v as usize].push(t as u32);
                quadrics[v as usize] = quadrics[v as usize].plus(&quadric);
            }
        }
        Self {
            points: surface.points.clone(),
            triangles: surface.triangles.iter().copied().map(Some).collect(),
            at_vertex,
            quadrics,
            stamp: vec![0; n],
            alive: surface.triangles.len(),
        }
    }

    fn candidate(&self, a: u32, b: u32) -> Reverse<Candidate> {
        let position = self.best_position(a, b);
        let quadric = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        let stamps = [self.stamp[a as usize], self.stamp[b as usize]];
        Reverse(Candidate { cost: quadric.at(&position).max(0.0), a, b, stamps })
    }

    /// The living triangles at a vertex.
    fn around(&self, v: u32) -> impl Iterator<Item = (u32, [u32; 3])> {
        self.at_vertex[v as usize].iter().filter_map(|&t| Some((t, self.triangles[t as usize]?)))
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut found: Vec<u32> =
            self.around(v).flat_map(|(_, t)| t).filter(|&other| other != v).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|v| self.points[v as usize])
    }

    /// The triangles at `a` or `b`, each once.
    fn star(&self, a: u32, b: u32) -> impl Iterator<Item = [u32; 3]> {
        let rest = self.around(b).filter(move |(_, t)| !t.contains(&a));
        self.around(a).chain(rest).map(|(_, t)| t)
    }

    /// Least quadric error among the places that keep the volume.
    fn best_position(&self, a: u32, b: u32) -> Vec3 {
        let middle = (self.points[a as usize] + self.points[b as usize]) / 2.0;
        let quadric = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        // Positions relative to the middle, for precision far from the origin.
        let pull = MIDDLE_PULL * quadric.a.trace();
        let matrix = quadric.a + Mat3::identity() * pull;
        let right = quadric.b - quadric.a * middle;
        // The tets between the new vertex and the old star have no volume in sum: g . x = h.
        let (mut g, mut h) = (Vec3::zeros(), 0.0);
        for triangle in self.star(a, b) {
            let [p, q, r] = self.corners(triangle).map(|x| x - middle);
            g += (q - p).cross(&(r - p));
            h += p.dot(&q.cross(&r));
        }
        let mut system = Matrix4::zeros();
        system.fixed_view_mut::<3, 3>(0, 0).copy_from(&matrix);
        system.fixed_view_mut::<3, 1>(0, 3).copy_from(&g);
        system.fixed_view_mut::<1, 3>(3, 0).copy_from(&g.transpose());
        let solution = system.lu().solve(&Vector4::new(right.x, right.y, right.z, h));
        let reach = 2.0 * (self.points[a as usize] - middle).norm();
        match solution {
            Some(x) if x.xyz().norm() <= reach => middle + x.xyz(),
            _ => middle,
        }
    }

    /// Link condition: `a` and `b` have exactly the two neighbours in common that the two triangles
    /// of their edge have.
    fn keeps_topology(&self, a: u32, b: u32) -> bool {
        let of_b = self.neighbours(b);
        let common = self.neighbours(a).into_iter().filter(|v| of_b.contains(v)).count();
        let shared = self.around(a).filter(|(_, t)| t.contains(&b)).count();
        common == 2 && shared == 2 && self.alive > 4
    }

    /// Whether some triangle that stays would turn too far or get too thin.
    fn turns_over(&self, a: u32, b: u32, position: &Vec3) -> bool {
        self.star(a, b).filter(|t| !(t.contains(&a) && t.contains(&b))).any(|triangle| {
            let [p, q, r] = self.corners(triangle);
            let before = (q - p).cross(&(r - p));
            let [p, q, r] = triangle
                .map(|v| if v == a || v == b { *position } else { self.points[v as usize] });
            let after = (q - p).cross(&(r - p));
            let longest =
                (q - p).norm_squared().max((r - q).norm_squared()).max((p - r).norm_squared());
            let turned = before.dot(&after) < SMALLEST_TURN_COSINE * before.norm() * after.norm();
            turned || after.norm() <= THINNEST * longest
        })
    }

    /// `b` becomes `a`, at `position`.
    fn collapse(&mut self, a: u32, b: u32, position: Vec3) {
        let (ia, ib) = (a as usize, b as usize);
        for t in std::mem::take(&mut self.at_vertex[ib]) {
            let Some(triangle) = &mut self.triangles[t as usize] else { continue };
            if triangle.contains(&a) {
                self.triangles[t as usize] = None;
                self.alive -= 1;
            } else {
                *triangle = triangle.map(|v| if v == b { a } else { v });
                self.at_vertex[ia].push(t);
            }
        }
        let triangles = &self.triangles;
        self.at_vertex[ia].retain(|&t| triangles[t as usize].is_some());
        self.points[ia] = position;
        self.quadrics[ia] = self.quadrics[ia].plus(&self.quadrics[ib]);
        self.stamp[ib] += 1;
        // All edges around the moved vertex get new costs.
        self.stamp[ia] += 1;
    }

    fn finish(self) -> TriMesh {
        let mut number = vec![u32::MAX; self.points.len()];
        let mut mesh = TriMesh::default();
        for triangle in self.triangles.into_iter().flatten() {
            let renumbered = triangle.map(|v| {
                let n = &mut number[v as usize];
                if *n == u32::MAX {
                    *n = mesh.points.len() as u32;
                    mesh.points.push(self.points[v as usize]);
                }
                *n
            });
            mesh.triangles.push(renumbered);
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::ClosestPoints;
    use crate::locate::test_shapes::sphere;
    use crate::mesh::SurfaceCheck;

    #[test]
    fn keeps_volume_topology_and_shape() {
        let (points, triangles) = sphere(40, 60);
        let full = TriMesh::new(
            points.iter().map(|p| Vec3::new(p.x * 3.0, p.y + 100.0, p.z * 0.7)).collect(),
            triangles,
        )
        .unwrap();
        let coarse = simplify(&full, 400);
        assert!((390..=400).contains(&coarse.triangles.len()), "{}", coarse.triangles.len());
        assert!(SurfaceCheck::new(&coarse).sentences(&coarse).is_empty());
        assert!((coarse.volume() / full.volume() - 1.0).abs() < 1e-3);
        let closest = ClosestPoints::new(&coarse.points, &coarse.triangles);
        let far = full.points.iter().map(|p| closest.closest(p).unwrap().distance);
        assert!(far.fold(0.0, f64::max) < 0.06);
    }

    #[test]
    fn stops_where_nothing_can_be_collapsed() {
        let (points, triangles) = sphere(2, 3);
        let coarse = simplify(&TriMesh::new(points, triangles).unwrap(), 1);
        assert!(SurfaceCheck::new(&coarse).is_closed());
    }
}
