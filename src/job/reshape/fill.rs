//! The tets of a job: made from the surface, or read from a file.

use std::path::Path;

use super::spec::ReshapeJob;
use crate::error::{Error, Result};
use crate::io;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::tetrahedralize::{Method, Options, Tetrahedralization, given_tets, tetrahedralize};

/// Makes or reads the tets that `job` asks for.
pub fn fill(job: &ReshapeJob, surface: &TriMesh, run: &Run) -> Result<Tetrahedralization> {
    let how = job.tets.as_deref().unwrap_or(Path::new("auto"));
    let method = match how.to_str() {
        Some("auto") => Method::Auto,
        Some("tetgen") => Method::TetGen,
        Some("lattice") => Method::Lattice,
        _ if how.extension().is_some() => return from_file(how, surface),
        _ => {
            return Err(Error::invalid(format!(
                "tets = '{}' is not known; auto, tetgen, lattice or a tet mesh file are",
                how.display()
            )));
        }
    };
    let defaults = Options::default();
    let options = Options {
        method,
        tet_count: job.tet_count.unwrap_or(defaults.tet_count),
        tetgen_path: job.tetgen.clone(),
    };
    tetrahedralize(surface, &options, run)
}

/// Makes tets for a shape that has left those of `job`; tets from a file serve only the template.
pub fn fill_anew(job: &ReshapeJob, surface: &TriMesh, run: &Run) -> Result<Tetrahedralization> {
    let from_file = job.tets.as_deref().is_some_and(|how| how.extension().is_some());
    let tets = if from_file { None } else { job.tets.clone() };
    fill(&ReshapeJob { tets, ..job.clone() }, surface, run)
}

fn from_file(path: &Path, surface: &TriMesh) -> Result<Tetrahedralization> {
    let made_by = path.display().to_string();
    let mesh = io::read_tets(path)?;
    given_tets(mesh, surface, made_by).map_err(|e| Error::parse(path, None, e.to_string()))
}
