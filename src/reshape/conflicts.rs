//! Pairs that cannot all be right: not on the template, one place with two targets, neighbours torn apart,
//! two that were exchanged, or the other side of the body.

use super::findings::{Concern, Finding, Remedy, Severity};
use super::pairs::Pair;
use crate::align::best_similarity;
use crate::math::Vec3;
use crate::mesh::{TriMesh, bounding_box, diagonal};

/// Places on the template that lie this share of the diagonal outside its box are not on it,
const OFF_TEMPLATE: f64 = 0.05;
/// and here nothing can be made of them.
const FAR_OFF: f64 = 0.5;
/// Points nearer than this share of the diagonal are the same place.
const SAME_PLACE: f64 = 1e-6;
/// Targets farther apart than this share of the diagonal are different places.
const OTHER_PLACE: f64 = 0.02;
/// Neighbouring landmarks whose targets are this many times farther apart are suspicious.
const TORN: f64 = 10.0;
/// Fewer landmarks fit whatever is done to them; of more, each two are not tried.
const FEWEST: usize = 4;
const MOST: usize = 60;
/// Landmarks that a similarity brings as near as this, in extents of the targets, are like the template's.
const ALIKE: f64 = 0.08;
/// An exchange is believed if it leaves at most this share of the distances, and any other one more than
/// so many times as much.
const EXPLAINED: f64 = 0.35;
const ALONE: f64 = 1.5;

/// What is wrong with pairs, called `what`.
pub fn conflicts(surface: &TriMesh, pairs: &[Pair], what: &str) -> Vec<Finding> {
    let found = [off_template(surface, pairs, what), torn(pairs, what, surface.diagonal())];
    found.into_iter().flatten().collect()
}

/// Pairs whose places are not on or in the template: in another frame or unit.
fn off_template(surface: &TriMesh, pairs: &[Pair], what: &str) -> Option<Finding> {
    let (low, high) = bounding_box(&surface.points)?;
    let off = |pair: &Pair| (pair.position - pair.position.sup(&low).inf(&high)).norm();
    let worst = pairs.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
    let count = pairs.iter().filter(|p| off(p) > OFF_TEMPLATE * surface.diagonal()).count();
    let refused = off(worst) > FAR_OFF * surface.diagonal();
    (count > 0).then(|| {
        Finding::new(
            Concern::Landmarks,
            if refused { Severity::Refused } else { Severity::Note },
            format!(
                "{count} of {} {what} are not on the template, '{}' lies {:.3} outside the box around it; give the place on the template first, then the person's, both in the template's unit",
                pairs.len(),
                worst.label,
                off(worst)
            ),
        )
    })
}

/// One place with two targets, or neighbours torn apart.
fn torn(pairs: &[Pair], what: &str, diagonal: f64) -> Option<Finding> {
    let mut torn = Vec::new();
    for (i, a) in pairs.iter().enumerate() {
        for b in &pairs[..i] {
            let here = (a.position - b.position).norm();
            let there = (a.target - b.target).norm();
            if here <= SAME_PLACE * diagonal && there > OTHER_PLACE * diagonal {
                let text = format!(
                    "the {what} '{}' and '{}' are the same place of the template, but their targets are {there:.3} apart; remove one",
                    b.label, a.label
                );
                return Some(Finding::new(Concern::Landmarks, Severity::Refused, text));
            }
            if there > TORN * here && there > OTHER_PLACE * diagonal {
                torn.push((b, a, here, there));
            }
        }
    }
    let (b, a, here, there) = torn.first()?;
    let text = format!(
        "{} pairs of {what} contradict each other, such as '{}' and '{}': {here:.3} apart on the template, {there:.3} on the person; look for swapped points",
        torn.len(),
        b.label,
        a.label
    );
    Some(Finding::new(Concern::Landmarks, Severity::Note, text))
}

