//! Flat lids: where a scan ends and was closed.
//!
//! Programs close a surface that a plane cuts off. On the lid there is no bone: what lies beyond was not seen,
//! as beyond an open edge.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::{DisjointSets, components, first_at_place, renumbered};
use crate::mesh::diagonal;
use crate::mesh::normals::unit_or_zero;

/// A face is flat up to this share of its piece's diagonal: single precision and six digits are finer, the
/// curvature of bones is not.
const FLAT: f64 = 1e-5;
/// A lid is as large as a circle of this radius, as a share of the diagonal, which nothing round is at that
/// flatness,
const LEAST_RADIUS: f64 = 0.003;
/// and has so many triangles: after coarse simplification each is flat by itself.
const LEAST_TRIANGLES: usize = 6;
/// A piece with more of its area in flat faces is made of them (boxes, voxels): none is a lid.
const MOST_FLAT: f64 = 0.5;

/// Unit normal, and distance from the origin along it.
struct Plane {
    normal: Vec3,
    offset: f64,
}

impl Plane {
    fn through(point: &Vec3, normal: &Vec3) -> Self {
        let normal = unit_or_zero(normal);
        Self { normal, offset: normal.dot(point) }
    }

    fn height(&self, p: &Vec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    fn holds(&self, corners: &[Vec3; 3], flat: f64) -> bool {
        corners.iter().all(|p| self.height(p).abs() <= flat)
    }
}

/// Takes the lids out of a surface; how many there were.
pub(super) fn open_lids(mesh: &mut TriMesh) -> usize {
    let first = first_at_place(&mesh.points);
    let joined = renumbered(&mesh.triangles, &first);
    let piece_of = components(mesh.points.len(), &joined);
    let count = piece_of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut pieces = vec![Vec::new(); count];
    for (t, &piece) in piece_of.iter().enumerate() {
        pieces[piece as usize].push(t);
    }
    let mut lids = 0;
    let mut is_lid = vec![false; joined.len()];
    for own in pieces {
        let piece = Piece::new(mesh, &joined, &own);
        let planes = piece.lids();
        lids += planes.len();
        for (&t, corners) in own.iter().zip(&piece.corners) {
            is_lid[t] = planes.iter().any(|plane| plane.holds(corners, piece.flat));
        }
    }
    if lids > 0 {
        *mesh = mesh.part(|t| !is_lid[t]);
    }
    lids
}

/// Triangles that hang together.
struct Piece {
    places: Vec<[u32; 3]>,
    corners: Vec<[Vec3; 3]>,
    /// Twice their areas, along their normals.
    normals: Vec<Vec3>,
    /// Heights up to this are none.
    flat: f64,
}

impl Piece {
    fn new(mesh: &TriMesh, joined: &[[u32; 3]], own: &[usize]) -> Self {
        let corners: Vec<[Vec3; 3]> = own.iter().map(|&t| mesh.corners(t)).collect();
        Self {
            places: own.iter().map(|&t| joined[t]).collect(),
            normals: corners.iter().map(|[a, b, c]| (b - a).cross(&(c - a))).collect(),
            flat: FLAT * diagonal(corners.as_flattened()),
            corners,
        }
    }

    /// The planes of its lids: all of it lies on one side of them.
    fn lids(&self) -> Vec<Plane> {
        let faces = self.flat_faces();
        let whole: f64 = self.normals.iter().map(Vec3::norm).sum();
        if faces.iter().map(|(_, area)| area).sum::<f64>() > MOST_FLAT * whole {
            return Vec::new();
        }
        let least = 2.0 * PI * (LEAST_RADIUS / FLAT * self.flat).powi(2);
        let large = faces.into_iter().filter(|(_, area)| *area > least).map(|(plane, _)| plane);
        let mut lids: Vec<Plane> = Vec::new();
        for plane in large {
            let heights = || self.corners.as_flattened().iter().map(|p| plane.height(p));
            let ends_it = heights().all(|h| h <= self.flat) || heights().all(|h| h >= -self.flat);
            let same = |lid: &Plane| {
                lid.normal.dot(&plane.normal) > 0.0
                    && lid.height(&(plane.offset * plane.normal)).abs() <= self.flat
            };
            if ends_it && !lids.iter().any(same) {
                lids.push(plane);
            }
        }
        lids
    }

