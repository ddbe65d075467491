//! What a batch came to: `table.csv`, `index.html`, and statistics over results that share vertices.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::case::{Case, Status};
use crate::align::ShapeStatistics;
use crate::error::{Error, Result};
use crate::io::markup::escaped;
use crate::io::stem;
use crate::io::{SurfaceFile, read_surface, write_beside};
use crate::job::report::html::{self, Column, marked, picture};
use crate::job::report::picture::{View, draw};
use crate::job::report::ramp::SKIN;
use crate::mesh::TriMesh;

/// Modes that are drawn and written as surfaces.
const MODES: usize = 3;
/// Standard deviations of the drawn shapes.
const DEVIATIONS: f64 = 2.0;

/// Statistics of one surface over the cases.
struct Group {
    name: String,
    cases: Vec<String>,
    file: SurfaceFile,
    triangles: Vec<[u32; 3]>,
    found: ShapeStatistics,
}

/// Writes all into `folder`.
pub(crate) fn write(folder: &Path, cases: &[Case]) -> Result<()> {
    let table = table(cases)?;
    write_beside(&folder.join("table.csv"), |out| out.write_all(&table))?;
    let groups = groups(folder, cases)?;
    for group in &groups {
        write_group(&folder.join("statistics").join(&group.name), group)?;
    }
    let page = page(cases, &groups);
    write_beside(&folder.join("index.html"), |out| out.write_all(page.as_bytes()))
}

/// All figures that any case has.
fn figure_names(cases: &[Case]) -> Vec<&str> {
    let all: BTreeSet<&str> =
        cases.iter().flat_map(|c| c.record.figures.keys().map(String::as_str)).collect();
    all.into_iter().collect()
}

/// One row per case. Seconds are left out, so that equal results give equal tables.
fn table(cases: &[Case]) -> Result<Vec<u8>> {
    let failed = |e: csv::Error| Error::invalid(format!("the table cannot be written: {e}"));
    let figures = figure_names(cases);
    let mut out = csv::Writer::from_writer(Vec::new());
    let head = ["case", "status"].into_iter().chain(figures.iter().copied()).chain(["message"]);
    out.write_record(head).map_err(failed)?;
    for Case { record, .. } in cases {
        let mut row = vec![record.name.clone(), record.status.name().to_owned()];
        row.extend(
            figures
                .iter()
                .map(|f| record.figures.get(*f).map_or(String::new(), |v| format!("{v:.6}"))),
        );
        row.push(record.message.clone());
        out.write_record(row).map_err(failed)?;
    }
    out.into_inner().map_err(|e| Error::invalid(format!("the table cannot be written: {e}")))
}

/// Surfaces of the same name and the same triangles, of two or more cases.
fn groups(folder: &Path, cases: &[Case]) -> Result<Vec<Group>> {
    let with_result = || cases.iter().filter(|c| c.record.status != Status::Failed);
    let names: BTreeSet<&PathBuf> = with_result().flat_map(|c| &c.record.surfaces).collect();
    let mut groups = Vec::new();
    for name in names {
        let mut members: Vec<(String, SurfaceFile, TriMesh)> = Vec::new();
        for Case { record, .. } in with_result().filter(|c| c.record.surfaces.contains(name)) {
            let file = read_surface(&folder.join(&record.name).join(name))?;
            let mesh = file.mesh()?;
            // Other templates than the first one's are not comparable.
            let same = members.first().is_none_or(|m| {
                m.2.triangles == mesh.triangles && m.2.points.len() == mesh.points.len()
            });
            if same {
                members.push((record.name.clone(), file, mesh));
            }
        }
        if members.len() < 2 {
            continue;
        }
        let shapes: Vec<_> = members.iter().map(|m| m.2.points.clone()).collect();
        let cases = members.iter().map(|m| m.0.clone()).collect();
        let (_, file, mesh) = members.swap_remove(0);
        groups.push(Group {
            name: stem(name),
            cases,
            file,
            triangles: mesh.triangles,
            found: ShapeStatistics::of(&shapes)?,
        });
    }
    Ok(groups)
}

