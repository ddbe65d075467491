//! Points carried by a tet mesh: each is a weighted sum of the corners of one tet.

use std::cmp::Reverse;

use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree};
use super::triangle::{at, closest_on_triangle};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TetMesh;

/// The faces of a tet, each opposite to the corner of its index, normals outwards.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Where each of a list of points lies in a tet mesh. Points outside are extrapolated from the
/// nearest tet, with weights below 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Embedding {
    /// The tet of each point.
    pub tets: Vec<u32>,
    /// Its corners: vertices of the tet mesh.
    pub vertices: Vec<[u32; 4]>,
    /// Their weights, sum 1; all at least 0 (to rounding) for points inside.
    pub weights: Vec<[f64; 4]>,
}

impl Embedding {
    /// Finds the tet of each point; of several that hold it, the lowest index. Fails for a mesh
    /// without tets and for points that are not finite.
    pub fn new(mesh: &TetMesh, points: &[Vec3]) -> Result<Self> {
        let locator = TetLocator::new(mesh)?;
        if let Some(i) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::invalid(format!(
                "point {i} to be carried along has a coordinate that is not a finite number"
            )));
        }
        let tets: Vec<u32> =
            points.par_iter().with_min_len(64).map(|p| locator.tet_of(p)).collect();
        Ok(Self::in_tets(mesh, points, tets))
    }

    /// Like [`Self::new`] where the tet of most points is known already.
    pub fn in_known_tets(mesh: &TetMesh, points: &[Vec3], known: &[Option<u32>]) -> Result<Self> {
        let unknown: Vec<Vec3> =
            points.iter().zip(known).filter(|(_, k)| k.is_none()).map(|(p, _)| *p).collect();
        let mut found = if unknown.is_empty() {
            Vec::new().into_iter()
        } else {
            Self::new(mesh, &unknown)?.tets.into_iter()
        };
        let tets = known.iter().filter_map(|known| known.or_else(|| found.next())).collect();
        Ok(Self::in_tets(mesh, points, tets))
    }

    /// Embeds each point in the tet given for it.
    pub fn in_tets(mesh: &TetMesh, points: &[Vec3], tets: Vec<u32>) -> Self {
        let weights =
            points.iter().zip(&tets).map(|(p, &t)| tet_weights(&mesh.corners(t as usize), p));
        let weights = weights.collect();
        let vertices = tets.iter().map(|&t| mesh.tets[t as usize]).collect();
        Self { tets, vertices, weights }
    }

    /// Each point is a vertex of the mesh: `vertices[i]` for point i, in some tet that uses it.
    /// Fails for a vertex that no tet uses.
    pub fn at_vertices(mesh: &TetMesh, vertices: &[u32]) -> Result<Self> {
        let mut tet_of = vec![u32::MAX; mesh.points.len()];
        for (t, tet) in mesh.tets.iter().enumerate().rev() {
            for &v in tet {
                tet_of[v as usize] = t as u32;
            }
        }
        let mut embedding = Self::default();
        for &v in vertices {
            let t = tet_of.get(v as usize).copied().filter(|&t| t != u32::MAX);
            let t = t.ok_or_else(|| Error::invalid(format!("no tet uses vertex {v}")))?;
            let tet = mesh.tets[t as usize];
            embedding.tets.push(t);
            embedding.vertices.push(tet);
            embedding.weights.push(tet.map(|corner| f64::from(u8::from(corner == v))));
        }
        Ok(embedding)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.tets.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.tets.is_empty()
    }

    /// Position of point `i` for the given positions of the mesh's vertices.
    pub fn position(&self, i: usize, tet_points: &[Vec3]) -> Vec3 {
        let (vertices, weights) = (&self.vertices[i], &self.weights[i]);
        (0..4).fold(Vec3::zeros(), |sum, k| sum + tet_points[vertices[k] as usize] * weights[k])
    }

    /// Positions of all points for the given positions of the mesh's vertices.
    pub fn apply(&self, tet_points: &[Vec3]) -> Vec<Vec3> {
        (0..self.len()).map(|i| self.position(i, tet_points)).collect()
    }
}

