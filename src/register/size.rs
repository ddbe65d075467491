//! How large the person is against the template, before anything is bent.

use super::correspond::{Correspond, Correspondences};
use super::elastic::whole_motion;
use super::pose::{BoneMoments, moved};
use super::registration::{Registration, State};
use super::start::CLEARLY_BETTER;

/// Rounds of closest points.
const ROUNDS: usize = 20;
/// A factor nearer to 1 ends them.
const STILL: f64 = 1e-3;
/// The largest factor, either way.
const LARGEST: f64 = 2.0;

impl Registration {
    /// Gives the skeleton, as one stiff body, the size and place in which it comes nearest to the target,
    /// where that is clearly nearer than in its own size.
    ///
    /// A bone's own pairs hardly tell its size while it lies beside its place; all bones together do.
    pub(super) fn take_size(&self, search: &mut Correspond, state: &mut State) {
        if search.in_image() {
            return;
        }
        let rules = &self.first_rigid().rules;
        let mut sized = state.clone();
        let mut pairs = search.at(&sized.points, rules);
        let before = pairs.rms_distance;
        for _ in 0..ROUNDS {
            let factor = self.make_larger(&mut sized, &pairs);
            if !(1.0 / LARGEST..=LARGEST).contains(&sized.scales[0].x) {
                return;
            }
            pairs = search.at(&sized.points, rules);
            if factor.ln().abs() < STILL {
                break;
            }
        }
        if pairs.rms_distance < CLEARLY_BETTER * before {
            *state = sized;
        }
    }

    /// Carries the skeleton to where its pairs want it, as one body of another size; the factor.
    fn make_larger(&self, state: &mut State, pairs: &Correspondences) -> f64 {
        let masses = self.masses(pairs);
        let motion = whole_motion(&state.points, &pairs.wanted, &masses);
        let [from, to] =
            [&state.points, &pairs.wanted].map(|points| BoneMoments::new(points, &masses));
        let factor = (to.spread.trace() / from.spread.trace()).sqrt();
        state.reference.move_bones(&vec![motion; state.reference.bones.len()]);
        state.reference.scale_about(&moved(&motion, &from.centre), factor);
        state.points.clone_from(&state.reference.points);
        for scale in &mut state.scales {
            *scale *= factor;
        }
        factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::mesh::TriMesh;
    use crate::register::joint_limits::JointLimits;
    use crate::register::options::Options;
    use crate::register::skeleton::Skeleton;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::target::Target;

    #[test]
    fn a_skeleton_of_bones_apart_takes_the_size_of_its_target_and_keeps_its_own_where_that_fits() {
        let half = Vec3::new(4.0, 2.0, 1.0);
        let centres =
            [Vec3::new(-6.0, 0.0, 0.0), Vec3::new(6.0, 1.0, 0.0), Vec3::new(0.0, 12.0, 5.0)];
        let limits = JointLimits::new(Vec3::repeat(0.3), Vec3::repeat(0.3), 0.1).unwrap();
        let joint = joint_at("joint", [0, 1], Vec3::new(0.0, 0.5, 0.0), limits);
        let bones = centres.iter().map(|&c| ("bone".to_owned(), block(c, half, 6)));
        let named = bones.enumerate().map(|(k, (name, mesh))| (format!("{name} {k}"), mesh));
        let skeleton = Skeleton::new(named.collect(), vec![joint]).unwrap();
        let registration = Registration::new(skeleton.clone(), Options::default()).unwrap();
        let sized = |size: f64| {
            let mut person = skeleton.clone();
            person.scale_about(&Vec3::new(0.0, 4.0, 0.0), size);
            let surface = TriMesh::new(person.points.clone(), person.triangles).unwrap();
            let target = Target::whole(surface).unwrap();
            let mut search = registration.search(&target, 0.0);
            let mut state = State::at(skeleton.clone());
            registration.take_size(&mut search, &mut state);
            let off = state.points.iter().zip(&person.points).map(|(p, q)| (p - q).norm());
            let at = state.reference.joints[0].child_frame.translation.vector;
            let joint_off = (at - person.joints[0].child_frame.translation.vector).norm();
            (state.scales[0].x, off.fold(joint_off, f64::max))
        };
        for size in [0.8, 1.25] {
            let (scale, off) = sized(size);
            assert!((scale / size - 1.0).abs() < 0.02 && off < 0.3, "{size}: {scale} {off}");
        }
        let (scale, off) = sized(1.0);
        assert!((scale - 1.0).abs() < 1e-12 && off < 1e-9, "{scale} {off}");
    }
}
