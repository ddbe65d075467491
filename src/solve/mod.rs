//! Linear solvers: sparse Cholesky with a fixed pattern, nested dissection, small dense systems.

mod block_matrix;
mod dense;
mod factor;
mod ordering;
mod saddle;

pub use block_matrix::{BlockMatrix, BlockPattern};
pub use dense::{ColumnBlocks, DenseCholesky};
pub use factor::{Factor, SymbolicFactor};
pub use ordering::nested_dissection;
pub use saddle::{SaddleFactor, SaddleSystem};
