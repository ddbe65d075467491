//! One person's bones as seen: a surface of all bones together, or one surface per bone.

use super::image::{Appearance, ImageTarget};
use super::landmarks::{Landmark, PlacedLandmark};
use super::prepared::Prepared;
use super::skeleton::Skeleton;
use super::surface::SearchedSurface;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::volume::Volume;

/// What the skeleton is registered to.
#[derive(Clone, Debug)]
pub struct Target {
    /// Flat ends of the surfaces that were taken for cuts.
    pub(super) lids: usize,
    /// Some surface came with its normals inwards and was turned.
    pub(super) turned: bool,
    /// Some surface was so noisy that it was smoothed.
    pub(super) smoothed: bool,
    /// Share of its area that lies far from all bones and was left out.
    pub(super) left_out: f64,
    /// One surface for all bones, or one (or none) for each bone.
    pub(super) surfaces: Vec<Option<SearchedSurface>>,
    pub(super) labelled: bool,
    /// An image in place of surfaces.
    pub(super) image: Option<ImageTarget>,
    pub(super) landmarks: Vec<PlacedLandmark>,
}

/// A surface, and the bones that are sought on it.
pub(super) struct Part<'a> {
    pub(super) bones: Vec<usize>,
    pub(super) surface: &'a SearchedSurface,
}

impl Target {
    /// One surface of the whole skeleton; bones may be fused. It may be open and noisy. A surface whose
    /// triangles face inwards is turned, a very noisy one smoothed, and flat ends are taken for cuts.
    pub fn whole(surface: TriMesh) -> Result<Self> {
        if surface.triangles.is_empty() {
            return Err(Error::invalid("the target surface has no triangles"));
        }
        let Prepared { mesh, lids, turned, smoothed } = Prepared::new(surface);
        let surfaces = vec![Some(SearchedSurface::new(mesh))];
        Ok(Self { lids, turned, smoothed, surfaces, ..Self::empty() })
    }

    /// A surface for each named bone; bones that are not named have no data of their own and follow
    /// their joints.
    pub fn per_bone(skeleton: &Skeleton, surfaces: Vec<(String, TriMesh)>) -> Result<Self> {
        let mut of_bone: Vec<Option<SearchedSurface>> = vec![None; skeleton.bones.len()];
        let (mut lids, mut turned, mut smoothed) = (0, false, false);
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
            let prepared = Prepared::new(mesh);
            lids += prepared.lids;
            turned |= prepared.turned;
            smoothed |= prepared.smoothed;
            if of_bone[b].replace(SearchedSurface::new(prepared.mesh)).is_some() {
                return Err(Error::invalid(format!("the target gives bone {name} twice")));
            }
        }
        if of_bone.iter().all(Option::is_none) {
            return Err(Error::invalid("the target names no bone of the skeleton"));
        }
        let surfaces = of_bone;
        Ok(Self { lids, turned, smoothed, surfaces, labelled: true, ..Self::empty() })
    }

    /// An image of the person, in which the template already lies roughly on its bones (within the
    /// reach of the search, [`super::Options::image_reach`]). `appearance`: what the template shows
    /// in its reference image, made by the same protocol.
    pub fn image(skeleton: &Skeleton, volume: Volume, appearance: Appearance) -> Result<Self> {
        let image = Some(ImageTarget::new(skeleton, volume, appearance)?);
        Ok(Self { image, ..Self::empty() })
    }

    /// The same with landmarks. A landmark that is not on its bone, or not a number, is an error.
    pub fn with_landmarks(mut self, skeleton: &Skeleton, landmarks: &[Landmark]) -> Result<Self> {
        let placed = landmarks.iter().enumerate().map(|(k, landmark)| {
            PlacedLandmark::new(skeleton, landmark)
                .map_err(|e| Error::invalid(format!("landmark {k} {e}")))
        });
        self.landmarks = placed.collect::<Result<_>>()?;
        Ok(self)
    }

    fn empty() -> Self {
        Self {
            lids: 0,
            turned: false,
            smoothed: false,
            left_out: 0.0,
            surfaces: Vec::new(),
            labelled: false,
            image: None,
            landmarks: Vec::new(),
        }
    }

    /// Whether bone `b` has a surface to be sought on.
    pub(in crate::register) fn has_surface_of(&self, b: usize) -> bool {
        !self.labelled || self.surfaces[b].is_some()
    }

    /// Whether the target tells the bones apart.
    pub fn is_labelled(&self) -> bool {
        self.labelled
    }

    /// Its surfaces: one, or those of the bones that have one; none of an image.
    pub fn surfaces(&self) -> impl Iterator<Item = &TriMesh> {
        self.surfaces.iter().flatten().map(|surface| &surface.mesh)
    }

    /// How far each vertex of a skeleton lies from it, for a labelled target from its bone's surface;
    /// NaN where there is none.
    pub fn distances(&self, skeleton: &Skeleton) -> Vec<f64> {
        let mut distances = vec![f64::NAN; skeleton.points.len()];
        for part in self.parts(skeleton.bones.len()) {
            for bone in part.bones {
                let vertices = skeleton.bones[bone].vertices.clone();
                let hits = part.surface.search.closest_many(&skeleton.points[vertices.clone()]);
                for (distance, hit) in distances[vertices].iter_mut().zip(hits) {
                    *distance = hit.map_or(f64::NAN, |hit| hit.distance);
                }
            }
        }
        distances
    }

    /// Its surfaces with the bones that are sought on each.
    pub(super) fn parts(&self, bone_count: usize) -> Vec<Part<'_>> {
        let bones_of = |b: usize| if self.labelled { vec![b] } else { (0..bone_count).collect() };
        let surfaces = self.surfaces.iter().enumerate();
        let known = surfaces.filter_map(|(b, surface)| Some((b, surface.as_ref()?)));
        known.map(|(b, surface)| Part { bones: bones_of(b), surface }).collect()
    }

    /// What was done to it, in sentences.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.lids > 0 {
            let ends = if self.lids == 1 { "a flat face" } else { "flat faces" };
            notes.push(format!(
                "the target ends in {ends}, as where a plane cuts it off; beyond it shows nothing"
            ));
        }
        if self.turned {
            notes.push("the target's triangles face inwards; they were turned".to_owned());
        }
        if self.smoothed {
            notes.push(
                "the target is so noisy that its triangles face in all directions; it was smoothed"
                    .to_owned(),
            );
        }
        if self.left_out > 0.0 {
            notes.push(format!(
                "{:.1} % of the target lie far from all bones; they were left out",
                100.0 * self.left_out
            ));
        }
        notes
    }

    /// All its surfaces as one.
    pub(super) fn joined(&self) -> SearchedSurface {
        let mut all = TriMesh::default();
        for surface in self.surfaces.iter().flatten() {
            all.append(&surface.mesh);
        }
        SearchedSurface::new(all)
    }

    /// Its mirror image.
    pub(super) fn mirrored(&self) -> Self {
        let mirrored = |surface: &SearchedSurface| {
            let points = surface.mesh.points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
            let triangles = surface.mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
            SearchedSurface::new(TriMesh { points, triangles })
        };
        let surfaces = self.surfaces.iter().map(|s| s.as_ref().map(mirrored)).collect();
        let landmarks = self.landmarks.iter().map(PlacedLandmark::mirrored).collect();
        Self { surfaces, landmarks, ..self.clone() }
    }
}
