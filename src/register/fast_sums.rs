//! Sums over the balls around all vertices, each ball reached from a neighbouring one.
//!
//! [G] section 3.3: the sum over a cluster is that over a neighbour's cluster, plus what came in,
//! minus what went out. The order of the visits is a maximum spanning forest of the savings
//! ("propagate"); a cluster without a saving neighbour is summed directly.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::neighbours::PointGrid;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::adjacency::vertex_neighbours;

/// Cluster members at most, over all clusters: 4 bytes each while the list is built.
const MAX_MEMBERS: usize = 300_000_000;

/// The visits that give all cluster sums.
#[derive(Clone, Debug)]
pub struct FastSums {
    steps: Vec<Step>,
    sizes: Vec<u32>,
    members: usize,
    additions: usize,
}

#[derive(Clone, Debug)]
struct Step {
    vertex: u32,
    parent: Option<u32>,
    plus: Vec<u32>,
    minus: Vec<u32>,
}

/// A possible visit; the heap gives the largest gain first, then the lowest indices.
#[derive(PartialEq, Eq)]
struct Candidate {
    gain: i64,
    vertex: u32,
    parent: u32,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |c: &Self| (c.gain, std::cmp::Reverse((c.vertex, c.parent)));
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl FastSums {
    /// The clusters of all vertices within `radius` of each vertex. Fails where the clusters are
    /// so large that the lists would not fit into memory.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]], radius: f64) -> Result<Self> {
        let grid = PointGrid::new(points, radius);
        let sizes: Vec<u32> = points.par_iter().map(|p| grid.within(p).len() as u32).collect();
        let members: usize = sizes.iter().map(|&s| s as usize).sum();
        if members > MAX_MEMBERS {
            return Err(Error::invalid(format!(
                "exact clusters of radius {radius} hold {members} vertices in all; use sampled clusters or a coarser template"
            )));
        }
        let clusters: Vec<Vec<u32>> = points.par_iter().map(|p| grid.within(p)).collect();
        let mut builder = Builder {
            links: links(points, triangles, radius),
            clusters,
            done: vec![false; points.len()],
            heap: BinaryHeap::new(),
            steps: Vec::with_capacity(points.len()),
        };
        builder.build();
        let additions = builder.steps.iter().map(Step::additions).sum();
        Ok(Self { steps: builder.steps, sizes, members, additions })
    }

    /// Sum of `field` over the cluster of every vertex.
    pub fn sum<const K: usize>(&self, field: &[[f64; K]]) -> Vec<[f64; K]> {
        let mut sums = vec![[0.0; K]; field.len()];
        for step in &self.steps {
            let mut sum = step.parent.map_or([0.0; K], |p| sums[p as usize]);
            for &j in &step.plus {
                for k in 0..K {
                    sum[k] += field[j as usize][k];
                }
            }
            for &j in &step.minus {
                for k in 0..K {
                    sum[k] -= field[j as usize][k];
                }
            }
            sums[step.vertex as usize] = sum;
        }
        sums
    }

    /// Vertices in the cluster of vertex `i`.
    pub fn cluster_size(&self, i: usize) -> u32 {
        self.sizes[i]
    }

    /// Share of the additions of direct sums that is saved, 0 to 1.
    pub fn saving(&self) -> f64 {
        1.0 - self.additions as f64 / self.members.max(1) as f64
    }
}

impl Step {
    fn additions(&self) -> usize {
        self.plus.len() + self.minus.len() + usize::from(self.parent.is_some())
    }
}

struct Builder {
    links: Vec<Vec<u32>>,
    clusters: Vec<Vec<u32>>,
    done: Vec<bool>,
    heap: BinaryHeap<Candidate>,
    steps: Vec<Step>,
}

