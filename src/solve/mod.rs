//! Linear solvers: sparse Cholesky with a fixed pattern, nested dissection, conjugate gradients, small
//! dense systems; backtracking along a step.

mod block_matrix;
mod conjugate_gradients;
mod dense;
mod factor;
mod line_search;
mod memory;
mod ordering;
mod real;
mod saddle;
mod triangular;

pub use block_matrix::{BlockMatrix, BlockPattern};
pub use conjugate_gradients::{Goal, Solved, Unknowns, conjugate_gradients};
pub use dense::{ColumnBlocks, DenseCholesky};
pub use factor::{Factor, RoundedFactor, SymbolicFactor};
pub use line_search::{Lower, backtrack};
pub use memory::Memory;
pub use ordering::nested_dissection;
pub use real::Real;
pub use saddle::{SaddleFactor, SaddleSystem};
