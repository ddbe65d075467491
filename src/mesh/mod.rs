//! Triangle and tet meshes: data, adjacency, quality.

mod tet_mesh;
mod tri_mesh;

pub use tet_mesh::{TetMesh, signed_volume};
pub use tri_mesh::{TriMesh, bounding_box};
