//! Triangle and tet meshes: data, adjacency, quality.

pub mod adjacency;
pub mod normals;
pub mod quality;
pub mod section;
pub mod surface;
#[cfg(test)]
pub(crate) mod test_shapes;
mod tet_mesh;
mod tri_mesh;

pub use quality::TetQuality;
pub use section::plane_section;
pub use surface::{SurfaceCheck, boundary_triangles};
pub use tet_mesh::{TetMesh, signed_volume, tet_faces};
pub use tri_mesh::{TriMesh, bounding_box, diagonal};
