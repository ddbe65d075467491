//! How much of a tet is inside the surface, and in how many pieces.

use crate::locate::WindingNumber;
use crate::math::Vec3;

/// Sample points have barycentric coordinates i/9, all i at least 1: 56 of them. Found to give the
/// total volume to about 0.1 %.
const ORDER: usize = 9;

/// The sample points of a tet, and which of them are next to each other.
pub struct Samples {
    weights: Vec<[f64; 4]>,
    neighbours: Vec<Vec<usize>>,
}

impl Samples {
    pub fn new() -> Self {
        let mut indices: Vec<[usize; 4]> = Vec::new();
        for i in 1..ORDER {
            for j in 1..ORDER {
                for k in 1..ORDER {
                    if i + j + k < ORDER {
                        indices.push([i, j, k, ORDER - i - j - k]);
                    }
                }
            }
        }
        // One step is one unit from one coordinate to another.
        let adjacent = |a: &[usize; 4], b: &[usize; 4]| {
            (0..4).map(|k| a[k].abs_diff(b[k])).sum::<usize>() == 2
        };
        let neighbours = indices
            .iter()
            .map(|a| (0..indices.len()).filter(|&j| adjacent(a, &indices[j])).collect())
            .collect();
        let weights = indices.iter().map(|i| i.map(|k| k as f64 / ORDER as f64)).collect();
        Self { weights, neighbours }
    }

    /// Share of the tet that is inside, and the number of separate inside pieces in it.
    pub fn measure(&self, winding: &WindingNumber, corners: &[Vec3; 4]) -> (f64, usize) {
        let inside: Vec<bool> = self
            .weights
            .iter()
            .map(|w| winding.is_inside(&(0..4).map(|k| corners[k] * w[k]).sum()))
            .collect();
        let count = inside.iter().filter(|&&i| i).count();
        (count as f64 / inside.len() as f64, self.pieces(&inside))
    }

    fn pieces(&self, inside: &[bool]) -> usize {
        let mut seen = vec![false; inside.len()];
        let mut pieces = 0;
        for start in 0..inside.len() {
            if !inside[start] || seen[start] {
                continue;
            }
            pieces += 1;
            seen[start] = true;
            let mut open = vec![start];
            while let Some(i) = open.pop() {
                for &j in &self.neighbours[i] {
                    if inside[j] && !seen[j] {
                        seen[j] = true;
                        open.push(j);
                    }
                }
            }
        }
        pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tet_faces;

    /// Two slabs across a tet, made of flat boxes (here: tets).
    #[test]
    fn two_sheets_in_one_tet_are_told_apart() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        // The two ends of the edge from x to y, cut off.
        for (tip, toward) in [(1, 2), (2, 1)] {
            let first = points.len() as u32;
            let other = (0..4).filter(|&k| k != tip && k != toward);
            points.push(corners[tip] * 1.2 - corners[toward] * 0.2);
            for k in other.chain([toward]) {
                points.push(corners[tip] * 0.6 + corners[k] * 0.4);
            }
            let tet = [first, first + 1, first + 2, first + 3];
            triangles.extend(tet_faces(&tet));
        }
        let winding = WindingNumber::new(&points, &triangles);
        let (fraction, pieces) = Samples::new().measure(&winding, &corners);
        assert_eq!(pieces, 2);
        assert!(fraction > 0.0 && fraction < 0.3);
    }
}
