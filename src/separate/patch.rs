//! The vertices that may move: those within some edges of an overlap ([W] 4.1.4: a 5-ring).

use super::scene::Body;
use crate::mesh::adjacency::{Lists, vertex_neighbours};

/// Which vertices of the bodies' tets are free.
pub(super) struct Patch {
    neighbours: Vec<Lists>,
    rings: usize,
    /// Per body and vertex.
    pub free: Vec<Vec<bool>>,
}

impl Patch {
    /// Nothing is free yet.
    pub fn new(bodies: &[Body], rings: usize) -> Self {
        let graph = |body: &Body| vertex_neighbours(body.tets.points.len(), &body.tets.tets);
        let held = |body: &Body| vec![false; body.tets.points.len()];
        Self {
            neighbours: bodies.iter().map(graph).collect(),
            rings,
            free: bodies.iter().map(held).collect(),
        }
    }

    /// Frees the vertices of body `b` within the rings around `seeds`.
    pub fn add(&mut self, b: usize, seeds: &[u32]) {
        let mut reached = vec![false; self.free[b].len()];
        let mut front: Vec<u32> = Vec::new();
        for &v in seeds {
            if !std::mem::replace(&mut reached[v as usize], true) {
                front.push(v);
            }
        }
        for _ in 0..self.rings {
            let mut next = Vec::new();
            for &v in &front {
                for &w in self.neighbours[b].of(v as usize) {
                    if !std::mem::replace(&mut reached[w as usize], true) {
                        next.push(w);
                    }
                }
            }
            front = next;
        }
        for (free, reached) in self.free[b].iter_mut().zip(reached) {
            *free |= reached;
        }
    }
}
