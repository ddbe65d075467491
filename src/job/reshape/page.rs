//! The report of a reshaping as a page.

use super::pictures::pictures;
use super::plots;
use super::report::{Change, Ending, PairLine, Report, Shapes};
use crate::error::Shown;
use crate::io::markup::escaped;
use crate::job::report::html::{self, Column, figure, marked, notes, number, picture, table};
use crate::job::report::stages;
use crate::measure::Spread;

/// The page of a report.
pub fn page(report: &Report, shapes: &Shapes) -> String {
    let name = report.template.file_name().unwrap_or(report.template.as_os_str());
    let name = name.to_string_lossy();
    let (class, ending) = match report.ending {
        Ending::Good => ("good", "Done"),
        Ending::GaveUp => ("failed", "The solver gave up; this is its best shape"),
        Ending::Interrupted => ("failed", "Interrupted; this is the best shape so far"),
    };
    let plots = [
        figure(
            &plots::convergence(report),
            "Distance of the markers over the iterations; where it rises, markers that were far off are \
             tried again, or attachments are pulled closer",
        ),
        figure(
            &plots::objective(report),
            "The objective; it grows with the weight of markers and attachments",
        ),
        figure(
            &plots::marker_histogram(report),
            "Markers by their distance; the last bar holds all beyond",
        ),
        figure(&plots::dihedral_histogram(report), "Smallest dihedral angle of each tet"),
    ];
    let body = [
        format!(
            "<h1>{}</h1>\n<p class=\"{class}\"><b>{ending}.</b> {}</p>\n",
            escaped(&name),
            escaped(&report.why)
        ),
        notes(&report.warnings),
        pictures(report, shapes),
        slices(report),
        format!("<h2>Figures</h2>\n{}", figures(report)),
        format!("<h2>Course</h2>\n<div class=\"row\">{}</div>\n", plots.concat()),
        pairs("Landmarks", &report.landmarks),
        pairs("Attachments", &report.attachments),
    ];
    html::page(&name, "the template's", &body.concat())
}

/// The figures of \[W\] Table 2, and some more.
fn figures(report: &Report) -> String {
    let [low, high] = report.stretch_range;
    let mut rows = fit_figures(report);
    rows.extend([("Template", report.template.shown()), ("Markers", report.markers.to_string())]);
    if report.fixed > 0 {
        rows.push(("Fixed vertices", report.fixed.to_string()));
    }
    rows.extend([
        ("Tolerance", number(report.tolerance)),
        ("Template vertices", report.vertices.to_string()),
        (
            "Tets",
            format!(
                "{} with {} vertices, by {}",
                report.tets, report.tet_vertices, report.tets_made_by
            ),
        ),
    ]);
    rows.extend(report.remeshes.iter().map(|remesh| ("Remeshed", remesh.sentence())));
    rows.extend([
        ("Inverted tets", report.inverted_tets.to_string()),
        ("Principal stretches", format!("{low:.3} to {high:.3}")),
        ("Volume, result / template", format!("{:.4}", report.volume_ratio)),
    ]);
    rows.extend(report.volume_text().map(|volume| ("Volume", volume)));
    rows.push(("Surface area", report.area.text("")));
    if let Some(deviations) = &report.deviations {
        let (across, any) = (two(&deviations.sd_normal), two(&deviations.sd));
        rows.push((
            "Standard deviation of vertices, mean / largest",
            format!(
                "{across} across the surface, {any} in all directions, by {} plausible shapes",
                deviations.samples
            ),
        ));
    }
    rows.extend([
        ("Iterations", report.iteration_count.to_string()),
        ("Seconds", stages::sentence(&report.stages)),
    ]);
    rows.extend(report.written.iter().map(|path| ("Written", path.shown())));
    let cells = rows.into_iter().map(|(name, value)| vec![name.to_owned(), escaped(&value)]);
    table(&[Column::Text(""), Column::Text("")], cells)
}

/// Mean and largest.
fn two(s: &Spread) -> String {
    format!("{} / {}", number(s.mean), number(s.max))
}

/// How well markers and label are met.
fn fit_figures(report: &Report) -> Vec<(&'static str, String)> {
    let Change { before, after } = &report.marker_distance;
    let mut rows = vec![(
        "Marker distance, mean / largest",
        format!("{} before, {} after", two(before), two(after)),
    )];
    if let Some(refined) = &report.refinement {
        let found = format!(
            "{} markers of mean confidence {:.2}, {} mm from the first result; the user's markers were then {} off",
            refined.added,
            refined.confidence.mean,
            number(refined.shift.mean),
            two(&refined.marker_distance_before)
        );
        rows.push(("Added by the image", found));
    }
    if let Some(fit) = &report.label_fit {
        rows.push(("Dice with the label", format!("{:.4}", fit.dice)));
        let mm = |s: &Spread| format!("{} mm", two(s));
        rows.push(("Label to result, mean / largest", mm(&fit.label_to_surface)));
        rows.push(("Result to label, mean / largest", mm(&fit.surface_to_label)));
    }
    rows
}

/// The result on slices of the person's image.
fn slices(report: &Report) -> String {
    if report.slices.is_empty() {
        return String::new();
    }
    let pictures = report.slices.iter().map(|slice| picture(&slice.png, &escaped(&slice.caption)));
    let label = if report.label_fit.is_some() { ", blue: label" } else { "" };
    format!(
        "<h2>On the image</h2>\n<div class=\"grid\">{}</div>\n\
         <p>Green: result, orange: template{label}, red: markers near the slice.</p>\n",
        pictures.collect::<String>()
    )
}

fn pairs(title: &str, list: &[PairLine]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let spread = |of: fn(&PairLine) -> f64| Spread::of(&list.iter().map(of).collect::<Vec<_>>());
    let (before, after) = (spread(|p| p.before), spread(|p| p.after));
    let columns = [
        Column::Text("Label"),
        Column::Number("Before"),
        Column::Number("After"),
        Column::Text(""),
    ];
    let rows = list.iter().map(|pair| {
        let suspect = if pair.suspect { marked("failed", "suspect") } else { String::new() };
        vec![escaped(&pair.label), number(pair.before), number(pair.after), suspect]
    });
    format!(
        "<h2>{title}</h2>\n<p>Distance to the target, mean / largest: {} before, {} after.</p>\n\
         <details><summary>{} {}</summary>{}</details>\n",
        two(&before),
        two(&after),
        list.len(),
        title.to_lowercase(),
        table(&columns, rows)
    )
}
