//! Memory that is used again: large blocks are otherwise returned to the system and cleared by it
//! each time (a tenth of a reshaping, docs/benchmarks.md).

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Blocks that are not in use.
#[derive(Debug)]
pub struct Memory<T>(Mutex<Vec<Vec<T>>>);

impl<T: Copy + Default> Memory<T> {
    /// A block of `length` values that say nothing; the smallest one at hand that has room for them.
    pub fn take(&self, length: usize) -> Vec<T> {
        let mut blocks = self.lock();
        let fitting = (0..blocks.len()).filter(|&k| blocks[k].capacity() >= length);
        let best = fitting.min_by_key(|&k| blocks[k].capacity());
        let mut block = best.map(|k| blocks.swap_remove(k)).unwrap_or_default();
        drop(blocks);
        block.reserve_exact(length.saturating_sub(block.len()));
        block.resize(length, T::default());
        block
    }
}

impl<T> Memory<T> {
    /// Returns a block.
    pub fn give(&self, block: Vec<T>) {
        self.lock().push(block);
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Vec<T>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Default for Memory<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

/// Memory in both precisions.
#[derive(Debug, Default)]
pub struct Memories {
    pub(super) single: Memory<f32>,
    pub(super) double: Memory<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_block_that_fits_is_taken() {
        let memory = Memory::default();
        memory.give(vec![1; 100]);
        memory.give(vec![2; 10]);
        let block = memory.take(7);
        assert!(block.len() == 7 && (10..100).contains(&block.capacity()));
        assert!(memory.take(20).capacity() >= 100);
        assert_eq!(memory.take(20).len(), 20);
    }
}
