//! The files a job writes.

use std::path::{Path, PathBuf};

use super::inputs::Inputs;
use super::result::Outcome;
use super::spec::ReshapeJob;
use crate::error::{Error, Result, Shown};
use crate::fem::principal_stretches;
use crate::io::{DataArray, check_output, check_writable, stem, write_ply, write_vtu};
use crate::measure::distance_to_markers;
use crate::mesh::TriMesh;
use crate::reshape::{Reshaped, Uncertainty};

/// Refuses outputs that would come to nothing, before anything is computed.
pub(crate) fn check_places(job: &ReshapeJob) -> Result<()> {
    let places = [&job.out, &job.report, &job.tets_out, &job.ply_out, &job.samples_out];
    if places.into_iter().all(Option::is_none) {
        return Err(Error::invalid(
            "no output is named; give the result's file with -o or as out in the job",
        ));
    }
    let needed = [
        (&job.out, &["obj", "ply", "stl"][..], "-o"),
        (&job.tets_out, &["vtu"], "--tets-out"),
        (&job.ply_out, &["ply"], "--ply-out"),
    ];
    for (path, extensions, flag) in needed {
        let Some(path) = path else { continue };
        check_output(path, extensions, flag)?;
    }
    if let Some(folder) = &job.report {
        check_writable(&folder.join("report.json"))?;
    }
    if let Some(folder) = &job.samples_out {
        if job.samples == Some(0) {
            return Err(Error::invalid(
                "plausible shapes are to be written, but none are asked for; leave out either --samples 0 or --samples-out",
            ));
        }
        check_writable(&folder.join("shape"))?;
    }
    if job.carry.as_ref().is_some_and(|list| !list.is_empty()) && job.out.is_none() {
        return Err(Error::invalid(
            "meshes to carry are written beside the result; name it with -o",
        ));
    }
    let same = |a: &PathBuf, b: &PathBuf| {
        a == b || a.canonicalize().ok().is_some_and(|a| b.canonicalize().ok() == Some(a))
    };
    match (&job.out, &job.template) {
        (Some(out), Some(template)) if same(out, template) => Err(Error::invalid(format!(
            "the result would replace the template {}; give it another name",
            template.shown()
        ))),
        _ => Ok(()),
    }
}

/// Writes all that `job` asks for; returns the files.
pub(crate) fn write(job: &ReshapeJob, inputs: &Inputs, outcome: &Outcome) -> Result<Vec<PathBuf>> {
    let reshaped = &outcome.reshaped;
    let mut written = Vec::new();
    if let Some(out) = &job.out {
        inputs.template.write_with_points(out, &reshaped.surface_points)?;
        written.push(out.clone());
        written.extend(write_carried(out, inputs, reshaped)?);
    }
    if let Some(path) = &job.tets_out {
        write_deformed_tets(path, reshaped)?;
        written.push(path.clone());
    }
    if let (Some(folder), Some(uncertainty)) = (&job.samples_out, &outcome.uncertainty) {
        write_shapes(folder, job, inputs, uncertainty)?;
        written.push(folder.clone());
    }
    let in_report = job.report.as_ref().map(|folder| folder.join("result.ply"));
    for path in job.ply_out.iter().chain(&in_report) {
        write_stretch(path, inputs, outcome)?;
        written.push(path.clone());
    }
    Ok(written)
}

/// \[W\] 4.3: other meshes follow the tets they lie in; points outside follow the nearest tet.
fn write_carried(out: &Path, inputs: &Inputs, reshaped: &Reshaped) -> Result<Vec<PathBuf>> {
    let stem = stem(out);
    let mut written = Vec::new();
    for (path, file, points) in &inputs.carried {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let carried = out.with_file_name(format!("{stem}_{name}"));
        file.write_with_points(&carried, &reshaped.carry(points)?)?;
        written.push(carried);
    }
    Ok(written)
}

/// Plausible shapes, in the format of the result.
fn write_shapes(
    folder: &Path,
    job: &ReshapeJob,
    inputs: &Inputs,
    uncertainty: &Uncertainty,
) -> Result<()> {
    let out = job.out.as_ref().and_then(|out| out.extension());
    let extension = out.map_or_else(|| "obj".into(), |extension| extension.to_string_lossy());
    let shapes = (0..uncertainty.count()).map_while(|number| uncertainty.shape(number));
    for (number, points) in (1..).zip(shapes) {
        let path = folder.join(format!("shape_{number:03}.{extension}"));
        inputs.template.write_with_points(&path, &points)?;
    }
    Ok(())
}

/// The deformed tets; plastic strain and its principal stretches per tet (\[W\] Fig. 1 d, e).
pub fn write_deformed_tets(path: &Path, reshaped: &Reshaped) -> Result<()> {
    let strains = &reshaped.plastic_strain;
    let stretches: Vec<_> = strains.iter().map(principal_stretches).collect();
    let matrices: Vec<f64> =
        strains.iter().flat_map(|m| m.transpose().iter().copied().collect::<Vec<_>>()).collect();
    let principal: Vec<f64> = stretches.iter().flat_map(|s| [s[0], s[1], s[2]]).collect();
    let ratio: Vec<f64> = stretches.iter().map(|s| s[0] / s[2]).collect();
    let rest: Vec<f64> = reshaped.rest_positions()?.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let scalar = |name, values| DataArray { name, components: 1, values };
    // Corner order stays as in the rest mesh: inverted tets must not be turned around here.
    let deformed = reshaped.deformed_tets();
    write_vtu(
        path,
        &deformed,
        &[
            DataArray { name: "Fp", components: 9, values: &matrices },
            DataArray { name: "principal_stretches", components: 3, values: &principal },
            scalar("stretch_ratio", &ratio),
            scalar("inside_fraction", &reshaped.problem.inside_fraction),
        ],
        &[DataArray { name: "rest_position", components: 3, values: &rest }],
    )
}

fn write_stretch(path: &Path, inputs: &Inputs, outcome: &Outcome) -> Result<()> {
    let mesh = TriMesh {
        points: outcome.reshaped.surface_points.clone(),
        triangles: inputs.surface.triangles.clone(),
    };
    let distance = distance_to_markers(&mesh.points, &outcome.markers);
    let (largest, smallest) = &outcome.stretch;
    let mut scalars: Vec<(&str, &[f64])> =
        vec![("stretch", largest), ("stretch_min", smallest), ("marker_distance", &distance)];
    if let Some(uncertainty) = &outcome.uncertainty {
        scalars.extend([("sd_normal", &uncertainty.sd_normal[..]), ("sd", &uncertainty.sd)]);
    }
    write_ply(path, &mesh, &scalars)
}
