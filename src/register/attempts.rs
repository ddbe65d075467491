//! Several attempts: where the first one leaves bones in doubt others follow, and the one that leaves
//! the least doubt is kept.

use super::registration::Registration;
use super::skeleton::Skeleton;
use super::summary::Registered;
use super::target::Target;
use super::verdict::Verdict;
use crate::run::Run;

/// Robust distance scale of the further attempts, in median distances.
const NEAR_FACTOR: f64 = 4.0;

/// How the levels are gone through, and from where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attempt {
    /// What the progress says before its stages.
    name: &'static str,
    /// Its part of the progress.
    from: f64,
    to: f64,
    /// Distance scale of robust weights on levels that do not have one of their own. Without it far
    /// pairs carry bones of other sizes to their places; with it things that belong to no bone pull
    /// less.
    pub(super) robust: Option<f64>,
    /// Which of the rigid starts, best first.
    pub(super) start: usize,
    /// How far an image is searched to each side, template unit; none = as the level says.
    pub(super) reach: Option<f64>,
}

impl Attempt {
    /// The first one.
    pub(super) const PLAIN: Self =
        Self { name: "", from: 0.0, to: 0.6, robust: None, start: 0, reach: None };
    /// In an image, on the levels on which bones are rigid: much there looks like a bone, so far pairs are
    /// trusted less from the beginning.
    pub(super) const IN_IMAGE: Self = Self { to: 0.4, robust: Some(NEAR_FACTOR), ..Self::PLAIN };
    /// The same, from where that ended.
    pub(super) const IN_IMAGE_AGAIN: Self =
        Self { name: "again: ", from: 0.4, to: 0.55, ..Self::IN_IMAGE };
    /// The levels after those.
    pub(super) const FINER_IN_IMAGE: Self = Self { from: 0.7, to: 0.95, ..Self::IN_IMAGE };
    /// The first one to the mirrored target.
    pub(super) const MIRRORED: Self =
        Self { name: "mirrored: ", from: 0.6, to: 0.7, ..Self::PLAIN };
    const NEAR: Self = Self {
        name: "far pairs trusted less: ",
        from: 0.7,
        to: 0.85,
        robust: Some(NEAR_FACTOR),
        ..Self::PLAIN
    };
    const SECOND_START: Self =
        Self { name: "second start: ", from: 0.85, to: 1.0, start: 1, ..Self::NEAR };

    /// The first one to a target.
    pub(super) fn first(target: &Target) -> Self {
        if target.image.is_some() { Self::IN_IMAGE } else { Self::PLAIN }
    }

    /// The same with images searched this far.
    pub(super) fn searching(self, reach: f64) -> Self {
        Self { reach: Some(reach), ..self }
    }

    /// The next one of its kind, with half of what is left of their part of the progress.
    pub(super) fn followed(self) -> Self {
        let end = Self::FINER_IN_IMAGE.from;
        Self { from: self.to, to: f64::midpoint(self.to, end), ..self }
    }

    /// Says that a stage begins at a share of this attempt.
    pub(super) fn enter(&self, run: &Run, stage: &str, share: f64) {
        let fraction = self.from + share * (self.to - self.from);
        run.enter(&format!("{}{stage}", self.name), fraction);
    }
}

/// The attempts after the plain one, in order, and the share of the bones in doubt from which on.
const FURTHER: [(Attempt, f64); 2] = [(Attempt::NEAR, 0.0), (Attempt::SECOND_START, 0.5)];

impl Registration {
    /// The result that leaves the least doubt, `found` or that of a further attempt.
    pub(super) fn best_of_attempts(
        &self,
        found: Registered,
        target: &Target,
        starts: &[Vec<Skeleton>],
        run: &Run,
    ) -> Registered {
        let mut best = found;
        for (attempt, share) in FURTHER.into_iter().take(self.options.further_attempts) {
            let named = best.named_bones() as f64;
            if named == 0.0 || named < share * best.bones.len() as f64 || run.is_cancelled() {
                break;
            }
            let other = self.find(target, starts, attempt, run).filter(|other| !other.cancelled);
            if let Some(other) = other.filter(|other| doubt(other) < doubt(&best)) {
                best = other;
            }
        }
        Registered { cancelled: run.is_cancelled(), ..best }
    }
}

/// Bones in doubt, failed ones counted twice.
fn doubt(found: &Registered) -> usize {
    let count = |verdict| found.bones.iter().filter(|b| b.verdict == verdict).count();
    count(Verdict::Doubtful) + 2 * count(Verdict::Failed)
}
