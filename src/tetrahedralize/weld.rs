//! A surface as a solid sees it: each place one vertex, no empty triangles, nothing unused.

use crate::mesh::TriMesh;
use crate::mesh::adjacency::first_at_place;

/// The welded surface and where it came from.
pub struct Welded {
    /// Vertices that some triangle uses, those at exactly the same place made one (seams of
    /// textures, STL files); triangles with three different corners.
    pub mesh: TriMesh,
    /// The welded vertex of each original vertex; None where no triangle uses it.
    pub vertex_of: Vec<Option<u32>>,
}

impl Welded {
    pub fn new(surface: &TriMesh) -> Self {
        let first = first_at_place(&surface.points);
        let mut number = vec![None; surface.points.len()];
        let mut mesh = TriMesh::default();
        let mut vertex_of = vec![None; surface.points.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| first[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            let welded = triangle.map(|v| {
                let vertex = *number[first[v as usize] as usize].get_or_insert_with(|| {
                    mesh.points.push(surface.points[v as usize]);
                    mesh.points.len() as u32 - 1
                });
                vertex_of[v as usize] = Some(vertex);
                vertex
            });
            mesh.triangles.push(welded);
        }
        Self { mesh, vertex_of }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::math::Vec3;
    use crate::mesh::SurfaceCheck;

    #[test]
    fn a_triangle_soup_becomes_a_closed_surface() {
        let (points, triangles) = sphere(6, 8);
        let soup: Vec<Vec3> = triangles.iter().flatten().map(|&v| points[v as usize]).collect();
        let mut all: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        all.insert(0, [0, 0, 1]);
        let mut soup = TriMesh::new(soup, all).unwrap();
        soup.points.push(Vec3::repeat(7.0));
        let welded = Welded::new(&soup);
        assert_eq!(welded.mesh.points.len(), points.len());
        assert!(SurfaceCheck::new(&welded.mesh).sentences(&welded.mesh).is_empty());
        assert_eq!(welded.mesh.triangles.len(), triangles.len());
        assert_eq!(welded.vertex_of.last(), Some(&None));
    }
}