impl Builder {
    /// Prim's algorithm on the gains; every new tree starts at the smallest cluster left.
    fn build(&mut self) {
        let mut by_size: Vec<u32> = (0..self.clusters.len() as u32).collect();
        by_size.sort_by_key(|&i| (self.clusters[i as usize].len(), i));
        for root in by_size {
            if self.done[root as usize] {
                continue;
            }
            let plus = self.clusters[root as usize].clone();
            self.finish(Step { vertex: root, parent: None, plus, minus: Vec::new() });
            while let Some(best) = self.heap.pop() {
                if !self.done[best.vertex as usize] {
                    let (zeta_i, zeta_k) = (
                        &self.clusters[best.vertex as usize],
                        &self.clusters[best.parent as usize],
                    );
                    let step = Step {
                        vertex: best.vertex,
                        parent: Some(best.parent),
                        plus: difference(zeta_i, zeta_k),
                        minus: difference(zeta_k, zeta_i),
                    };
                    self.finish(step);
                }
            }
        }
    }

    fn finish(&mut self, step: Step) {
        let k = step.vertex;
        self.done[k as usize] = true;
        self.steps.push(step);
        let zeta_k = &self.clusters[k as usize];
        for &i in &self.links[k as usize] {
            if !self.done[i as usize] {
                // g_ik = 2 |zeta_k n zeta_i| - |zeta_k| - 1, the additions saved.
                let common = common_count(zeta_k, &self.clusters[i as usize]) as i64;
                let gain = 2 * common - zeta_k.len() as i64 - 1;
                if gain > 0 {
                    self.heap.push(Candidate { gain, vertex: i, parent: k });
                }
            }
        }
    }
}

/// Mesh neighbours, and for each connected part links from its vertices to a near vertex of
/// another part, so that the parts (bones) do not each need a root of their own.
fn links(points: &[Vec3], triangles: &[[u32; 3]], radius: f64) -> Vec<Vec<u32>> {
    let neighbours = vertex_neighbours(points.len(), triangles);
    let mut links: Vec<Vec<u32>> = (0..points.len()).map(|i| neighbours.of(i).to_vec()).collect();
    let part = crate::mesh::adjacency::components(points.len(), triangles);
    let grid = PointGrid::new(points, radius / 4.0);
    let across: Vec<Option<u32>> = (0..points.len())
        .into_par_iter()
        .map(|i| {
            let other =
                grid.within(&points[i]).into_iter().filter(|&j| part[j as usize] != part[i]);
            let distance = |j: &u32| (points[*j as usize] - points[i]).norm_squared();
            other.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)))
        })
        .collect();
    for (i, j) in across.into_iter().enumerate() {
        if let Some(j) = j {
            links[i].push(j);
            links[j as usize].push(i as u32);
        }
    }
    links
}

fn common_count(a: &[u32], b: &[u32]) -> usize {
    let (mut i, mut j, mut count) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        match a[i].cmp(&b[j]) {
            Ordering::Less => i += 1,
            Ordering::Greater => j += 1,
            Ordering::Equal => {
                count += 1;
                i += 1;
                j += 1;
            }
        }
    }
    count
}

/// Members of the ascending list `a` that are not in the ascending list `b`.
fn difference(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut j = 0;
    a.iter()
        .copied()
        .filter(|x| {
            while j < b.len() && b[j] < *x {
                j += 1;
            }
            j == b.len() || b[j] != *x
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;

    #[test]
    fn fast_sums_are_the_direct_sums_with_fewer_additions() {
        let mut mesh = block(Vec3::new(0.0, 5.0, 0.0), Vec3::new(3.0, 1.0, 1.0), 14);
        mesh.append(&block(Vec3::new(3.5, 6.5, 0.0), Vec3::new(1.0, 0.3, 1.0), 9));
        let sums = FastSums::new(&mesh.points, &mesh.triangles, 1.2).unwrap();
        let field: Vec<[f64; 2]> =
            mesh.points.iter().map(|p| [1.0, p.x * libm::sin(p.y)]).collect();
        let fast = sums.sum(&field);
        for (i, p) in mesh.points.iter().enumerate() {
            let mut direct = [0.0; 2];
            for (q, f) in mesh.points.iter().zip(&field) {
                if (p - q).norm() <= 1.2 {
                    direct = [direct[0] + f[0], direct[1] + f[1]];
                }
            }
            assert!((fast[i][0] - direct[0]).abs() < 1e-9);
            assert!((f64::from(sums.cluster_size(i)) - direct[0]).abs() < 1e-9);
            assert!((fast[i][1] - direct[1]).abs() < 1e-10 * direct[0]);
        }
        assert!(sums.saving() > 0.6, "{}", sums.saving());
    }
}
