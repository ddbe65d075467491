//! Neighbours that overlap are pushed apart by local contact simulation ([W] section 4.1.4).
//!
//! Each organ is reshaped by itself, so results overlap where markers were placed inexactly. Around
//! each overlap, and only there, the tets of both bodies are simulated with contact between their
//! surfaces; their present shape is their shape at rest. The published method adds one muscle after
//! the other; here all bodies that touch are solved together, so that each yields its share.
//!
//! - `contacts` - which surface points are too near, and in which direction they part
//! - `escape`   - in which direction a vertex leaves another body
//! - `patch`    - the vertices that may move
//! - `islands`  - bodies that are solved together
//! - `holds`    - what keeps bodies in their places
//! - `energy`   - elasticity, contact and holds, with derivatives
//! - `solver`   - rounds of detection and Newton's method
//! - `overlap`  - what is left, decided exactly
//! - `summary`  - the figures

mod contacts;
mod energy;
mod escape;
mod holds;
mod islands;
mod options;
mod overlap;
mod patch;
mod scene;
mod solver;
mod summary;

pub use options::Options;
pub use overlap::{Overlap, overlaps};
pub use scene::{Body, Obstacle};
pub use solver::{Ending, Separation, separate};
pub use summary::{ContradictingMarker, MovedBody, OverlapLine, Summary};
