//! `moulage model`: shape statistics from earlier results, and shapes made from them.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::model_file::{read_shape_model, write_shape_model};
use super::skeleton_build::document_of;
use super::skeleton_files::{SkeletonFiles, read_skeleton};
use crate::error::{Error, Result};
use crate::io::write_beside;
use crate::job::report::files::write_report;
use crate::job::report::html::{self, Column, picture, table};
use crate::job::report::picture::{View, draw};
use crate::job::report::ramp::Colour;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::register::{ShapeModel, Skeleton, left_out, same_bones, shape_in_place};
use crate::run::Run;

/// Modes with pictures in the report.
const SHOWN_MODES: usize = 4;
/// How far shapes in pictures are from the mean, standard deviations.
const SHOWN_DEVIATIONS: f64 = 2.0;

/// `moulage model fit`.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ModelFitJob {
    /// Template of all the results
    #[cfg_attr(feature = "cli", arg(value_name = "SKELETON"))]
    pub skeleton: PathBuf,
    /// Results of earlier registrations of this template: result.skeleton.json, two or more
    #[cfg_attr(feature = "cli", arg(value_name = "RESULT", required = true, num_args = 1..))]
    pub results: Vec<PathBuf>,
    /// The model: .h5.json, as scalismo reads it
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FILE"))]
    pub out: PathBuf,
    /// Folder for report.html and report.json: pictures of the modes
    #[cfg_attr(feature = "cli", arg(long, value_name = "FOLDER"))]
    pub report: Option<PathBuf>,
}

/// `moulage model shape`.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ModelShapeJob {
    /// Template of the model
    #[cfg_attr(feature = "cli", arg(value_name = "SKELETON"))]
    pub skeleton: PathBuf,
    /// The model: .h5.json
    #[cfg_attr(feature = "cli", arg(value_name = "MODEL"))]
    pub model: PathBuf,
    /// Coefficients of the first modes, in standard deviations
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "NUMBER", num_args = 1.., allow_negative_numbers = true)
    )]
    pub coefficients: Vec<f64>,
    /// Folder for the shape: bones/ and shape.skeleton.json
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER"))]
    pub out: PathBuf,
}

/// Figures of a model.
#[derive(Clone, Debug, Serialize)]
pub struct ModelReport {
    /// Version of this program.
    pub version: &'static str,
    /// The results it was learnt from.
    pub results: Vec<PathBuf>,
    /// Root mean square movement of the surface at one standard deviation, the template's unit.
    pub deviations: Vec<f64>,
    /// Share of the variance in the first modes.
    pub explained: Vec<f64>,
    /// Root mean square distance of each result from what a model of the others makes of it: how well
    /// the model fits a new person, the template's unit. Empty for two results.
    pub left_out: Vec<f64>,
}

/// Learns a model from results and writes it.
pub fn run_model_fit(job: &ModelFitJob, run: &Run) -> Result<ModelReport> {
    run.enter("reading", 0.0);
    let files = read_skeleton(&job.skeleton)?;
    let template = &files.skeleton;
    let samples =
        job.results.iter().map(|path| sample(template, path)).collect::<Result<Vec<_>>>()?;
    run.enter("principal components", 0.3);
    let model = ShapeModel::fit(template, &samples)?;
    let report = ModelReport {
        version: env!("CARGO_PKG_VERSION"),
        results: job.results.clone(),
        deviations: model.deviations(template),
        explained: model.explained(),
        left_out: left_out(template, &samples, run)?,
    };
    run.enter("writing", 0.9);
    write_shape_model(&job.out, template, &model)?;
    if let Some(folder) = &job.report {
        write_report(folder, &report, &page(&report, template, &model))?;
    }
    run.enter("done", 1.0);
    Ok(report)
}

/// The vertices of a result, if it has the template's bones.
fn sample(template: &Skeleton, path: &Path) -> Result<Vec<Vec3>> {
    let found = read_skeleton(path)?.skeleton;
    if !same_bones(template, &found) {
        return Err(Error::parse(
            path,
            None,
            "not a result of this template: its bones have other names or vertices",
        ));
    }
    Ok(found.points)
}

