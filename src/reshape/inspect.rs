//! What is suspicious about a job's inputs, before anything is computed.

use super::pairs::Pair;
use super::problem::check_amount;
use crate::align::Freedom;
use crate::error::{Error, Result};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, TriMesh, bounding_box, diagonal};

/// Markers and template whose sizes differ by more than this do not have the same unit.
const UNIT_RATIO: f64 = 30.0;
/// Ratios between the units people mix up.
const UNITS: [(f64, &str); 4] = [
    (1000.0, "metres beside millimetres"),
    (100.0, "metres beside centimetres"),
    (10.0, "centimetres beside millimetres"),
    (25.4, "inches beside millimetres"),
];
/// Markers this share of the diagonal away from the template, on average, are somewhere else.
const FAR: f64 = 0.5;
/// Places on the template that lie this share of the diagonal outside its box are not on it.
const OFF_TEMPLATE: f64 = 0.05;
/// A frame is mixed up if turning it brings the markers this much nearer.
const NEARER: f64 = 0.2;
/// Fewer markers leave most of the shape to the prior.
const FEW_MARKERS: usize = 10;
/// Points nearer than this share of the diagonal are the same place.
const SAME_PLACE: f64 = 1e-6;
/// Targets farther apart than this share of the diagonal are different places.
const OTHER_PLACE: f64 = 0.02;
/// Neighbouring landmarks whose targets are this many times farther apart are suspicious.
const TORN: f64 = 10.0;
/// Points within this share of their extent from one line do not hold a body.
const COLLINEAR: f64 = 1e-3;

/// What [`inspect_data`] looks at.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// The template's surface, and what to call it.
    pub surface: (&'a TriMesh, &'a str),
    /// Points on the person's surface, those of a weight above 0.
    pub markers: &'a [Vec3],
    /// Paired points.
    pub landmarks: &'a [Pair],
    /// Attachments.
    pub attachments: &'a [Pair],
    /// Vertices that stay.
    pub fixed: &'a [u32],
}

/// Checks template, points and pairs against each other. What cannot work is an error; what may be a
/// mistake comes back as a sentence each. `align`: how the template will be moved as a whole first.
pub fn inspect_data(data: &Data, align: Option<Freedom>) -> Result<Vec<String>> {
    let (surface, name) = data.surface;
    let mut warnings = surface_warnings(surface, name);
    let of_weight = |pairs: &[Pair]| pairs.iter().filter(|p| p.weight > 0.0).count();
    check_amount(data.markers.len(), of_weight(data.landmarks), of_weight(data.attachments))?;
    if align != Some(Freedom::Similarity) {
        check_units(surface, data.markers)?;
    }
    if align.is_none() {
        check_place(surface, data.markers, &mut warnings)?;
    }
    if (1..FEW_MARKERS).contains(&data.markers.len()) && data.landmarks.len() < FEW_MARKERS {
        warnings.push(format!(
            "there are only {} markers; where none is near, the shape is a smooth guess",
            data.markers.len()
        ));
    }
    for (pairs, what) in [(data.landmarks, "landmarks"), (data.attachments, "attachments")] {
        check_places(surface, pairs, what, &mut warnings)?;
        check_pairs(pairs, what, surface.diagonal(), &mut warnings)?;
    }
    check_attachments(data)?;
    Ok(warnings)
}

fn surface_warnings(surface: &TriMesh, name: &str) -> Vec<String> {
    let check = SurfaceCheck::new(surface);
    let mut warnings: Vec<String> = check
        .sentences(surface)
        .into_iter()
        .map(|sentence| format!("{name}: {sentence}"))
        .collect();
    if check.is_closed() && surface.volume() < 0.0 {
        warnings.push(format!(
            "{name}: the surface is inside out (its normals point inwards); flip the normals"
        ));
    }
    warnings
}

fn check_units(surface: &TriMesh, markers: &[Vec3]) -> Result<()> {
    let (own, theirs) = (surface.diagonal(), diagonal(markers));
    if markers.len() < 3 || theirs == 0.0 || own == 0.0 {
        return Ok(());
    }
    let ratio = (own / theirs).max(theirs / own);
    if ratio < UNIT_RATIO {
        return Ok(());
    }
    let nearest =
        UNITS.iter().min_by(|a, b| (a.0 / ratio).ln().abs().total_cmp(&(b.0 / ratio).ln().abs()));
    let guess = nearest
        .filter(|(unit, _)| (0.6..1.7).contains(&(unit / ratio)))
        .map_or(String::new(), |(_, name)| format!(", as with {name}"));
    let larger = if own > theirs { "the template" } else { "the markers' cloud" };
    Err(Error::invalid(format!(
        "the markers span {theirs:.4} and the template {own:.4}: {larger} is {ratio:.0} times larger{guess}; bring both to one unit"
    )))
}

