//! Many markers in groups of neighbours, one of which can stand for all.

use crate::math::Vec3;
use crate::mesh::bounding_box;

/// More markers than this are grouped; each has one to three rows in a dense system.
const MOST_SINGLE: usize = 1000;

/// Groups at most.
const MOST_GROUPS: usize = 640;

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
    if markers.len() <= MOST_SINGLE {
        return None;
    }
    let mut parts: Vec<Vec<u32>> = vec![(0..markers.len() as u32).collect()];
    while 2 * parts.len() <= MOST_GROUPS {
        parts = parts.into_iter().flat_map(|part| halves(part, markers)).collect();
    }
    Some(parts.into_iter().map(|members| group(members, markers)).collect())
}

/// The two sides of the median across the longest extent.
fn halves(mut members: Vec<u32>, markers: &[Vec3]) -> [Vec<u32>; 2] {
    let points: Vec<Vec3> = members.iter().map(|&m| markers[m as usize]).collect();
    let extent = bounding_box(&points).map_or_else(Vec3::zeros, |(low, high)| high - low);
    let axis = extent.imax();
    let place = |&m: &u32| (markers[m as usize][axis], m);
    members.sort_unstable_by(|a, b| {
        let ((a, i), (b, j)) = (place(a), place(b));
        a.total_cmp(&b).then(i.cmp(&j))
    });
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
