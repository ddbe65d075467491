//! Closest points, point location and embedding.

mod box_tree;
mod closest;
mod crossing;
mod embed;
mod nearest_points;
mod solid;
mod spread;
#[cfg(test)]
pub(crate) mod test_shapes;
mod triangle;
mod winding;

pub use closest::{ClosestPoints, SurfacePoint};
pub use crossing::{crossing_triangles, triangles_cross};
pub use embed::{Embedding, tet_weights};
pub use nearest_points::NearestPoints;
pub use solid::Solid;
pub use spread::{SAME, coordinate_order, spread_evenly};
pub use triangle::closest_on_triangle;
pub use winding::{WindingNumber, winding_number};
