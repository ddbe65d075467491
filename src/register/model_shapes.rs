//! Shapes of a model on a skeleton, and how well a model fits a new person.

use nalgebra::Isometry3;

use super::areas::vertex_areas;
use super::bone_scales::put_in_place;
use super::joint_frames::{Fit, take_shape};
use super::riders::ride;
use super::shape_model::ShapeModel;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::run::Run;

/// Whether two skeletons have bones of the same names and numbers of vertices, in one order.
pub fn same_bones(one: &Skeleton, other: &Skeleton) -> bool {
    one.bones.len() == other.bones.len()
        && one
            .bones
            .iter()
            .zip(&other.bones)
            .all(|(a, b)| a.name == b.name && a.vertices == b.vertices)
}

/// The shape with each bone on the template's and the joints closed again.
pub fn shape_in_place(template: &Skeleton, shape: &[Vec3]) -> Skeleton {
    let areas = vertex_areas(&template.points, &template.triangles);
    let mut skeleton = template.clone();
    take_shape(&mut skeleton, template, shape, &areas, Fit::Affine);
    // Along the joints outwards, each bone is shifted until its joint point lies on its neighbour's.
    let mut shifts = vec![Isometry3::identity(); skeleton.bones.len()];
    ride(&skeleton, &skeleton.spanning_forest(0), &mut shifts);
    skeleton.move_bones(&shifts);
    skeleton
}

/// The root mean square distance of each of three or more samples from what a model of the others makes
/// of it, in the template's unit; empty for two.
pub fn left_out(template: &Skeleton, samples: &[Vec<Vec3>], run: &Run) -> Result<Vec<f64>> {
    if samples.len() < 3 {
        return Ok(Vec::new());
    }
    let areas = vertex_areas(&template.points, &template.triangles);
    let mut distances = Vec::new();
    for k in 0..samples.len() {
        if run.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let mut others = samples.to_vec();
        let own = others.remove(k);
        let model = ShapeModel::fit(template, &others)?;
        let shape = model.synthesize(&model.project(template, &own, &areas));
        let placed = put_in_place(template, &shape, &own, &areas);
        let squares: f64 =
            placed.iter().zip(&own).zip(&areas).map(|((p, q), a)| a * (p - q).norm_squared()).sum();
        distances.push((squares / areas.iter().sum::<f64>()).sqrt());
    }
    Ok(distances)
}
