//! Markers on slices: their planes, and where an outline was left open.

use crate::math::Vec3;
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
    let apart = |a: usize, b: usize| (slice[a] - slice[b]).norm();
    let mut links = shortest_tree(slice);
    links.retain(|&(a, b)| apart(a, b) <= gap);
    let is_end = |i: &usize| links.iter().filter(|(a, b)| a == i || b == i).count() < 2;
    let ends: Vec<usize> = (0..slice.len()).filter(is_end).collect();
    let is_loose = |i: usize| ends.iter().all(|&end| end == i || apart(end, i) > gap);
    let mut sides = vec![None; slice.len()];
    let mut done = vec![false; slice.len()];
    for start in 0..slice.len() {
        if done[start] {
            continue;
        }
        let ways = path_lengths(slice, &links, start);
        let outline: Vec<usize> = (0..slice.len()).filter(|&i| ways[i].is_finite()).collect();
        let farthest = |ways: &[f64]| {
            outline.iter().copied().max_by(|&a, &b| ways[a].total_cmp(&ways[b])).unwrap_or(start)
        };
        let one = farthest(&ways);
        let other = farthest(&path_lengths(slice, &links, one));
        let side = if is_loose(one) && is_loose(other) {
            side_between(slice, &outline, axis, [one, other], gap)
        } else {
            None
        };
        for i in outline {
            (sides[i], done[i]) = (side, true);
        }
    }
    sides
}

/// What lies beyond the two ends of an outline, seen from its middle. The tree of a thin outline runs to
/// and fro between its two sides; there, markers lie between the ends.
fn side_between(
    slice: &[Vec3],
    outline: &[usize],
    axis: usize,
    [one, other]: [usize; 2],
    gap: f64,
) -> Option<HalfSpace> {
    let (a, b) = (slice[one], slice[other]);
    let between = 0.5 * (a + b);
    let middle = outline.iter().map(|&i| slice[i]).sum::<Vec3>() / outline.len() as f64;
    let across = (b - a).cross(&Vec3::ith(axis, 1.0));
    let outward = across * (between - middle).dot(&across).signum();
    let is_near = |p: &Vec3| (p - between).norm() < 0.25 * gap;
    (!slice.iter().any(is_near)).then_some(HalfSpace { border: a, outward })
}

/// Links of the tree through all points whose total length is least.
fn shortest_tree(points: &[Vec3]) -> Vec<(usize, usize)> {
    let mut left: Vec<usize> = (1..points.len()).collect();
    let mut nearest = vec![0; points.len()];
    let mut links = Vec::new();
    let length = |i: usize, nearest: &[usize]| (points[i] - points[nearest[i]]).norm_squared();
    while let Some(place) = (0..left.len())
        .min_by(|&a, &b| length(left[a], &nearest).total_cmp(&length(left[b], &nearest)))
    {
        let new = left.swap_remove(place);
        links.push((new, nearest[new]));
        for &i in &left {
            if (points[i] - points[new]).norm_squared() < length(i, &nearest) {
                nearest[i] = new;
            }
        }
    }
    links
}

/// Lengths of the ways along the links; infinite where there is none.
fn path_lengths(points: &[Vec3], links: &[(usize, usize)], start: usize) -> Vec<f64> {
    let mut lengths = vec![f64::INFINITY; points.len()];
    lengths[start] = 0.0;
    let mut waiting = vec![start];
    while let Some(at) = waiting.pop() {
        for &(a, b) in links.iter().filter(|&&(a, b)| a == at || b == at) {
            let next = if a == at { b } else { a };
            if lengths[next].is_infinite() {
                lengths[next] = lengths[at] + (points[a] - points[b]).norm();
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
            Vec3::new(x + 10.0 * angle.cos(), 10.0 * angle.sin(), 0.0)
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
