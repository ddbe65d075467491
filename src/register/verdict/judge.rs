//! The verdict on each bone.

use super::coverage::{Coverage, coverage};
use super::distortion::distortions;
use super::evidence::Evidence;
use super::findings::{image_findings, shape_findings, surface_findings};
use super::open_joints::beyond_open_joints;
use super::{Finding, Judgement, Verdict};
use crate::math::median;
use crate::register::skeleton::Skeleton;

/// Beside a bone in doubt this share of the limits is enough: what draws a bone away draws at its
/// neighbours.
const BESIDE: f64 = 0.55;
/// Of two bones that do not go together the one is in doubt that the target shows less of, by this share of it.
const SHOWN_LESS: f64 = 0.1;

/// What is said of each bone, and what it stands on.
pub(in crate::register) struct Judged {
    /// The verdict on each bone and the share of it that the target shows.
    pub(in crate::register) bones: Vec<(Judgement, f64)>,
    /// The same share for each vertex.
    pub(in crate::register) seen: Vec<f64>,
    /// The share of the target that is explained; none for an image.
    pub(in crate::register) explained: Option<f64>,
}

/// The verdict on each bone.
pub(in crate::register) fn judge_bones(evidence: &Evidence) -> Judged {
    let changes = distortions(evidence.template, evidence.areas, &evidence.result.points);
    let middle_radius = median(changes.iter().map(|change| change.radius)).unwrap_or(0.0);
    let shown = Shown::new(evidence);
    let mut shares = Vec::new();
    let mut findings: Vec<Vec<Finding>> = Vec::new();
    for b in 0..changes.len() {
        let (share, mut own) = match &shown {
            Shown::InImage(likeness) => image_findings(evidence, likeness, b),
            Shown::OnSurface(seen) => {
                surface_findings(evidence.target, seen, b, [changes[b].radius, middle_radius])
            }
        };
        own.extend(shape_findings(evidence, &changes, b));
        shares.push(share);
        findings.push(own);
    }
    let radii: Vec<f64> = changes.iter().map(|change| change.radius).collect();
    for (own, finding) in findings.iter_mut().zip(beyond_open_joints(evidence, &radii, &shares)) {
        own.extend(finding);
    }
    blame(&mut findings, &shares);
    spread_doubt(evidence.template, &mut findings);
    let bones = findings.into_iter().map(Judgement::new).zip(shares).collect();
    match shown {
        Shown::InImage(_) => Judged { bones, seen: evidence.pairs.trust.clone(), explained: None },
        Shown::OnSurface(Coverage { seen, explained, .. }) => {
            Judged { bones, seen, explained: Some(explained) }
        }
    }
}

/// What the target shows of the result.
enum Shown {
    /// How like the reference image the image is around each vertex.
    InImage(Vec<Option<f64>>),
    OnSurface(Coverage),
}

impl Shown {
    fn new(evidence: &Evidence) -> Self {
        let result = evidence.result;
        match &evidence.target.image {
            Some(image) => Self::InImage(image.likeness(&result.points, &result.triangles)),
            None => Self::OnSurface(coverage(
                evidence.template,
                result,
                evidence.areas,
                evidence.target,
            )),
        }
    }
}

/// Where two bones do not go together and something else speaks against one of them, it is that one; else the one
/// that the target shows less of. `shares`: how much it shows of each.
fn blame(findings: &mut [Vec<Finding>], shares: &[f64]) {
    let alone =
        |own: &Vec<Finding>| own.iter().any(|f| f.verdict > Verdict::Good && f.against.is_none());
    let in_doubt: Vec<bool> = findings.iter().map(alone).collect();
    for (b, own) in findings.iter_mut().enumerate() {
        let is_others = |other: usize| in_doubt[other] || shares[other] < shares[b] - SHOWN_LESS;
        own.retain(|f| in_doubt[b] || !f.against.is_some_and(is_others));
    }
}

/// Bones jointed to one in doubt are doubtful from a part of the limits on, and so on from bone to
/// bone; what two bones have against each other does not count twice.
fn spread_doubt(template: &Skeleton, findings: &mut [Vec<Finding>]) {
    let named = |own: &Vec<Finding>| own.iter().any(|f| f.verdict > Verdict::Good);
    let mut beside: Vec<usize> = (0..findings.len()).filter(|&b| named(&findings[b])).collect();
    while let Some(b) = beside.pop() {
        let beside_doubt = format!(" (it hangs on {}, which is in doubt)", template.bones[b].name);
        let neighbours = template.joints.iter().filter_map(|j| j.neighbour(b));
        for other in neighbours {
            if named(&findings[other]) {
                continue;
            }
            for finding in &mut findings[other] {
                if finding.share > BESIDE && !finding.alone {
                    finding.verdict = Verdict::Doubtful;
                    finding.reason.push_str(&beside_doubt);
                }
            }
            if named(&findings[other]) {
                beside.push(other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::joint_limits::JointLimits;
    use crate::register::skeleton::tests::{block, joint_at};

    #[test]
    fn doubt_spreads_along_joints_as_far_as_something_speaks_for_it() {
        let bone = |k: usize| {
            let at = Vec3::new(4.0 * k as f64, 0.0, 0.0);
            (format!("bone {k}"), block(at, Vec3::repeat(1.0), 1))
        };
        let limits = JointLimits::new(Vec3::zeros(), Vec3::zeros(), 1.0).unwrap();
        let joint = |k: usize| joint_at(&format!("joint {k}"), [k, k + 1], Vec3::zeros(), limits);
        let chain = Skeleton::new((0..5).map(bone).collect(), (0..4).map(joint).collect()).unwrap();
        let figures = [0.1, 1.5, 0.9, 0.7, 0.4];
        let mut findings: Vec<Vec<Finding>> =
            figures.iter().map(|&f| vec![Finding::new(f, [1.0, 2.0], "so".into())]).collect();
        spread_doubt(&chain, &mut findings);
        let judgements: Vec<Judgement> = findings.into_iter().map(Judgement::new).collect();
        let verdicts: Vec<&str> = judgements.iter().map(|j| j.verdict.name()).collect();
        assert_eq!(verdicts, ["good", "doubtful", "doubtful", "doubtful", "good"]);
        assert_eq!(judgements[3].reasons, ["so (it hangs on bone 2, which is in doubt)"]);
        let worst = Finding::new(f64::NAN, [1.0, 2.0], String::new());
        assert_eq!(worst.verdict, Verdict::Failed);
    }

    #[test]
    fn of_two_bones_that_do_not_go_together_the_one_with_something_else_against_it_or_less_shown_is_in_doubt()
     {
        let own = |figure: f64| Finding::new(figure, [1.0, 2.0], "own".into());
        let against = |other: usize| Finding::new(1.5, [1.0, 2.0], "size".into()).against(other);
        let mut findings = vec![
            vec![own(0.4), against(1)],
            vec![own(1.2), against(0)],
            vec![against(3)],
            vec![against(2)],
            vec![against(5)],
            vec![against(4)],
        ];
        blame(&mut findings, &[0.9, 0.9, 0.85, 0.9, 0.9, 0.7]);
        let named = |own: &Vec<Finding>| own.iter().any(|f| f.verdict > Verdict::Good);
        let named: Vec<bool> = findings.iter().map(named).collect();
        assert_eq!(named, [false, true, true, true, false, true]);
        assert_eq!(findings[1].len(), 2);
    }
}
