//! The shapes of a report: a view that turns, and still pictures of the same.

use super::report::{PairLine, Report, Shapes};
use crate::job::report::html::{number, picture};
use crate::job::report::picture::{Dot, View, draw};
use crate::job::report::ramp::{Colour, Ramp, SKIN};
use crate::job::report::view3d::View3d;
use crate::math::Vec3;
use crate::measure::interpolate;
use crate::mesh::TriMesh;
use crate::reshape::{Pair, Tolerances};

/// Diameter in pixels.
const MARKER: u32 = 7;
const LANDMARK: u32 = 12;
/// Of a stretch.
const STRETCH: [(f64, Colour); 3] =
    [(0.5, [0.15, 0.30, 0.85]), (1.0, [0.82, 0.82, 0.82]), (2.0, [0.85, 0.15, 0.10])];
/// Of a distance in tolerances.
const DISTANCE: [(f64, Colour); 3] =
    [(0.0, [0.10, 0.30, 0.80]), (1.0, [0.75, 0.80, 0.88]), (3.0, [0.85, 0.10, 0.10])];
/// Of a standard deviation; 1 is the 95th percentile.
const DOUBT: [(f64, Colour); 2] = [(0.0, [0.96, 0.96, 0.93]), (1.0, [0.42, 0.10, 0.55])];

pub(super) fn pictures(report: &Report, shapes: &Shapes) -> String {
    let colours = Colours::new(report);
    let still = still(report, shapes, &colours);
    format!("<h2>Shape</h2>\n{}", turning(report, shapes, &colours).html(&still))
}

/// The colours of values.
struct Colours {
    stretch: Ramp,
    distance: Ramp,
    doubt: Ramp,
    /// The standard deviation at the end of its scale.
    most_doubt: f64,
}

impl Colours {
    fn new(report: &Report) -> Self {
        let most_doubt = report.deviations.as_ref().map_or(0.0, |d| d.sd_normal.p95);
        Self {
            stretch: Ramp::scaled(&STRETCH, 1.0),
            distance: Ramp::scaled(&DISTANCE, report.tolerance),
            doubt: Ramp::scaled(&DOUBT, most_doubt),
            most_doubt,
        }
    }
}

fn turning(report: &Report, shapes: &Shapes, colours: &Colours) -> View3d {
    let mut view = View3d::between(["template", "result"]);
    view.part("surface", shapes.triangles, &[shapes.before, shapes.after]);
    view.by_class("Surface", "", vec![("surface".to_owned(), SKIN)], [0]);
    view.by_value("Stretch", "largest stretch".to_owned(), &colours.stretch, &[shapes.stretch]);
    let distances = &report.marker_distances;
    if !shapes.markers.is_empty() {
        let near = interpolate(shapes.markers, &distances.after, shapes.after);
        let title = "distance of the markers".to_owned();
        view.by_value("Distance", title, &colours.distance, &[&near]);
    }
    if let Some(deviations) = shapes.sd_normal {
        let title = "standard deviation across the surface".to_owned();
        view.by_value("How sure", title, &colours.doubt, &[deviations]);
    }
    let ends = [&distances.before[..], &distances.after];
    view.dots("markers", MARKER, shapes.markers, &colours.distance, ends);
    let Tolerances { landmark, attachment, .. } = shapes.tolerances;
    for (name, pairs, lines, tolerance) in [
        ("landmarks", shapes.landmarks, &report.landmarks, landmark),
        ("attachments", shapes.attachments, &report.attachments, attachment),
    ] {
        let targets: Vec<Vec3> = pairs.iter().map(|pair: &Pair| pair.target).collect();
        let distances = |of: fn(&PairLine) -> f64| lines.iter().map(of).collect::<Vec<f64>>();
        let [before, after] = [distances(|p| p.before), distances(|p| p.after)];
        let ramp = Ramp::scaled(&DISTANCE, tolerance);
        view.dots(name, LANDMARK, &targets, &ramp, [&before, &after]);
    }
    view
}

fn still(report: &Report, shapes: &Shapes, colours: &Colours) -> String {
    let frame: Vec<Vec3> =
        shapes.before.iter().chain(shapes.after).chain(shapes.markers).copied().collect();
    let skin = vec![SKIN; shapes.before.len()];
    let dots = |distances: &[f64]| -> Vec<Dot> {
        let markers = shapes.markers.iter().zip(distances);
        markers
            .map(|(&position, &d)| Dot { position, colour: colours.distance.colour(d) })
            .collect()
    };
    let distances = &report.marker_distances;
    let (before, after) = (dots(&distances.before), dots(&distances.after));
    let (none, stretch) = (Vec::new(), colours.stretch.colours(shapes.stretch));
    let stretch_caption = "Result, largest stretch: blue 0.5, grey 1, red 2";
    let mut rows = vec![
        (shapes.before, skin.clone(), &before, "Template and markers".to_owned()),
        (shapes.after, skin, &after, "Result and markers".to_owned()),
        (shapes.after, stretch, &none, stretch_caption.to_owned()),
    ];
    if let Some(deviations) = shapes.sd_normal {
        let caption = format!(
            "How sure it is, standard deviation across the surface: white 0, purple {} or more",
            number(colours.most_doubt)
        );
        rows.push((shapes.after, colours.doubt.colours(deviations), &after, caption));
    }
    let mut text = String::new();
    for (points, colours, dots, caption) in rows {
        let mesh = TriMesh { points: points.to_vec(), triangles: shapes.triangles.to_vec() };
        text.push_str("<div class=\"row\">");
        for (view, from) in [(View::Front, "from the front"), (View::Side, "from the right")] {
            let png = draw(&mesh, &colours, dots, &frame, view);
            text.push_str(&picture(&png, &format!("{caption}; {from} (z up)")));
        }
        text.push_str("</div>\n");
    }
    text + "<p>Red markers are three tolerances off, or more. Faint ones are behind.</p>\n"
}
