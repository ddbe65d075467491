//! The bones of a report: a view that turns, and still pictures of the same.

use crate::job::report::html::image;
use crate::job::report::picture::{View, draw};
use crate::job::report::ramp::{Colour, DOUBTFUL, FAILED, Ramp, UNSEEN};
use crate::job::report::view3d::View3d;
use crate::measure::Spread;
use crate::mesh::TriMesh;
use crate::register::summary::BoneSummary;
use crate::register::{Registered, Skeleton, Target, Verdict};

/// Colours of neighbouring bones.
const PALETTE: [Colour; 6] = [
    [0.90, 0.86, 0.74],
    [0.55, 0.75, 0.92],
    [0.95, 0.70, 0.55],
    [0.65, 0.85, 0.60],
    [0.85, 0.65, 0.85],
    [0.80, 0.80, 0.80],
];
/// Of a distance to the target, after viridis; 1 is the 95th percentile.
const DISTANCE: [(f64, Colour); 3] =
    [(0.0, [0.27, 0.00, 0.33]), (0.5, [0.13, 0.57, 0.55]), (1.0, [0.99, 0.91, 0.14])];

fn verdict_colour(verdict: Verdict) -> Colour {
    match verdict {
        Verdict::Good => PALETTE[0],
        Verdict::Doubtful => DOUBTFUL,
        Verdict::Failed => FAILED,
    }
}

/// `distances`: of the person's vertices to the target.
pub(super) fn pictures(
    template: &Skeleton,
    target: &Target,
    distances: &[f64],
    found: &Registered,
) -> String {
    let view = turning(template, target, distances, found);
    format!("<h2>Shape</h2>\n{}", view.html(&still(template, found)))
}

fn turning(template: &Skeleton, target: &Target, distances: &[f64], found: &Registered) -> View3d {
    let mut view = View3d::between(["template", "person"]);
    let person = &found.skeleton;
    let bones = || template.bones.iter().enumerate();
    for (b, bone) in bones() {
        let before = template.bone_surface(b, &template.points);
        let after = &person.points[bone.vertices.clone()];
        view.part(&bone.name, &before.triangles, &[&before.points, after]);
    }
    let mut whole = TriMesh::default();
    target.surfaces().for_each(|surface| whole.append(surface));
    if !whole.triangles.is_empty() {
        view.clear_part("target", &whole.triangles, &whole.points);
    }
    let names = bones().map(|(b, bone)| (bone.name.clone(), palette(b))).collect();
    view.by_class("Bones", "", names, 0..template.bones.len());
    let verdicts = [Verdict::Good, Verdict::Doubtful, Verdict::Failed];
    let classes = verdicts.map(|v| (v.name().to_owned(), verdict_colour(v))).to_vec();
    let of_bone = |b: &BoneSummary| verdicts.iter().position(|v| *v == b.verdict).unwrap_or(0);
    view.by_class("Verdict", "verdict", classes, found.bones.iter().map(of_bone));
    view.by_value(
        "Seen",
        "shown by the target".to_owned(),
        &seen_ramp(),
        &of_bones(template, &found.seen),
    );
    let known: Vec<f64> = distances.iter().copied().filter(|d| !d.is_nan()).collect();
    if !known.is_empty() {
        let ramp = Ramp::scaled(&DISTANCE, Spread::of(&known).p95);
        view.by_value(
            "Distance",
            "distance to the target".to_owned(),
            &ramp,
            &of_bones(template, distances),
        );
    }
    view
}

/// The values of each bone's vertices.
fn of_bones<'v>(skeleton: &Skeleton, values: &'v [f64]) -> Vec<&'v [f64]> {
    skeleton.bones.iter().map(|bone| &values[bone.vertices.clone()]).collect()
}

fn still(template: &Skeleton, found: &Registered) -> String {
    let person = &found.skeleton;
    let verdict = |bone: usize| verdict_colour(found.bones[bone].verdict);
    let pictures = [
        ("Template", "", template, colours(template, palette)),
        ("Person", "", person, colours(person, palette)),
        ("Verdict", "Pale: good. Orange: doubtful. Red: failed.", person, colours(person, verdict)),
        (
            "Seen",
            "Blue: the target does not show it, a guess.",
            person,
            seen_ramp().colours(&found.seen),
        ),
    ];
    let part = |(title, key, skeleton, colours): (&str, &str, &Skeleton, Vec<Colour>)| {
        let mesh = skeleton.surface();
        let picture = |view| image(&draw(&mesh, &colours, &[], &mesh.points, view), title);
        let views = [View::Front, View::Side].map(picture);
        format!("<h3>{title}</h3>\n<p>{key}</p>\n{}", views.concat())
    };
    pictures.map(part).concat()
}

/// From what is not seen to what is.
fn seen_ramp() -> Ramp {
    Ramp::scaled(&[(0.0, UNSEEN), (1.0, PALETTE[0])], 1.0)
}

fn palette(bone: usize) -> Colour {
    PALETTE[bone % PALETTE.len()]
}

/// A colour for each vertex, by its bone.
fn colours(skeleton: &Skeleton, of_bone: impl Fn(usize) -> Colour) -> Vec<Colour> {
    skeleton.bone_of_vertex().iter().map(|&b| of_bone(b as usize)).collect()
}
