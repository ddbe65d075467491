//! Triangle and tet meshes: data, adjacency, quality.

pub mod adjacency;
pub mod quality;
pub mod surface;
mod tet_mesh;
mod tri_mesh;

pub use quality::TetQuality;
pub use surface::{SurfaceCheck, boundary_triangles};
pub use tet_mesh::{TetMesh, signed_volume};
pub use tri_mesh::{TriMesh, bounding_box};
