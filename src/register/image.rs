//! An image as the target: each vertex looks along its normal for what the template shows there in
//! a reference image. [G] 3.2.2 compares histogram moments; profiles find the place better.

use std::sync::Arc;

use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::normals::{area_vectors, vertex_normals};
use crate::volume::{Match, Moments, Profiles, Volume};

/// Profiles reach so many smallest voxel sizes to each side of the surface,
const PROFILE_VOXELS: f64 = 10.0;
/// but no further than this, mm: further out lie other bones, which move by themselves.
const LONGEST_PROFILE: f64 = 8.0;
/// Samples of a profile, in smallest voxel sizes.
const PROFILE_STEP: f64 = 0.8;

/// What the template shows around its surface in the reference image.
#[derive(Clone, Debug, PartialEq)]
pub enum Appearance {
    /// Intensities along the normals, compared by their correlation.
    Profiles(Profiles),
    /// Histogram moments in balls, as published.
    Moments(Moments),
}

impl Appearance {
    /// Profiles of the template as it lies in `reference`. `reach`: mm to each side of the surface
    /// \[10 of the image's smallest voxel sizes, 8 mm at most\].
    pub fn profiles(template: &Skeleton, reference: &Volume, reach: Option<f64>) -> Result<Self> {
        let voxel = reference.spacing().min();
        let normals = normals_of(&template.points, &template.triangles);
        let reach = reach.unwrap_or((PROFILE_VOXELS * voxel).min(LONGEST_PROFILE));
        let step = (PROFILE_STEP * voxel).min(reach);
        let profiles = Profiles::new(reference, &template.points, &normals, reach, step)?;
        if profiles.values().iter().all(|v| v.is_nan()) {
            return Err(Error::invalid(
                "the template lies outside its reference image; it must lie on the bones there",
            ));
        }
        Ok(Self::Profiles(profiles))
    }

    /// Moments of the template as it lies in `reference`, in balls of radius `radius`, twice and
    /// four times that (mm).
    pub fn moments(template: &Skeleton, reference: &Volume, radius: f64) -> Result<Self> {
        Moments::new(reference, &template.points, radius).map(Self::Moments)
    }

    fn len(&self) -> usize {
        match self {
            Self::Profiles(profiles) => profiles.len(),
            Self::Moments(moments) => moments.len(),
        }
    }

    /// Similarities below this are no correspondence: [G] 3.2.2 has 0.2 for moments.
    fn threshold(&self) -> f64 {
        match self {
            Self::Profiles(_) => 0.3,
            Self::Moments(_) => 0.2,
        }
    }
}

fn normals_of(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    vertex_normals(points.len(), triangles, &area_vectors(points, triangles))
}

/// A person's image with what to look for in it.
#[derive(Clone, Debug)]
pub(super) struct ImageTarget {
    volume: Arc<Volume>,
    appearance: Arc<Appearance>,
    /// The moments of the person's image, made once.
    features: Option<Arc<crate::volume::moments::FeatureGrids>>,
}

impl ImageTarget {
    pub fn new(template: &Skeleton, volume: Volume, appearance: Appearance) -> Result<Self> {
        if appearance.len() != template.points.len() {
            return Err(Error::invalid(format!(
                "the reference features are of {} vertices, the skeleton has {}",
                appearance.len(),
                template.points.len()
            )));
        }
        let features = match &appearance {
            Appearance::Moments(moments) => Some(Arc::new(moments.grids(&volume)?)),
            Appearance::Profiles(_) => None,
        };
        Ok(Self { volume: Arc::new(volume), appearance: Arc::new(appearance), features })
    }

    /// For each vertex how far along its normal the image shows what the template shows, at most
    /// `range` mm; none where nothing is like it.
    pub fn find(&self, points: &[Vec3], normals: &[Vec3], range: f64) -> Vec<Option<Match>> {
        let mut found = match (&*self.appearance, &self.features) {
            (Appearance::Profiles(profiles), _) => {
                profiles.find(&self.volume, points, normals, range)
            }
            (Appearance::Moments(moments), Some(grids)) => {
                moments.find(grids, points, normals, range)
            }
            (Appearance::Moments(_), None) => vec![None; points.len()],
        };
        let threshold = self.appearance.threshold();
        for one in &mut found {
            *one = one.filter(|m| m.score >= threshold);
        }
        found
    }

    /// How like the template's surroundings in its own image the person's image is around each point; none
    /// where nothing can be said.
    pub fn likeness(&self, points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Option<f64>> {
        match (&*self.appearance, &self.features) {
            (Appearance::Profiles(profiles), _) => {
                profiles.likeness(&self.volume, points, &normals_of(points, triangles))
            }
            (Appearance::Moments(moments), Some(grids)) => moments.likeness(grids, points),
            (Appearance::Moments(_), None) => vec![None; points.len()],
        }
    }
}
