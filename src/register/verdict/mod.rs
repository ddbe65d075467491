//! How far a result can be trusted, bone by bone and as a whole, from what can be measured without
//! knowing the truth. The limits were found with `examples/verdict`; docs/register.md has the table.

mod coverage;
mod distortion;
mod evidence;
mod findings;
mod judge;
mod open_joints;
mod whole;

use std::cmp::Ordering;

use serde::Serialize;

pub(super) use evidence::Evidence;
pub(super) use judge::{Judged, judge_bones};
pub(super) use whole::judge_whole;

/// How far a result, or one bone of it, can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing speaks against it.
    #[default]
    Good,
    /// It may be wrong: look at it.
    Doubtful,
    /// It is wrong.
    Failed,
}

impl Verdict {
    /// Its name: good, doubtful, failed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Failed => "failed",
        }
    }
}

/// A verdict with its reasons, each with what can be done about it; no reasons where it is good.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// The worst that any reason says.
    pub verdict: Verdict,
    /// Sentences, worst first.
    pub reasons: Vec<String>,
}

/// A figure that speaks against a result.
struct Finding {
    /// The figure as a share of the limit beyond which it makes doubtful; infinite if it is no number.
    share: f64,
    verdict: Verdict,
    reason: String,
    /// The other bone that may be the wrong one of the two.
    against: Option<usize>,
    /// Doubt about the bones beside it makes it no worse.
    alone: bool,
}

impl Finding {
    /// From a figure and its two limits, beyond which it makes doubtful and failed.
    fn new(figure: f64, [doubtful, failed]: [f64; 2], reason: String) -> Self {
        let share = if figure.is_nan() { f64::INFINITY } else { figure / doubtful };
        let verdict = match figure {
            _ if share <= 1.0 => Verdict::Good,
            _ if figure <= failed => Verdict::Doubtful,
            _ => Verdict::Failed,
        };
        Self { share, verdict, reason, against: None, alone: false }
    }

    /// The same, against another bone too.
    fn against(self, other: usize) -> Self {
        Self { against: Some(other), alone: true, ..self }
    }

    /// The same, whatever is said of the bones beside it.
    fn alone(self) -> Self {
        Self { alone: true, ..self }
    }
}

impl Judgement {
    fn new(mut findings: Vec<Finding>) -> Self {
        findings.retain(|finding| finding.verdict > Verdict::Good);
        let weight = |finding: &Finding| (finding.verdict, finding.share);
        findings.sort_by(|a, b| weight(b).partial_cmp(&weight(a)).unwrap_or(Ordering::Equal));
        let verdict = findings.first().map_or(Verdict::Good, |finding| finding.verdict);
        Self { verdict, reasons: findings.into_iter().map(|finding| finding.reason).collect() }
    }
}