fn write_group(folder: &Path, group: &Group) -> Result<()> {
    let Group { found, file, .. } = group;
    file.write_with_points(&folder.join("mean.obj"), &found.mean)?;
    for mode in 0..found.modes.len().min(MODES) {
        for (sign, word) in [(-1.0, "minus"), (1.0, "plus")] {
            let path = folder.join(format!("mode_{}_{word}.obj", mode + 1));
            file.write_with_points(&path, &found.along(mode, sign * DEVIATIONS))?;
        }
    }
    write_beside(&folder.join("modes.csv"), |out| {
        writeln!(out, "mode,share,rms_move")?;
        for (k, (share, moves)) in found.shares.iter().zip(&found.modes).enumerate() {
            let squares: f64 = moves.iter().map(nalgebra::Matrix::norm_squared).sum();
            writeln!(out, "{},{share:.6},{:.6}", k + 1, (squares / moves.len() as f64).sqrt())?;
        }
        Ok(())
    })?;
    write_beside(&folder.join("scores.csv"), |out| {
        write!(out, "case")?;
        (1..=found.modes.len()).try_for_each(|k| write!(out, ",mode_{k}"))?;
        writeln!(out)?;
        for (case, scores) in group.cases.iter().zip(&found.scores) {
            write!(out, "{case}")?;
            scores.iter().try_for_each(|s| write!(out, ",{s:.6}"))?;
            writeln!(out)?;
        }
        Ok(())
    })
}

fn page(cases: &[Case], groups: &[Group]) -> String {
    let count = |wanted: Status| cases.iter().filter(|c| c.record.status == wanted).count();
    let names = figure_names(cases);
    let heads: Vec<String> = names.iter().map(|name| name.replace('_', " ")).collect();
    let mut columns = vec![Column::Text("case"), Column::Text("status")];
    columns.extend(heads.iter().map(|head| Column::Number(head)));
    columns.extend([Column::Number("s"), Column::Text("what to know")]);
    let row = |Case { record, kept }: &Case| {
        let name = escaped(&record.name);
        let word = record.status.name();
        let link = match record.status {
            Status::Failed => name,
            _ => format!("<a href=\"{name}/report/report.html\">{name}</a>"),
        };
        let kept = if *kept { ", kept" } else { "" };
        let figure = |name: &&str| record.figures.get(*name).map_or_else(String::new, number);
        let mut row = vec![link, marked(word, &format!("{word}{kept}"))];
        row.extend(names.iter().map(figure));
        row.extend([format!("{:.1}", record.seconds), escaped(&record.message)]);
        row
    };
    let body = format!(
        "<h1>{} cases: {} good, {} doubtful, {} failed</h1>\n{}{}",
        cases.len(),
        count(Status::Good),
        count(Status::Doubtful),
        count(Status::Failed),
        html::table(&columns, cases.iter().map(row)),
        groups.iter().map(statistics).collect::<String>()
    );
    html::page("batch", "the templates'", &body)
}

fn statistics(group: &Group) -> String {
    let found = &group.found;
    let name = escaped(&group.name);
    let mut shapes = vec![("mean".to_owned(), found.mean.clone())];
    for mode in 0..found.modes.len().min(MODES) {
        let share = 100.0 * found.shares[mode];
        for (sign, word) in [(-1.0, "&minus;"), (1.0, "+")] {
            let caption =
                format!("mode {}, {word}{DEVIATIONS} ({share:.0} % of the variance)", mode + 1);
            shapes.push((caption, found.along(mode, sign * DEVIATIONS)));
        }
    }
    let frame: Vec<_> = shapes.iter().flat_map(|s| s.1.iter().copied()).collect();
    let pictures = shapes.into_iter().map(|(caption, points)| {
        let colours = vec![SKIN; points.len()];
        let mesh = TriMesh { points, triangles: group.triangles.clone() };
        picture(&draw(&mesh, &colours, &[], &frame, View::Front), &caption)
    });
    format!(
        "<h2>{name} over {} cases</h2>\n<p>Mean shape and the first modes at {DEVIATIONS} standard deviations, rotation and shift \
         removed. Files: statistics/{name}/.</p>\n<div class=\"grid\">{}</div>\n",
        group.cases.len(),
        pictures.collect::<String>()
    )
}

/// Counts without decimals.
fn number(value: &f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.4}") }
}
