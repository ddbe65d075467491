//! Several attempts: where the first one leaves bones in doubt others follow, and the one that leaves
//! the least doubt is kept.

use super::joint_frames::{Fit, take_shape};
use super::piece_match::{Match, PieceMatch};
use super::pieces::without_far_parts;
use super::pose_starts::towards_mid_range;
use super::registration::{Registration, State};
use super::skeleton::Skeleton;
use super::summary::Registered;
use super::target::Target;
use super::verdict::Verdict;
use crate::math::{Vec3, median};
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
    /// From the best result so far, with a piece of the target for each bone; so many times at most.
    in_pieces: usize,
}

impl Attempt {
    /// The first one.
    pub(super) const PLAIN: Self =
        Self { name: "", from: 0.0, to: 0.6, robust: None, start: 0, reach: None, in_pieces: 0 };
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
        to: 0.8,
        robust: Some(NEAR_FACTOR),
        ..Self::PLAIN
    };
    const SECOND_START: Self =
        Self { name: "second start: ", from: 0.8, to: 0.9, start: 1, ..Self::NEAR };
    const IN_PIECES: Self =
        Self { name: "piece by piece: ", from: 0.9, to: 1.0, in_pieces: 8, ..Self::NEAR };

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

    /// Round `k` of those of an attempt that is made several times.
    fn round(self, k: usize) -> Self {
        let step = (self.to - self.from) / self.in_pieces.max(1) as f64;
        let from = self.from + step * k as f64;
        Self { from, to: from + step, ..self }
    }

    /// Says that a stage begins at a share of this attempt.
    pub(super) fn enter(&self, run: &Run, stage: &str, share: f64) {
        let fraction = self.from + share * (self.to - self.from);
        run.enter(&format!("{}{stage}", self.name), fraction);
    }
}

/// The attempts after the plain one, in order, and the share of the bones in doubt from which and up to which each
/// is made. Where nearly all are, the skeleton lies elsewhere, and the pieces near its bones say nothing of them.
const FURTHER: [(Attempt, [f64; 2]); 3] = [
    (Attempt::NEAR, [0.0, 1.0]),
    (Attempt::SECOND_START, [0.5, 1.0]),
    (Attempt::IN_PIECES, [0.0, 0.8]),
];

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
        for (attempt, [least, most]) in FURTHER.into_iter().take(self.options.further_attempts) {
            for k in 0..attempt.in_pieces.max(1) {
                let named = best.named_bones() as f64 / best.bones.len() as f64;
                if run.is_cancelled() || named == 0.0 || !(least..=most).contains(&named) {
                    break;
                }
                let other = if attempt.in_pieces > 0 {
                    self.find_in_pieces(&best, target, attempt.round(k), run)
                } else {
                    self.find(target, starts, attempt, run)
                };
                match other.filter(|o| !o.cancelled && doubt(o) < doubt(&best)) {
                    Some(other) => best = other,
                    None => break,
                }
            }
        }
        Registered { cancelled: run.is_cancelled(), ..best }
    }

    /// The loop from a result on, with the bones in doubt put back and a piece of the target for each bone; none
    /// where then no bone wants a piece that another one needs more.
    fn find_in_pieces(
        &self,
        found: &Registered,
        target: &Target,
        attempt: Attempt,
        run: &Run,
    ) -> Option<Registered> {
        let (template, points) = (&self.template, &found.skeleton.points);
        let near = without_far_parts(target, points, &template.triangles, self.diagonal);
        let target = near.as_ref().unwrap_or(target);
        let pieces = self.pieces(target)?;
        let matches = PieceMatch::new(template, &pieces)?;
        let mut state = self.with_doubtful_put_back(found);
        let Match { owners, contested, moves } = matches.at(&state.points);
        if !contested {
            return None;
        }
        // From its neighbour's piece the nearest points would turn a bone round.
        for (bone, by) in template.bones.iter().zip(moves) {
            let by = by.unwrap_or_default();
            state.points[bone.vertices.clone()].iter_mut().for_each(|p| *p += by);
        }
        let in_pieces = Some((pieces.owned_by(owners), &matches));
        Some(self.find_from(state, in_pieces, self.coarse_search(target), target, attempt, run))
    }

    /// A result with its bones in doubt as the template has them on the bones they hang on, of the usual size.
    fn with_doubtful_put_back(&self, found: &Registered) -> State {
        let in_doubt: Vec<bool> = found.bones.iter().map(|b| b.verdict > Verdict::Good).collect();
        let good = found.scales.iter().zip(&in_doubt).filter(|(_, in_doubt)| !**in_doubt);
        let usual = median(good.map(|(scale, _)| scale.mean())).unwrap_or(1.0);
        let mut scales = found.scales.clone();
        for (scale, _) in scales.iter_mut().zip(&in_doubt).filter(|(_, in_doubt)| **in_doubt) {
            *scale = Vec3::repeat(usual);
        }
        let mut shape = found.skeleton.points.clone();
        let of_scales = self.scales.shape(&scales);
        let bones = self.template.bones.iter().zip(&in_doubt);
        for (bone, _) in bones.filter(|(_, in_doubt)| **in_doubt) {
            let range = bone.vertices.clone();
            shape[range.clone()].copy_from_slice(&of_scales[range]);
        }
        let mut reference = found.skeleton.clone();
        take_shape(&mut reference, &self.template, &shape, &self.areas, Fit::Affine);
        let motions = towards_mid_range(&self.template, &reference, self.root, &in_doubt, 0.0);
        reference.move_bones(&motions);
        State { scales, coefficients: found.coefficients.clone(), ..State::at(reference) }
    }
}

/// Bones in doubt, failed ones counted twice.
fn doubt(found: &Registered) -> usize {
    let count = |verdict| found.bones.iter().filter(|b| b.verdict == verdict).count();
    count(Verdict::Doubtful) + 2 * count(Verdict::Failed)
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::register::options::Options;
    use crate::register::piece_match::tests::row;

    #[test]
    fn bones_that_lie_on_their_neighbours_pieces_go_to_their_own() {
        let whole = row();
        let mut shifted = whole.clone();
        shifted.move_bones(&[Isometry3::translation(10.0, 0.0, 0.0); 5]);
        let options = Options { align: false, ..Options::default() };
        let registration = Registration::new(shifted.clone(), options).unwrap();
        let (one_off, target) = (shifted.surface(), Target::whole(whole.surface()).unwrap());
        let run = Run::new();
        let found = registration.register(&Target::whole(one_off).unwrap(), &run).unwrap();
        let attempt = Attempt::IN_PIECES;
        let right = registration.find_in_pieces(&found, &target, attempt, &run).unwrap();
        // Blocks lie on themselves in many ways: their middles tell which one lies where, 10 apart.
        let middle = |of: &Skeleton, b: usize| {
            let points = &of.points[of.bones[b].vertices.clone()];
            points.iter().sum::<Vec3>() / points.len() as f64
        };
        let off = |b: usize| (middle(&right.skeleton, b) - middle(&whole, b)).norm();
        let off: Vec<f64> = (0..whole.bones.len()).map(off).collect();
        assert!(off.iter().all(|off| *off < 2.0), "{off:?}");
        assert!(registration.find_in_pieces(&right, &target, attempt, &run).is_none());
    }
}
