//! What speaks against a bone: figures, their limits, and what can be done about them.

use super::Finding;
use super::coverage::Coverage;
use super::distortion::Distortion;
use super::evidence::Evidence;
use crate::register::summary::JointSummary;
use crate::register::target::Target;

// Limits beyond which a figure makes doubtful, and failed.
/// How far a bone goes on from what the target shows of it, against the radius of the skeleton's middle bone.
const GUESSED: [f64; 2] = [1.0, 3.0];
/// Less than this share of a small bone tells too little of it, however near all of it is to what is shown.
const TOO_LITTLE: f64 = 0.2;
/// Share of a bone that an image does not show.
const UNSEEN: [f64; 2] = [0.7, 0.95];
/// The same of a bone that the target has no surface for: always doubtful, never failed.
const NO_DATA: [f64; 2] = [0.0, 1.0];
/// How much the image around a bone differs from the reference image: 1 less their likeness.
const UNLIKE: [f64; 2] = [0.4, 0.7];
/// Share of a bone that lies where another bone lies.
const SHARED: [f64; 2] = [0.05, 0.3];
/// Target beside a bone that lies on no bone, as a share of the bone's area.
const UNEXPLAINED: [f64; 2] = [2.0, 6.0];
/// Distance of a bone to the target as a share of its radius,
const FAR: [f64; 2] = [0.12, 0.4];
/// unless the target's noise, in middle distances, is larger.
const NOISE: f64 = 2.5;
/// Logarithm of a bone's size against that of a bone it is jointed to.
const SIZE: [f64; 2] = [0.25, 0.7];
/// Bending of a bone as a share of its radius.
const BENT: [f64; 2] = [0.15, 0.4];
/// Share of a bone's surface that is crumpled.
const CRUMPLED: [f64; 2] = [0.025, 0.2];
/// Distance from its data at which joints hold a bone, as a share of its radius.
const HELD: [f64; 2] = [0.12, 0.4];
/// Degrees by which its data would turn a joint of a bone beyond its limit.
const TURNED: [f64; 2] = [8.0, 40.0];
/// Distance of a landmark from its place as a share of its bone's radius.
const MISSED: [f64; 2] = [0.5, 1.5];

/// Share of bone `b`'s vertices that found something like them in the image, and what the image says of it.
/// `likeness`: of each vertex, see [`ImageTarget::likeness`](crate::register::image::ImageTarget::likeness).
pub(super) fn image_findings(
    evidence: &Evidence,
    likeness: &[Option<f64>],
    b: usize,
) -> (f64, Vec<Finding>) {
    let range = evidence.result.bones[b].vertices.clone();
    let count = range.len().max(1) as f64;
    let share = evidence.pairs.trust[range.clone()].iter().sum::<f64>() / count;
    let mut findings = vec![Finding::new(
        1.0 - share,
        UNSEEN,
        format!(
            "the image shows what the template shows on {:.0} % of it only; look at it on slices",
            100.0 * share
        ),
    )];
    let (mut sum, mut area) = (0.0, 0.0);
    for i in range {
        if let Some(like) = likeness[i] {
            sum += evidence.areas[i] * like;
            area += evidence.areas[i];
        }
    }
    if area > 0.0 {
        let likeness = sum / area;
        findings.push(Finding::new(
            1.0 - likeness,
            UNLIKE,
            format!(
                "around it the image is like the reference image by {likeness:.2} only (1 is the same); look at it on slices, and whether the two images are of one kind"
            ),
        ));
    }
    (share, findings)
}

/// Share of bone `b` that lies on the target, and what the target says of it: with its radius and that of the
/// skeleton's middle bone.
pub(super) fn surface_findings(
    target: &Target,
    coverage: &Coverage,
    b: usize,
    [radius, middle_radius]: [f64; 2],
) -> (f64, Vec<Finding>) {
    let seen = &coverage.bones[b];
    if !target.has_surface_of(b) {
        let reason = "the target has no surface of it: it follows its joints".to_owned();
        return (0.0, vec![Finding::new(1.0, NO_DATA, reason)]);
    }
    let beyond_noise = seen.forward > NOISE * coverage.middle;
    let far = if beyond_noise { seen.forward / radius } else { 0.0 };
    let guessed = (seen.from_seen / middle_radius).max((1.0 - seen.seen) / (1.0 - TOO_LITTLE));
    let findings = vec![
        Finding::new(
            guessed,
            GUESSED,
            format!(
                "only {:.0} % of it lie on the target, the rest is a guess; see whether the target shows it, or give it a surface of its own (labels)",
                100.0 * seen.seen
            ),
        )
        .alone(),
        Finding::new(
            seen.shared,
            SHARED,
            format!(
                "{:.0} % of it lie where another bone lies; give each bone a surface of its own (labels)",
                100.0 * seen.shared
            ),
        ),
        Finding::new(
            seen.unexplained,
            UNEXPLAINED,
            format!(
                "beside it {:.1} times its own area of the target lie on no bone; it may belong there, or take out what is no bone",
                seen.unexplained
            ),
        ),
        Finding::new(
            far,
            FAR,
            format!(
                "it lies {:.3} off the target (root mean square), {:.0} % of its radius; look whether it lies on another bone",
                seen.forward,
                100.0 * far
            ),
        ),
    ];
    (seen.seen, findings)
}