/// Barycentric coordinates of `p` in a tet of non-zero volume; sum 1, negative beyond a face.
pub fn tet_weights([a, b, c, d]: &[Vec3; 4], p: &Vec3) -> [f64; 4] {
    let (ab, ac, ad, ap) = (b - a, c - a, d - a, p - a);
    let volume = ab.cross(&ac).dot(&ad);
    let wb = ap.cross(&ac).dot(&ad) / volume;
    let wc = ab.cross(&ap).dot(&ad) / volume;
    let wd = ab.cross(&ac).dot(&ap) / volume;
    [1.0 - wb - wc - wd, wb, wc, wd]
}

/// Finds the tet that holds a point, or the nearest one.
struct TetLocator<'a> {
    mesh: &'a TetMesh,
    tree: BoxTree,
}

impl<'a> TetLocator<'a> {
    fn new(mesh: &'a TetMesh) -> Result<Self> {
        if mesh.tets.is_empty() {
            return Err(Error::invalid("the tet mesh has no tets, nothing can be carried by it"));
        }
        let bounds: Vec<Bounds> =
            (0..mesh.tets.len()).map(|t| Bounds::of(&mesh.corners(t))).collect();
        Ok(Self { mesh, tree: BoxTree::new(&bounds) })
    }

    fn tet_of(&self, p: &Vec3) -> u32 {
        let nearest = self.tree.nearest(p, f64::INFINITY, |t, _| {
            (distance_squared_to_tet(&self.mesh.corners(t as usize), p), ())
        });
        let (nearest, distance_squared, ()) = nearest.expect("there is at least one tet");
        if distance_squared == 0.0 {
            return nearest;
        }
        // Outside, several tets may share the closest vertex or edge: the one that extrapolates
        // least is the safest.
        let limit = distance_squared.sqrt() * (1.0 + 1e-9);
        let mut best = (nearest, f64::NEG_INFINITY);
        self.tree.visit_within(p, limit, |t| {
            let corners = self.mesh.corners(t as usize);
            if distance_squared_to_tet(&corners, p) <= limit * limit {
                let least = tet_weights(&corners, p).into_iter().fold(f64::INFINITY, f64::min);
                if (least, Reverse(t)) > (best.1, Reverse(best.0)) {
                    best = (t, least);
                }
            }
        });
        best.0
    }
}

/// 0 for a point inside.
fn distance_squared_to_tet(corners: &[Vec3; 4], p: &Vec3) -> f64 {
    if tet_weights(corners, p).iter().all(|&w| w >= 0.0) {
        return 0.0;
    }
    let to_face = |face: [usize; 3]| {
        let triangle = face.map(|k| corners[k]);
        (at(&closest_on_triangle(p, &triangle), &triangle) - p).norm_squared()
    };
    FACES.into_iter().map(to_face).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::Noise;

    /// The unit cube in six tets around its diagonal.
    fn cube() -> TetMesh {
        let points = (0..8)
            .map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let ring = [1, 3, 2, 6, 4, 5];
        let tets = (0..6).map(|i| [0, ring[i], ring[(i + 1) % 6], 7]).collect();
        TetMesh::new(points, tets).unwrap()
    }

    #[test]
    fn carries_any_affine_map_inside_and_outside() {
        let mesh = cube();
        let mut noise = Noise::new(1);
        let points: Vec<Vec3> = (0..200).map(|_| noise.vector() * 1.5).collect();
        let embedding = Embedding::new(&mesh, &points).unwrap();
        let map = |p: &Vec3| Vec3::new(2.0 * p.x + p.y, p.z - 1.0, 0.3 * p.x - p.z + p.y);
        let moved: Vec<Vec3> = mesh.points.iter().map(map).collect();
        for (i, (p, q)) in points.iter().zip(embedding.apply(&moved)).enumerate() {
            assert!((map(p) - q).norm() < 1e-13);
            let inside = p.iter().all(|&c| (0.0..=1.0).contains(&c));
            assert_eq!(inside, embedding.weights[i].iter().all(|&w| w >= -1e-15));
            let sum: f64 = embedding.weights[i].iter().sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn vertices_are_carried_exactly_and_bad_input_is_named() {
        let mesh = cube();
        let embedding = Embedding::at_vertices(&mesh, &[7, 2, 0]).unwrap();
        assert_eq!(
            embedding.apply(&mesh.points),
            vec![mesh.points[7], mesh.points[2], mesh.points[0]]
        );
        assert!(Embedding::at_vertices(&mesh, &[8]).is_err());
        assert!(Embedding::new(&TetMesh::default(), &[Vec3::zeros()]).is_err());
        assert!(Embedding::new(&mesh, &[Vec3::repeat(f64::NAN)]).is_err());
    }
}
