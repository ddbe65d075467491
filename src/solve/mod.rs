//! Linear solvers: sparse Cholesky with a fixed pattern, nested dissection, small dense systems.

mod block_matrix;
mod dense;
mod factor;
mod memory;
mod ordering;
mod real;
mod saddle;
mod triangular;

pub use block_matrix::{BlockMatrix, BlockPattern};
pub use dense::{ColumnBlocks, DenseCholesky};
pub use factor::{Factor, RoundedFactor, SymbolicFactor};
pub use memory::Memory;
pub use ordering::nested_dissection;
pub use real::Real;
pub use saddle::{SaddleFactor, SaddleSystem};
