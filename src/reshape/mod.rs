//! A template follows markers through optimized plastic strains (Wang, Matcuk, Barbic 2021).

mod affine_start;
mod carried_surface;
mod correspondences;
mod coverage;
mod damping;
mod data_terms;
mod earlier;
mod folds;
mod formulation;
mod gauss_newton;
mod inspect;
mod legs;
mod linearization;
mod marker_groups;
mod markers;
mod numbering;
mod objective;
mod options;
mod paired_points;
mod pairs;
mod problem;
mod refine;
mod reshaped;
mod rows;
mod scene;
mod schedule;
mod slices;
mod solver;
mod step;
mod summary;
mod term;
#[cfg(test)]
mod test_problems;
mod trial;
mod woodbury;

pub use gauss_newton::{Direction, NormalEquations};
pub use inspect::{Data, inspect_data};
pub use legs::{reshape, reshape_again};
pub use linearization::Linearization;
pub use options::{Options, Tolerances};
pub use pairs::{Pair, attach_to_bone, keep_gaps};
pub use problem::{Landmark, Marker, Problem, TemplatePoint};
pub use refine::{Refinement, find_borders};
pub use reshaped::Reshaped;
pub use rows::{Row, Rows};
pub use summary::{IterationRecord, Remesh, Shapeliness, Stop, Summary};
