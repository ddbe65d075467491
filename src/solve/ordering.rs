//! Fill-reducing ordering by geometric nested dissection.
//!
//! Vertices of a mesh carry coordinates, so that the graph can be cut by planes: recursive
//! bisection along the longest axis, with the boundary layer of the smaller side as separator.
//! On tet meshes this comes close to METIS without its C code (figures in docs/benchmarks.md).

use crate::math::Vec3;
use crate::mesh::bounding_box;

/// Parts of at most this many vertices are not cut further.
const LEAF: usize = 48;

/// Elimination order of the vertices of a graph: `order[k]` is eliminated as number k.
///
/// `neighbours[v]` lists the vertices adjacent to v (both directions present).
pub fn nested_dissection(points: &[Vec3], neighbours: &[Vec<u32>]) -> Vec<usize> {
    let mut order = Vec::with_capacity(points.len());
    let mut side = vec![Side::Outside; points.len()];
    let all: Vec<u32> = (0..points.len() as u32).collect();
    dissect(all, points, neighbours, &mut side, &mut order);
    order
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Low,
    High,
}

/// Appends the order of `part`: low half, high half, separator.
fn dissect(
    part: Vec<u32>,
    points: &[Vec3],
    graph: &[Vec<u32>],
    side: &mut [Side],
    order: &mut Vec<usize>,
) {
    if part.len() <= LEAF {
        order.extend(part.into_iter().map(|v| v as usize));
        return;
    }
    let (low, high) = halves(part, points);
    for &v in &low {
        side[v as usize] = Side::Low;
    }
    for &v in &high {
        side[v as usize] = Side::High;
    }
    let touches =
        |v: u32, other: Side| graph[v as usize].iter().any(|&w| side[w as usize] == other);
    let low_border = low.iter().filter(|&&v| touches(v, Side::High)).count();
    let high_border = high.iter().filter(|&&v| touches(v, Side::Low)).count();
    let (separator, low, high) = if low_border <= high_border {
        let (separator, rest): (Vec<u32>, Vec<u32>) =
            low.into_iter().partition(|&v| touches(v, Side::High));
        (separator, rest, high)
    } else {
        let (separator, rest): (Vec<u32>, Vec<u32>) =
            high.into_iter().partition(|&v| touches(v, Side::Low));
        (separator, low, rest)
    };
    for &v in low.iter().chain(&high).chain(&separator) {
        side[v as usize] = Side::Outside;
    }
    dissect(low, points, graph, side, order);
    dissect(high, points, graph, side, order);
    order.extend(separator.into_iter().map(|v| v as usize));
}

/// Cuts at the median along the longest axis of the bounding box; ties by vertex number.
fn halves(mut part: Vec<u32>, points: &[Vec3]) -> (Vec<u32>, Vec<u32>) {
    let corners: Vec<Vec3> = part.iter().map(|&v| points[v as usize]).collect();
    let (low, high) = bounding_box(&corners).expect("parts are not empty");
    let axis = (high - low).imax();
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |&a, &b| {
        points[a as usize][axis].total_cmp(&points[b as usize][axis]).then(a.cmp(&b))
    });
    let mut upper = part.split_off(middle);
    part.sort_unstable();
    upper.sort_unstable();
    (part, upper)
}
