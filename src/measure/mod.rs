//! Figures of a result: distances, how well it meets a label map.

mod distances;
mod label_fit;

pub use distances::{Spread, distance_to_markers, marker_distances};
pub use label_fit::LabelFit;
