//! Plausible bone shapes without statistics: every bone of the template scaled along its own
//! principal axes.
//!
//! [G] section 3.3 uses "a fictitious scaling component" where samples are too few for an analysis.
//! Here the scales are a small hierarchy: one for the skeleton, one per bone pulled towards it, and
//! one per principal axis pulled towards that of the bone.

use nalgebra::{Isometry3, SymmetricEigen};
use rayon::prelude::*;

use super::pose::{BoneMoments, moved};
use super::rotation::PairSums;
use super::skeleton::Skeleton;
use crate::math::{Mat3, Vec3};

/// Rounds of fitting pose and scale in turn; the main loop goes on from the scales found.
const ROUNDS: usize = 1;

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
    /// Pull of a bone's scale towards the skeleton's, as a share of the data's own weight.
    pub bone_pull: f64,
    /// Pull of an axis's scale towards its bone's, as a share of the data's own weight.
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
    bones: Vec<Principal>,
    options: ScaleOptions,
}

#[derive(Clone, Debug)]
struct Principal {
    centre: Vec3,
    /// World from principal axes.
    axes: Mat3,
    /// Second moments of the whole bone along them.
    moments: Vec3,
    area: f64,
}

/// Sums of one bone over the fit of its scales.
struct BoneFit {
    /// Template and wanted points in principal axes, products per axis.
    xy: Vec3,
    xx: Vec3,
}

impl BoneScales {
    /// Prepares the bones of the template.
    pub fn new(template: &Skeleton, areas: &[f64], options: ScaleOptions) -> Self {
        let bones = template
            .bones
            .iter()
            .map(|bone| {
                let range = bone.vertices.clone();
                let moments = BoneMoments::new(&template.points[range.clone()], &areas[range]);
                let eigen = SymmetricEigen::new(moments.spread);
                Principal {
                    centre: moments.centre,
                    axes: eigen.eigenvectors,
                    moments: eigen.eigenvalues,
                    area: moments.mass,
                }
            })
            .collect();
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
        let mut scales = start.to_vec();
        if freedom == ScaleFreedom::Fixed {
            return scales;
        }
        // Mass for each unit of area: the pulls weigh as a bone that is seen as a whole.
        let density = masses.iter().sum::<f64>() / self.bones.iter().map(|b| b.area).sum::<f64>();
        for _ in 0..ROUNDS {
            let fits: Vec<BoneFit> = (0..self.bones.len())
                .into_par_iter()
                .map(|b| self.bone_fit(template, b, &scales[b], wanted, masses))
                .collect();
            scales = self.update(&fits, freedom, pull * density);
        }
        scales
    }

    fn bone_fit(
        &self,
        template: &Skeleton,
        b: usize,
        scale: &Vec3,
        wanted: &[Vec3],
        masses: &[f64],
    ) -> BoneFit {
        let range = template.bones[b].vertices.clone();
        let scaled: Vec<Vec3> =
            template.points[range.clone()].iter().map(|p| self.scaled(b, p, scale)).collect();
        let mut sums = PairSums::new(self.bones[b].centre);
        let (mut x_mean, mut y_mean, mut mass) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for (i, from) in range.clone().zip(&scaled) {
            sums.add(from, &wanted[i], masses[i]);
            x_mean += masses[i] * template.points[i];
            y_mean += masses[i] * wanted[i];
            mass += masses[i];
        }
        let Some(motion) = sums.best_rigid() else {
            return BoneFit { xy: Vec3::zeros(), xx: Vec3::zeros() };
        };
        let (x_mean, y_mean) = (x_mean / mass, y_mean / mass);
        let (into, back) = (self.bones[b].axes.transpose(), motion.rotation.inverse());
        let mut fit = BoneFit { xy: Vec3::zeros(), xx: Vec3::zeros() };
        for i in range {
            let x = into * (template.points[i] - x_mean);
            let y = into * (back * (wanted[i] - y_mean));
            fit.xy += masses[i] * x.component_mul(&y);
            fit.xx += masses[i] * x.component_mul(&x);
        }
        fit
    }

    fn update(&self, fits: &[BoneFit], freedom: ScaleFreedom, strength: f64) -> Vec<Vec3> {
        let total_xx: f64 = fits.iter().map(|f| f.xx.sum()).sum();
        let total_xy: f64 = fits.iter().map(|f| f.xy.sum()).sum();
        let whole = if total_xx > 0.0 { (total_xy / total_xx).max(1e-3) } else { 1.0 };
        let held = |scale: f64| {
            scale.clamp(whole / self.options.max_ratio, whole * self.options.max_ratio)
        };
        fits.iter()
            .zip(&self.bones)
            .map(|(fit, of_bone)| {
                let xx = fit.xx.sum();
                if freedom == ScaleFreedom::Whole || xx <= 0.0 {
                    return Vec3::repeat(whole);
                }
                let pull = strength * self.options.bone_pull * of_bone.moments.sum();
                let bone = held((fit.xy.sum() + pull * whole) / (xx + pull));
                if freedom == ScaleFreedom::PerBone {
                    return Vec3::repeat(bone);
                }
                Vec3::from_fn(|k, _| {
                    let pull = strength * self.options.axis_pull * of_bone.moments[k] + 1e-9 * xx;
                    held((fit.xy[k] + pull * bone) / (fit.xx[k] + pull))
                })
            })
            .collect()
    }

    /// A template point of bone `b` after scaling about the bone's centre.
    fn scaled(&self, b: usize, point: &Vec3, scale: &Vec3) -> Vec3 {
        let bone = &self.bones[b];
        let local = bone.axes.transpose() * (point - bone.centre);
        bone.centre + bone.axes * local.component_mul(scale)
    }

    /// The template's points after scaling, each bone about its own centre.
    pub fn shape(&self, template: &Skeleton, scales: &[Vec3]) -> Vec<Vec3> {
        let shapes = template.bones.par_iter().enumerate().map(|(b, bone)| {
            let points = &template.points[bone.vertices.clone()];
            points.iter().map(|p| self.scaled(b, p, &scales[b])).collect::<Vec<_>>()
        });
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
        let shape = put_in_place(&template, &model.shape(&template, &scales), &wanted, &areas);
        let worst = shape.iter().zip(&wanted).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
        // Without mass a bone takes the scale of the skeleton.
        let mut masses = areas.clone();
        masses[template.bones[1].vertices.clone()].fill(0.0);
        let scales = fit(&masses);
        assert!((scales[1].x - scales[1].z).abs() < 1e-12 && (scales[1].x - 1.19).abs() < 0.05);
    }
}
