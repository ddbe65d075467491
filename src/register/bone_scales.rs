//! Plausible bone shapes without statistics: every bone of the template scaled along its own
//! principal axes.
//!
//! [G] section 3.3 uses "a fictitious scaling component" where samples are too few for an analysis.
//! Here the scales are a small hierarchy: one for the skeleton, one per bone pulled towards it, and
//! one per principal axis pulled towards that of the bone.
//! What the data say of a bone's scales: [`ScaledBone`].

use nalgebra::Isometry3;
use rayon::prelude::*;

use super::pose::moved;
use super::scaled_bone::{ScaleData, ScaledBone};
use super::skeleton::Skeleton;
use crate::math::{Mat3, Vec3};
use crate::mesh::normals::{area_vectors, vertex_normals};

/// Weight by which an axis that nothing is known of still keeps to its bone's scale.
const LEAST_PULL: f64 = 1e-9;

/// How freely bones scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ScaleFreedom {
    /// Bones keep the template's shape.
    Fixed,
    /// One scale for the whole skeleton.
    Whole,
    /// A scale for each bone.
    PerBone,
    /// Three scales for each bone, along its principal axes.
    PerAxis,
}

/// How strongly scales are held together, and how far they may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleOptions {
    /// Pull of a bone's scale towards the skeleton's, as a share of what the whole bone's surface says.
    pub bone_pull: f64,
    /// Pull of an axis's scale towards its bone's, as a share of the same.
    pub axis_pull: f64,
    /// Largest factor of a bone's scale against the skeleton's, either way.
    pub max_ratio: f64,
}

impl Default for ScaleOptions {
    fn default() -> Self {
        Self { bone_pull: 0.05, axis_pull: 0.02, max_ratio: 1.4 }
    }
}

/// The template's bones in their principal axes, ready for scaling.
#[derive(Clone, Debug)]
pub struct BoneScales {
    bones: Vec<ScaledBone>,
    options: ScaleOptions,
}

impl BoneScales {
    /// Prepares the bones of the template.
    pub fn new(template: &Skeleton, areas: &[f64], options: ScaleOptions) -> Self {
        let faces = area_vectors(&template.points, &template.triangles);
        let normals = vertex_normals(template.points.len(), &template.triangles, &faces);
        let bones = template.bones.iter().map(|bone| {
            let range = bone.vertices.clone();
            ScaledBone::new(&template.points[range.clone()], &normals[range.clone()], &areas[range])
        });
        let bones = bones.collect();
        Self { bones, options }
    }

    /// The scales of every bone that bring the template nearest to `wanted` under vertex `masses`,
    /// starting from the scales `start`; `pull` multiplies the pulls of the options.
    pub fn fit(
        &self,
        template: &Skeleton,
        wanted: &[Vec3],
        masses: &[f64],
        start: &[Vec3],
        (freedom, pull): (ScaleFreedom, f64),
    ) -> Vec<Vec3> {
        if freedom == ScaleFreedom::Fixed {
            return start.to_vec();
        }
        // Mass for each unit of area: the pulls weigh as a bone that is seen as a whole.
        let density = masses.iter().sum::<f64>() / self.bones.iter().map(|b| b.area).sum::<f64>();
        let data: Vec<ScaleData> = self
            .bones
            .par_iter()
            .zip(&template.bones)
            .zip(start)
            .map(|((own, bone), scale)| {
                let range = bone.vertices.clone();
                own.data(scale, &wanted[range.clone()], &masses[range])
            })
            .collect();
        self.update(&data, freedom, pull * density)
    }

