//! Figure 4 of Gilles, Reveret, Pai 2010 at its hardest angle: what joints and plausible shapes add.
#![allow(clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../examples/figure4.rs"]
mod figure4;

use figure4::ablation;

#[test]
fn a_strongly_bent_finger_needs_joints_and_pairs_both_ways() {
    let found = ablation(&[21, 22, 23], [85.0]);
    let vertices = |name: &str| found.iter().find(|(n, _)| *n == name).unwrap().1[0][0];
    let published = vertices("published loop: clusters, scales, joints");
    assert!(published <= 0.7 && vertices("default") <= 0.7, "{found:?}");
    for lost in ["bones apart", "the same, template to target pairs only"] {
        assert!(vertices(lost) > 5.0 * published, "{lost}: {found:?}");
    }
    let no_joints = vertices("clusters and bone scales, no joints");
    assert!(no_joints > published, "{found:?}");
    assert!(vertices("clusters across bones only") > 2.0 * no_joints, "{found:?}");
}
