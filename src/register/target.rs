//! One person's bones as seen: a surface of all bones together, or one surface per bone.

use super::areas::vertex_areas;
use super::image::{Appearance, ImageTarget};
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};
use crate::volume::Volume;

/// A surface with what the search for closest points needs.
#[derive(Clone, Debug)]
pub(super) struct SearchedSurface {
    pub(super) mesh: TriMesh,
    pub(super) search: ClosestPoints,
    pub(super) areas: Vec<f64>,
    pub(super) vertex_normals: Vec<Vec3>,
    pub(super) face_normals: Vec<Vec3>,
}

impl SearchedSurface {
    fn new(mesh: TriMesh) -> Self {
        let faces = area_vectors(&mesh.points, &mesh.triangles);
        Self {
            search: ClosestPoints::new(&mesh.points, &mesh.triangles),
            areas: vertex_areas(&mesh.points, &mesh.triangles),
            vertex_normals: vertex_normals(mesh.points.len(), &mesh.triangles, &faces),
            face_normals: faces.iter().map(unit_or_zero).collect(),
            mesh,
        }
    }
}

/// What the skeleton is registered to.
#[derive(Clone, Debug)]
pub struct Target {
    /// One surface for all bones, or one (or none) for each bone.
    pub(super) surfaces: Vec<Option<SearchedSurface>>,
    pub(super) labelled: bool,
    /// An image in place of surfaces.
    pub(super) image: Option<ImageTarget>,
}

impl Target {
    /// One surface of the whole skeleton; bones may be fused. It may be open and noisy but its
    /// triangles must be oriented outwards.
    pub fn whole(surface: TriMesh) -> Result<Self> {
        if surface.triangles.is_empty() {
            return Err(Error::invalid("the target surface has no triangles"));
        }
        let surfaces = vec![Some(SearchedSurface::new(surface))];
        Ok(Self { surfaces, labelled: false, image: None })
    }

    /// A surface for each named bone; bones that are not named have no data of their own and follow
    /// their joints.
    pub fn per_bone(skeleton: &Skeleton, surfaces: Vec<(String, TriMesh)>) -> Result<Self> {
        let mut of_bone: Vec<Option<SearchedSurface>> = vec![None; skeleton.bones.len()];
        for (name, mesh) in surfaces {
            let b = skeleton.bone_index(&name).ok_or_else(|| {
                Error::invalid(format!(
                    "the target names a bone {name} that the skeleton does not have"
                ))
            })?;
            if mesh.triangles.is_empty() {
                return Err(Error::invalid(format!(
                    "the target surface of bone {name} has no triangles"
                )));
            }
            if of_bone[b].replace(SearchedSurface::new(mesh)).is_some() {
                return Err(Error::invalid(format!("the target gives bone {name} twice")));
            }
        }
        if of_bone.iter().all(Option::is_none) {
            return Err(Error::invalid("the target names no bone of the skeleton"));
        }
        Ok(Self { surfaces: of_bone, labelled: true, image: None })
    }

    /// An image of the person, in which the template already lies roughly on its bones (within the
    /// reach of the search, [`super::Options::image_reach`]). `appearance`: what the template shows
    /// in its reference image, made by the same protocol.
    pub fn image(skeleton: &Skeleton, volume: Volume, appearance: Appearance) -> Result<Self> {
        let image = Some(ImageTarget::new(skeleton, volume, appearance)?);
        Ok(Self { surfaces: Vec::new(), labelled: false, image })
    }

    /// Whether the target tells the bones apart.
    pub fn is_labelled(&self) -> bool {
        self.labelled
    }

    /// All vertices with their areas, for a first rigid alignment.
    pub(super) fn points_and_areas(&self) -> (Vec<Vec3>, Vec<f64>) {
        let surfaces = self.surfaces.iter().flatten();
        let points = surfaces.clone().flat_map(|s| s.mesh.points.iter().copied()).collect();
        (points, surfaces.flat_map(|s| s.areas.iter().copied()).collect())
    }
}
