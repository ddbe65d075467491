//! A result in the sentences that a user should read.

use super::few::few;
use super::skeleton::Skeleton;
use super::summary::{BoneSummary, Registered};
use super::verdict::Verdict;

/// Bones and joints that are named in the warnings; all stand in the tables.
const WORST: usize = 5;
/// Joints that turn further beyond their limits are named, degrees.
const BEYOND_DEGREES: f64 = 0.5;

impl Registered {
    /// What to look at in a result, in sentences: the worst bones and joints; all others have their
    /// reasons in [`Self::bones`].
    pub fn warnings(&self, template: &Skeleton) -> Vec<String> {
        let mut warnings = self.notes.clone();
        warnings.extend(self.judgement.reasons.iter().cloned());
        let mut named: Vec<&BoneSummary> =
            self.bones.iter().filter(|b| b.verdict > Verdict::Good).collect();
        named.sort_by_key(|bone| std::cmp::Reverse(bone.verdict));
        for bone in named.iter().take(WORST) {
            let (verdict, worst) = (bone.verdict.name(), bone.reasons.first());
            let worst = worst.map_or("", String::as_str);
            warnings.push(format!("bone {} is {verdict}: {worst}", bone.name));
        }
        let beyond = self.joints.iter().filter(|joint| joint.excess_degrees > BEYOND_DEGREES);
        let beyond = beyond.map(|joint| (joint.excess_degrees, joint.name.as_str()));
        if let Some(worst) = worst_joints(beyond, 1) {
            warnings.push(format!(
                "joints turn beyond the template's limits, by degrees: {worst}; see whether this person can do that"
            ));
        }
        let apart = self.joints.iter().zip(&template.joints);
        let apart = apart.filter(|(joint, template)| joint.seam > 2.0 * template.limits.shift);
        let apart = apart.map(|(joint, _)| (joint.seam, joint.name.as_str()));
        if let Some(worst) = worst_joints(apart, 2) {
            warnings.push(format!(
                "the bones found on both sides leave more than twice the allowed gap at the joints, by length: {worst}; look whether those bones are right"
            ));
        }
        warnings
    }
}

/// The joints with the largest figures, which are written with so many digits; none of none.
fn worst_joints<'a>(joints: impl Iterator<Item = (f64, &'a str)>, digits: usize) -> Option<String> {
    let mut joints: Vec<(f64, &str)> = joints.collect();
    joints.sort_by(|a, b| b.0.total_cmp(&a.0));
    let told: Vec<String> =
        joints.iter().map(|(figure, name)| format!("{name} ({figure:.digits$})")).collect();
    (!told.is_empty()).then(|| few(&told, WORST))
}
