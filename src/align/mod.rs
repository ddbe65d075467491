//! Best rigid and similarity fits between point sets.

mod rigid;

pub use rigid::{Rigid, Similarity, best_rigid, best_similarity};
