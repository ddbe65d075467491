//! All pairs of points nearer than a radius, through a hash grid.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::math::Vec3;

/// A fast hash of cell numbers; nobody can choose them to our harm beyond making a search slow.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(5) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_i64(&mut self, x: i64) {
        self.write_u64(x as u64);
    }
}

type Cells = HashMap<(i64, i64, i64), Vec<u32>, BuildHasherDefault<CellHasher>>;

/// Points sorted into cubes of one size.
pub(super) struct PointGrid<'a> {
    points: &'a [Vec3],
    size: f64,
    cells: Cells,
}

impl<'a> PointGrid<'a> {
    /// A grid for searches up to `radius`, which must be positive and finite.
    pub(super) fn new(points: &'a [Vec3], radius: f64) -> Self {
        let mut cells = Cells::default();
        for (i, p) in points.iter().enumerate() {
            cells.entry(cell(p, radius)).or_default().push(i as u32);
        }
        Self { points, size: radius, cells }
    }

    /// An empty grid over the same points; fill it with [`Self::insert`].
    pub(super) fn empty(points: &'a [Vec3], radius: f64) -> Self {
        Self { points, size: radius, cells: Cells::default() }
    }

    /// Adds point `i`.
    pub(super) fn insert(&mut self, i: u32) {
        self.cells.entry(cell(&self.points[i as usize], self.size)).or_default().push(i);
    }

    /// Indices of the points within the radius of `p`, ascending.
    pub(super) fn within(&self, p: &Vec3) -> Vec<u32> {
        let mut found: Vec<u32> = self.around(p).collect();
        found.sort_unstable();
        found
    }

    /// The point nearest to `p` within the radius; the first of several.
    pub(super) fn nearest(&self, p: &Vec3) -> Option<u32> {
        let distance = |i: u32| (self.points[i as usize] - p).norm_squared();
        self.around(p).min_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)))
    }

    /// Whether a point within the radius of `p` counts.
    pub(super) fn any_within(&self, p: &Vec3, counts: impl Fn(u32) -> bool) -> bool {
        self.around(p).any(counts)
    }

    /// The points within the radius of `p`, cell by cell, those of its own cell first.
    fn around<'b>(&'b self, p: &'b Vec3) -> impl Iterator<Item = u32> + 'b {
        let centre = cell(p, self.size);
        // 13 is the cell itself.
        let cells = (0..27).map(|k| (k + 13) % 27).filter_map(move |k| {
            let key = (centre.0 + k / 9 - 1, centre.1 + k / 3 % 3 - 1, centre.2 + k % 3 - 1);
            self.cells.get(&key)
        });
        let limit = self.size * self.size;
        cells
            .flatten()
            .copied()
            .filter(move |&i| (self.points[i as usize] - p).norm_squared() <= limit)
    }
}

fn cell(p: &Vec3, size: f64) -> (i64, i64, i64) {
    let along = |k: usize| (p[k] / size).floor() as i64;
    (along(0), along(1), along(2))
}
