//! Markers on slices: their planes, and where an outline was left open.

use crate::math::Vec3;
use crate::mesh::adjacency::{DisjointSets, Lists, vertex_neighbours};
use crate::mesh::bounding_box;

/// Markers lie on slices when they have at most this many different coordinates per marker.
const PLANES_PER_MARKER: f64 = 0.34;

/// Of which nothing was seen.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    pub border: Vec3,
    pub outward: Vec3,
}

impl HalfSpace {
    pub fn holds(&self, p: &Vec3) -> bool {
        (p - self.border).dot(&self.outward) > 0.0
    }
}

/// The axis along which the markers lie on planes, and the markers of each plane in order.
pub fn slices(markers: &[Vec3]) -> Option<(usize, Vec<Vec<Vec3>>)> {
    let (low, high) = bounding_box(markers)?;
    let resolution = 1e-4 * (high - low).norm();
    (0..3)
        .map(|axis| {
            let mut sorted = markers.to_vec();
            sorted.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
            let planes =
                sorted.chunk_by(|a, b| b[axis] - a[axis] < resolution).map(<[Vec3]>::to_vec);
            (axis, planes.collect::<Vec<_>>())
        })
        .min_by_key(|(_, planes)| planes.len())
        .filter(|(_, planes)| {
            planes.len() >= 3 && planes.len() as f64 <= PLANES_PER_MARKER * markers.len() as f64
        })
}

/// For each marker of a slice, the side on which its outline is open: the shortest tree through the
/// markers, without links longer than `gap`, follows each outline, and where it is closed the tree's ends
/// meet each other.
pub fn open_sides(slice: &[Vec3], axis: usize, gap: f64) -> Vec<Option<HalfSpace>> {
    let apart = |a: u32, b: u32| (slice[a as usize] - slice[b as usize]).norm();
    let all = 0..slice.len() as u32;
    let mut links = shortest_tree(slice);
    links.retain(|&[a, b]| apart(a, b) <= gap);
    let tree = vertex_neighbours(slice.len(), &links);
    let ends: Vec<u32> = all.clone().filter(|&i| tree.of(i as usize).len() < 2).collect();
    let is_loose = |i: u32| ends.iter().all(|&end| end == i || apart(end, i) > gap);
    let mut sets = DisjointSets::new(slice.len());
    for &[a, b] in &links {
        sets.join(a, b);
    }
    let outline_of: Vec<u32> = all.clone().map(|i| sets.root(i)).collect();
    let mut sides = vec![None; slice.len()];
    for first in all.clone().filter(|&i| outline_of[i as usize] == i) {
        let outline: Vec<u32> = all.clone().filter(|&i| outline_of[i as usize] == first).collect();
        let farthest = |from: u32| {
            let lengths = path_lengths(slice, &tree, from);
            let length = |i: u32| lengths[i as usize];
            outline.iter().copied().max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(from)
        };
        let one = farthest(first);
        let other = farthest(one);
        if is_loose(one) && is_loose(other) {
            let side = side_between(slice, &outline, axis, [one, other], gap);
            for &i in &outline {
                sides[i as usize] = side;
            }
        }
    }
    sides
}

/// What lies beyond the two ends of an outline, seen from its middle. The tree of a thin outline runs to
/// and fro between its two sides; there, markers lie between the ends.
fn side_between(
    slice: &[Vec3],
    outline: &[u32],
    axis: usize,
    [one, other]: [u32; 2],
    gap: f64,
) -> Option<HalfSpace> {
    let (a, b) = (slice[one as usize], slice[other as usize]);
    let between = 0.5 * (a + b);
    let middle = outline.iter().map(|&i| slice[i as usize]).sum::<Vec3>() / outline.len() as f64;
    let across = (b - a).cross(&Vec3::ith(axis, 1.0));
    let outward = across * (between - middle).dot(&across).signum();
    let is_near = |p: &Vec3| (p - between).norm() < 0.25 * gap;
    (!slice.iter().any(is_near)).then_some(HalfSpace { border: a, outward })
}

/// Links of the tree through all points whose total length is least.
fn shortest_tree(points: &[Vec3]) -> Vec<[u32; 2]> {
    let mut left: Vec<usize> = (1..points.len()).collect();
    let mut nearest = vec![0; points.len()];
    let mut links = Vec::new();
    let length = |i: usize, nearest: &[usize]| (points[i] - points[nearest[i]]).norm_squared();
    while let Some(place) = (0..left.len())
        .min_by(|&a, &b| length(left[a], &nearest).total_cmp(&length(left[b], &nearest)))
    {
        let new = left.swap_remove(place);
        links.push([new as u32, nearest[new] as u32]);
        for &i in &left {
            if (points[i] - points[new]).norm_squared() < length(i, &nearest) {
                nearest[i] = new;
            }
        }
    }
    links
}

/// Lengths of the paths along the tree; infinite where there is none.
fn path_lengths(points: &[Vec3], tree: &Lists, start: u32) -> Vec<f64> {
    let mut lengths = vec![f64::INFINITY; points.len()];
    lengths[start as usize] = 0.0;
    let mut waiting = vec![start as usize];
    while let Some(at) = waiting.pop() {
        for next in tree.of(at).iter().map(|&next| next as usize) {
            if lengths[next].is_infinite() {
                lengths[next] = lengths[at] + (points[at] - points[next]).norm();
                waiting.push(next);
            }
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a circle of radius 10 about (`x`, 0, 0), from one angle to another in degrees.
    fn arc(x: f64, from: i32, to: i32) -> Vec<Vec3> {
        let at = |degrees: i32| {
            let angle = f64::from(degrees).to_radians();
            Vec3::new(x + 10.0 * libm::cos(angle), 10.0 * libm::sin(angle), 0.0)
        };
        (from..to).step_by(20).map(at).collect()
    }

    #[test]
    fn closed_outlines_have_no_open_side() {
        let mut slice = arc(0.0, 0, 360);
        slice.extend(arc(40.0, 0, 360));
        assert!(open_sides(&slice, 2, 9.0).iter().all(Option::is_none));
    }

    #[test]
    fn an_arc_is_open_beyond_its_ends() {
        let mut slice = arc(0.0, 0, 360);
        slice.extend(arc(40.0, -90, 91));
        let sides = open_sides(&slice, 2, 9.0);
        assert!(sides[..18].iter().all(Option::is_none));
        for side in &sides[18..] {
            let side = side.unwrap();
            assert!(
                side.holds(&Vec3::new(35.0, 3.0, 1.0)) && !side.holds(&Vec3::new(45.0, 3.0, 1.0))
            );
        }
    }

    #[test]
    fn a_thin_outline_is_closed() {
        let side = |y: f64| (0..10).map(move |i| Vec3::new(4.0 * f64::from(i), y, 0.0));
        let slice: Vec<Vec3> = side(-1.5).chain(side(1.5)).collect();
        assert!(open_sides(&slice, 2, 9.0).iter().all(Option::is_none));
    }

    #[test]
    fn a_kidney_shape_is_closed() {
        let mut slice = arc(0.0, -130, 131);
        slice.extend(arc(0.0, -130, 131).iter().map(|p| p * 0.4));
        assert!(open_sides(&slice, 2, 9.0).iter().all(Option::is_none));
    }
}
