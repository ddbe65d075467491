//! What is done to a target's surface before it is used: lids are opened, noise is smoothed, what faces inwards
//! is turned.

use super::lids::open_lids;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::{components, first_at_place, renumbered, vertex_neighbours};
use crate::mesh::normals::{area_vectors, unit_or_zero};

/// Triangles agree with those around them from this mean cosine on. A bone's surface has .95 and more, one
/// with noise as large as its edges .5.
const AGREEMENT: f64 = 0.8;
/// Rounds of smoothing, at most.
const MOST_ROUNDS: usize = 12;

/// A surface ready for the search.
pub(super) struct Prepared {
    pub(super) mesh: TriMesh,
    /// Flat ends that were taken out.
    pub(super) lids: usize,
    /// Its triangles faced inwards.
    pub(super) turned: bool,
    /// It was noisy.
    pub(super) smoothed: bool,
}

impl Prepared {
    pub(super) fn new(mut mesh: TriMesh) -> Self {
        let lids = open_lids(&mut mesh);
        // One number for all vertices of a place, so that seams do not count as edges.
        let first = first_at_place(&mesh.points);
        let joined = renumbered(&mesh.triangles, &first);
        let steady = smoothed(&mesh.points, &joined, &first);
        let smoothed = steady.is_some();
        let mesh = TriMesh { points: steady.unwrap_or(mesh.points), ..mesh };
        let (mesh, turned) = facing_outwards(mesh, &joined);
        Self { mesh, lids, turned, smoothed }
    }
}

/// The surface with its normals outwards, and whether it was turned: by the volume that its pieces
/// enclose, each seen from its own middle, so that open pieces count by the way they bulge.
fn facing_outwards(mut mesh: TriMesh, joined: &[[u32; 3]]) -> (TriMesh, bool) {
    let piece = components(mesh.points.len(), joined);
    let count = piece.iter().max().map_or(0, |&last| last as usize + 1);
    let mut middle = vec![(Vec3::zeros(), 0.0); count];
    for (triangle, &piece) in mesh.triangles.iter().zip(&piece) {
        let (sum, corners) = &mut middle[piece as usize];
        *sum += triangle.iter().map(|&v| mesh.points[v as usize]).sum::<Vec3>();
        *corners += 3.0;
    }
    let volume: f64 = (0..mesh.triangles.len())
        .map(|t| {
            let (sum, corners) = middle[piece[t] as usize];
            let [a, b, c] = mesh.corners(t).map(|p| p - sum / corners);
            a.dot(&b.cross(&c))
        })
        .sum();
    if volume < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    (mesh, volume < 0.0)
}

/// The points smoothed: vertices go towards the mean of their neighbours until triangles agree with those
/// around them. None where they do.
fn smoothed(points: &[Vec3], triangles: &[[u32; 3]], first: &[u32]) -> Option<Vec<Vec3>> {
    if agreement(points, triangles) > AGREEMENT {
        return None;
    }
    let neighbours = vertex_neighbours(points.len(), triangles);
    let mut points = points.to_vec();
    for _ in 0..MOST_ROUNDS {
        let towards_mean = |&v: &u32| {
            let (own, near) = (points[v as usize], neighbours.of(v as usize));
            let sum: Vec3 = near.iter().map(|&n| points[n as usize]).sum();
            if near.is_empty() { own } else { (own + sum / near.len() as f64) / 2.0 }
        };
        points = first.iter().map(towards_mean).collect();
        if agreement(&points, triangles) > AGREEMENT {
            break;
        }
    }
    Some(points)
}

/// How far triangles agree with those around them: the mean cosine of their normals.
fn agreement(points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let faces = area_vectors(points, triangles);
    let mut sums = vec![Vec3::zeros(); points.len()];
    for (triangle, face) in triangles.iter().zip(&faces) {
        for &v in triangle {
            sums[v as usize] += face;
        }
    }
    let around = |t: &[u32; 3]| t.iter().map(|&v| sums[v as usize]).sum::<Vec3>();
    let agreeing = triangles.iter().zip(&faces).map(|(t, f)| f.dot(&unit_or_zero(&around(t))));
    agreeing.sum::<f64>() / faces.iter().map(Vec3::norm).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};
    use crate::register::skeleton::tests::block;

    #[test]
    fn surfaces_that_face_inwards_are_turned_open_ones_too() {
        let mut mesh = block(Vec3::new(30.0, 0.0, 0.0), Vec3::new(4.0, 2.0, 1.0), 4);
        for _ in 0..2 {
            assert!(!Prepared::new(mesh.clone()).turned);
            let inwards: Vec<_> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
            let inwards = TriMesh { points: mesh.points.clone(), triangles: inwards };
            let Prepared { mesh: outwards, turned, .. } = Prepared::new(inwards);
            assert!(turned && (outwards.volume() - mesh.volume()).abs() < 1e-9);
            // The second round: without one of its ends.
            mesh.triangles.drain(..mesh.triangles.len() / 6);
        }
    }

    #[test]
    fn only_a_surface_of_noise_is_smoothed() {
        let (points, triangles) = sphere(20, 40);
        let clean = TriMesh { points, triangles };
        assert!(!Prepared::new(clean.clone()).smoothed);
        let mut noise = Noise::new(3);
        let mut noisy = clean.clone();
        for point in &mut noisy.points {
            *point += 0.1 * noise.vector();
        }
        let off = |mesh: &TriMesh| {
            let squares: f64 = mesh.points.iter().map(|p| (p.norm() - 1.0).powi(2)).sum();
            (squares / mesh.points.len() as f64).sqrt()
        };
        let prepared = Prepared::new(noisy.clone());
        assert!(prepared.smoothed && !prepared.turned);
        assert!(off(&prepared.mesh) < 0.6 * off(&noisy), "{} {}", off(&prepared.mesh), off(&noisy));
    }
}
