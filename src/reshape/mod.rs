//! A template follows markers through optimized plastic strains (Wang, Matcuk, Barbic 2021).

mod affine_start;
mod coverage;
mod evidence;
mod gauss_newton;
mod numbering;
mod options;
mod problem;
mod scene;
mod solver;
mod summary;
mod woodbury;

pub use gauss_newton::{Direction, Linearization, Row, Rows};
pub use options::Options;
pub use problem::{Landmark, Marker, Problem, TemplatePoint};
pub use solver::{Reshaped, reshape};
pub use summary::{IterationRecord, Stop, Summary};
