//! `report.json` and `report.html`; the page has no links to anything outside.

use std::fmt::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::plots;
use super::report::{Change, Ending, PairLine, Report, Shapes};
use crate::error::Result;
use crate::io::markup::escaped;
use crate::io::write_beside;
use crate::job::report::picture::{Colour, Dot, View, draw};
use crate::math::Vec3;
use crate::measure::Spread;
use crate::mesh::TriMesh;

const SKIN: Colour = [0.86, 0.80, 0.74];
const MARKER: Colour = [0.10, 0.30, 0.80];
const FAR_MARKER: Colour = [0.85, 0.10, 0.10];

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#1c1c22;background:#fff;\
max-width:62rem;margin:2rem auto;padding:0 1rem}h1{font-size:1.5rem}h2{font-size:1.1rem;\
margin-top:2rem}table{border-collapse:collapse}td,th{padding:.2rem .9rem .2rem 0;text-align:left;\
border-bottom:1px solid #ddd;vertical-align:top}td.n,th.n{text-align:right;\
font-variant-numeric:tabular-nums}.row{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0;width:440px;max-width:100%}\
.slices{display:grid;grid-template-columns:repeat(auto-fill,minmax(280px,1fr));gap:1rem}\
.slices figure{width:auto}figcaption{color:#555;font-size:.9rem}img,svg{max-width:100%;height:auto}.good{color:#176b2c}\
.bad{color:#a11}ul.w{background:#fff6e0;padding:.6rem 1rem .6rem 2rem}";

/// Writes `report.json` and `report.html` into `folder`.
pub fn write_report(report: &Report, shapes: &Shapes, folder: &Path) -> Result<()> {
    write_beside(&folder.join("report.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, report)?;
        writeln!(out)
    })?;
    let page = page(report, shapes);
    write_beside(&folder.join("report.html"), |out| out.write_all(page.as_bytes()))
}

fn page(report: &Report, shapes: &Shapes) -> String {
    let mut page = String::new();
    let name = report.template.file_name().unwrap_or(report.template.as_os_str());
    let name = escaped(&name.to_string_lossy());
    let (class, ending) = match report.ending {
        Ending::Good => ("good", "Done"),
        Ending::GaveUp => ("bad", "The solver gave up; this is its best shape"),
        Ending::Interrupted => ("bad", "Interrupted; this is the best shape so far"),
    };
    let mut add = |text: &str| page.push_str(text);
    add(&format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>moulage: {name}</title>\
         <style>{STYLE}</style></head><body>\n<h1>{name}</h1>\n<p class=\"{class}\"><b>{ending}.</b> {}</p>\n",
        escaped(&report.why)
    ));
    add(&warnings(&report.warnings));
    add(&figures(report));
    add(&pictures(report, shapes));
    add(&slices(report));
    add("<h2>Course</h2>\n<div class=\"row\">");
    add(&figure(
        &plots::convergence(report),
        "Distance of the markers over the iterations; where it rises, markers that were far off are \
         tried again, or attachments are pulled closer",
    ));
    add(&figure(
        &plots::objective(report),
        "The objective; it grows with the weight of markers and attachments",
    ));
    add(&figure(
        &plots::marker_histogram(report),
        "Markers by their distance; the last bar holds all beyond",
    ));
    add(&figure(&plots::dihedral_histogram(report), "Smallest dihedral angle of each tet"));
    add("</div>\n");
    add(&pairs("Landmarks", &report.landmarks));
    add(&pairs("Attachments", &report.attachments));
    add(&format!(
        "<p>moulage {}. Lengths are in the template's unit.</p></body></html>\n",
        report.version
    ));
    page
}

fn warnings(list: &[String]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let mut items = String::new();
    for warning in list {
        let _ = write!(items, "<li>{}</li>", escaped(warning));
    }
    format!("<ul class=\"w\">{items}</ul>\n")
}

/// The figures of \[W\] Table 2, and some more.
fn figures(report: &Report) -> String {
    let mut rows = String::new();
    let mut row = |name: &str, value: String| {
        let _ = write!(rows, "<tr><td>{name}</td><td>{}</td></tr>", escaped(&value));
    };
    let change = |c: &Change<Spread>| {
        format!(
            "{} / {} before, {} / {} after",
            number(c.before.mean),
            number(c.before.max),
            number(c.after.mean),
            number(c.after.max)
        )
    };
    row("Marker distance, mean / largest", change(&report.marker_distance));
    if let Some(refined) = &report.refinement {
        row(
            "Added by the image",
            format!(
                "{} markers of mean confidence {:.2}, {} mm from the first result; the user's markers were then {} / {} off",
                refined.added,
                refined.confidence.mean,
                number(refined.shift.mean),
                number(refined.marker_distance_before.mean),
                number(refined.marker_distance_before.max)
            ),
        );
    }
    if let Some(fit) = &report.label_fit {
        row("Dice with the label", format!("{:.4}", fit.dice));
        let both = |s: &Spread| format!("{} / {} mm", number(s.mean), number(s.max));
        row("Label to result, mean / largest", both(&fit.label_to_surface));
        row("Result to label, mean / largest", both(&fit.surface_to_label));
    }
    row("Template", report.template.display().to_string());
    row("Markers", report.markers.to_string());
    if report.fixed > 0 {
        row("Fixed vertices", report.fixed.to_string());
    }
    row("Tolerance", number(report.tolerance));
    row("Template vertices", report.vertices.to_string());
    row(
        "Tets",
        format!(
            "{} with {} vertices, by {}",
            report.tets, report.tet_vertices, report.tets_made_by
        ),
    );
    for remesh in &report.remeshes {
        row("Tets made anew", remesh.sentence());
    }
    row("Inverted tets", report.inverted_tets.to_string());
    let [low, high] = report.stretch_range;
    row("Principal stretches", format!("{low:.3} to {high:.3}"));
    row("Volume, result / template", format!("{:.4}", report.volume_ratio));
    row("Iterations", report.iteration_count.to_string());
    let stages: Vec<String> =
        report.stages.iter().map(|s| format!("{} {:.1}", s.name, s.seconds)).collect();
    row("Seconds", stages.join(", "));
    for path in &report.written {
        row("Written", path.display().to_string());
    }
    format!("<table>{rows}</table>\n")
}

fn pictures(report: &Report, shapes: &Shapes) -> String {
    let frame: Vec<Vec3> =
        shapes.before.iter().chain(shapes.after).chain(shapes.markers).copied().collect();
    let skin = vec![SKIN; shapes.before.len()];
    let dots = |distances: &[f64]| -> Vec<Dot> {
        let far = FAR_TOLERANCES * report.tolerance;
        let colour = |d: f64| if d > far { FAR_MARKER } else { MARKER };
        let markers = shapes.markers.iter().zip(distances);
        markers.map(|(&position, &d)| Dot { position, colour: colour(d) }).collect()
    };
    let stretch: Vec<Colour> = shapes.stretch.iter().map(|&s| stretch_colour(s)).collect();
    let rows = [
        (shapes.before, &skin, dots(&report.marker_distances.before), "Template and markers"),
        (shapes.after, &skin, dots(&report.marker_distances.after), "Result and markers"),
        (shapes.after, &stretch, Vec::new(), "Result, largest stretch: blue 0.5, grey 1, red 2"),
    ];
    let mut text = String::from("<h2>Shape</h2>\n");
    for (points, colours, dots, caption) in rows {
        let mesh = TriMesh { points: points.to_vec(), triangles: shapes.triangles.to_vec() };
        text.push_str("<div class=\"row\">");
        for (view, from) in [(View::Front, "from the front"), (View::Side, "from the right")] {
            let image = STANDARD.encode(draw(&mesh, colours, &dots, &frame, view));
            let caption = format!("{caption}; {from} (z up)");
            let image = format!("<img alt=\"{caption}\" src=\"data:image/png;base64,{image}\">");
            text.push_str(&figure(&image, &caption));
        }
        text.push_str("</div>\n");
    }
    text.push_str(
        "<p>Red markers are more than three tolerances off. Faint ones are behind.</p>\n",
    );
    text
}

/// The result on slices of the person's image.
fn slices(report: &Report) -> String {
    if report.slices.is_empty() {
        return String::new();
    }
    let mut text = String::from("<h2>On the image</h2>\n<div class=\"slices\">");
    for slice in &report.slices {
        let image = STANDARD.encode(&slice.png);
        let caption = escaped(&slice.caption);
        text.push_str(&figure(
            &format!("<img alt=\"{caption}\" src=\"data:image/png;base64,{image}\">"),
            &caption,
        ));
    }
    let label = if report.label_fit.is_some() { ", blue: label" } else { "" };
    let _ = writeln!(
        text,
        "</div>\n<p>Green: result, orange: template{label}, red: markers near the slice.</p>"
    );
    text
}

/// Markers beyond so many tolerances are drawn in red.
const FAR_TOLERANCES: f64 = 3.0;

/// Blue at 1/2, grey at 1, red at 2, logarithmic.
fn stretch_colour(stretch: f64) -> Colour {
    let along = stretch.max(f64::MIN_POSITIVE).log2().clamp(-1.0, 1.0);
    let end = if along > 0.0 { [0.85, 0.15, 0.10] } else { [0.15, 0.30, 0.85] };
    [0, 1, 2].map(|k| 0.82 + along.abs() * (end[k] - 0.82))
}

fn pairs(title: &str, list: &[PairLine]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let spread = |of: fn(&PairLine) -> f64| Spread::of(&list.iter().map(of).collect::<Vec<_>>());
    let (before, after) = (spread(|p| p.before), spread(|p| p.after));
    let mut text = format!(
        "<h2>{title}</h2>\n<p>Distance to the target, mean / largest: {} / {} before, {} / {} after.</p>\n\
         <details><summary>{} {}</summary><table><tr><th>Label</th><th class=\"n\">Before</th>\
         <th class=\"n\">After</th><th></th></tr>",
        number(before.mean),
        number(before.max),
        number(after.mean),
        number(after.max),
        list.len(),
        title.to_lowercase()
    );
    for pair in list {
        let suspect = if pair.suspect { "<span class=\"bad\">suspect</span>" } else { "" };
        let _ = write!(
            text,
            "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{suspect}</td></tr>",
            escaped(&pair.label),
            number(pair.before),
            number(pair.after)
        );
    }
    text.push_str("</table></details>\n");
    text
}

fn figure(content: &str, caption: &str) -> String {
    format!("<figure>{content}<figcaption>{caption}</figcaption></figure>\n")
}

/// Three significant digits, three decimals from 1 on.
fn number(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || v >= 1.0 => format!("{value:.3}"),
        v if v >= 1e-4 => {
            let decimals = (2.0 - v.log10().floor()) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        let written: Vec<String> = [0.0, 12.3456, 0.080_48, 0.001_234_5, 1.2e-7].map(number).into();
        assert_eq!(written, ["0.000", "12.346", "0.0805", "0.00123", "1.20e-7"]);
    }
}
