//! A template that lies elsewhere than the person because its file and theirs mean different things by
//! their numbers: another unit, another up axis, LPS beside RAS.
//!
//! Each of the usual mistakes is undone about the origin, where such mistakes are made, and judged by
//! how near the person's points then are. The nearest is believed where it is near, and much nearer
//! than the template is as it stands.

use rayon::prelude::*;

use super::findings::{Concern, Finding, Remedy, Severity};
use super::pairs::Pair;
use crate::align::Similarity;
use crate::locate::ClosestPoints;
use crate::math::{Mat3, Vec3};
use crate::mesh::{TriMesh, diagonal};

/// Ratios between the units people mix up.
const UNITS: [(f64, &str); 4] = [
    (1000.0, "metres beside millimetres"),
    (100.0, "metres beside centimetres"),
    (10.0, "centimetres beside millimetres"),
    (25.4, "inches beside millimetres"),
];
/// The markers of one unit with the template span at least this share of it, and at most its inverse.
const SAME_UNIT: f64 = 0.1;
/// Template and person of one unit differ in size by less than this.
const UNIT_RATIO: f64 = 30.0;
/// A template as near as this, in diagonals, lies where it should.
const IN_PLACE: f64 = 0.04;
/// A mistake is believed if undoing it leaves at most this share of the distance,
const NEARER: f64 = 0.4;
/// and is not believed if it leaves more than this, in diagonals.
const NEAR: f64 = 0.2;
/// A template farther than this from the person's points, in diagonals, is somewhere else.
const FAR: f64 = 0.5;
/// So many markers tell how near the template is.
const MARKERS: usize = 200;

/// A template that is not where the person is: by another unit or frame, or altogether. `will_move`: it is
/// aligned first; another unit is found all the same.
pub fn place(
    surface: &TriMesh,
    markers: &[Vec3],
    landmarks: &[Pair],
    will_move: bool,
) -> Option<Finding> {
    let found = if will_move { None } else { misplaced(surface, markers, landmarks) };
    let mistake = found.and_then(|found| Some((found, found.without?)));
    let finding = match (other_unit(surface, markers), mistake) {
        (Some((ratio, units)), _) => {
            let (own, theirs) = (surface.diagonal(), diagonal(markers));
            let larger = if own > theirs { "the template" } else { "the markers' cloud" };
            let guess = units.map_or(String::new(), |units| format!(", as with {units}"));
            Finding::new(
                Concern::Unit,
                Severity::Refused,
                format!(
                    "the markers span {theirs:.4} and the template {own:.4}: {larger} is {ratio:.0} times larger{guess}; bring both to one unit"
                ),
            )
        }
        (None, Some((found, (mistake, left)))) => mistaken(&found, &mistake, left),
        (None, None) => return elsewhere(&found?),
    };
    let Some((found, (mistake, left))) = mistake else { return Some(finding) };
    Some(Finding {
        distance: Some(found.now),
        mended_distance: Some(left),
        remedy: Some(Remedy::Move(mistake.motion().matrix())),
        ..finding
    })
}

/// What a mistake about unit or frame is called.
fn mistaken(found: &Distances, mistake: &Mistake, left: f64) -> Finding {
    let (mut with, mut because) = (Vec::new(), Vec::new());
    let mut concern = Concern::Frame;
    if mistake.negated {
        with.push("x and y negated".to_owned());
        because.push("one of the files is in LPS, the other in RAS".to_owned());
    }
    if let Some(to_z) = mistake.turned {
        let (own, theirs) = if to_z { ("Y", "Z") } else { ("Z", "Y") };
        with.push(format!("the template turned from {own} up to {theirs} up"));
        because.push(format!("{own} is up in the template's file, {theirs} in the other"));
        concern = Concern::UpAxis;
    }
    if let Some((units, factor)) = mistake.unit {
        with.push(format!("the template {factor:.4} times as large"));
        because.push(format!("two units, as {units}"));
        concern = Concern::Unit;
    }
    let severity = if found.share < FAR { Severity::Doubtful } else { Severity::Refused };
    Finding::new(
        concern,
        severity,
        format!(
            "the markers lie {:.3} from the template on average, but only {left:.3} with {}: {}; convert one of them",
            found.now,
            with.join(" and "),
            because.join(", and ")
        ),
    )
}

fn elsewhere(found: &Distances) -> Option<Finding> {
    (found.share >= FAR).then(|| {
        let text = format!(
            "the markers lie {:.3} from the template on average, more than half its size; move the template there first, by an alignment",
            found.now
        );
        let finding = Finding::new(Concern::Place, Severity::Doubtful, text);
        Finding { distance: Some(found.now), ..finding }
    })
}

/// How the template's file and the person's differ.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mistake {
    /// The two units, and what the template has to be multiplied by.
    unit: Option<(&'static str, f64)>,
    /// Whether x and y are negated: LPS beside RAS.
    negated: bool,
    /// Whether the template has to be turned from Y up to Z up (`true`), or back.
    turned: Option<bool>,
}

