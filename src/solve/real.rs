//! Single and double precision in one code.

use faer::traits::RealField;

use super::memory::{Memories, Memory};

/// `f32` or `f64`.
pub trait Real: RealField + Copy + Default + Send + Sync {
    /// Rounded.
    fn from_f64(value: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// Memory for values of this precision.
    fn memory(memories: &Memories) -> &Memory<Self>;
}

impl Real for f64 {
    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    fn memory(memories: &Memories) -> &Memory<Self> {
        &memories.double
    }
}

impl Real for f32 {
    #[inline]
    fn from_f64(value: f64) -> Self {
        value as Self
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.into()
    }

    fn memory(memories: &Memories) -> &Memory<Self> {
        &memories.single
    }
}
