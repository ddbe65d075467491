//! What is suspicious about a problem's inputs, before anything is computed.

use super::conflicts::{conflicts, exchanged};
use super::findings::{Concern, Finding, Severity};
use super::misplaced::place;
use super::pairs::Pair;
use super::problem::check_amount;
use crate::align::Freedom;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, TriMesh, diagonal};

/// Fewer markers leave most of the shape to the prior.
const FEW_MARKERS: usize = 10;
/// Points within this share of their extent from one line do not hold a body.
const COLLINEAR: f64 = 1e-3;

/// What [`inspect`] looks at.
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

/// Checks template, points and pairs against each other: [`inspect`], in sentences. The first finding that
/// is refused is an error.
pub fn inspect_data(data: &Data, align: Option<Freedom>) -> Result<Vec<String>> {
    let findings = inspect(data, align);
    match findings.iter().find(|finding| finding.severity == Severity::Refused) {
        Some(refused) => Err(Error::invalid(refused.text.clone())),
        None => Ok(findings.into_iter().map(|finding| finding.text).collect()),
    }
}

/// All that is suspicious about a template with its points and pairs. `align`: how the template will be
/// moved as a whole first.
pub fn inspect(data: &Data, align: Option<Freedom>) -> Vec<Finding> {
    let (surface, name) = data.surface;
    let mut findings = surface_findings(surface, name);
    findings.extend(amount(data));
    for (pairs, what) in [(data.landmarks, "landmarks"), (data.attachments, "attachments")] {
        findings.extend(conflicts(surface, pairs, what));
    }
    findings.extend(exchanged(data.landmarks));
    if align != Some(Freedom::Similarity) {
        findings.extend(place(surface, data.markers, data.landmarks, align.is_some()));
    }
    findings.extend(attachments(data));
    findings
}

fn surface_findings(surface: &TriMesh, name: &str) -> Vec<Finding> {
    let check = SurfaceCheck::new(surface);
    let mut sentences = check.sentences(surface);
    if check.is_closed() && surface.volume() < 0.0 {
        sentences
            .push("the surface is inside out (its normals point inwards); flip the normals".into());
    }
    let finding =
        |sentence| Finding::new(Concern::Surface, Severity::Note, format!("{name}: {sentence}"));
    sentences.into_iter().map(finding).collect()
}

fn amount(data: &Data) -> Option<Finding> {
    let of_weight = |pairs: &[Pair]| pairs.iter().filter(|p| p.weight > 0.0).count();
    let count = data.markers.len();
    let enough = check_amount(count, of_weight(data.landmarks), of_weight(data.attachments));
    if let Err(error) = enough {
        return Some(Finding::new(Concern::Amount, Severity::Refused, error.to_string()));
    }
    let few = (1..FEW_MARKERS).contains(&count) && data.landmarks.len() < FEW_MARKERS;
    few.then(|| {
        let text = format!(
            "there are only {count} markers; where none is near, the shape is a smooth guess"
        );
        Finding::new(Concern::Amount, Severity::Note, text)
    })
}

/// Attachments hold the body; on one line they leave it free to turn around that line.
fn attachments(data: &Data) -> Option<Finding> {
    if data.attachments.is_empty() {
        return None;
    }
    let mut points: Vec<Vec3> = data.attachments.iter().map(|a| a.position).collect();
    points.extend(data.fixed.iter().map(|&v| data.surface.0.points[v as usize]));
    (off_line(&points) <= COLLINEAR * diagonal(&points).max(f64::MIN_POSITIVE)).then(|| {
        Finding::new(Concern::Attachments, Severity::Refused, format!(
            "the {} attachments lie on one line or at one point, so the body can turn around it; add an attachment or a fixed point beside that line",
            data.attachments.len()
        ))
    })
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
    use crate::reshape::findings::Remedy;

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

    impl Inputs {
        fn data(&self) -> Data<'_> {
            Data {
                surface: (&self.surface, "box.obj"),
                markers: &self.markers,
                landmarks: &self.landmarks,
                attachments: &self.attachments,
                fixed: &self.fixed,
            }
        }
    }

    fn inspected(inputs: &Inputs) -> Result<Vec<String>> {
        inspect_data(&inputs.data(), None)
    }

    fn pair(label: &str, position: [f64; 3], target: [f64; 3]) -> Pair {
        let (position, target) = (position.into(), target.into());
        Pair { label: label.into(), position, vertex: None, target, weight: 1.0, within: None }
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
    fn usual_mistakes_are_found_with_what_undoes_them() {
        let y_up = |p: &Vec3| Vec3::new(p.x, p.z, -p.y);
        let centimetres = |p: &Vec3| p / 10.0;
        let negated = |p: &Vec3| Vec3::new(-p.x, -p.y, p.z);
        let check = |concern, change: &dyn Fn(&Vec3) -> Vec3| {
            let mut inputs = inputs();
            let right = inputs.surface.points.clone();
            inputs.surface.points = right.iter().map(change).collect();
            let found = inspect(&inputs.data(), None);
            let [Finding { concern: own, remedy: Some(Remedy::Move(motion)), .. }] = &found[..]
            else {
                panic!("{found:?}")
            };
            assert_eq!(*own, concern, "{found:?}");
            for (p, r) in inputs.surface.points.iter().zip(&right) {
                assert!(
                    (motion.transform_point(&(*p).into()).coords - r).norm() < 1e-9,
                    "{found:?}"
                );
            }
        };
        check(Concern::UpAxis, &y_up);
        check(Concern::Frame, &negated);
        check(Concern::UpAxis, &|p| negated(&y_up(p)));
        check(Concern::Unit, &centimetres);
        check(Concern::Unit, &|p| p * 1000.0);
        check(Concern::Unit, &|p| y_up(&centimetres(p)));
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
