//! The geometry of the body-centred-cubic lattice, in units of its cell edge.
//!
//! Vertices are the corners and the centres of unit cubes. Two cubes that share a face give four
//! tets: both centres with each edge of the face. All tets are congruent (dihedral angles 60 and 90
//! degrees) and have volume 1/12.

use crate::math::Vec3;

/// Volume of a tet of the lattice with cell edge 1.
pub const TET_VOLUME: f64 = 1.0 / 12.0;

/// A lattice vertex in half cell edges: cube corners are even, cube centres odd.
pub type LatticeVertex = [i32; 3];

/// One tet: the face between cube `cell` and the next one along `axis`, and one of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LatticeTet {
    cell: [i32; 3],
    axis: u8,
    /// Which edge of the face: it lies at the low (0, 2) or high (1, 3) end of the first (0, 1) or
    /// second (2, 3) of the two other axes.
    edge: u8,
}

impl LatticeTet {
    /// The tet that holds `p`; points on a face belong to one of its two tets.
    pub fn at(p: &Vec3) -> Self {
        let mut cell = [0; 3];
        let mut offset = [0.0; 3];
        for k in 0..3 {
            let floor = p[k].floor();
            cell[k] = floor as i32;
            offset[k] = p[k] - floor - 0.5;
        }
        // The largest offset from the centre chooses the face, the second largest its edge.
        let size = |k: usize| offset[k].abs();
        let axis = (1..3).fold(0, |best, k| if size(k) > size(best) { k } else { best });
        let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
        let across = usize::from(size(third) > size(second));
        let high = offset[[second, third][across]] > 0.0;
        if offset[axis] < 0.0 {
            cell[axis] -= 1;
        }
        Self { cell, axis: axis as u8, edge: 2 * across as u8 + u8::from(high) }
    }

    /// All tets that reach into a cube.
    pub fn of_cell(cell: [i32; 3]) -> impl Iterator<Item = Self> {
        (0..24_u8).map(move |i| {
            let (axis, edge, low) = (i / 8, i % 4, i % 8 < 4);
            let mut cell = cell;
            cell[usize::from(axis)] -= i32::from(low);
            Self { cell, axis, edge }
        })
    }

    /// Its corners, so that the volume is positive.
    pub fn vertices(&self) -> [LatticeVertex; 4] {
        let axis = usize::from(self.axis);
        let (across, high) = (usize::from(self.edge / 2), i32::from(self.edge % 2));
        let (m, n) = if across == 0 {
            ((axis + 1) % 3, (axis + 2) % 3)
        } else {
            ((axis + 2) % 3, (axis + 1) % 3)
        };
        let near = self.cell.map(|c| 2 * c + 1);
        let mut far = near;
        far[axis] += 2;
        let mut first = near;
        first[axis] += 1;
        first[m] += 2 * high - 1;
        let mut second = first;
        first[n] -= 1;
        second[n] += 1;
        // Each mirroring (axis order, end of the face) turns the tet around.
        if (across == 0) == (high == 1) {
            [near, far, first, second]
        } else {
            [near, far, second, first]
        }
    }

    /// Positions of its corners.
    pub fn corners(&self) -> [Vec3; 4] {
        self.vertices().map(position)
    }

    /// Its centroid.
    pub fn centroid(&self) -> Vec3 {
        self.corners().iter().sum::<Vec3>() / 4.0
    }

    /// The tet across the face opposite to corner `k`.
    pub fn neighbour(&self, k: usize) -> Self {
        let corners = self.corners();
        let centroid = self.centroid();
        let face = (centroid * 4.0 - corners[k]) / 3.0;
        Self::at(&(face + (face - centroid) * 0.5))
    }
}

/// Position of a lattice vertex.
pub fn position(vertex: LatticeVertex) -> Vec3 {
    Vec3::from(vertex.map(|c| f64::from(c) / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::tet_weights;
    use crate::mesh::signed_volume;

    #[test]
    fn every_point_lies_in_the_tet_found_for_it() {
        for i in 0..1000_i32 {
            let p =
                Vec3::new(f64::from(i * 37 % 101), f64::from(i * 53 % 97), f64::from(i * 71 % 89))
                    / 17.3
                    - Vec3::repeat(2.0);
            let tet = LatticeTet::at(&p);
            assert!((signed_volume(tet.corners()) - TET_VOLUME).abs() < 1e-14);
            assert!(tet_weights(&tet.corners(), &p).iter().all(|&w| w >= -1e-12), "{p:?}");
        }
    }

    #[test]
    fn neighbours_share_three_corners_and_know_each_other() {
        for tet in LatticeTet::of_cell([2, -1, 0]) {
            assert_eq!(LatticeTet::at(&tet.centroid()), tet);
            for k in 0..4 {
                let other = tet.neighbour(k);
                let own = tet.vertices();
                let shared = other.vertices().iter().filter(|v| own.contains(v)).count();
                assert_eq!(shared, 3);
                assert!(!other.vertices().contains(&own[k]));
                assert!((0..4).any(|l| other.neighbour(l) == tet));
            }
        }
    }

    #[test]
    fn a_cell_is_filled_by_half_of_each_of_its_tets() {
        let mut tets: Vec<_> = LatticeTet::of_cell([0, 0, 0]).collect();
        tets.sort_unstable();
        tets.dedup();
        assert_eq!(tets.len(), 24);
        assert!((24.0 * TET_VOLUME / 2.0 - 1.0).abs() < 1e-15);
    }
}