    fn update(&self, data: &[ScaleData], freedom: ScaleFreedom, strength: f64) -> Vec<Vec3> {
        let weight: f64 = data.iter().map(|d| d.weight.sum()).sum();
        let pull: f64 = data.iter().map(|d| d.pull.sum()).sum();
        let whole = if weight > 0.0 { (pull / weight).max(1e-3) } else { 1.0 };
        let held = |scale: f64| {
            scale.clamp(whole / self.options.max_ratio, whole * self.options.max_ratio)
        };
        let of_bone = |(data, own): (&ScaleData, &ScaledBone)| {
            let weight = data.weight.sum();
            if freedom == ScaleFreedom::Whole || weight <= 0.0 {
                return Vec3::repeat(whole);
            }
            let to_whole = strength * self.options.bone_pull * own.weight.sum();
            let bone = held((data.pull.sum() + to_whole * whole) / (weight + to_whole));
            if freedom == ScaleFreedom::PerBone {
                return Vec3::repeat(bone);
            }
            let to_bone = strength * self.options.axis_pull * own.weight.diagonal()
                + Vec3::repeat(LEAST_PULL * weight);
            let matrix = data.weight + Mat3::from_diagonal(&to_bone);
            let solved = matrix.cholesky().map(|c| c.solve(&(data.pull + bone * to_bone)));
            solved.unwrap_or(Vec3::repeat(bone)).map(held)
        };
        data.iter().zip(&self.bones).map(of_bone).collect()
    }

    /// The template's points after scaling, each bone about its own centre.
    pub fn shape(&self, scales: &[Vec3]) -> Vec<Vec3> {
        let shapes = self.bones.par_iter().zip(scales).map(|(bone, scale)| bone.shape(scale));
        shapes.collect::<Vec<_>>().concat()
    }
}

/// Puts every bone of `shape` rigidly on the same bone at `place`, so that only the shape changes.
pub fn put_in_place(
    skeleton: &Skeleton,
    shape: &[Vec3],
    place: &[Vec3],
    areas: &[f64],
) -> Vec<Vec3> {
    let motions = super::pose::rigid_targets(skeleton, shape, place, areas);
    let placed = skeleton.bones.par_iter().zip(motions).map(|(bone, motion)| {
        let motion = motion.unwrap_or_else(Isometry3::identity);
        shape[bone.vertices.clone()].iter().map(|p| moved(&motion, p)).collect::<Vec<_>>()
    });
    placed.collect::<Vec<_>>().concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    #[test]
    fn scales_along_the_axes_are_found_again_in_any_pose() {
        let a = block(Vec3::new(50.0, 0.0, 0.0), Vec3::new(10.0, 2.0, 1.0), 6);
        let b = block(Vec3::new(75.0, 0.0, 0.0), Vec3::new(1.0, 5.0, 3.0), 6);
        let template = Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![]).unwrap();
        let areas = vertex_areas(&template.points, &template.triangles);
        let options = ScaleOptions { bone_pull: 0.0, axis_pull: 0.0, max_ratio: 2.0 };
        let model = BoneScales::new(&template, &areas, options);
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let wanted: Vec<Vec3> = template
            .points
            .iter()
            .map(|p| moved(&motion, &Vec3::new(p.x * 1.2, p.y * 0.9, p.z)))
            .collect();
        let fit = |masses: &[f64]| {
            let mut scales = vec![Vec3::repeat(1.0); 2];
            for _ in 0..10 {
                let how = (ScaleFreedom::PerAxis, 1.0);
                scales = model.fit(&template, &wanted, masses, &scales, how);
            }
            scales
        };
        let scales = fit(&areas);
        let shape = put_in_place(&template, &model.shape(&scales), &wanted, &areas);
        let worst = shape.iter().zip(&wanted).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
        // Without mass a bone takes the scale of the skeleton.
        let mut masses = areas.clone();
        masses[template.bones[1].vertices.clone()].fill(0.0);
        let scales = fit(&masses);
        let of_all = (ScaleFreedom::Whole, 1.0);
        let whole = model.fit(&template, &wanted, &masses, &scales, of_all)[1];
        assert!((scales[1] - whole).norm() < 1e-6 && whole.x > 1.0 && whole.x < 1.2, "{whole}");
    }
}