/// What its own shape and its joints say of bone `b`.
pub(super) fn shape_findings(
    evidence: &Evidence,
    changes: &[Distortion],
    b: usize,
) -> Vec<Finding> {
    let (template, own) = (evidence.template, &changes[b]);
    let range = template.bones[b].vertices.clone();
    let count = range.len().max(1) as f64;
    let off = |i: usize| (evidence.elastic[i] - evidence.result.points[i]).norm();
    let held = range.map(off).sum::<f64>() / count;
    let mut findings = vec![
        Finding::new(
            own.bend,
            BENT,
            format!(
                "it is bent by {:.0} % of its radius; look whether the target has this bone, whole",
                100.0 * own.bend
            ),
        ),
        Finding::new(
            own.crumpled,
            CRUMPLED,
            format!(
                "{:.1} % of its surface are crumpled; look whether the target has this bone, whole",
                100.0 * own.crumpled
            ),
        ),
        Finding::new(
            held / own.radius,
            HELD,
            format!("its joints hold it {held:.3} off its data; look at their centres and limits"),
        ),
    ];
    let ratio = |other: &usize| libm::log(own.size / changes[*other].size).abs();
    let neighbours = template.joints.iter().filter_map(|j| j.neighbour(b));
    if let Some(other) = neighbours.max_by(|p, q| ratio(p).total_cmp(&ratio(q))) {
        let reason = format!(
            "against the template it is {:.2} times as large as {}; look which of them is on a wrong place",
            own.size / changes[other].size,
            template.bones[other].name
        );
        findings.push(Finding::new(ratio(&other), SIZE, reason).against(other));
    }
    findings.extend(turned(evidence, b));
    findings.extend(missed(evidence, own.radius, b));
    findings
}

/// The landmark of a bone that ends furthest from its place.
fn missed(evidence: &Evidence, radius: f64, b: usize) -> Option<Finding> {
    let own = evidence.target.landmarks.iter().filter(|landmark| landmark.bone == b);
    let distances = own.map(|landmark| landmark.distance(&evidence.result.points));
    let distance = distances.max_by(f64::total_cmp)?;
    let reason = format!(
        "its landmark is {distance:.3} from where the person has it; see whether that is the place, and whether the bone lies on another one"
    );
    Some(Finding::new(distance / radius, MISSED, reason))
}

/// The joint of a bone that its data would turn furthest beyond its limit.
fn turned(evidence: &Evidence, b: usize) -> Option<Finding> {
    let joints = evidence.template.joints.iter().zip(evidence.joints);
    let own = joints.filter_map(|(joint, summary)| Some((joint.neighbour(b)?, summary)));
    let excess = |(_, joint): &(usize, &JointSummary)| joint.wanted_excess_degrees;
    let (other, joint) = own.max_by(|p, q| excess(p).total_cmp(&excess(q)))?;
    let axis = ["first", "second", "third"][joint.wanted_rotation.iamax()];
    let reason = format!(
        "its data would turn {} {:.1} degrees beyond its limit, most about its {axis} axis; widen the limit if this person can do that",
        joint.name, joint.wanted_excess_degrees
    );
    Some(Finding::new(joint.wanted_excess_degrees, TURNED, reason).against(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::skeleton::tests::block;
    use crate::register::verdict::Verdict;
    use crate::register::verdict::coverage::BoneCoverage;

    #[test]
    fn a_bone_of_which_less_than_a_fifth_is_shown_is_in_doubt_however_small() {
        let target = Target::whole(block(Vec3::zeros(), Vec3::repeat(1.0), 2)).unwrap();
        let verdict = |seen: f64, from_seen: f64| {
            let mut coverage =
                Coverage { bones: vec![BoneCoverage::default()], ..Coverage::default() };
            (coverage.bones[0].seen, coverage.bones[0].from_seen) = (seen, from_seen);
            surface_findings(&target, &coverage, 0, [1.0, 10.0]).1[0].verdict
        };
        // A small bone ends near whatever is shown of it.
        assert_eq!([0.15, 0.25].map(|seen| verdict(seen, 1.0)), [Verdict::Doubtful, Verdict::Good]);
        // How far a large one goes on counts, however much of it is shown.
        assert_eq!([11.0, 31.0].map(|far| verdict(0.8, far)), [Verdict::Doubtful, Verdict::Failed]);
        assert_eq!(verdict(0.04, f64::INFINITY), Verdict::Failed);
    }
}
