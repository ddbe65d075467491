//! Fill-reducing elimination order by geometric nested dissection.
//!
//! Vertices of a mesh carry coordinates, so that the graph can be cut by planes. Of several planes
//! the one with the smallest separator is taken, and the separator of a plane is a minimum vertex
//! cover of the edges it cuts (König's theorem). On tet meshes this comes within a tenth to a third
//! of METIS's fill, without its C code (figures in docs/benchmarks.md).

use std::cmp::Reverse;

use rayon::prelude::*;

use crate::math::symmetric3::eigen;
use crate::math::{Mat3, Vec3};

/// Parts of at most this many vertices are not cut further.
const LEAF: usize = 12;

/// Parts of fewer vertices are cut along the axes only; more planes no longer pay.
const SMALL: usize = 200;

/// Shares of the vertices that a plane leaves on its lower side.
const SHARES: [f64; 3] = [0.5, 0.42, 0.58];

/// How much an uneven cut counts beside the size of its separator.
const IMBALANCE: f64 = 2.0;

const NONE: u32 = u32::MAX;

/// Elimination order of the vertices of a graph: `order[k]` is eliminated as number k.
///
/// `neighbours(v)` lists the vertices adjacent to v (both directions present).
pub fn nested_dissection<'a>(
    points: &[Vec3],
    neighbours: impl Fn(usize) -> &'a [u32] + Sync,
) -> Vec<usize> {
    let graph = Graph { points, neighbours };
    let mut order = Vec::with_capacity(points.len());
    graph.dissect((0..points.len() as u32).collect(), &mut order);
    order.into_iter().map(|v| v as usize).collect()
}

struct Graph<'p, F> {
    points: &'p [Vec3],
    neighbours: F,
}

/// A part without its separator falls into two that no edge joins.
struct Cut {
    low: Vec<u32>,
    high: Vec<u32>,
    separator: Vec<u32>,
}

impl<'a, F: Fn(usize) -> &'a [u32] + Sync> Graph<'_, F> {
    /// Appends the order of `part`: low half, high half, separator.
    fn dissect(&self, mut part: Vec<u32>, order: &mut Vec<u32>) {
        part.sort_unstable();
        if part.len() <= LEAF {
            order.extend(part);
            return;
        }
        let directions = self.directions(&part);
        let shares = if part.len() < SMALL { &SHARES[..1] } else { &SHARES };
        let planes: Vec<(Vec3, f64)> =
            directions.iter().flat_map(|d| shares.iter().map(move |share| (*d, *share))).collect();
        let cuts: Vec<Cut> = if part.len() < SMALL {
            planes.iter().map(|(d, share)| self.cut(&part, d, *share)).collect()
        } else {
            planes.par_iter().map(|(d, share)| self.cut(&part, d, *share)).collect()
        };
        let best = cuts.into_iter().min_by(|a, b| a.cost().total_cmp(&b.cost()));
        let Cut { low, high, separator } = best.expect("there are at least three planes");
        if low.is_empty() || high.is_empty() {
            order.extend(part);
            return;
        }
        self.dissect(low, order);
        self.dissect(high, order);
        order.extend(separator);
    }

    /// Normals of the planes to try.
    fn directions(&self, part: &[u32]) -> Vec<Vec3> {
        let mut directions = vec![Vec3::x(), Vec3::y(), Vec3::z()];
        if part.len() >= SMALL {
            let at = |v: &u32| self.points[*v as usize];
            let center = part.iter().map(at).sum::<Vec3>() / part.len() as f64;
            let spread: Mat3 =
                part.iter().map(|v| (at(v) - center) * (at(v) - center).transpose()).sum();
            directions.extend(eigen(&spread).1.column_iter().map(nalgebra::Matrix::into_owned));
            let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
            directions.extend(signs.map(|(y, z)| Vec3::new(1.0, y, z)));
        }
        directions
    }

    /// Cuts `part` (ascending) by the plane that leaves a share of it below.
    fn cut(&self, part: &[u32], normal: &Vec3, share: f64) -> Cut {
        let mut sorted: Vec<(f64, u32)> =
            part.iter().map(|&v| (self.points[v as usize].dot(normal), v)).collect();
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let middle = (share * part.len() as f64) as usize;
        let place = |v: u32| part.binary_search(&v).ok();
        let mut is_high = vec![false; part.len()];
        for (_, v) in &sorted[middle..] {
            is_high[place(*v).expect("sorted holds the part")] = true;
        }
        // Edges from low to high, by places in the part.
        let across = |i: usize| -> Vec<u32> {
            let neighbours = (self.neighbours)(part[i] as usize).iter();
            neighbours.filter_map(|&w| place(w)).filter(|&j| is_high[j]).map(|j| j as u32).collect()
        };
        let crossing: Vec<Vec<u32>> =
            (0..part.len()).map(|i| if is_high[i] { Vec::new() } else { across(i) }).collect();
        let covered = minimum_vertex_cover(&crossing);
        let mut cut = Cut { low: Vec::new(), high: Vec::new(), separator: Vec::new() };
        for (i, &v) in part.iter().enumerate() {
            match (covered[i], is_high[i]) {
                (true, _) => cut.separator.push(v),
                (false, false) => cut.low.push(v),
                (false, true) => cut.high.push(v),
            }
        }
        cut
    }
}

