//! Who is next to whom: edges, vertex neighbours, tet neighbours.

use super::tet_mesh::tet_faces;
use std::collections::HashMap;

use super::TetMesh;
use crate::math::Vec3;

/// Many short lists in one array.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Lists {
    /// List `of` gets `entry` for each pair (of, entry), in the order of the pairs.
    fn from_pairs(count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0_u32; count + 1];
        for (of, _) in pairs.clone() {
            starts[of as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; starts[count] as usize];
        for (of, entry) in pairs {
            entries[next[of as usize] as usize] = entry;
            next[of as usize] += 1;
        }
        Self { starts, entries }
    }

    /// List `i`.
    pub fn of(&self, i: usize) -> &[u32] {
        &self.entries[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Number of lists.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no lists.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The edges of polygons or tets (all pairs of corners), lower vertex first, each once, sorted.
pub fn edges<const N: usize>(cells: &[[u32; N]]) -> Vec<[u32; 2]> {
    let mut edges = Vec::with_capacity(cells.len() * N * (N - 1) / 2);
    for cell in cells {
        for i in 0..N {
            for j in 0..i {
                edges.push([cell[i].min(cell[j]), cell[i].max(cell[j])]);
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The vertices that share an edge with each vertex, ascending.
pub fn vertex_neighbours<const N: usize>(vertex_count: usize, cells: &[[u32; N]]) -> Lists {
    let mut both: Vec<[u32; 2]> = edges(cells);
    both.extend(both.clone().into_iter().map(|[a, b]| [b, a]));
    both.sort_unstable();
    Lists::from_pairs(vertex_count, both.into_iter().map(|[a, b]| (a, b)))
}

/// The tet across each face of each tet (face k lies opposite to corner k); None at the boundary.
/// Where more than two tets share a face, they are paired in ascending order.
pub fn tet_neighbours(mesh: &TetMesh) -> Vec<[Option<u32>; 4]> {
    let mut faces: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * mesh.tets.len());
    for (t, tet) in mesh.tets.iter().enumerate() {
        for (k, face) in tet_faces(tet).into_iter().enumerate() {
            let mut key = face;
            key.sort_unstable();
            faces.push((key, t as u32, k as u8));
        }
    }
    faces.sort_unstable();
    let mut neighbours = vec![[None; 4]; mesh.tets.len()];
    let mut i = 0;
    while i + 1 < faces.len() {
        let ((key, t, k), (next_key, u, l)) = (faces[i], faces[i + 1]);
        if key != next_key {
            i += 1;
            continue;
        }
        neighbours[t as usize][k as usize] = Some(u);
        neighbours[u as usize][l as usize] = Some(t);
        i += 2;
    }
    neighbours
}

/// Number of the connected component of each cell, cells being connected by shared vertices.
/// Numbers count from 0 in the order of the first cell of each.
pub fn components<const N: usize>(vertex_count: usize, cells: &[[u32; N]]) -> Vec<u32> {
    let mut sets = DisjointSets::new(vertex_count);
    for cell in cells {
        for &v in cell {
            sets.join(cell[0], v);
        }
    }
    let mut number = vec![u32::MAX; vertex_count];
    let mut count = 0;
    let number_of = |cell: &[u32; N]| {
        let root = sets.root(cell[0]) as usize;
        if number[root] == u32::MAX {
            number[root] = count;
            count += 1;
        }
        number[root]
    };
    cells.iter().map(number_of).collect()
}

/// For each vertex the first one at exactly the same place: seams of textures and STL files are one there.
/// (Adding 0 makes -0 and 0 one place.)
pub fn first_at_place(points: &[Vec3]) -> Vec<u32> {
    let mut first_at: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    let place = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
    let points = points.iter().enumerate();
    points.map(|(v, p)| *first_at.entry(place(p)).or_insert(v as u32)).collect()
}

/// Cells with other numbers for their vertices.
pub fn renumbered<const N: usize>(cells: &[[u32; N]], number: &[u32]) -> Vec<[u32; N]> {
    cells.iter().map(|cell| cell.map(|v| number[v as usize])).collect()
}

/// Union-find; the root of a set is its lowest member.
#[derive(Clone, Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// `count` sets of one member each.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The lowest member of the set of `i`.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    /// Makes one set of those of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn two_tets() -> TetMesh {
        let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), Vec3::repeat(1.0)];
        TetMesh::new(points, vec![[0, 1, 2, 3], [1, 2, 3, 4]]).unwrap()
    }

    #[test]
    fn neighbours_of_two_tets() {
        let mesh = two_tets();
        assert_eq!(edges(&mesh.tets).len(), 9);
        let around = vertex_neighbours(5, &mesh.tets);
        assert_eq!(around.of(0), [1, 2, 3]);
        assert_eq!(around.of(1), [0, 2, 3, 4]);
        let across = tet_neighbours(&mesh);
        assert_eq!(across[0], [Some(1), None, None, None]);
        assert_eq!(across[1].iter().filter(|n| **n == Some(0)).count(), 1);
    }

    #[test]
    fn components_are_numbered_in_order() {
        let triangles = [[4, 5, 6], [0, 1, 2], [6, 7, 8], [2, 3, 0]];
        assert_eq!(components(9, &triangles), [0, 1, 0, 1]);
    }
}
