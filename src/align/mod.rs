//! Best rigid and similarity fits between point sets, and the rough placing of a template.

mod icp;
mod rigid;

pub use icp::{Freedom, LandmarkPairs, pre_align};
pub use rigid::{Rigid, Similarity, best_rigid, best_similarity};
