//! A view that a person can turn: shapes, their colours and dots, drawn by `viewer/` inside the page. The
//! page needs nothing else: the numbers stand in it, compressed.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

use super::ramp::{Colour, Ramp};
use crate::math::Vec3;

/// Made from `viewer/src` by `npm run build`; it holds three.js, under the licence beside it.
const SCRIPT: &str = include_str!("viewer/viewer.js");
const STYLE: &str = include_str!("viewer/viewer.css");
/// More than these make a page that no browser likes to open.
const MOST_TRIANGLES: usize = 1_000_000;

/// A place in the block of numbers: the first one, and how many.
type Span = [usize; 2];

/// What the view shows. `viewer/src/shapes.js` reads it.
#[derive(Debug, Default, Serialize)]
pub(crate) struct View3d {
    /// Names of the two ends between which the shapes go, where they have two.
    ends: Option<[&'static str; 2]>,
    parts: Vec<Part>,
    colourings: Vec<Colouring>,
    dots: Vec<Dots>,
    #[serde(skip)]
    numbers: Vec<u8>,
    #[serde(skip)]
    origin: Option<Vec3>,
    #[serde(skip)]
    triangle_count: usize,
}

#[derive(Debug, Serialize)]
struct Part {
    name: String,
    triangles: Span,
    points: Vec<Span>,
    /// Shown on demand, seen through.
    clear: bool,
}

#[derive(Debug, Serialize)]
struct Colouring {
    name: &'static str,
    title: String,
    /// Colours of values, where the parts have them.
    stops: Option<Ramp>,
    /// Names with their colours, where each part has one.
    classes: Vec<(String, Colour)>,
    parts: Vec<Paint>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Paint {
    Values(Span),
    Class(usize),
}

#[derive(Debug, Serialize)]
struct Dots {
    name: &'static str,
    title: String,
    /// Diameter in pixels.
    size: u32,
    points: Span,
    stops: Ramp,
    values: [Span; 2],
}

impl View3d {
    /// Shapes that stand still.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Shapes that a slider takes from one end to the other.
    pub(crate) fn between(ends: [&'static str; 2]) -> Self {
        Self { ends: Some(ends), ..Self::default() }
    }

    /// Adds a surface; `points` at each end.
    pub(crate) fn part(&mut self, name: &str, triangles: &[[u32; 3]], points: &[&[Vec3]]) {
        self.add(name, triangles, points, false);
    }

    /// Adds, after all others, a surface that is shown on demand and seen through, unless it makes the
    /// page too large.
    pub(crate) fn clear_part(&mut self, name: &str, triangles: &[[u32; 3]], points: &[Vec3]) {
        if self.triangle_count + triangles.len() <= MOST_TRIANGLES {
            self.add(name, triangles, &[points], true);
        }
    }

    fn add(&mut self, name: &str, triangles: &[[u32; 3]], points: &[&[Vec3]], clear: bool) {
        self.triangle_count += triangles.len();
        let triangles = self.store(triangles.iter().flatten().map(|v| v.to_le_bytes()));
        let points = points.iter().map(|points| self.places(points)).collect();
        self.parts.push(Part { name: name.to_owned(), triangles, points, clear });
    }

    /// Colours by values, a list for each part.
    pub(crate) fn by_value(
        &mut self,
        name: &'static str,
        title: String,
        ramp: &Ramp,
        values: &[&[f64]],
    ) {
        let parts = values.iter().map(|v| Paint::Values(self.floats(v.iter().copied()))).collect();
        let stops = Some(ramp.clone());
        self.colourings.push(Colouring { name, title, stops, classes: Vec::new(), parts });
    }

    /// Colours by classes: their names with their colours, and the class of each part. Without a title
    /// there is no legend.
    pub(crate) fn by_class(
        &mut self,
        name: &'static str,
        title: &str,
        classes: Vec<(String, Colour)>,
        parts: impl IntoIterator<Item = usize>,
    ) {
        let parts = parts.into_iter().map(Paint::Class).collect();
        self.colourings.push(Colouring {
            name,
            title: title.to_owned(),
            stops: None,
            classes,
            parts,
        });
    }

    /// Adds dots, coloured by the distances at both ends that `name` has.
    pub(crate) fn dots(
        &mut self,
        name: &'static str,
        size: u32,
        points: &[Vec3],
        ramp: &Ramp,
        values: [&[f64]; 2],
    ) {
        if !points.is_empty() {
            let title = format!("distance of the {name}");
            let points = self.places(points);
            let values = values.map(|v| self.floats(v.iter().copied()));
            self.dots.push(Dots { name, title, size, points, stops: ramp.clone(), values });
        }
    }

    /// Positions as differences from the first one, which single precision keeps.
    fn places(&mut self, points: &[Vec3]) -> Span {
        let Some(&first) = points.first() else { return [0, 0] };
        let origin = *self.origin.get_or_insert(first);
        self.floats(points.iter().flat_map(|p| <[f64; 3]>::from(p - origin)))
    }

    fn floats(&mut self, values: impl Iterator<Item = f64>) -> Span {
        self.store(values.map(|v| (v as f32).to_le_bytes()))
    }

    /// Adds numbers to the block; nothing for a page that will not hold them.
    fn store(&mut self, numbers: impl Iterator<Item = [u8; 4]>) -> Span {
        let first = self.numbers.len() / 4;
        if !self.is_too_large() {
            self.numbers.extend(numbers.flatten());
        }
        [first, self.numbers.len() / 4 - first]
    }

    /// Whether a page cannot hold it.
    fn is_too_large(&self) -> bool {
        self.triangle_count > MOST_TRIANGLES
    }

    /// The view as HTML, with all that it needs; one for each page. `still`: pictures of the same, which
    /// are there to be printed and where there is no WebGL.
    pub(crate) fn html(&self, still: &str) -> String {
        if self.is_too_large() {
            return format!(
                "<p>{} triangles are too many for a view in a page (at most {MOST_TRIANGLES}); open the \
                 result in Blender or MeshLab to turn it.</p>\n{still}",
                self.triangle_count
            );
        }
        let shapes = serde_json::to_string(self).expect("numbers and names").replace("</", "<\\/");
        let numbers = STANDARD.encode(compressed(&self.numbers));
        format!(
            "<style>{STYLE}</style>\n<figure class=\"view3d\">\
             <div class=\"stage\"><canvas tabindex=\"0\" aria-label=\"The shapes; arrow keys turn them\"></canvas></div>\
             <noscript>The view that turns needs JavaScript.</noscript>\
             <figcaption>Drag to turn, or use the arrow keys; click, then the wheel zooms; the right button shifts. \
             Point at a place for its value.</figcaption>\n\
             <script type=\"application/json\">{shapes}</script>\n\
             <script type=\"text/plain\">{numbers}</script></figure>\n\
             <details class=\"still\"><summary>Still pictures</summary>{still}</details>\n\
             <script>{SCRIPT}</script>\n"
        )
    }
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes all")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_script_ends_it_early() {
        assert!(!SCRIPT.contains("</script") && !SCRIPT.contains("<!--"));
    }

    #[test]
    fn a_name_cannot_end_the_description() {
        let mut view = View3d::new();
        view.part("</script><b>", &[[0, 1, 2]], &[&[Vec3::zeros(), Vec3::x(), Vec3::y()]]);
        assert!(view.html("").contains(r#""<\/script><b>""#));
    }

    #[test]
    fn a_surface_with_too_many_triangles_is_a_sentence() {
        let mut view = View3d::between(["a", "b"]);
        let points = [Vec3::zeros(); 3];
        view.part("all", &vec![[0, 1, 2]; MOST_TRIANGLES + 1], &[&points, &points]);
        view.by_value(
            "Stretch",
            String::new(),
            &Ramp::scaled(&[(1.0, [0.0; 3])], 1.0),
            &[&[1.0; 3]],
        );
        let html = view.html("pictures");
        assert!(html.contains("1000001 triangles are too many") && html.ends_with("pictures"));
        assert!(view.numbers.is_empty());
    }
}
