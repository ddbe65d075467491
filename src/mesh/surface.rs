//! Surfaces: the boundary of a tet mesh, and what is wrong with a triangle mesh.

use std::collections::HashMap;

use super::adjacency::components;
use super::tet_mesh::tet_faces;
use super::{TetMesh, TriMesh};
use crate::math::Vec3;

/// The faces that belong to one tet only, counter-clockwise seen from outside, in the order of
/// their tets; vertex indices are those of the tet mesh.
pub fn boundary_triangles(mesh: &TetMesh) -> Vec<[u32; 3]> {
    let neighbours = super::adjacency::tet_neighbours(mesh);
    let of_tet = |t: usize| {
        let across = neighbours[t];
        let own = tet_faces(&mesh.tets[t]).into_iter().enumerate();
        own.filter(move |(k, _)| across[*k].is_none()).map(|(_, face)| face)
    };
    (0..mesh.tets.len()).flat_map(of_tet).collect()
}

/// What keeps a triangle mesh from being the boundary of a solid.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SurfaceCheck {
    /// Edges of one triangle only: the rims of holes.
    pub open_edges: Vec<[u32; 2]>,
    /// Edges of more than two triangles.
    pub crowded_edges: Vec<[u32; 2]>,
    /// Edges whose two triangles disagree about which side is outside.
    pub flipped_edges: Vec<[u32; 2]>,
    /// Triangles without area, or with a vertex used twice.
    pub empty_triangles: Vec<u32>,
    /// Vertices at the same place as another one, of lower index.
    pub double_vertices: Vec<u32>,
    /// Vertices that no triangle uses.
    pub unused_vertices: Vec<u32>,
    /// Number of connected pieces.
    pub components: usize,
}

impl SurfaceCheck {
    /// Looks at a mesh.
    pub fn new(mesh: &TriMesh) -> Self {
        let mut check = Self::default();
        check.count_edges(mesh);
        check.empty_triangles =
            (0..mesh.triangles.len()).filter(|&t| is_empty(mesh, t)).map(|t| t as u32).collect();
        let mut used = vec![false; mesh.points.len()];
        mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        check.unused_vertices =
            (0..mesh.points.len() as u32).filter(|&v| !used[v as usize]).collect();
        check.double_vertices = double_vertices(&mesh.points);
        let numbers = components(mesh.points.len(), &mesh.triangles);
        check.components = numbers.iter().max().map_or(0, |&last| last as usize + 1);
        check
    }

    fn count_edges(&mut self, mesh: &TriMesh) {
        let mut uses: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * mesh.triangles.len());
        for &[a, b, c] in &mesh.triangles {
            uses.extend([(a, b), (b, c), (c, a)].map(|(i, j)| ([i.min(j), i.max(j)], i < j)));
        }
        uses.sort_unstable();
        for run in uses.chunk_by(|x, y| x.0 == y.0) {
            match run {
                [(edge, _)] => self.open_edges.push(*edge),
                [(edge, first), (_, second)] => {
                    if first == second {
                        self.flipped_edges.push(*edge);
                    }
                }
                _ => self.crowded_edges.push(run[0].0),
            }
        }
    }

    /// Whether the surface encloses a solid, as far as its edges tell (it may still cut itself).
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_empty()
            && self.crowded_edges.is_empty()
            && self.flipped_edges.is_empty()
            && self.components > 0
    }

    /// What is wrong, one sentence per kind, with a place to look at; empty for a clean mesh.
    pub fn sentences(&self, mesh: &TriMesh) -> Vec<String> {
        let at = |v: u32| {
            let p = mesh.points[v as usize];
            format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z)
        };
        let mut sentences = Vec::new();
        let mut edges = |list: &[[u32; 2]], what: &str| {
            if let Some([a, b]) = list.first() {
                let (n, place) = (list.len(), at(*a));
                sentences.push(format!(
                    "{n} edges {what}, the first between vertices {a} and {b} at {place}"
                ));
            }
        };
        edges(&self.open_edges, "border a hole");
        edges(&self.crowded_edges, "belong to more than two triangles");
        edges(&self.flipped_edges, "lie between triangles that face opposite ways");
        if let Some(t) = self.empty_triangles.first() {
            let n = self.empty_triangles.len();
            sentences.push(format!("{n} triangles have no area, the first is triangle {t}"));
        }
        if let Some(&v) = self.double_vertices.first() {
            let (n, place) = (self.double_vertices.len(), at(v));
            sentences.push(format!(
                "{n} vertices lie exactly on another one, the first is vertex {v} at {place}"
            ));
        }
        if let Some(v) = self.unused_vertices.first() {
            let n = self.unused_vertices.len();
            sentences.push(format!("{n} vertices belong to no triangle, the first is vertex {v}"));
        }
        if self.components > 1 {
            sentences.push(format!("the surface has {} separate pieces", self.components));
        }
        sentences
    }
}

fn is_empty(mesh: &TriMesh, t: usize) -> bool {
    let [i, j, k] = mesh.triangles[t];
    let [a, b, c] = mesh.corners(t);
    let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
    i == j || j == k || k == i || (b - a).cross(&(c - a)).norm() <= 1e-14 * longest
}

fn double_vertices(points: &[Vec3]) -> Vec<u32> {
    let mut seen = HashMap::with_capacity(points.len());
    let mut doubles = Vec::new();
    for (v, p) in points.iter().enumerate() {
        // Adding 0 makes -0 and 0 one place.
        let key = [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
        if seen.insert(key, v).is_some() {
            doubles.push(v as u32);
        }
    }
    doubles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tet_surface() -> TriMesh {
        let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        TriMesh::new(points, tet_faces(&[0, 1, 2, 3]).to_vec()).unwrap()
    }

    #[test]
    fn the_boundary_of_tets_is_closed_and_faces_outwards() {
        let mut points = tet_surface().points;
        points.push(Vec3::repeat(1.0));
        let mesh = TetMesh::new(points.clone(), vec![[0, 1, 2, 3], [1, 2, 3, 4]]).unwrap();
        let surface = TriMesh::new(points, boundary_triangles(&mesh)).unwrap();
        assert_eq!(surface.triangles.len(), 6);
        assert!(SurfaceCheck::new(&surface).is_closed());
        assert!((surface.volume() - mesh.total_volume()).abs() < 1e-15);
    }

    #[test]
    fn each_fault_is_found() {
        let clean = tet_surface();
        assert!(SurfaceCheck::new(&clean).sentences(&clean).is_empty());
        let mut broken = clean.clone();
        broken.triangles.pop();
        assert_eq!(SurfaceCheck::new(&broken).open_edges.len(), 3);
        let mut flipped = clean.clone();
        flipped.triangles[0].swap(0, 1);
        assert_eq!(SurfaceCheck::new(&flipped).flipped_edges.len(), 3);
        let mut more = clean.clone();
        more.points.extend([Vec3::x(), Vec3::new(9.0, 9.0, 9.0)]);
        more.triangles.extend([[0, 1, 4], [2, 1, 0]]);
        let check = SurfaceCheck::new(&more);
        assert_eq!((check.double_vertices.len(), check.unused_vertices.len()), (1, 1));
        assert_eq!(check.empty_triangles, [4]);
        assert!(!check.crowded_edges.is_empty());
        assert!(check.sentences(&more).len() >= 4);
        assert!(!SurfaceCheck::new(&TriMesh::default()).is_closed());
    }
}
