//! Targets that cannot be meant: in another unit, or of the other side of the body.

use super::attempts::Attempt;
use super::registration::Registration;
use super::summary::Registered;
use super::target::Target;
use crate::error::{Error, Result};
use crate::math::{Vec3, median};
use crate::run::Run;

/// A target larger or smaller than the template by more than this factor is in another unit.
const UNIT_FACTOR: f64 = 6.0;
/// The mirror image must have so many times fewer bones in doubt.
const CLEARLY: usize = 4;
/// Units that are mistaken for each other, by the factor between them.
const UNITS: [(f64, &str, &str); 5] = [
    (10.0, "millimetres", "centimetres"),
    (25.4, "millimetres", "inches"),
    (39.37, "inches", "metres"),
    (100.0, "centimetres", "metres"),
    (1000.0, "millimetres", "metres"),
];

impl Registration {
    /// Refuses a target whose size says that it is in another unit.
    pub(super) fn refuse_other_unit(&self, target: &Target) -> Result<()> {
        let Some(ratio) = self.size_ratio(target) else { return Ok(()) };
        if (1.0 / UNIT_FACTOR..=UNIT_FACTOR).contains(&ratio) {
            return Ok(());
        }
        let factor = ratio.max(1.0 / ratio);
        let off = |unit: &&(f64, &str, &str)| libm::log(unit.0 / factor).abs();
        let guess = UNITS.iter().min_by(|p, q| off(p).total_cmp(&off(q)));
        let guess = guess.filter(|unit| off(unit) < 0.4).map_or_else(String::new, |unit| {
            let (target, template) = if ratio < 1.0 { (unit.2, unit.1) } else { (unit.1, unit.2) };
            format!(": as if it were in {target} and the template in {template}")
        });
        Err(Error::invalid(format!(
            "the target is {ratio:.3e} times as large as the template{guess}; scale it, or say that it is meant as it is"
        )))
    }

    /// Size of the target against the template's; none for an image.
    fn size_ratio(&self, target: &Target) -> Option<f64> {
        let template = &self.template;
        let of_bones = |b: usize| {
            let surface = target.surfaces.get(b)?.as_ref()?;
            let own = &template.points[template.bones[b].vertices.clone()];
            Some(middle_reach(&surface.mesh.points) / middle_reach(own))
        };
        let ratios: Vec<f64> = if target.labelled {
            (0..template.bones.len()).filter_map(of_bones).collect()
        } else {
            let surface = target.surfaces.first()?.as_ref()?;
            vec![middle_reach(&surface.mesh.points) / middle_reach(&template.points)]
        };
        median(ratios)
    }

    /// Refuses the target where its mirror image is the better one. A target that fits is not mirrored,
    /// so the trial is only made where at least half of the bones are in doubt.
    pub(super) fn refuse_mirrored(
        &self,
        found: &Registered,
        target: &Target,
        run: &Run,
    ) -> Result<()> {
        let (named, count) = (found.named_bones(), found.bones.len());
        if 2 * named < count {
            return Ok(());
        }
        let mirrored = target.mirrored();
        let other = self.find(&mirrored, &self.starts(&mirrored), Attempt::MIRRORED, run);
        let Some(other) = other.filter(|other| !other.cancelled) else { return Ok(()) };
        if CLEARLY * other.named_bones() > named {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "the target looks like a mirror image of the template: as it is {named} of {count} bones are in doubt, mirrored {}; mirror one of them (left and right?), or say that it is meant as it is",
            other.named_bones()
        )))
    }
}

/// Middle distance from the middle point: a size that a few strange points do not change.
fn middle_reach(points: &[Vec3]) -> f64 {
    let centre = Vec3::from_fn(|k, _| median(points.iter().map(|p| p[k])).unwrap_or(0.0));
    median(points.iter().map(|p| (p - centre).norm())).unwrap_or(0.0)
}
