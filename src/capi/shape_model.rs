//! Shape statistics of a skeleton's bones.

use libc::c_char;
use std::sync::Arc;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::mesh::Surface;
use super::skeleton::{MlgSkeleton, SkeletonObject};
use super::{access, buffers, handles};
use crate::job::skeleton_build::document_of;
use crate::job::{read_shape_model, write_shape_model};
use crate::math::Vec3;
use crate::register::{ShapeModel, left_out, same_bones, shape_in_place};
use crate::run::Run;

/// Mean shape and modes of all bones of a template. Immutable; may be read from many threads.
pub struct MlgShapeModel;

/// A model with the skeleton whose vertices it speaks of.
pub(super) struct ModelObject {
    template: Arc<SkeletonObject>,
    pub model: ShapeModel,
    deviations: Vec<f64>,
    explained: Vec<f64>,
}

impl ModelObject {
    fn new(template: Arc<SkeletonObject>, model: ShapeModel) -> Self {
        let deviations = model.deviations(&template.skeleton);
        Self { template, deviations, explained: model.explained(), model }
    }

    /// Whether the model speaks of the vertices of `skeleton`.
    pub fn check_template(&self, skeleton: &SkeletonObject) -> Outcome<()> {
        if same_bones(&self.template.skeleton, &skeleton.skeleton) {
            return Ok(());
        }
        Err(Failure::invalid(
            "the shape model is one of another template: its bones have other names or vertices",
        ))
    }
}

/// Learns the shapes of all bones together, pose removed. Takes seconds for large skeletons.
///
/// `samples`: `sample_count` skeletons, two or more, such as results of registrations of the
/// template: with its bones and vertices, in any pose. Free with `mlg_shape_model_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_fit(
    template_skeleton: *const MlgSkeleton,
    samples: *const *const MlgSkeleton,
    sample_count: usize,
    out_model: *mut *mut MlgShapeModel,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_model, "out_model"), error, || {
        let template = handles::get::<SkeletonObject, _>(template_skeleton, "template_skeleton")?;
        // SAFETY: the caller's promise (see the module).
        let samples = unsafe { samples_of(&template, samples, sample_count)? };
        let model = ShapeModel::fit(&template.skeleton, &samples)?;
        Ok(ModelObject::new(template, model))
    })
}

/// Tells how well models fit new persons: for each sample, the root mean square distance from what a
/// model of the others makes of it, in the template's unit. `samples`: as for `mlg_shape_model_fit`,
/// three or more. `out_distances`: room for `sample_count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_left_out(
    template_skeleton: *const MlgSkeleton,
    samples: *const *const MlgSkeleton,
    sample_count: usize,
    out_distances: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_distances, "out_distances")?;
        let template = handles::get::<SkeletonObject, _>(template_skeleton, "template_skeleton")?;
        // SAFETY: the caller's promise (see the module).
        let samples = unsafe { samples_of(&template, samples, sample_count)? };
        if samples.len() < 3 {
            return Err(Failure::invalid(
                "samples: three or more are needed, so that two are left when one is left out",
            ));
        }
        let distances = left_out(&template.skeleton, &samples, &Run::new())?;
        // SAFETY: as above.
        unsafe { buffers::copy_out(&distances, out_distances) };
        Ok(())
    })
}

unsafe fn samples_of(
    template: &SkeletonObject,
    samples: *const *const MlgSkeleton,
    count: usize,
) -> Outcome<Vec<Vec<Vec3>>> {
    // SAFETY: passed on from the caller.
    let handles = unsafe { buffers::list(samples, count, "samples")? };
    let mut points = Vec::new();
    for (k, handle) in handles.into_iter().enumerate() {
        let sample = handles::get::<SkeletonObject, _>(handle, &format!("samples[{k}]"))?;
        if !same_bones(&template.skeleton, &sample.skeleton) {
            return Err(Failure::invalid(format!(
                "samples[{k}] is not of this template: its bones have other names or vertices"
            )));
        }
        points.push(sample.skeleton.points.clone());
    }
    Ok(points)
}

/// Reads a model of a template's bones from a `.h5.json` file, as `mlg_shape_model_save` and scalismo
/// write it. `path`: UTF-8. Free with `mlg_shape_model_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_load(
    template_skeleton: *const MlgSkeleton,
    path: *const c_char,
    out_model: *mut *mut MlgShapeModel,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_model, "out_model"), error, || {
        let template = handles::get::<SkeletonObject, _>(template_skeleton, "template_skeleton")?;
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::path(path, "path")? };
        let model = read_shape_model(&template.skeleton, &path)?;
        Ok(ModelObject::new(template, model))
    })
}

/// Writes a model as `.h5.json`; numbers have single precision there. `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_save(
    model: *const MlgShapeModel,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((model, "model"), error, |model: &ModelObject| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::new_path(path, "path")? };
        Ok(write_shape_model(&path, &model.template.skeleton, &model.model)?)
    })
}

/// How far the surface moves at one standard deviation of each mode, root mean square, in the
/// template's unit: `*out_count` numbers, falling, borrowed until the model is freed. NULL without
/// modes or for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_deviations(
    model: *const MlgShapeModel,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(model, out_count, |model: &ModelObject| &model.deviations)
}

/// The share of the variance in the first modes: `*out_count` numbers, rising to 1, as
/// `mlg_shape_model_deviations`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_explained(
    model: *const MlgShapeModel,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(model, out_count, |model: &ModelObject| &model.explained)
}

/// Makes a shape: a skeleton in the template's pose, its joints closed.
///
/// `coefficients`: `count` numbers in standard deviations, of the first modes; the others are 0. May
/// be NULL if `count` is 0: the mean. Free with `mlg_skeleton_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_shape(
    model: *const MlgShapeModel,
    coefficients: *const f64,
    count: usize,
    out_skeleton: *mut *mut MlgSkeleton,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_skeleton, "out_skeleton"), error, || {
        let object = handles::get::<ModelObject, _>(model, "model")?;
        // SAFETY: the caller's promise (see the module).
        let coefficients = unsafe { buffers::numbers(coefficients, count, "coefficients")? };
        if let Some(k) = coefficients.iter().position(|c| !c.is_finite()) {
            return Err(Failure::invalid(format!(
                "coefficients: number {k} is {}; it must be finite",
                coefficients[k]
            )));
        }
        if count > object.model.mode_count() {
            return Err(Failure::invalid(format!(
                "coefficients: {count} given, but the model has {} modes",
                object.model.mode_count()
            )));
        }
        let template = &object.template;
        let skeleton = shape_in_place(&template.skeleton, &object.model.synthesize(&coefficients));
        let document = document_of(&skeleton, &template.document);
        let surfaces: Vec<Arc<Surface>> = template.surfaces.clone();
        Ok(SkeletonObject::new(document, skeleton, surfaces, &[]))
    })
}

/// Frees a model. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_shape_model_free(model: *mut MlgShapeModel) {
    access::free::<ModelObject, _>(model);
}
