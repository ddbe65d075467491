//! A tree of axis-aligned boxes over items of any kind (triangles, tets, points).
//!
//! Own code rather than a crate because refitting to moved items is the hot path of the solvers and
//! ties must fall alike in every run: the libraries at hand either rebuild or leave ties open.

use rayon::prelude::*;

use crate::math::Vec3;

/// Items in a leaf: small enough to prune well, large enough to keep the tree shallow.
const LEAF_ITEMS: usize = 4;
/// Boxes are searched a little beyond the best distance, so that rounding never hides a tie.
const SLACK: f64 = 1.0 + 1e-12;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    pub fn of(corners: &[Vec3]) -> Self {
        let empty =
            Self { low: Vec3::repeat(f64::INFINITY), high: Vec3::repeat(f64::NEG_INFINITY) };
        corners.iter().fold(empty, |b, p| Self { low: b.low.inf(p), high: b.high.sup(p) })
    }

    fn centre(&self) -> Vec3 {
        (self.low + self.high) / 2.0
    }

    /// Whether the two boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// Bounds in half the memory, rounded outwards.
#[derive(Clone, Copy, Debug)]
struct ShortBounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl ShortBounds {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn around(bounds: &Bounds) -> Self {
        // One step of single precision down, whichever way the conversion rounded.
        let below = |x: f64| {
            let near = x as f32;
            near - (near.abs() * f32::EPSILON + f32::MIN_POSITIVE)
        };
        let (low, high) = (bounds.low, bounds.high);
        Self {
            low: [below(low.x), below(low.y), below(low.z)],
            high: [-below(-high.x), -below(-high.y), -below(-high.z)],
        }
    }

    fn union(&self, other: &Self) -> Self {
        let mut joined = *self;
        for k in 0..3 {
            joined.low[k] = joined.low[k].min(other.low[k]);
            joined.high[k] = joined.high[k].max(other.high[k]);
        }
        joined
    }

    /// Whether the two boxes have a point in common.
    fn meets(&self, other: &Bounds) -> bool {
        (0..3).all(|k| {
            f64::from(self.low[k]) <= other.high[k] && other.low[k] <= f64::from(self.high[k])
        })
    }

    fn distance_squared(&self, p: &Vec3) -> f64 {
        let mut sum = 0.0;
        for k in 0..3 {
            let outside =
                (f64::from(self.low[k]) - p[k]).max(p[k] - f64::from(self.high[k])).max(0.0);
            sum += outside * outside;
        }
        sum
    }
}

/// A node. The children of an inner node stand together, so that one look at memory finds both.
#[derive(Clone, Debug)]
struct Node {
    bounds: ShortBounds,
    /// Leaf: first entry in `items`. Inner: index of the left child; the right one follows.
    first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    count: u32,
}

/// A node seen from outside.
pub(super) enum Part<'a> {
    Leaf(&'a [u32]),
    Inner([u32; 2]),
}

/// The tree. It knows the boxes of its items, not the items.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

impl BoxTree {
    pub fn new(bounds: &[Bounds]) -> Self {
        let centres: Vec<Vec3> = bounds.iter().map(Bounds::centre).collect();
        let mut tree = Self { nodes: Vec::new(), items: (0..bounds.len() as u32).collect() };
        if !bounds.is_empty() {
            tree.nodes.push(Node { bounds: ShortBounds::EMPTY, first: 0, count: 0 });
            tree.split(&centres, 0, 0, bounds.len());
            tree.refit(|item| bounds[item as usize]);
        }
        tree
    }

    /// Makes `node` of `items[first..end]`, split at the median along the longest side of their
    /// centres. Children come after their parents.
    fn split(&mut self, centres: &[Vec3], node: usize, first: usize, end: usize) {
        let count = end - first;
        if count <= LEAF_ITEMS {
            self.nodes[node].first = first as u32;
            self.nodes[node].count = count as u32;
            return;
        }
        let items = &mut self.items[first..end];
        let spread = items.iter().fold(Bounds::of(&[]), |b, &i| {
            let c = centres[i as usize];
            Bounds { low: b.low.inf(&c), high: b.high.sup(&c) }
        });
        let axis = (spread.high - spread.low).imax();
        items.select_nth_unstable_by(count / 2, |&a, &b| {
            centres[a as usize][axis].total_cmp(&centres[b as usize][axis]).then(a.cmp(&b))
        });
        let middle = first + count / 2;
        let left = self.nodes.len();
        self.nodes[node].first = left as u32;
        let unset = Node { bounds: ShortBounds::EMPTY, first: 0, count: 0 };
        self.nodes.extend([unset.clone(), unset]);
        self.split(centres, left, first, middle);
        self.split(centres, left + 1, middle, end);
    }