/// Markers that are not where the template is: by a mixed-up frame, or altogether.
fn check_place(surface: &TriMesh, markers: &[Vec3], warnings: &mut Vec<String>) -> Result<()> {
    if markers.is_empty() {
        return Ok(());
    }
    let closest = ClosestPoints::new(&surface.points, &surface.triangles);
    let mean = |signs: Vec3| {
        let moved: Vec<Vec3> = markers.iter().map(|m| m.component_mul(&signs)).collect();
        let found = closest.closest_many(&moved).into_iter().flatten();
        found.map(|hit| hit.distance).sum::<f64>() / markers.len() as f64
    };
    let (as_is, turned) = (mean(Vec3::new(1.0, 1.0, 1.0)), mean(Vec3::new(-1.0, -1.0, 1.0)));
    if as_is < FAR * surface.diagonal() {
        return Ok(());
    }
    if turned < NEARER * as_is {
        return Err(Error::invalid(format!(
            "the markers lie {as_is:.3} from the template on average, but only {turned:.3} with x and y negated: \
             one of the files is in LPS, the other in RAS; convert one of them"
        )));
    }
    warnings.push(format!(
        "the markers lie {as_is:.3} from the template on average, more than half its size; move the template there first, by an alignment"
    ));
    Ok(())
}

/// Pairs whose places are not on or in the template: in another frame or unit.
fn check_places(
    surface: &TriMesh,
    pairs: &[Pair],
    what: &str,
    warnings: &mut Vec<String>,
) -> Result<()> {
    let Some((low, high)) = bounding_box(&surface.points) else { return Ok(()) };
    let off = |pair: &Pair| (pair.position - pair.position.sup(&low).inf(&high)).norm();
    let Some(worst) = pairs.iter().max_by(|a, b| off(a).total_cmp(&off(b))) else { return Ok(()) };
    let count = pairs.iter().filter(|p| off(p) > OFF_TEMPLATE * surface.diagonal()).count();
    if count == 0 {
        return Ok(());
    }
    let sentence = format!(
        "{count} of {} {what} are not on the template, '{}' lies {:.3} outside the box around it; give the place on the template first, then the person's, both in the template's unit",
        pairs.len(),
        worst.label,
        off(worst)
    );
    if off(worst) > FAR * surface.diagonal() {
        return Err(Error::invalid(sentence));
    }
    warnings.push(sentence);
    Ok(())
}

/// Pairs that contradict each other: one place with two targets, or neighbours torn apart.
fn check_pairs(
    pairs: &[Pair],
    what: &str,
    diagonal: f64,
    warnings: &mut Vec<String>,
) -> Result<()> {
    let mut torn = Vec::new();
    for (i, a) in pairs.iter().enumerate() {
        for b in &pairs[..i] {
            let here = (a.position - b.position).norm();
            let there = (a.target - b.target).norm();
            if here <= SAME_PLACE * diagonal && there > OTHER_PLACE * diagonal {
                return Err(Error::invalid(format!(
                    "the {what} '{}' and '{}' are the same place of the template, but their targets are {there:.3} apart; remove one",
                    b.label, a.label
                )));
            }
            if there > TORN * here && there > OTHER_PLACE * diagonal {
                torn.push((b, a, here, there));
            }
        }
    }
    if let Some((b, a, here, there)) = torn.first() {
        warnings.push(format!(
            "{} pairs of {what} contradict each other, such as '{}' and '{}': {here:.3} apart on the template, {there:.3} on the person; look for swapped points",
            torn.len(),
            b.label,
            a.label
        ));
    }
    Ok(())
}

/// Attachments hold the body; on one line they leave it free to turn around that line.
fn check_attachments(data: &Data) -> Result<()> {
    if data.attachments.is_empty() {
        return Ok(());
    }
    let mut points: Vec<Vec3> = data.attachments.iter().map(|a| a.position).collect();
    points.extend(data.fixed.iter().map(|&v| data.surface.0.points[v as usize]));
    if off_line(&points) > COLLINEAR * diagonal(&points).max(f64::MIN_POSITIVE) {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "the {} attachments lie on one line or at one point, so the body can turn around it; add an attachment or a fixed point beside that line",
        data.attachments.len()
    )))
}