    /// Planes of the faces of several triangles, with twice their areas.
    fn flat_faces(&self) -> Vec<(Plane, f64)> {
        let mut sets = DisjointSets::new(self.places.len());
        for [i, j] in self.neighbours() {
            let (less, more) =
                if self.normals[i].norm() < self.normals[j].norm() { (i, j) } else { (j, i) };
            let plane = Plane::through(&self.corners[more][0], &self.normals[more]);
            if plane.holds(&self.corners[less], self.flat) {
                sets.join(i as u32, j as u32);
            }
        }
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for t in 0..self.places.len() {
            members.entry(sets.root(t as u32)).or_default().push(t);
        }
        let face = |own: Vec<usize>| {
            let normal = own.iter().map(|&t| self.normals[t]).sum();
            let plane = Plane::through(&self.corners[own[0]][0], &normal);
            let is_flat = own.iter().all(|&t| plane.holds(&self.corners[t], self.flat));
            is_flat.then_some((plane, normal.norm()))
        };
        let several = members.into_values().filter(|own| own.len() >= LEAST_TRIANGLES);
        several.filter_map(face).collect()
    }

    /// Triangles on both sides of an edge.
    fn neighbours(&self) -> Vec<[usize; 2]> {
        let around = |(t, &[a, b, c]): (usize, &[u32; 3])| {
            [[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], t))
        };
        let mut edges: Vec<([u32; 2], usize)> =
            self.places.iter().enumerate().flat_map(around).collect();
        edges.sort_unstable();
        let shared = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2);
        shared.map(|same| [same[0].1, same[1].1]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::register::skeleton::tests::block;

    /// The part of a ball below `height`; what is above is pressed onto a lid.
    fn ball_closed_at(height: f64) -> TriMesh {
        let (mut points, triangles) = sphere(40, 80);
        for p in &mut points {
            p.z = p.z.min(height);
        }
        TriMesh { points, triangles }
    }

    fn opened(mut mesh: TriMesh) -> (usize, usize) {
        let before = mesh.triangles.len();
        let lids = open_lids(&mut mesh);
        (lids, before - mesh.triangles.len())
    }

    #[test]
    fn a_flat_end_is_taken_out_and_what_is_round_or_made_of_flat_faces_stays() {
        let cut = ball_closed_at(0.4);
        let above = |t: usize| cut.corners(t).iter().all(|p| p.z >= 0.4);
        let expected = (0..cut.triangles.len()).filter(|&t| above(t)).count();
        assert_eq!(opened(cut.clone()), (1, expected));
        // Both ends, and a second piece.
        let mut twice = cut.clone();
        twice.points.iter_mut().for_each(|p| p.z = p.z.max(-0.5));
        let far: Vec<Vec3> =
            ball_closed_at(2.0).points.iter().map(|p| p + 5.0 * Vec3::x()).collect();
        twice.append(&TriMesh { points: far, triangles: cut.triangles.clone() });
        assert_eq!(opened(twice).0, 2);
        assert_eq!(opened(ball_closed_at(2.0)), (0, 0));
        assert_eq!(opened(block(Vec3::zeros(), Vec3::new(4.0, 2.0, 1.0), 6)), (0, 0));
        // Without any area there is no face.
        let points = vec![Vec3::repeat(1.0); cut.points.len()];
        assert_eq!(opened(TriMesh { points, ..cut.clone() }), (0, 0));
        // A dent is no end.
        let dented = |p: &Vec3| if p.z > 0.6 && p.xy().norm() < 0.5 { p.z.min(0.62) } else { p.z };
        let mut ball = ball_closed_at(2.0);
        ball.points = ball.points.iter().map(|p| Vec3::new(p.x, p.y, dented(p))).collect();
        assert_eq!(opened(ball).0, 0);
    }
}
