//! The verdict on a whole result.

use super::{Finding, Judgement, Verdict};
use crate::register::few::few;
use crate::register::summary::BoneSummary;

/// Share of the target that lies on no bone: doubtful, failed.
const UNEXPLAINED: [f64; 2] = [0.15, 0.5];
/// Share of the bones that failed, doubtful ones counted half: beyond these the whole is doubtful,
/// failed.
const BONES: [f64; 2] = [1e-9, 0.35];
/// Bones that the target has no surface of: always doubtful, never failed.
const ABSENT: [f64; 2] = [0.5, f64::INFINITY];
/// Share of the target's area that was left out because it is far from all bones: doubtful, failed.
const LEFT_OUT: [f64; 2] = [0.05, 0.9];
/// Bones that are named in a sentence.
const NAMED: usize = 5;

fn listed<'a>(bones: impl Iterator<Item = &'a (&'a BoneSummary, &'a bool)>) -> String {
    let names: Vec<&str> = bones.map(|(bone, _)| bone.name.as_str()).collect();
    few(&names, NAMED)
}

/// The verdict on a result from that on its bones, of which some are `without` a surface in the target, the
/// share of the target that is explained, and the share of its area that was left out.
pub(in crate::register) fn judge_whole(
    bones: &[BoneSummary],
    without: &[bool],
    explained: Option<f64>,
    left_out: f64,
) -> Judgement {
    let (absent, sought): (Vec<_>, Vec<_>) =
        bones.iter().zip(without).partition(|(_, without)| **without);
    let is = |verdict| sought.iter().filter(move |(b, _)| b.verdict == verdict);
    let (failed, doubtful) = (is(Verdict::Failed), is(Verdict::Doubtful));
    let counts = [failed.clone().count(), doubtful.clone().count()];
    let share = (counts[0] as f64 + 0.5 * counts[1] as f64) / sought.len().max(1) as f64;
    let unexplained = 1.0 - explained.unwrap_or(1.0);
    Judgement::new(vec![
        Finding::new(
            share,
            BONES,
            format!(
                "{} of {} bones failed, {} are doubtful: {}",
                counts[0],
                sought.len(),
                counts[1],
                listed(failed.chain(doubtful))
            ),
        ),
        Finding::new(
            absent.len() as f64,
            ABSENT,
            format!(
                "the target has no surface of {} of {} bones, which follow their joints: {}",
                absent.len(),
                bones.len(),
                listed(absent.iter())
            ),
        ),
        Finding::new(
            unexplained,
            UNEXPLAINED,
            format!(
                "{:.0} % of the target lie on no bone; take out what is not of this skeleton",
                100.0 * unexplained
            ),
        ),
        Finding::new(
            left_out,
            LEFT_OUT,
            format!(
                "{:.0} % of the target lie far from all bones and were left out; see whether they belong to it",
                100.0 * left_out
            ),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_that_the_target_does_not_have_make_doubtful_but_never_failed() {
        let bone = |verdict| BoneSummary { name: "b".into(), verdict, ..BoneSummary::default() };
        let mut bones = vec![bone(Verdict::Doubtful); 20];
        bones[0] = bone(Verdict::Good);
        let without: Vec<bool> = (0..20).map(|b| b > 0).collect();
        let judged = judge_whole(&bones, &without, None, 0.0);
        assert_eq!(judged.verdict, Verdict::Doubtful);
        assert!(judged.reasons[0].contains("19 of 20 bones"), "{judged:?}");
        assert!(judged.reasons[0].contains("and 14 more"), "{judged:?}");
        assert_eq!(judge_whole(&bones, &[false; 20], None, 0.0).verdict, Verdict::Failed);
        bones[0] = bone(Verdict::Failed);
        assert_eq!(judge_whole(&bones, &without, None, 0.0).verdict, Verdict::Failed);
    }
}
