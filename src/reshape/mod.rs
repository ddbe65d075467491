//! A template follows markers through optimized plastic strains (Wang, Matcuk, Barbic 2021).

mod affine_start;
mod again;
mod coverage;
mod damping;
mod earlier;
mod evidence;
mod far_markers;
mod folds;
mod gauss_newton;
mod inspect;
mod lagging_attachments;
mod linearization;
mod marker_groups;
mod numbering;
mod options;
mod pairs;
mod problem;
mod refine;
mod rows;
mod scene;
mod solver;
mod step;
mod summary;
mod trial;
mod woodbury;

pub use again::reshape_again;
pub use gauss_newton::{Direction, NormalEquations};
pub use inspect::{Data, inspect_data};
pub use linearization::Linearization;
pub use options::{Options, Tolerances};
pub use pairs::{Pair, attach_to_bone, keep_gaps};
pub use problem::{Landmark, Marker, Problem, TemplatePoint};
pub use refine::{Refinement, find_borders};
pub use rows::{Row, Rows};
pub use solver::{Reshaped, reshape};
pub use summary::{IterationRecord, Stop, Summary};