impl Cut {
    /// Size of the separator, with a surcharge for halves of different size.
    fn cost(&self) -> f64 {
        let total = (self.low.len() + self.high.len() + self.separator.len()) as f64;
        let larger = self.low.len().max(self.high.len()) as f64 / total;
        self.separator.len() as f64 * (1.0 + IMBALANCE * (larger - 0.5).max(0.0))
    }
}

/// A smallest set of vertices that touches every edge i -> crossing[i] of a bipartite graph.
fn minimum_vertex_cover(crossing: &[Vec<u32>]) -> Vec<bool> {
    let mut matching = Matching { crossing, mate: vec![NONE; crossing.len()] };
    let mut sources: Vec<usize> =
        (0..crossing.len()).filter(|&i| !crossing[i].is_empty()).collect();
    sources.sort_by_key(|&i| Reverse(crossing[i].len()));
    let mut visited = vec![NONE; crossing.len()];
    for &i in &sources {
        matching.augment(i as u32, i as u32, &mut visited);
    }
    // König: low vertices not reached, and high vertices reached, by alternating paths from
    // unmatched low vertices.
    let mut reached = vec![false; crossing.len()];
    let mut open: Vec<u32> = Vec::new();
    for &i in &sources {
        if matching.mate[i] == NONE {
            reached[i] = true;
            open.push(i as u32);
        }
    }
    let mut covered = vec![false; crossing.len()];
    while let Some(i) = open.pop() {
        for &j in &crossing[i as usize] {
            if !covered[j as usize] {
                covered[j as usize] = true;
                let back = matching.mate[j as usize];
                if back != NONE && !reached[back as usize] {
                    reached[back as usize] = true;
                    open.push(back);
                }
            }
        }
    }
    for &i in &sources {
        covered[i] = !reached[i];
    }
    covered
}

/// A matching of a bipartite graph: `mate` of both sides.
struct Matching<'c> {
    crossing: &'c [Vec<u32>],
    mate: Vec<u32>,
}

impl Matching<'_> {
    /// Lengthens the matching by a path from `i`; `visited[j] == round` marks vertices tried.
    fn augment(&mut self, i: u32, round: u32, visited: &mut [u32]) -> bool {
        let crossing = self.crossing;
        for &j in &crossing[i as usize] {
            if visited[j as usize] == round {
                continue;
            }
            visited[j as usize] = round;
            let other = self.mate[j as usize];
            if other == NONE || self.augment(other, round, visited) {
                self.mate[j as usize] = i;
                self.mate[i as usize] = j;
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vertices of an n x n x n grid, each with its 26 neighbours.
    fn grid(n: i32) -> (Vec<Vec3>, Vec<Vec<u32>>) {
        let all =
            || (0..n).flat_map(move |x| (0..n).flat_map(move |y| (0..n).map(move |z| (x, y, z))));
        let points = all().map(|(x, y, z)| Vec3::new(f64::from(x), f64::from(y), f64::from(z)));
        let near = |p: (i32, i32, i32), q: (i32, i32, i32)| {
            p != q && (p.0 - q.0).abs().max((p.1 - q.1).abs()).max((p.2 - q.2).abs()) == 1
        };
        let neighbours = all().map(|p| {
            all().enumerate().filter(|(_, q)| near(p, *q)).map(|(i, _)| i as u32).collect()
        });
        (points.collect(), neighbours.collect())
    }

    #[test]
    fn the_order_is_a_permutation_that_puts_the_middle_layer_last() {
        let (points, neighbours) = grid(7);
        let order = nested_dissection(&points, |v| &neighbours[v]);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, v)| i == *v));
        let last: Vec<Vec3> = order[order.len() - 49..].iter().map(|&v| points[v]).collect();
        assert!((0..3).any(|axis| last.iter().all(|p| (2.0..=4.0).contains(&p[axis]))));
    }

    #[test]
    fn a_star_is_covered_by_its_middle() {
        // 0 is joined to 2, 3, 4; 1 to 4.
        let covered = minimum_vertex_cover(&[vec![2, 3, 4], vec![4], vec![], vec![], vec![]]);
        assert_eq!(covered.iter().filter(|c| **c).count(), 2);
        assert!(covered[0] && (covered[1] || covered[4]));
    }
}
