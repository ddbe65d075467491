//! Overlapping clusters around a sparse set of centres.

use nalgebra::Isometry3;
use rayon::prelude::*;

use super::neighbours::PointGrid;
use super::pose::moved;
use super::rotation::PairSums;
use crate::math::Vec3;

/// Lists of (index, weight), one list per row.
#[derive(Clone, Debug, Default)]
struct WeightedLists {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl WeightedLists {
    fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    fn from_rows(rows: &[Vec<(u32, f64)>]) -> Self {
        let mut lists = Self { starts: vec![0], entries: Vec::new() };
        for row in rows {
            lists.entries.extend_from_slice(row);
            lists.starts.push(lists.entries.len());
        }
        lists
    }
}

/// Clusters of one radius S around centres some share of S apart; the weight of a vertex at
/// distance d from a centre is (1 - d^2/S^2)^2.
#[derive(Clone, Debug)]
pub struct SampledClusters {
    members: WeightedLists,
    clusters_of: WeightedLists,
}

impl SampledClusters {
    /// Clusters of `radius` around vertices `spacing` x radius apart (0 < spacing < 1), taken in
    /// vertex order. With `bone_of`, centres and members are kept apart bone by bone.
    pub fn new(points: &[Vec3], radius: f64, spacing: f64, bone_of: Option<&[u32]>) -> Self {
        let same_bone = |i: u32, j: u32| bone_of.is_none_or(|b| b[i as usize] == b[j as usize]);
        let mut centres = PointGrid::empty(points, radius * spacing);
        let mut chosen = Vec::new();
        for i in 0..points.len() as u32 {
            if !centres.any_within(&points[i as usize], |c| same_bone(i, c)) {
                centres.insert(i);
                chosen.push(i);
            }
        }
        let grid = PointGrid::new(points, radius);
        let members: Vec<Vec<(u32, f64)>> = chosen
            .par_iter()
            .map(|&c| {
                let centre = points[c as usize];
                let weight = |i: u32| {
                    let ratio = (points[i as usize] - centre).norm_squared() / (radius * radius);
                    (1.0 - ratio).powi(2)
                };
                let near = grid.within(&centre);
                near.into_iter().filter(|&i| same_bone(i, c)).map(|i| (i, weight(i))).collect()
            })
            .collect();
        let mut clusters_of = vec![Vec::new(); points.len()];
        for (c, row) in members.iter().enumerate() {
            for &(i, weight) in row {
                clusters_of[i as usize].push((c as u32, weight));
            }
        }
        Self {
            members: WeightedLists::from_rows(&members),
            clusters_of: WeightedLists::from_rows(&clusters_of),
        }
    }

    /// Number of clusters.
    pub fn len(&self) -> usize {
        self.members.rows()
    }

    /// Whether there is no cluster, as there is without vertices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn apply(&self, reference: &[Vec3], wanted: &[Vec3], masses: &[f64]) -> Vec<Vec3> {
        let motions: Vec<Option<Isometry3<f64>>> = (0..self.len())
            .into_par_iter()
            .with_min_len(8)
            .map(|c| {
                let row = self.members.row(c);
                let mut sums = PairSums::new(reference[row.first()?.0 as usize]);
                for &(i, weight) in row {
                    let i = i as usize;
                    sums.add(&reference[i], &wanted[i], masses[i] * weight);
                }
                sums.best_rigid()
            })
            .collect();
        (0..reference.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let (mut position, mut total) = (Vec3::zeros(), 0.0);
                for &(c, weight) in self.clusters_of.row(i) {
                    if let Some(motion) = &motions[c as usize] {
                        position += weight * (moved(motion, &reference[i]) - reference[i]);
                        total += weight;
                    }
                }
                if total > 0.0 { reference[i] + position / total } else { wanted[i] }
            })
            .collect()
    }
}