/// Two pairs whose targets were exchanged, or a template of the other side of the body.
pub fn exchanged(pairs: &[Pair]) -> Option<Finding> {
    let pairs: Vec<(usize, &Pair)> =
        pairs.iter().enumerate().filter(|(_, pair)| pair.weight > 0.0).collect();
    if !(FEWEST..=MOST).contains(&pairs.len()) {
        return None;
    }
    let from: Vec<Vec3> = pairs.iter().map(|(_, pair)| pair.position).collect();
    let mut to: Vec<Vec3> = pairs.iter().map(|(_, pair)| pair.target).collect();
    let extent = diagonal(&to);
    let now = unlikeness(&from, &to)?;
    if now <= ALIKE * extent {
        return None;
    }
    let mirrored: Vec<Vec3> = from.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
    let other_side = unlikeness(&mirrored, &to).unwrap_or(f64::INFINITY);
    let mut tried = Vec::new();
    for i in 0..to.len() {
        for k in 0..i {
            to.swap(i, k);
            tried.extend(unlikeness(&from, &to).map(|left| (left, k, i)));
            to.swap(i, k);
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let &(left, k, i) = tried.first()?;
    let next = tried.get(1).map_or(f64::INFINITY, |next| next.0);
    if other_side <= EXPLAINED * now && other_side < left {
        return Some(other_side_of_the_body(&from));
    }
    (left <= EXPLAINED * now && next > ALONE * left).then(|| {
        let ((k, a), (i, b)) = (pairs[k], pairs[i]);
        let text = format!(
            "the landmarks '{}' and '{}' look exchanged: with their targets swapped the landmarks lie as on the template; swap them",
            a.label, b.label
        );
        let finding = Finding::new(Concern::Exchange, Severity::Doubtful, text);
        Finding { remedy: Some(Remedy::Exchange(k, i)), ..finding }
    })
}

fn other_side_of_the_body(from: &[Vec3]) -> Finding {
    let centre = from.iter().sum::<Vec3>() / from.len() as f64;
    let mut motion = nalgebra::Matrix4::identity();
    (motion[(0, 0)], motion[(0, 3)]) = (-1.0, 2.0 * centre.x);
    let text = "the landmarks lie as on a mirror image of the template: it is of the other side of the body; mirror it";
    let finding = Finding::new(Concern::Side, Severity::Doubtful, text.to_owned());
    Finding { remedy: Some(Remedy::Move(motion)), ..finding }
}

/// How far apart two sets of points are when the one is moved and scaled to the other, root mean square.
fn unlikeness(from: &[Vec3], to: &[Vec3]) -> Option<f64> {
    let motion = best_similarity(from, to, None).ok()?;
    let squares = from.iter().zip(to).map(|(f, t)| (motion.apply(f) - t).norm_squared());
    Some((squares.sum::<f64>() / from.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(change: impl Fn(usize, Vec3) -> Vec3) -> Vec<Pair> {
        let places =
            [[0.0, 0.0, 0.0], [9.0, 1.0, 0.0], [2.0, 7.0, 1.0], [3.0, 2.0, 8.0], [6.0, 5.0, 4.0]];
        let pair = |(i, p): (usize, [f64; 3])| {
            let position = Vec3::from(p);
            let target = change(
                i,
                position * 1.1 + Vec3::new(0.2 * libm::sin(p[1]), 3.0, 0.3 * libm::cos(p[0])),
            );
            Pair {
                label: format!("l{i}"),
                position,
                vertex: None,
                target,
                weight: 1.0,
                within: None,
            }
        };
        places.into_iter().enumerate().map(pair).collect()
    }

    #[test]
    fn good_landmarks_are_not_suspected() {
        assert!(exchanged(&pairs(|_, p| p)).is_none());
    }

    #[test]
    fn the_two_that_were_exchanged_are_named() {
        let mut pairs = pairs(|_, p| p);
        let (a, b) = (pairs[1].target, pairs[3].target);
        (pairs[1].target, pairs[3].target) = (b, a);
        let found = exchanged(&pairs).unwrap();
        assert_eq!(found.concern, Concern::Exchange);
        assert_eq!(found.remedy, Some(Remedy::Exchange(1, 3)));
        assert!(found.text.contains("'l1' and 'l3' look exchanged"), "{}", found.text);
    }

    #[test]
    fn a_template_of_the_other_side_is_told_from_exchanged_landmarks() {
        let found = exchanged(&pairs(|_, p| Vec3::new(-p.x, p.y, p.z))).unwrap();
        assert_eq!(found.concern, Concern::Side);
        assert!(matches!(found.remedy, Some(Remedy::Move(m)) if m.determinant() < 0.0));
    }
}
