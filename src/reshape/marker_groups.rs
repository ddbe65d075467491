//! Many markers in groups of neighbours, one of which can stand for all.

use std::cmp::Ordering;

use crate::math::Vec3;
use crate::mesh::bounding_box;

/// More markers than this are grouped; each has one to three rows in a dense system.
const MOST_SINGLE: usize = 1000;

/// Groups that they form: a power of two.
const GROUPS: usize = 512;

/// Coordinates and extents that differ by less than this share of the extent are taken for the same.
/// Irrational, so that markers on a regular grid do not lie on the border of two levels.
const SAME_PLACE: f64 = std::f64::consts::PI * 1e-4;

/// Markers that lie close together.
#[derive(Clone, Debug)]
pub struct MarkerGroup {
    /// All of them.
    pub members: Vec<u32>,
    /// The one nearest to their centre.
    pub middle: u32,
}

/// Groups of nearly the same size, or `None` for markers that are few.
pub fn marker_groups(markers: &[Vec3]) -> Option<Vec<MarkerGroup>> {
    (markers.len() > MOST_SINGLE).then(|| {
        parts(markers, GROUPS).into_iter().map(|members| group(members, markers)).collect()
    })
}

/// Every second marker of an order in which neighbours follow each other, whatever their order in a
/// file.
pub fn every_second(markers: &[Vec3]) -> Vec<bool> {
    let mut chosen = vec![false; markers.len()];
    let order = parts(markers, markers.len().next_power_of_two()).into_iter().flatten();
    for marker in order.step_by(2) {
        chosen[marker as usize] = true;
    }
    chosen
}

/// So many parts, a power of two, each next to the one before.
fn parts(markers: &[Vec3], count: usize) -> Vec<Vec<u32>> {
    let mut parts: Vec<Vec<u32>> = vec![(0..markers.len() as u32).collect()];
    while parts.len() < count {
        parts = parts.into_iter().flat_map(|part| halves(part, markers)).collect();
    }
    parts
}

/// The two sides of the median across the longest extent.
fn halves(mut members: Vec<u32>, markers: &[Vec3]) -> [Vec<u32>; 2] {
    let points: Vec<Vec3> = members.iter().map(|&m| markers[m as usize]).collect();
    let extent = bounding_box(&points).map_or_else(Vec3::zeros, |(low, high)| high - low);
    let longest = extent.max();
    let is_longest = |k: &usize| extent[*k] >= longest * (1.0 - SAME_PLACE);
    let axis = (0..3).find(is_longest).unwrap_or(0);
    let along = |m: u32| [0, 1, 2].map(|k| markers[m as usize][(axis + k) % 3]);
    members.sort_by(|&a, &b| {
        let pairs = along(a).into_iter().zip(along(b));
        pairs.map(|(a, b)| a.total_cmp(&b)).fold(Ordering::Equal, Ordering::then)
    });
    // Markers of one slice are level with each other, whatever the rounding in their file.
    let level = SAME_PLACE * longest;
    members.sort_by_cached_key(|&m| along(m).map(|c| (c / level).round() as i64));
    let upper = members.split_off(members.len() / 2);
    [members, upper]
}

fn group(members: Vec<u32>, markers: &[Vec3]) -> MarkerGroup {
    let center =
        members.iter().map(|&m| markers[m as usize]).sum::<Vec3>() / members.len().max(1) as f64;
    let distance = |m: &u32| (markers[*m as usize] - center).norm_squared();
    let nearest = members.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    MarkerGroup { middle: nearest.copied().unwrap_or(0), members }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_of_a_line_is_chosen_whatever_the_order() {
        let at = |i: u32| Vec3::new(f64::from(i), 0.0, 0.0);
        let along: Vec<Vec3> = (0..7).map(at).collect();
        assert_eq!(every_second(&along), [true, false, true, false, true, false, true]);
        let mixed = [5, 2, 6, 0, 4, 1, 3];
        let chosen = every_second(&mixed.map(at));
        assert_eq!(chosen, mixed.map(|i| i % 2 == 0));
        assert!(every_second(&[]).is_empty());
    }

    #[test]
    fn rounding_does_not_change_which_markers_of_slices_are_chosen() {
        let grid = |i: u32| Vec3::new(f64::from(i % 9), f64::from(i / 9 % 5), f64::from(i / 45));
        let exact: Vec<Vec3> = (0..135).map(grid).collect();
        let rounded = |(i, p): (usize, &Vec3)| {
            p + Vec3::new((i as f64).sin(), (i as f64).cos(), (3.0 * i as f64).sin()) * 1e-7
        };
        let rounded: Vec<Vec3> = exact.iter().enumerate().map(rounded).collect();
        assert_eq!(every_second(&rounded), every_second(&exact));
    }

    #[test]
    fn groups_share_all_markers_evenly_and_only_when_there_are_many() {
        let on_spiral = |i: u32| {
            let t = f64::from(i) * 0.01;
            Vec3::new(t.cos(), t.sin(), 0.03 * t)
        };
        let markers: Vec<Vec3> = (0..5000).map(on_spiral).collect();
        assert!(marker_groups(&markers[..900]).is_none());
        let groups = marker_groups(&markers).unwrap();
        let mut all: Vec<u32> = groups.iter().flat_map(|g| g.members.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..5000).collect::<Vec<u32>>());
        assert!(groups.iter().all(|g| g.members.len() < 12 && g.members.contains(&g.middle)));
    }
}
