//! The page of a job with many objects.

use std::path::{Path, PathBuf};

use super::anatomy_report::{AnatomyReport, ObjectLine};
use super::case::Status;
use crate::error::Result;
use crate::io::markup::escaped;
use crate::io::{read_surface, stem};
use crate::job::report::html::{self, Column, image, marked, notes, table};
use crate::job::report::picture::{View, draw};
use crate::job::report::ramp::{Colour, DOUBTFUL, FAILED};
use crate::job::report::stages;
use crate::job::report::view3d::View3d;
use crate::job::separate::SeparationReport;
use crate::measure::Spread;
use crate::mesh::TriMesh;
use crate::separate::{MovedBody, OverlapLine};

const BONE: Colour = [0.88, 0.86, 0.80];
/// Colours of what is good, doubtful and failed.
const VERDICTS: [Colour; 3] = [[0.45, 0.68, 0.40], DOUBTFUL, FAILED];
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
    let mut shown = Vec::new();
    for path in bones {
        let mesh = read_surface(path)?.mesh()?;
        shown.push(Shown { name: stem(path), mesh, colour: BONE, status: None });
    }
    for (k, object) in report.objects.iter().enumerate() {
        if let Some(path) = &object.surface {
            let mesh = read_surface(&out.join(path))?.mesh()?;
            let (name, colour) = (object.name.clone(), PALETTE[k % PALETTE.len()]);
            shown.push(Shown { name, mesh, colour, status: object.status });
        }
    }
    let mut known = report.warnings.clone();
    for object in &report.objects {
        let warnings = object.figures.iter().flat_map(|f| &f.warnings);
        known.extend(warnings.map(|warning| format!("{}: {warning}", object.name)));
    }
    let body = [
        format!("<h1>{} objects, {} bones</h1>\n", report.objects.len(), report.bones.len()),
        verdict(report),
        format!(
            "<p>{:.0} seconds: {}.</p>\n",
            report.stages.iter().map(|s| s.seconds).sum::<f64>(),
            stages::sentence(&report.stages)
        ),
        notes(&known),
        pictures(&shown),
        objects(report),
        report.separation.as_ref().map_or_else(String::new, separated),
    ];
    Ok(html::page("anatomy", "the templates'", &body.concat()))
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
            "<p class=\"failed\">{good} objects are good, {doubtful} doubtful, {failed} failed, {open} not done.{stopped}</p>"
        )
    };
    text.push_str(match &report.separation {
        Some(s) if s.summary.separated => {
            "<p class=\"good\">No triangle of one surface crosses or lies inside another.</p>"
        }
        Some(_) => "<p class=\"failed\">Some overlaps are left.</p>",
        None => "<p>Overlaps were not looked at.</p>",
    });
    text
}

/// A surface on the page.
struct Shown {
    name: String,
    mesh: TriMesh,
    colour: Colour,
    /// Of an object; a bone has none.
    status: Option<Status>,
}

fn pictures(shown: &[Shown]) -> String {
    format!("<h2>Shape</h2>\n{}", turning(shown).html(&still(shown)))
}

fn turning(shown: &[Shown]) -> View3d {
    let mut view = View3d::new();
    for Shown { name, mesh, .. } in shown {
        view.part(name, &mesh.triangles, &[&mesh.points]);
    }
    let names = shown.iter().map(|s| (s.name.clone(), s.colour)).collect();
    view.by_class("Objects", "", names, 0..shown.len());
    let verdicts = [Status::Good, Status::Doubtful, Status::Failed];
    let mut classes = vec![("bone".to_owned(), BONE)];
    classes.extend(verdicts.iter().zip(VERDICTS).map(|(s, colour)| (s.name().to_owned(), colour)));
    let class = |s: &Shown| verdicts.iter().position(|v| Some(*v) == s.status).map_or(0, |v| v + 1);
    view.by_class("Verdict", "verdict", classes, shown.iter().map(class));
    view
}

