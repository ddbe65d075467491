//! The tets of a job: made from the surface, or read from a file.

use std::path::Path;

use super::spec::ReshapeJob;
use crate::error::{Error, Result, Shown};
use crate::io;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::tetrahedralize::{Method, Options, Tetrahedralization, given_tets, tetrahedralize};

/// Makes or reads the tets that `job` asks for.
pub fn fill(job: &ReshapeJob, surface: &TriMesh, run: &Run) -> Result<Tetrahedralization> {
    match job.tets.as_deref() {
        Some(path) if path.extension().is_some() => from_file(path, surface),
        how => tetrahedralize(surface, &Options { method: method(how)?, ..new_tets(job) }, run),
    }
}

/// How tets are made for a shape that has left those of `job`; tets from a file serve only the template.
pub fn new_tets(job: &ReshapeJob) -> Options {
    let defaults = Options::default();
    Options {
        method: method(job.tets.as_deref()).unwrap_or_default(),
        tet_count: job.tet_count.unwrap_or(defaults.tet_count),
        tetgen_path: job.tetgen.clone(),
    }
}

fn method(how: Option<&Path>) -> Result<Method> {
    let how = how.unwrap_or(Path::new("auto"));
    match how.to_str() {
        Some("auto") => Ok(Method::Auto),
        Some("tetgen") => Ok(Method::TetGen),
        Some("lattice") => Ok(Method::Lattice),
        _ => Err(Error::invalid(format!(
            "tets = '{}' is not known; auto, tetgen, lattice or a tet mesh file are",
            how.shown()
        ))),
    }
}

fn from_file(path: &Path, surface: &TriMesh) -> Result<Tetrahedralization> {
    let made_by = path.shown();
    let mesh = io::read_tets(path)?;
    given_tets(mesh, surface, made_by).map_err(|e| Error::parse(path, None, e.to_string()))
}
