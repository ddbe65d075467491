//! A target's surface with what the search for closest points needs.

use super::areas::vertex_areas;
use super::border::Border;
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};

/// A surface that is searched.
#[derive(Clone, Debug)]
pub(super) struct SearchedSurface {
    pub(super) mesh: TriMesh,
    pub(super) search: ClosestPoints,
    pub(super) areas: Vec<f64>,
    pub(super) vertex_normals: Vec<Vec3>,
    pub(super) face_normals: Vec<Vec3>,
    pub(super) border: Border,
}

impl SearchedSurface {
    pub(super) fn new(mesh: TriMesh) -> Self {
        let faces = area_vectors(&mesh.points, &mesh.triangles);
        Self {
            search: ClosestPoints::new(&mesh.points, &mesh.triangles),
            areas: vertex_areas(&mesh.points, &mesh.triangles),
            vertex_normals: vertex_normals(mesh.points.len(), &mesh.triangles, &faces),
            face_normals: faces.iter().map(unit_or_zero).collect(),
            border: Border::new(&mesh),
            mesh,
        }
    }

    /// The triangles whose vertices `keep` holds.
    pub(super) fn part(&self, keep: impl Fn(u32) -> bool) -> Self {
        Self::new(self.mesh.part(|t| self.mesh.triangles[t].iter().all(|&v| keep(v))))
    }
}
