//! All pairs of points nearer than a radius, through a hash grid.

use std::collections::HashMap;

use crate::math::Vec3;

/// Points sorted into cubes of one size.
pub(super) struct PointGrid<'a> {
    points: &'a [Vec3],
    size: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> PointGrid<'a> {
    /// A grid for searches up to `radius`, which must be positive and finite.
    pub(super) fn new(points: &'a [Vec3], radius: f64) -> Self {
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (i, p) in points.iter().enumerate() {
            cells.entry(cell(p, radius)).or_default().push(i as u32);
        }
        Self { points, size: radius, cells }
    }

    /// An empty grid over the same points; fill it with [`Self::insert`].
    pub(super) fn empty(points: &'a [Vec3], radius: f64) -> Self {
        Self { points, size: radius, cells: HashMap::new() }
    }

    /// Adds point `i`.
    pub(super) fn insert(&mut self, i: u32) {
        self.cells.entry(cell(&self.points[i as usize], self.size)).or_default().push(i);
    }

    /// Indices of the points within the radius of `p`, ascending.
    pub(super) fn within(&self, p: &Vec3) -> Vec<u32> {
        let centre = cell(p, self.size);
        let mut found = Vec::new();
        for offset in 0..27 {
            let step = [offset / 9 - 1, offset / 3 % 3 - 1, offset % 3 - 1];
            let key = std::array::from_fn(|k| centre[k] + step[k]);
            for &i in self.cells.get(&key).into_iter().flatten() {
                if (self.points[i as usize] - p).norm_squared() <= self.size * self.size {
                    found.push(i);
                }
            }
        }
        found.sort_unstable();
        found
    }
}

fn cell(p: &Vec3, size: f64) -> [i64; 3] {
    std::array::from_fn(|k| (p[k] / size).floor() as i64)
}
