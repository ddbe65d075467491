//! A few of many points, spread evenly.

use std::cmp::Ordering;
use std::f64::consts::PI;

use crate::math::Vec3;
use crate::mesh::bounding_box;

/// Lengths, and their squares, that differ by a smaller share are taken for the same. Irrational, so that
/// points on a regular grid do not lie on the border of two levels.
pub const SAME: f64 = PI * 1e-4;

/// `count` of the points, or all: first the one farthest from their middle, then always the one farthest
/// from those chosen. Of several equally far ones the one with the least coordinates, so that neither
/// the points' order nor rounding changes which are chosen.
pub fn spread_evenly(points: &[Vec3], count: usize) -> Vec<usize> {
    let extent = bounding_box(points).map_or(0.0, |(low, high)| (high - low).norm());
    let mut rank = vec![0; points.len()];
    for (place, i) in coordinate_order(points, 0, SAME * extent).into_iter().enumerate() {
        rank[i] = place;
    }
    let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let mut distance: Vec<f64> = points.iter().map(|p| (p - middle).norm_squared()).collect();
    let mut chosen = Vec::new();
    while chosen.len() < count.min(points.len()) {
        let farthest = distance.iter().copied().fold(0.0, f64::max);
        let is_far = |i: &usize| distance[*i] >= farthest * (1.0 - SAME);
        let Some(next) = (0..points.len()).filter(is_far).min_by_key(|&i| rank[i]) else { break };
        if chosen.is_empty() {
            distance.fill(f64::INFINITY);
        }
        for (d, p) in distance.iter_mut().zip(points) {
            *d = d.min((p - points[next]).norm_squared());
        }
        // Never again, not even beside a point at the same place.
        distance[next] = f64::NEG_INFINITY;
        chosen.push(next);
    }
    chosen
}

/// The points in the order of their coordinates, that of `axis` first. Coordinates on one level, a multiple
/// of `level`, are equal, so that rounding does not part the points of one slice; the exact ones decide
/// between points that are level in all three.
pub fn coordinate_order(points: &[Vec3], axis: usize, level: f64) -> Vec<usize> {
    let along = |i: usize| [0, 1, 2].map(|k| points[i][(axis + k) % 3]);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let pairs = along(a).into_iter().zip(along(b));
        pairs.map(|(a, b)| a.total_cmp(&b)).fold(Ordering::Equal, Ordering::then)
    });
    order.sort_by_cached_key(|&i| along(i).map(|c| (c / level).round() as i64));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(i: usize) -> Vec3 {
        Vec3::new(i as f64, 0.0, 0.0)
    }

    #[test]
    fn ends_come_first_whatever_the_order() {
        let mixed = [5, 2, 6, 0, 4, 1, 3];
        let chosen = spread_evenly(&mixed.map(at), 4);
        assert_eq!(chosen.iter().map(|&i| mixed[i]).collect::<Vec<_>>(), [0, 6, 3, 1]);
    }

    #[test]
    fn all_are_chosen_once_and_none_of_none() {
        let twice = [at(1), at(0), at(1), at(0)];
        let mut chosen = spread_evenly(&twice, 9);
        chosen.sort_unstable();
        assert_eq!(chosen, [0, 1, 2, 3]);
        assert!(spread_evenly(&[], 3).is_empty());
    }

    #[test]
    fn rounding_does_not_change_which_points_of_slices_are_chosen() {
        let grid = |i: u32| Vec3::new(f64::from(i % 9), f64::from(i / 9 % 5), f64::from(i / 45));
        let exact: Vec<Vec3> = (0..135).map(grid).collect();
        let rounded = |(i, p): (usize, &Vec3)| {
            p + Vec3::new(libm::sin(i as f64), libm::cos(i as f64), libm::sin(3.0 * i as f64))
                * 1e-7
        };
        let rounded: Vec<Vec3> = exact.iter().enumerate().map(rounded).collect();
        assert_eq!(spread_evenly(&rounded, 68), spread_evenly(&exact, 68));
    }
}