impl Mistake {
    /// There is none.
    const NONE: Self = Self { unit: None, negated: false, turned: None };

    /// All that are tried, of which a template of `size` has a size like the markers' where there are some.
    fn all(size: f64, markers: &[Vec3]) -> Vec<Self> {
        let both = UNITS.iter().flat_map(|&(ratio, name)| [(name, ratio), (name, 1.0 / ratio)]);
        let span = diagonal(markers);
        let of_size = |unit: &Option<(&str, f64)>| {
            let share = span / (size * unit.map_or(1.0, |(_, factor)| factor));
            markers.len() < 3 || unit.is_none() || (SAME_UNIT..1.0 / SAME_UNIT).contains(&share)
        };
        let units = [None].into_iter().chain(both.map(Some)).filter(of_size);
        let turns = [None, Some(true), Some(false)];
        let frames = [false, true].map(|negated| turns.map(|turned| (negated, turned)));
        units
            .flat_map(|unit| {
                frames.into_iter().flatten().map(move |(negated, turned)| Self {
                    unit,
                    negated,
                    turned,
                })
            })
            .collect()
    }

    /// What undoes it.
    fn motion(&self) -> Similarity {
        let upright = |to_z: bool| {
            let sign = if to_z { 1.0 } else { -1.0 };
            Mat3::new(1.0, 0.0, 0.0, 0.0, 0.0, -sign, 0.0, sign, 0.0)
        };
        let negated = if self.negated { Vec3::new(-1.0, -1.0, 1.0) } else { Vec3::repeat(1.0) };
        Similarity {
            scale: self.unit.map_or(1.0, |(_, factor)| factor),
            rotation: Mat3::from_diagonal(&negated) * self.turned.map_or(Mat3::identity(), upright),
            translation: Vec3::zeros(),
        }
    }
}

/// How far the person's points are from the template on average, as it is and with the mistake undone.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Distances {
    now: f64,
    /// The mistake that explains it best, and the distance without it.
    without: Option<(Mistake, f64)>,
    /// As it is, in diagonals of the template.
    share: f64,
}

/// Looks for a mistake. `None` without any points of the person.
fn misplaced(surface: &TriMesh, markers: &[Vec3], landmarks: &[Pair]) -> Option<Distances> {
    let size = surface.diagonal();
    if size == 0.0 || markers.is_empty() && landmarks.is_empty() {
        return None;
    }
    let few: Vec<Vec3> =
        markers.iter().step_by(markers.len().div_ceil(MARKERS).max(1)).copied().collect();
    let closest = ClosestPoints::new(&surface.points, &surface.triangles);
    let distance = |mistake: &Mistake| {
        let motion = mistake.motion();
        let back = motion.inverse();
        let to_surface = few.iter().filter_map(|m| closest.closest(&back.apply(m)));
        let to_surface = mean(to_surface.map(|hit| hit.distance * motion.scale));
        let gaps = mean(landmarks.iter().map(|l| (motion.apply(&l.position) - l.target).norm()));
        mean([to_surface, gaps].into_iter().flatten()).unwrap_or_default()
    };
    let now = distance(&Mistake::NONE);
    let share = now / size;
    if share <= IN_PLACE {
        return Some(Distances { now, without: None, share });
    }
    let believed = |&(mistake, left): &(Mistake, f64)| {
        let scale = mistake.motion().scale;
        // In diagonals of the template, which another unit makes another length.
        let left = left / (size * scale);
        mistake != Mistake::NONE && left <= NEARER * share && left <= NEAR
    };
    let tried: Vec<(Mistake, f64)> =
        Mistake::all(size, markers).into_par_iter().map(|m| (m, distance(&m))).collect();
    let relative = |(mistake, left): &(Mistake, f64)| left / mistake.motion().scale;
    let best = tried.into_iter().min_by(|a, b| relative(a).total_cmp(&relative(b)));
    Some(Distances { now, without: best.filter(believed), share })
}

/// The units of a template and markers whose sizes cannot be of one unit: how many times larger the one
/// is, and the units that have this ratio.
fn other_unit(surface: &TriMesh, markers: &[Vec3]) -> Option<(f64, Option<&'static str>)> {
    let (own, theirs) = (surface.diagonal(), diagonal(markers));
    if markers.len() < 3 || theirs == 0.0 || own == 0.0 {
        return None;
    }
    let ratio = (own / theirs).max(theirs / own);
    let off = |unit: f64| libm::log(unit / ratio).abs();
    let (unit, name) = UNITS.into_iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
    (ratio >= UNIT_RATIO).then(|| (ratio, (0.6..1.7).contains(&(unit / ratio)).then_some(name)))
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), v| (count + 1, sum + v));
    (count > 0).then(|| sum / f64::from(count))
}
