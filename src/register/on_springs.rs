//! The levels before the first: the skeleton hangs on springs and comes to its data as a whole.
//!
//! As long as bones lie on their neighbours' places, each by itself would stay there: a rib fits the next
//! rib's place, and the whole chest with it. On springs, stiff ones at first, a chain goes as a whole to where
//! most of it finds its place.

use nalgebra::SymmetricEigen;

use super::bone_scales::ScaleFreedom;
use super::pose::{BoneMoments, moments, moved};
use super::registration::{Registration, State};
use super::spring_pose::SpringPose;
use super::springs::{Posed, Pull};
use super::update::goals;
use crate::error::Result;
use crate::math::Vec3;

impl Registration {
    /// How the reference bones come towards `wanted` on springs at their joints. `softness`:
    /// the distance of a whole bone from its data, as a share of the template's diagonal, that counts as
    /// much as a joint turned by its whole range.
    pub(super) fn pose_on_springs(
        &self,
        softness: f64,
        State { reference, rest, .. }: &State,
        wanted: &[Vec3],
        [masses, unseen]: [&[f64]; 2],
    ) -> Result<Posed> {
        let moments = moments(reference, masses);
        let goals = goals(reference, &moments, wanted, [masses, unseen]);
        let mut pulls = Vec::new();
        for (b, (moments, goal)) in moments.iter().zip(goals).enumerate() {
            let Some(goal) = goal else { continue };
            let area: f64 = self.areas[reference.bones[b].vertices.clone()].iter().sum();
            let weight = moments.mass / area / (softness * self.diagonal).powi(2) / 4.0;
            let pull = |place| Pull { bone: b, place, goal: moved(&goal, &place), weight };
            pulls.extend(four_places(moments).map(pull));
        }
        let sized = self.model.is_none() && self.options.scale_freedom > ScaleFreedom::Fixed;
        SpringPose::new(reference, self.diagonal, rest, pulls, sized).solve()
    }
}

/// Four places that, with a quarter of the mass each, have the same centre and spread.
fn four_places(moments: &BoneMoments) -> [Vec3; 4] {
    let SymmetricEigen { eigenvectors, eigenvalues } = moments.spread.symmetric_eigen();
    let lengths = eigenvalues.map(|value| (value.max(0.0) / moments.mass).sqrt());
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    corners.map(|corner| moments.centre + eigenvectors * Vec3::from(corner).component_mul(&lengths))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::Noise;
    use crate::register::joint_limits::JointLimits;
    use crate::register::options::Options;
    use crate::register::skeleton::Skeleton;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::springs::joint_turns;

    #[test]
    fn four_places_stand_for_a_bone() {
        let mut noise = Noise::new(5);
        let points: Vec<Vec3> =
            (0..40).map(|_| noise.vector() + Vec3::new(3.0, 0.0, 1.0)).collect();
        let masses: Vec<f64> = (0..40).map(|k| f64::from(k % 7) + 0.5).collect();
        let moments = BoneMoments::new(&points, &masses);
        let same = BoneMoments::new(&four_places(&moments), &[moments.mass / 4.0; 4]);
        assert!((same.centre - moments.centre).norm() < 1e-12);
        assert!((same.spread - moments.spread).norm() < 1e-12 * moments.spread.norm());
    }

    #[test]
    fn a_bone_drawn_astray_goes_with_the_others_on_stiff_springs_and_its_own_way_on_soft_ones() {
        let half = Vec3::new(5.0, 2.0, 1.0);
        let at = |k: usize| Vec3::new(11.0 * k as f64, 0.0, 0.0);
        let limits = JointLimits::new(Vec3::repeat(0.3), Vec3::repeat(0.3), 0.1).unwrap();
        let joint = |k: usize| {
            let middle = (at(k) + at(k + 1)) / 2.0;
            joint_at(&format!("joint {k}"), [k, k + 1], middle, limits)
        };
        let bones = (0..5).map(|k| (format!("bone {k}"), block(at(k), half, 4))).collect();
        let chain = Skeleton::new(bones, (0..4).map(joint).collect()).unwrap();
        let registration = Registration::new(chain.clone(), Options::default()).unwrap();
        let mut state = State::at(chain.clone());
        state.rest = joint_turns(&chain);
        let astray = chain.bones[2].vertices.clone();
        let mut wanted = chain.points.clone();
        for (v, point) in wanted.iter_mut().enumerate() {
            point.y += if astray.contains(&v) { -3.0 } else { 1.0 };
        }
        let none = vec![0.0; wanted.len()];
        let end = |softness| {
            let posed = registration.pose_on_springs(
                softness,
                &state,
                &wanted,
                [&registration.areas, &none],
            );
            moved(&posed.unwrap().motions[2], &at(2)).y
        };
        // The mean of all is .2.
        let [stiff, soft] = [0.5, 0.001].map(end);
        assert!((stiff - 0.2).abs() < 0.1 && soft < -1.0, "{stiff} {soft}");
    }
}