/// Largest distance from the line through the first point and the one farthest from it.
fn off_line(points: &[Vec3]) -> f64 {
    let first = points[0];
    let far = points
        .iter()
        .copied()
        .max_by(|a, b| (a - first).norm().total_cmp(&(b - first).norm()))
        .unwrap_or(first);
    let Some(along) = (far - first).try_normalize(f64::MIN_POSITIVE) else { return 0.0 };
    points.iter().map(|p| (p - first).cross(&along).norm()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_shapes::cube;

    /// All that [`Data`] refers to.
    struct Inputs {
        surface: TriMesh,
        markers: Vec<Vec3>,
        landmarks: Vec<Pair>,
        attachments: Vec<Pair>,
        fixed: Vec<u32>,
    }

    /// A box of 2 x 3 x 4 at (10, 20, 30), with markers near its corners.
    fn inputs() -> Inputs {
        let mut surface = cube();
        for p in &mut surface.points {
            *p = Vec3::new(10.0, 20.0, 30.0) + p.component_mul(&Vec3::new(2.0, 3.0, 4.0));
        }
        Inputs {
            markers: surface.points.iter().cycle().take(16).map(|p| p * 1.01).collect(),
            surface,
            landmarks: Vec::new(),
            attachments: Vec::new(),
            fixed: Vec::new(),
        }
    }

    fn inspected(inputs: &Inputs) -> Result<Vec<String>> {
        let data = Data {
            surface: (&inputs.surface, "box.obj"),
            markers: &inputs.markers,
            landmarks: &inputs.landmarks,
            attachments: &inputs.attachments,
            fixed: &inputs.fixed,
        };
        inspect_data(&data, None)
    }

    fn pair(label: &str, position: [f64; 3], target: [f64; 3]) -> Pair {
        let (position, target) = (position.into(), target.into());
        Pair { label: label.into(), position, vertex: None, target, weight: 1.0 }
    }

    fn scale_markers(inputs: &mut Inputs, factor: [f64; 3]) {
        for marker in &mut inputs.markers {
            marker.component_mul_assign(&Vec3::from(factor));
        }
    }

    fn error(change: impl Fn(&mut Inputs)) -> String {
        let mut inputs = inputs();
        change(&mut inputs);
        inspected(&inputs).unwrap_err().to_string()
    }

    fn warnings(change: impl Fn(&mut Inputs)) -> String {
        let mut inputs = inputs();
        change(&mut inputs);
        inspected(&inputs).unwrap().join("\n")
    }

    #[test]
    fn good_inputs_raise_nothing() {
        assert_eq!(warnings(|_| {}), "");
    }

    #[test]
    fn too_few_points_are_an_error() {
        let text = error(|i| i.markers.truncate(1));
        assert!(text.starts_with("1 markers, 0 landmarks and 0 attachments do not"), "{text}");
        assert!(warnings(|i| i.markers.truncate(5)).contains("there are only 5 markers"));
    }

    #[test]
    fn metres_on_a_millimetre_template_are_named_by_their_ratio() {
        let text = error(|i| scale_markers(i, [0.001; 3]));
        assert!(text.contains("990 times larger, as with metres beside millimetres"), "{text}");
        let text = error(|i| scale_markers(i, [500.0; 3]));
        assert!(text.contains("the markers' cloud is 505 times larger; bring"), "{text}");
    }

    #[test]
    fn a_mixed_up_frame_is_suspected_and_a_far_template_is_named() {
        let text = error(|i| scale_markers(i, [-1.0, -1.0, 1.0]));
        assert!(text.contains("one of the files is in LPS, the other in RAS"), "{text}");
        let text = warnings(|i| i.markers.iter_mut().for_each(|m| m.z += 40.0));
        assert!(text.contains("more than half its size; move the template"), "{text}");
    }

    #[test]
    fn surfaces_turned_inside_out_or_broken_are_named() {
        let text = warnings(|i| i.surface.triangles.iter_mut().for_each(|t| t.swap(0, 1)));
        assert!(text.contains("box.obj: the surface is inside out"), "{text}");
        let text = warnings(|i| i.surface.triangles[0].swap(0, 1));
        assert!(
            text.contains("box.obj: 3 edges lie between triangles that face opposite"),
            "{text}"
        );
    }

    #[test]
    fn places_off_the_template_are_named() {
        let at = |x: f64| {
            move |i: &mut Inputs| i.landmarks.push(pair("tip", [x, 20.0, 30.0], [12.0, 20.0, 30.0]))
        };
        assert_eq!(warnings(at(11.0)), "");
        let text = warnings(at(14.0));
        assert!(
            text.starts_with("1 of 1 landmarks are not on the template, 'tip' lies 2.000 outside"),
            "{text}"
        );
        let text = error(at(1e6));
        assert!(text.contains("'tip' lies 999988.000 outside the box"), "{text}");
    }

    #[test]
    fn contradictory_landmarks_are_named() {
        let text = error(|i| {
            i.landmarks.push(pair("tip", [10.0, 20.0, 30.0], [10.0, 20.0, 30.0]));
            i.landmarks.push(pair("top", [10.0, 20.0, 30.0], [12.0, 20.0, 30.0]));
        });
        assert!(text.contains("landmarks 'tip' and 'top' are the same place"), "{text}");
        let text = warnings(|i| {
            i.landmarks.push(pair("tip", [10.0, 20.0, 30.0], [10.0, 20.0, 30.0]));
            i.landmarks.push(pair("top", [10.0, 20.0, 30.1], [12.0, 20.0, 30.0]));
        });
        assert!(text.contains("1 pairs of landmarks contradict each other"), "{text}");
    }

    #[test]
    fn attachments_on_a_line_are_an_error_unless_fixed_points_help() {
        let on_line = |i: &mut Inputs| {
            for k in 0..4 {
                let p = [10.0 + 0.5 * f64::from(k), 20.0, 30.0];
                i.attachments.push(pair(&k.to_string(), p, p));
            }
        };
        let text = error(on_line);
        assert!(text.contains("the 4 attachments lie on one line"), "{text}");
        assert_eq!(
            warnings(|i| {
                on_line(i);
                i.fixed.push(7);
            }),
            ""
        );
    }
}
