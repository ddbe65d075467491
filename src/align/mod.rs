//! Best rigid and similarity fits between point sets, the rough placing of a template, modes of shapes.

mod icp;
mod rigid;
mod shape_statistics;

pub use icp::{Freedom, LandmarkPairs, pre_align};
pub use rigid::{Rigid, Similarity, best_rigid, best_similarity};
pub use shape_statistics::ShapeStatistics;
