//! The verdict on a whole result.

use super::{Finding, Judgement, Verdict};
use crate::register::summary::BoneSummary;

/// Share of the target that lies on no bone: doubtful, failed.
const UNEXPLAINED: [f64; 2] = [0.15, 0.5];
/// Share of the bones that failed, doubtful ones counted half: beyond these the whole is doubtful,
/// failed.
const BONES: [f64; 2] = [1e-9, 0.35];
/// Share of the target's area that was left out because it is far from all bones: doubtful, failed.
const LEFT_OUT: [f64; 2] = [0.05, 0.9];
/// Bones that are named in a sentence.
const NAMED: usize = 5;

/// The verdict on a result from that on its bones, the share of the target that is explained, and the
/// share of its area that was left out.
pub(in crate::register) fn judge_whole(
    bones: &[BoneSummary],
    explained: Option<f64>,
    left_out: f64,
) -> Judgement {
    let is = |verdict| bones.iter().filter(move |b| b.verdict == verdict);
    let (failed, doubtful) = (is(Verdict::Failed), is(Verdict::Doubtful));
    let counts = [failed.clone().count(), doubtful.clone().count()];
    let share = (counts[0] as f64 + 0.5 * counts[1] as f64) / bones.len().max(1) as f64;
    let mut names: Vec<&str> = failed.chain(doubtful).map(|b| b.name.as_str()).collect();
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let unexplained = 1.0 - explained.unwrap_or(1.0);
    Judgement::new(vec![
        Finding::new(
            share,
            BONES,
            format!(
                "{} of {} bones failed, {} are doubtful: {}{more}",
                counts[0],
                bones.len(),
                counts[1],
                names.join(", ")
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