/// Makes a shape from a model and writes it as a skeleton in the template's pose.
pub fn run_model_shape(job: &ModelShapeJob) -> Result<PathBuf> {
    let files = read_skeleton(&job.skeleton)?;
    let template = &files.skeleton;
    let model = read_shape_model(template, &job.model)?;
    if job.coefficients.len() > model.mode_count() {
        return Err(Error::invalid(format!(
            "{} coefficients are given, but the model has {} modes",
            job.coefficients.len(),
            model.mode_count()
        )));
    }
    let shape = shape_in_place(template, &model.synthesize(&job.coefficients));
    write_shape(&job.out, &files, &shape)
}

fn write_shape(folder: &Path, files: &SkeletonFiles, shape: &Skeleton) -> Result<PathBuf> {
    let mut document = document_of(shape, &files.document);
    document.name_surfaces("bones");
    for ((bone, entry), file) in shape.bones.iter().zip(&document.bones).zip(&files.surfaces) {
        let points = &shape.points[bone.vertices.clone()];
        file.write_with_points(&folder.join(&entry.mesh), points)?;
    }
    let path = folder.join("shape.skeleton.json");
    let text = document.to_text()?;
    write_beside(&path, |out| out.write_all(text.as_bytes()))?;
    Ok(path)
}

fn page(report: &ModelReport, template: &Skeleton, model: &ShapeModel) -> String {
    let columns = [
        Column::Text("mode"),
        Column::Number("root mean square at one standard deviation"),
        Column::Number("explained so far"),
    ];
    let modes = report.deviations.iter().zip(&report.explained).enumerate();
    let rows = modes.map(|(k, (deviation, explained))| {
        let (mode, share) = ((k + 1).to_string(), format!("{:.1} %", 100.0 * explained));
        vec![mode, format!("{deviation:.3}"), share]
    });
    let mut body = vec![format!(
        "<h1>Shape model</h1>\n<p>{} bones, {} results, {} modes.</p>\n{}",
        template.bones.len(),
        report.results.len(),
        report.deviations.len(),
        table(&columns, rows)
    )];
    if !report.left_out.is_empty() {
        let mean = report.left_out.iter().sum::<f64>() / report.left_out.len() as f64;
        body.push(format!(
            "<p>Each result fitted by a model of the others: root mean square {mean:.3}.</p>\n"
        ));
    }
    body.push(format!(
        "<p>Colours: how far the surface moves outwards (red) or inwards (blue) against the mean, at \
         {SHOWN_DEVIATIONS} standard deviations.</p>\n"
    ));
    let mean = shape_in_place(template, model.mean());
    for mode in 0..model.mode_count().min(SHOWN_MODES) {
        let sides = [-SHOWN_DEVIATIONS, SHOWN_DEVIATIONS].map(|side| {
            let mut coefficients = vec![0.0; mode + 1];
            coefficients[mode] = side;
            let shape = shape_in_place(template, &model.synthesize(&coefficients));
            let png = mode_picture(template, model.mean(), &mean, &shape, &coefficients, model);
            picture(&png, &format!("mode {}, {side:+}", mode + 1))
        });
        let mode = mode + 1;
        body.push(format!("<h2>Mode {mode}</h2>\n<div class=\"grid\">{}</div>\n", sides.concat()));
    }
    html::page("shape model", "the template's", &body.concat())
}

/// A shape with the movement of each bone's surface against the mean in colours.
fn mode_picture(
    template: &Skeleton,
    mean: &[Vec3],
    frame: &Skeleton,
    shape: &Skeleton,
    coefficients: &[f64],
    model: &ShapeModel,
) -> Vec<u8> {
    let surface = TriMesh { points: mean.to_vec(), triangles: template.triangles.clone() };
    let normals = surface.vertex_normals();
    let moved = model.synthesize(coefficients);
    let outwards: Vec<f64> =
        moved.iter().zip(mean).zip(&normals).map(|((p, q), n)| (p - q).dot(n)).collect();
    let most = outwards.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    let colours: Vec<Colour> = outwards
        .iter()
        .map(|x| {
            let share = x / most;
            let fade = 0.9 * (1.0 - share.abs());
            if share > 0.0 { [0.9, fade, fade] } else { [fade, fade, 0.9] }
        })
        .collect();
    let mesh = shape.surface();
    let frame: Vec<Vec3> = frame.points.iter().chain(&shape.points).copied().collect();
    draw(&mesh, &colours, &[], &frame, View::Side)
}
