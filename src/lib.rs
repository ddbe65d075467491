//! moulage puts a template of an organ, bone or skeleton into one person's shape.
//!
//! Two systems share this crate:
//! - [`reshape`]: a template's tet mesh follows sparse landmarks, correspondence-free markers and
//!   attachments through optimized plastic strains under FEM equilibrium.
//! - [`register`]: a template skeleton with joints and limits follows a surface of a person's bones.
//!
//! The modules stand in layers; imports go only downwards. `ARCHITECTURE.md` has the picture and
//! `tests/architecture.rs` holds it.

// 0
pub mod error;
pub mod run;
// 1
pub mod math;
pub mod threads;
// 2
pub mod mesh;
pub mod volume;
// 3
pub mod locate;
pub mod material;
pub mod solve;
// 4
pub mod align;
pub mod fem;
pub mod io;
pub mod measure;
pub mod tetrahedralize;
// 5
pub mod register;
pub mod reshape;
pub mod separate;
// 6
pub mod job;
// 7
pub mod capi;

pub use error::{Error, Result};
pub use mesh::{TetMesh, TriMesh};
pub use run::{Progress, Run};
