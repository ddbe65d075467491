//! Figures of a result: distances, values between markers, how well it meets a label map.

mod distances;
mod interpolate;
mod label_fit;

pub use distances::{Spread, distance_to_markers, marker_distances};
pub use interpolate::interpolate;
pub use label_fit::LabelFit;
