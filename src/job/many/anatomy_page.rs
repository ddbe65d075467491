//! The page of a job with many objects.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::anatomy_report::{AnatomyReport, ObjectLine};
use super::case::Status;
use crate::error::Result;
use crate::io::markup::escaped;
use crate::io::read_surface;
use crate::job::report::picture::{Colour, View, draw};
use crate::job::separate::SeparationReport;
use crate::measure::Spread;
use crate::mesh::TriMesh;

const BONE: Colour = [0.88, 0.86, 0.80];
/// Colours of objects, one after the other.
const PALETTE: [Colour; 8] = [
    [0.80, 0.36, 0.34],
    [0.36, 0.55, 0.80],
    [0.45, 0.68, 0.40],
    [0.85, 0.62, 0.28],
    [0.60, 0.45, 0.75],
    [0.35, 0.68, 0.66],
    [0.80, 0.50, 0.65],
    [0.58, 0.52, 0.38],
];

/// The page, which shows the surfaces in `out` and the bones.
pub(crate) fn page(report: &AnatomyReport, out: &Path, bones: &[PathBuf]) -> Result<String> {
    let bones = bones.iter().map(|p| read_surface(p)?.mesh()).collect::<Result<Vec<_>>>()?;
    let mut surfaces = Vec::new();
    for (k, object) in report.objects.iter().enumerate() {
        if let Some(path) = &object.surface {
            surfaces.push((read_surface(&out.join(path))?.mesh()?, PALETTE[k % PALETTE.len()]));
        }
    }
    let mut html = String::from(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>moulage: anatomy</title>\
         <style>body{font:15px/1.45 system-ui,sans-serif;max-width:80rem;margin:2rem auto;padding:0 1rem}\
         table{border-collapse:collapse}td,th{padding:.2rem .9rem .2rem 0;text-align:left;border-bottom:1px solid #ddd}\
         td:first-child,td.n{white-space:nowrap}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}img{width:440px;max-width:100%}\
         .bad{color:#a11}.doubtful{color:#955b00}.good{color:#176b2c}ul{background:#fff6e0;padding:.6rem 1rem .6rem 2rem}\
         i.c{display:inline-block;width:.8em;height:.8em;margin-right:.5em}</style></head><body>\n",
    );
    let seconds: f64 = report.stages.iter().map(|s| s.seconds).sum();
    let _ = writeln!(
        html,
        "<h1>{} objects, {} bones</h1>\n{}\n<p>{seconds:.0} seconds: {}.</p>",
        report.objects.len(),
        report.bones.len(),
        verdict(report),
        report
            .stages
            .iter()
            .map(|s| format!("{} {:.1}", s.name, s.seconds))
            .collect::<Vec<_>>()
            .join(", ")
    );
    let mut notes = report.warnings.clone();
    for object in &report.objects {
        let warnings = object.figures.iter().flat_map(|f| &f.warnings);
        notes.extend(warnings.map(|warning| format!("{}: {warning}", object.name)));
    }
    if !notes.is_empty() {
        html.push_str("<ul>");
        for note in &notes {
            let _ = write!(html, "<li>{}</li>", escaped(note));
        }
        html.push_str("</ul>\n");
    }
    html.push_str(&pictures(&surfaces, &bones));
    html.push_str(&objects(report));
    if let Some(separation) = &report.separation {
        html.push_str(&separated(separation));
    }
    let _ = writeln!(
        html,
        "<p>moulage {}. Lengths are in the templates' unit.</p></body></html>",
        report.version
    );
    Ok(html)
}

fn verdict(report: &AnatomyReport) -> String {
    let [good, doubtful, failed] =
        [Status::Good, Status::Doubtful, Status::Failed].map(|status| report.count(status));
    let open = report.objects.len() - good - doubtful - failed;
    let mut text = if good == report.objects.len() {
        "<p class=\"good\">Every object was solved.</p>".to_owned()
    } else {
        let stopped = if report.interrupted { " The run was stopped." } else { "" };
        format!(
            "<p class=\"bad\">{good} objects are good, {doubtful} doubtful, {failed} failed, {open} not done.{stopped}</p>"
        )
    };
    text.push_str(match &report.separation {
        Some(s) if s.separated => {
            "<p class=\"good\">No triangle of one surface crosses or lies inside another.</p>"
        }
        Some(_) => "<p class=\"bad\">Some overlaps are left.</p>",
        None => "<p>Overlaps were not looked at.</p>",
    });
    text
}

fn pictures(surfaces: &[(TriMesh, Colour)], bones: &[TriMesh]) -> String {
    let (mut points, mut triangles, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    let coloured = surfaces.iter().map(|(surface, colour)| (surface, *colour));
    for (surface, colour) in bones.iter().map(|s| (s, BONE)).chain(coloured) {
        let first = points.len() as u32;
        points.extend_from_slice(&surface.points);
        triangles.extend(surface.triangles.iter().map(|t| t.map(|v| first + v)));
        colours.resize(points.len(), colour);
    }
    let mesh = TriMesh { points, triangles };
    let mut html = String::new();
    for (view, from) in [(View::Front, "from the front"), (View::Side, "from the right")] {
        let png = STANDARD.encode(draw(&mesh, &colours, &[], &mesh.points, view));
        let _ = write!(html, "<img alt=\"objects {from}\" src=\"data:image/png;base64,{png}\">");
    }
    html
}

fn objects(report: &AnatomyReport) -> String {
    let mut html = String::from(
        "<h2>Objects</h2><table><tr><th>object<th>status<th class=n>markers<th class=n>mean, largest before<th class=n>after\
         <th class=n>attachments<th class=n>mean, largest<th class=n>tets<th class=n>inverted<th class=n>s<th>what to know</tr>",
    );
    for (k, o) in report.objects.iter().enumerate() {
        html.push_str(&object(o, PALETTE[k % PALETTE.len()]));
    }
    html.push_str("</table>\n");
    html
}

fn object(o: &ObjectLine, colour: Colour) -> String {
    let [r, g, b] = colour.map(|c| (255.0 * c) as u8);
    let (class, word) = match o.status {
        Some(Status::Good) => ("good", "good"),
        Some(Status::Doubtful) => ("doubtful", "doubtful"),
        Some(Status::Failed) => ("bad", "failed"),
        None => ("bad", "not done"),
    };
    let name = escaped(&o.name);
    let kept = if o.kept { ", kept" } else { "" };
    let mut row = format!("<tr><td><i class=c style=\"background:rgb({r},{g},{b})\"></i>");
    let _ = match &o.figures {
        None => write!(row, "{name}<td class={class}>{word}{kept}<td colspan=7>"),
        Some(f) => {
            let attached: Vec<f64> = f.attachments.iter().map(|a| a.after).collect();
            write!(
                row,
                "<a href=\"objects/{name}/report/report.html\">{name}</a><td class={class}>{word}{kept}<td class=n>{}\
                 <td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}",
                f.markers,
                two(&f.marker_distance.before),
                two(&f.marker_distance.after),
                attached.len(),
                two(&Spread::of(&attached)),
                f.tets,
                f.inverted_tets
            )
        }
    };
    let _ = writeln!(row, "<td class=n>{:.1}<td>{}</tr>", o.seconds, escaped(&o.message));
    row
}

fn two(s: &Spread) -> String {
    format!("{:.3}, {:.3}", s.mean, s.max)
}

fn separated(separation: &SeparationReport) -> String {
    let mut html = format!(
        "<h2>Separation</h2><p>{} rounds, {:.1} s.</p><table><tr><th>between<th class=n>depth before<th class=n>after\
         <th class=n>crossing triangles before<th class=n>after</tr>",
        separation.rounds, separation.seconds
    );
    for line in &separation.overlaps {
        let [a, b] = &line.between;
        let _ = write!(
            html,
            "<tr><td>{} and {}<td class=n>{:.3}<td class=n>{:.3}<td class=n>{}<td class=n>{}</tr>",
            escaped(a),
            escaped(b),
            line.depth[0],
            line.depth[1],
            line.crossings[0],
            line.crossings[1]
        );
    }
    html.push_str(
        "</table><table><tr><th>object<th class=n>vertices moved<th class=n>farthest\
         <th class=n>inverted tets<th class=n>markers before, mean, largest<th class=n>after\
         <th class=n>markers inside bones</tr>",
    );
    for body in &separation.bodies {
        let two = |s: Option<&Spread>| s.map_or_else(String::new, two);
        let [before, after] = [0, 1].map(|k| body.marker_distance.as_ref().map(|d| &d[k]));
        let _ = write!(
            html,
            "<tr><td>{}<td class=n>{} of {}<td class=n>{:.3}<td class=n>{}<td class=n>{}<td class=n>{}<td class=n>{}</tr>",
            escaped(&body.name),
            body.moved,
            body.vertices,
            body.largest_move,
            body.inverted_tets,
            two(before),
            two(after),
            body.contradicting_markers.len()
        );
    }
    html.push_str("</table>\n");
    html
}
