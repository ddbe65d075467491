//! Short pieces joined to lines: what plane sections and outlines have in common.

use std::collections::HashMap;

use super::Vec3;

/// Points one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// The points; of a closed line the first is not repeated at the end.
    pub points: Vec<Vec3>,
    /// The last point is joined to the first.
    pub closed: bool,
}

impl Polyline {
    /// Its length, the closing piece included.
    pub fn length(&self) -> f64 {
        let open: f64 = self.points.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
        let closing = match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(first), Some(last)) => (first - last).norm(),
            _ => 0.0,
        };
        open + closing
    }
}

/// Joins pieces, given by the names of their ends, to chains: open ones first to last, closed ones
/// once around (`true`). Where more than two pieces meet, they are taken in the order given.
pub fn chain(pieces: &[[u64; 2]]) -> Vec<(Vec<u64>, bool)> {
    let mut at_end: HashMap<u64, Vec<u32>> = HashMap::new();
    for (p, piece) in pieces.iter().enumerate() {
        for end in piece {
            at_end.entry(*end).or_default().push(p as u32);
        }
    }
    let mut used = vec![false; pieces.len()];
    let mut chains = Vec::new();
    // Open chains start where only one piece ends; what is left after them is closed.
    let open = pieces.iter().flatten().filter(|end| at_end[end].len() % 2 == 1).copied();
    let starts: Vec<u64> = open.chain(pieces.iter().map(|p| p[0])).collect();
    for start in starts {
        let mut names = vec![start];
        let mut here = start;
        while let Some(&p) = at_end[&here].iter().find(|&&p| !used[p as usize]) {
            used[p as usize] = true;
            let [a, b] = pieces[p as usize];
            here = if a == here { b } else { a };
            if here == start {
                break;
            }
            names.push(here);
        }
        if names.len() > 1 {
            let closed = here == start;
            chains.push((names, closed));
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_in_any_order_become_open_and_closed_chains() {
        let chains = chain(&[[3, 1], [7, 8], [1, 2], [9, 8], [3, 2]]);
        assert_eq!(chains.len(), 2);
        assert_eq!(chains[0], (vec![7, 8, 9], false));
        assert!(chains[1].1 && chains[1].0.len() == 3);
        assert!(chain(&[]).is_empty());
        let square = [Vec3::zeros(), Vec3::x(), Vec3::x() + Vec3::y(), Vec3::y()];
        let line = Polyline { points: square.to_vec(), closed: true };
        assert!((line.length() - 4.0).abs() < 1e-15);
    }
}
