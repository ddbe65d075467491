//! A template prepared for registrations, and what they change of it.

use super::areas::vertex_areas;
use super::bone_scales::BoneScales;
use super::level::Level;
use super::options::Options;
use super::pose::{heaviest, moments};
use super::shape_model::ShapeModel;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A template prepared for registration to many targets.
#[derive(Clone, Debug)]
pub struct Registration {
    pub(super) template: Skeleton,
    pub(super) areas: Vec<f64>,
    pub(super) bone_of: Vec<u32>,
    pub(super) diagonal: f64,
    pub(super) options: Options,
    pub(super) levels: Vec<Level>,
    pub(super) scales: BoneScales,
    /// Statistics instead of bone scales.
    pub(super) model: Option<ShapeModel>,
    /// The heaviest bone.
    pub(super) root: usize,
}

/// What the loop changes.
#[derive(Clone)]
pub(super) struct State {
    /// Reference points and joint frames.
    pub(super) reference: Skeleton,
    /// The deformed points.
    pub(super) points: Vec<Vec3>,
    /// The joints' rotation vectors where the level began.
    pub(super) rest: Vec<Vec3>,
    pub(super) scales: Vec<Vec3>,
    /// Coefficients of the shape model, in standard deviations.
    pub(super) coefficients: Vec<f64>,
}

impl State {
    /// Everything where `reference` lies, of its size.
    pub(super) fn at(reference: Skeleton) -> Self {
        let scales = vec![Vec3::repeat(1.0); reference.bones.len()];
        let (points, rest) = (reference.points.clone(), Vec::new());
        Self { reference, points, rest, scales, coefficients: Vec::new() }
    }
}

impl Registration {
    /// Prepares clusters and shape model of the template.
    pub fn new(template: Skeleton, options: Options) -> Result<Self> {
        let areas = vertex_areas(&template.points, &template.triangles);
        let (low, high) = crate::mesh::bounding_box(&template.points)
            .ok_or_else(|| Error::invalid("the skeleton has no vertices"))?;
        let diagonal = (high - low).norm();
        if diagonal <= 0.0 || areas.iter().sum::<f64>() <= 0.0 {
            return Err(Error::invalid("the skeleton's surface has no area"));
        }
        let bone_of = template.bone_of_vertex();
        let scales = BoneScales::new(&template, &areas, options.scales);
        let mut registration = Self {
            template,
            areas,
            bone_of,
            diagonal,
            options,
            levels: Vec::new(),
            scales,
            model: None,
            root: 0,
        };
        registration.root = heaviest(&moments(&registration.template, &registration.areas));
        registration.levels = registration.make_levels()?;
        Ok(registration)
    }

    /// Uses statistics instead of bone scales. The model must come from the same template.
    pub fn with_shape_model(mut self, model: ShapeModel) -> Result<Self> {
        if model.mean().len() != self.template.points.len() {
            return Err(Error::invalid(format!(
                "the shape model has {} vertices, the skeleton {}",
                model.mean().len(),
                self.template.points.len()
            )));
        }
        self.model = Some(model);
        Ok(self)
    }
}
