//! Many markers in groups of neighbours, one of which can stand for all.

use crate::locate::{SAME, coordinate_order, spread_evenly};
use crate::math::Vec3;
use crate::mesh::bounding_box;

/// More markers than this are grouped; each has one to three rows in a dense system.
const MOST_SINGLE: usize = 1000;

/// Groups that they form: a power of two.
const GROUPS: usize = 512;

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

/// Half of the markers, spread evenly among the others.
pub fn half_spread_evenly(markers: &[Vec3]) -> Vec<bool> {
    let mut chosen = vec![false; markers.len()];
    for part in parts(markers, markers.len().div_ceil(MOST_SINGLE).next_power_of_two()) {
        let points: Vec<Vec3> = part.iter().map(|&m| markers[m as usize]).collect();
        for k in spread_evenly(&points, part.len().div_ceil(2)) {
            chosen[part[k] as usize] = true;
        }
    }
    chosen
}

/// So many parts, a power of two, each next to the one before.
fn parts(markers: &[Vec3], count: usize) -> Vec<Vec<u32>> {
    let mut parts: Vec<Vec<u32>> = vec![(0..markers.len() as u32).collect()];
    while parts.len() < count {
        parts = parts.iter().flat_map(|part| halves(part, markers)).collect();
    }
    parts
}

/// The two sides of the median across the longest extent.
fn halves(members: &[u32], markers: &[Vec3]) -> [Vec<u32>; 2] {
    let points: Vec<Vec3> = members.iter().map(|&m| markers[m as usize]).collect();
    let extent = bounding_box(&points).map_or_else(Vec3::zeros, |(low, high)| high - low);
    let longest = extent.max();
    let is_longest = |k: &usize| extent[*k] >= longest * (1.0 - SAME);
    let axis = (0..3).find(is_longest).unwrap_or(0);
    // Markers of one slice are level with each other, whatever the rounding in their file.
    let order = coordinate_order(&points, axis, SAME * longest);
    let mut members: Vec<u32> = order.into_iter().map(|i| members[i]).collect();
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
    fn half_of_the_markers_hold_for_their_neighbours_also_when_there_are_many() {
        for count in [0, 7, 3000] {
            let line: Vec<Vec3> = (0..count).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
            let chosen = half_spread_evenly(&line);
            let half = chosen.iter().filter(|chosen| **chosen).count();
            assert!(half.abs_diff(line.len().div_ceil(2)) <= 2, "{half} of {count}");
            assert!(chosen.windows(3).all(|three| three.contains(&true)));
        }
    }

    #[test]
    fn groups_share_all_markers_evenly_and_only_when_there_are_many() {
        let on_spiral = |i: u32| {
            let t = f64::from(i) * 0.01;
            Vec3::new(libm::cos(t), libm::sin(t), 0.03 * t)
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