    /// Fits all boxes to moved items; the tree's structure stays.
    pub fn refit(&mut self, bounds: impl Fn(u32) -> Bounds + Sync) {
        let items = &self.items;
        self.nodes.par_iter_mut().with_min_len(256).filter(|node| node.count > 0).for_each(
            |node| {
                let items = &items[node.first as usize..(node.first + node.count) as usize];
                let all = items.iter().fold(Bounds::of(&[]), |b, &i| {
                    let item = bounds(i);
                    Bounds { low: b.low.inf(&item.low), high: b.high.sup(&item.high) }
                });
                node.bounds = ShortBounds::around(&all);
            },
        );
        for n in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[n];
            if count == 0 {
                let left = &self.nodes[first as usize].bounds;
                self.nodes[n].bounds = left.union(&self.nodes[first as usize + 1].bounds);
            }
        }
    }

    /// The items in the order of the leaves: those that are close together stand together.
    pub fn items(&self) -> &[u32] {
        &self.items
    }

    /// The item of least `measure` (a squared distance, with anything the caller wants to keep) not
    /// above `limit`; the lowest index of those that are equal. `measure` gets the item and its place in
    /// [`Self::items`].
    pub fn nearest<T>(
        &self,
        p: &Vec3,
        limit: f64,
        mut measure: impl FnMut(u32, usize) -> (f64, T),
    ) -> Option<(u32, f64, T)> {
        let mut best: Option<(u32, f64, T)> = None;
        let mut bound = limit;
        self.visit_nearest(p, limit, |item, place| {
            let (value, kept) = measure(item, place);
            let lower = best.as_ref().is_none_or(|b| value < b.1 || item < b.0);
            if value <= bound && lower {
                bound = value;
                best = Some((item, value, kept));
            }
            bound
        });
        best
    }

    /// Calls `visit` for items, those of nearer boxes first, and leaves out boxes that are farther than the
    /// last squared distance it returned, `limit` at first. `visit` gets the item and its place in
    /// [`Self::items`].
    pub fn visit_nearest(&self, p: &Vec3, limit: f64, mut visit: impl FnMut(u32, usize) -> f64) {
        let mut bound = limit;
        let mut stack = [(0_u32, 0.0_f64); 64];
        let mut depth = 0;
        if let Some(root) = self.nodes.first() {
            stack[0] = (0, root.bounds.distance_squared(p));
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (n, distance) = stack[depth];
            if distance > bound * SLACK {
                continue;
            }
            let node = &self.nodes[n as usize];
            if node.count == 0 {
                let child = |c: u32| (c, self.nodes[c as usize].bounds.distance_squared(p));
                let mut children = [child(node.first), child(node.first + 1)];
                // The nearer child goes on top of the stack.
                if children[0].1 < children[1].1 {
                    children.swap(0, 1);
                }
                stack[depth] = children[0];
                stack[depth + 1] = children[1];
                depth += 2;
                continue;
            }
            for place in node.first as usize..(node.first + node.count) as usize {
                bound = visit(self.items[place], place);
            }
        }
    }

    /// One value per node, from the leaves up: `leaf` of a leaf's items, `join` of two children.
    pub fn fold_up<T: Clone>(
        &self,
        leaf: impl Fn(&[u32]) -> T,
        join: impl Fn(&T, &T) -> T,
    ) -> Vec<T> {
        let mut values: Vec<Option<T>> = vec![None; self.nodes.len()];
        for n in (0..self.nodes.len()).rev() {
            let value = match self.node(n as u32) {
                Part::Leaf(items) => leaf(items),
                Part::Inner([left, right]) => {
                    let child = |c: u32| values[c as usize].as_ref().expect("children come later");
                    join(child(left), child(right))
                }
            };
            values[n] = Some(value);
        }
        values.into_iter().flatten().collect()
    }

    /// What stands at node `n`; node 0 is the root of a tree that is not empty.
    pub fn node(&self, n: u32) -> Part<'_> {
        let Node { first, count, .. } = self.nodes[n as usize];
        if count == 0 {
            Part::Inner([first, first + 1])
        } else {
            Part::Leaf(&self.items[first as usize..(first + count) as usize])
        }
    }

    /// Calls `visit` for each item of a leaf whose box is within `distance` of `p`, in tree order.
    pub fn visit_within(&self, p: &Vec3, distance: f64, visit: impl FnMut(u32)) {
        let limit = distance * distance * SLACK;
        self.visit(|bounds| bounds.distance_squared(p) > limit, visit);
    }

    /// Calls `visit` for each item of a leaf whose box meets `bounds`, in tree order.
    pub fn visit_meeting(&self, bounds: &Bounds, visit: impl FnMut(u32)) {
        self.visit(|own| !own.meets(bounds), visit);
    }

    fn visit(&self, is_beyond: impl Fn(&ShortBounds) -> bool, mut visit: impl FnMut(u32)) {
        let mut stack: Vec<u32> = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(n) = stack.pop() {
            if is_beyond(&self.nodes[n as usize].bounds) {
                continue;
            }
            match self.node(n) {
                Part::Inner([left, right]) => stack.extend([right, left]),
                Part::Leaf(items) => items.iter().for_each(|&item| visit(item)),
            }
        }
    }
}
