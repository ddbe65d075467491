//! What happens to scans: pieces missing, noise, things that do not belong there.

use std::collections::HashSet;

use moulage::TriMesh;
use moulage::math::Vec3;
use moulage::mesh::adjacency::components;
use moulage::mesh::normals::area_vectors;

use super::Noise;

/// Near enough to a normal distribution of deviation 1.
fn normal(noise: &mut Noise) -> f64 {
    (0..12).map(|_| noise.next()).sum::<f64>() / 2.0
}

fn index(noise: &mut Noise, count: usize) -> usize {
    (f64::midpoint(noise.next(), 1.0) * count as f64) as usize
}

pub fn centroid(mesh: &TriMesh) -> Vec3 {
    mesh.points.iter().sum::<Vec3>() / mesh.points.len() as f64
}

/// Unit vectors of largest and of smallest spread.
fn axes(mesh: &TriMesh) -> [Vec3; 2] {
    let centre = centroid(mesh);
    let spread = mesh.points.iter().map(|p| (p - centre) * (p - centre).transpose()).sum();
    let eigen = nalgebra::SymmetricEigen::new(spread);
    [eigen.eigenvalues.imax(), eigen.eigenvalues.imin()]
        .map(|k| eigen.eigenvectors.column(k).into())
}

/// The triangles that `keep` holds, with the vertices they use.
pub fn kept(mesh: &TriMesh, keep: impl Fn(usize) -> bool) -> TriMesh {
    let mut number = vec![u32::MAX; mesh.points.len()];
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        if keep(t) {
            triangles.push(triangle.map(|v| {
                let slot = &mut number[v as usize];
                if *slot == u32::MAX {
                    *slot = points.len() as u32;
                    points.push(mesh.points[v as usize]);
                }
                *slot
            }));
        }
    }
    TriMesh { points, triangles }
}

fn middle(mesh: &TriMesh, t: usize) -> Vec3 {
    mesh.corners(t).iter().sum::<Vec3>() / 3.0
}

/// A plane across the longest axis, at its one end or the other: its normal, and the place on it beyond which
/// a share of the triangles lies.
fn cutting_plane(mesh: &TriMesh, share: f64, far_end: bool) -> (Vec3, f64) {
    let axis = axes(mesh)[0] * if far_end { 1.0 } else { -1.0 };
    let mut along: Vec<f64> =
        (0..mesh.triangles.len()).map(|t| axis.dot(&middle(mesh, t))).collect();
    along.sort_by(f64::total_cmp);
    (axis, along[((1.0 - share) * (along.len() - 1) as f64) as usize])
}

/// Without the outermost share of the triangles along the longest axis, at its one end or the other.
pub fn cut(mesh: &TriMesh, share: f64, far_end: bool) -> TriMesh {
    let (axis, edge) = cutting_plane(mesh, share, far_end);
    kept(mesh, |t| axis.dot(&middle(mesh, t)) <= edge)
}

/// The same, cut straight and closed with flat lids.
pub fn cut_and_closed(mesh: &TriMesh, share: f64, far_end: bool) -> TriMesh {
    let (axis, edge) = cutting_plane(mesh, share, far_end);
    let mut part = kept(mesh, |t| mesh.corners(t).iter().any(|p| axis.dot(p) < edge));
    for p in &mut part.points {
        *p -= axis * (axis.dot(p) - edge).max(0.0);
    }
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let all: HashSet<[u32; 2]> = part.triangles.iter().flat_map(sides).collect();
    let rim: Vec<[u32; 2]> =
        part.triangles.iter().flat_map(sides).filter(|[a, b]| !all.contains(&[*b, *a])).collect();
    let loops = components(part.points.len(), &rim);
    for own in 0..=loops.iter().copied().max().unwrap_or(0) {
        let edges: Vec<[u32; 2]> =
            rim.iter().zip(&loops).filter(|(_, l)| **l == own).map(|(e, _)| *e).collect();
        let sum: Vec3 = edges.iter().map(|[a, _]| part.points[*a as usize]).sum();
        let middle = part.points.len() as u32;
        part.points.push(sum / edges.len() as f64);
        part.triangles.extend(edges.iter().map(|[a, b]| [*b, *a, middle]));
    }
    part
}

/// Round holes at random places until this share of the triangles is gone.
pub fn holes(mesh: &TriMesh, share: f64, radius: f64) -> TriMesh {
    let mut noise = Noise(5);
    let mut gone = vec![false; mesh.triangles.len()];
    while gone.iter().filter(|g| **g).count() < (share * gone.len() as f64) as usize {
        let centre = mesh.points[index(&mut noise, mesh.points.len())];
        for (t, gone) in gone.iter_mut().enumerate() {
            *gone |= (middle(mesh, t) - centre).norm() < radius;
        }
    }
    kept(mesh, |t| !gone[t])
}

/// Only the triangles that face along the thinnest axis.
pub fn one_side(mesh: &TriMesh) -> TriMesh {
    let faces = area_vectors(&mesh.points, &mesh.triangles);
    let axis = axes(mesh)[1];
    kept(mesh, |t| faces[t].dot(&axis) > 0.0)
}

pub fn noisy(mesh: &TriMesh, deviation: f64) -> TriMesh {
    let mut noise = Noise(7);
    let mut shaken = mesh.clone();
    for point in &mut shaken.points {
        *point += deviation * Vec3::from_fn(|_, _| normal(&mut noise));
    }
    shaken
}

/// Balls at random places of the surface.
pub fn blobs(mesh: &TriMesh, count: usize, radius: f64) -> TriMesh {
    let mut noise = Noise(11);
    let mut all = mesh.clone();
    for _ in 0..count {
        let centre = mesh.points[index(&mut noise, mesh.points.len())];
        all = joined(&all, &ball(centre, radius, 16));
    }
    all
}

pub fn joined(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let first = a.points.len() as u32;
    let mut all = a.clone();
    all.points.extend_from_slice(&b.points);
    all.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + first)));
    all
}

/// A ball of `rings` rings of triangles.
pub fn ball(centre: Vec3, radius: f64, rings: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    let around = 2 * rings;
    for i in 0..=rings {
        for j in 0..around {
            let polar = std::f64::consts::PI * f64::from(i) / f64::from(rings);
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let out = Vec3::new(
                libm::sin(polar) * libm::cos(turn),
                libm::sin(polar) * libm::sin(turn),
                libm::cos(polar),
            );
            mesh.points.push(centre + radius * out);
        }
    }
    for i in 0..rings {
        for j in 0..around {
            let next = (j + 1) % around;
            let [a, b] = [i * around + j, i * around + next];
            mesh.triangles.push([a, a + around, b + around]);
            mesh.triangles.push([a, b + around, b]);
        }
    }
    mesh
}

pub fn mapped(mesh: &TriMesh, map: impl Fn(&Vec3) -> Vec3) -> TriMesh {
    TriMesh { points: mesh.points.iter().map(map).collect(), triangles: mesh.triangles.clone() }
}

pub fn inside_out(mesh: &TriMesh) -> TriMesh {
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriMesh { points: mesh.points.clone(), triangles }
}