fn still(shown: &[Shown]) -> String {
    let (mut mesh, mut colours) = (TriMesh::default(), Vec::new());
    for surface in shown {
        mesh.append(&surface.mesh);
        colours.resize(mesh.points.len(), surface.colour);
    }
    let views = [(View::Front, "objects from the front"), (View::Side, "objects from the right")];
    views.map(|(view, alt)| image(&draw(&mesh, &colours, &[], &mesh.points, view), alt)).concat()
}

fn objects(report: &AnatomyReport) -> String {
    let columns = [
        Column::Text("object"),
        Column::Text("status"),
        Column::Number("markers"),
        Column::Number("mean, largest before"),
        Column::Number("after"),
        Column::Number("attachments"),
        Column::Number("mean, largest"),
        Column::Number("tets"),
        Column::Number("inverted"),
        Column::Number("s"),
        Column::Text("what to know"),
    ];
    let rows = report.objects.iter().enumerate();
    let rows = rows.map(|(k, o)| object(o, PALETTE[k % PALETTE.len()]));
    format!("<h2>Objects</h2>\n{}", table(&columns, rows))
}

fn object(o: &ObjectLine, colour: Colour) -> Vec<String> {
    let [r, g, b] = colour.map(|c| (255.0 * c) as u8);
    let (class, word) =
        o.status.map_or(("failed", "not done"), |status| (status.name(), status.name()));
    let name = escaped(&o.name);
    let kept = if o.kept { ", kept" } else { "" };
    let mut figures = vec![String::new(); 7];
    let mut link = name.clone();
    if let Some(f) = &o.figures {
        let attached: Vec<f64> = f.attachments.iter().map(|a| a.after).collect();
        figures = vec![
            f.markers.to_string(),
            two(&f.marker_distance.before),
            two(&f.marker_distance.after),
            attached.len().to_string(),
            two(&Spread::of(&attached)),
            f.tets.to_string(),
            f.inverted_tets.to_string(),
        ];
        link = format!("<a href=\"objects/{name}/report/report.html\">{name}</a>");
    }
    let mut row = vec![
        format!("<i class=\"colour\" style=\"background:rgb({r},{g},{b})\"></i>{link}"),
        marked(class, &format!("{word}{kept}")),
    ];
    row.extend(figures);
    row.extend([format!("{:.1}", o.seconds), escaped(&o.message)]);
    row
}

fn two(s: &Spread) -> String {
    format!("{:.3}, {:.3}", s.mean, s.max)
}

fn separated(separation: &SeparationReport) -> String {
    let columns = [
        Column::Text("between"),
        Column::Number("depth before"),
        Column::Number("after"),
        Column::Number("crossing triangles before"),
        Column::Number("after"),
    ];
    let overlap = |line: &OverlapLine| {
        let mut row = vec![line.between.each_ref().map(|name| escaped(name)).join(" and ")];
        row.extend(line.depth.map(|depth| format!("{depth:.3}")));
        row.extend(line.crossings.map(|count| count.to_string()));
        row
    };
    let overlaps = table(&columns, separation.summary.overlaps.iter().map(overlap));
    let columns = [
        Column::Text("object"),
        Column::Number("vertices moved"),
        Column::Number("farthest"),
        Column::Number("inverted tets"),
        Column::Number("markers before, mean, largest"),
        Column::Number("after"),
        Column::Number("markers inside bones"),
    ];
    let body = |body: &MovedBody| {
        let markers =
            |k: usize| body.marker_distance.as_ref().map_or_else(String::new, |d| two(&d[k]));
        vec![
            escaped(&body.name),
            format!("{} of {}", body.moved, body.vertices),
            format!("{:.3}", body.largest_move),
            body.inverted_tets.to_string(),
            markers(0),
            markers(1),
            body.contradicting_markers.len().to_string(),
        ]
    };
    format!(
        "<h2>Separation</h2>\n<p>{} rounds, {:.1} s.</p>\n{overlaps}{}",
        separation.summary.rounds,
        separation.seconds,
        table(&columns, separation.summary.bodies.iter().map(body))
    )
}
