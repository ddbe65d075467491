//! The tets of a job: made from the surface, or read from a file.

use std::path::Path;

use super::spec::ReshapeJob;
use crate::error::{Error, Result};
use crate::io;
use crate::locate::{Embedding, WindingNumber};
use crate::mesh::{TetMesh, TriMesh};
use crate::run::Run;
use crate::tetrahedralize::{Method, Options, Used, tetrahedralize};

/// Tets that carry a surface.
#[derive(Clone, Debug)]
pub struct Filling {
    /// The tets.
    pub mesh: TetMesh,
    /// Where each vertex of the surface lies in them.
    pub embedding: Embedding,
    /// Share of each tet that is inside the surface.
    pub inside_fraction: Vec<f64>,
    /// What made them, in words.
    pub made_by: String,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// A surface vertex farther than this share of the diagonal outside a given tet mesh shows that
/// the mesh belongs to another surface.
const OUTSIDE: f64 = 0.1;

/// Makes or reads the tets that `job` asks for.
pub fn fill(job: &ReshapeJob, surface: &TriMesh, run: &Run) -> Result<Filling> {
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
    let filled = tetrahedralize(surface, &options, run)?;
    let made_by = match filled.used {
        Used::TetGen => "TetGen",
        Used::Lattice => "the lattice",
    };
    Ok(Filling {
        mesh: filled.mesh,
        embedding: filled.embedding,
        inside_fraction: filled.inside_fraction,
        made_by: made_by.to_owned(),
        warnings: filled.warnings,
    })
}

/// Makes tets for a shape that has left those of `job`; tets from a file serve only the template.
pub fn fill_anew(job: &ReshapeJob, surface: &TriMesh, run: &Run) -> Result<Filling> {
    let from_file = job.tets.as_deref().is_some_and(|how| how.extension().is_some());
    let tets = if from_file { None } else { job.tets.clone() };
    fill(&ReshapeJob { tets, ..job.clone() }, surface, run)
}

fn from_file(path: &Path, surface: &TriMesh) -> Result<Filling> {
    let made_by = path.display().to_string();
    let mesh = io::read_tets(path)?;
    fill_with(mesh, surface, made_by).map_err(|e| Error::parse(path, None, e.to_string()))
}

/// Takes tets that somebody else made; tets of another surface are an error. A tet counts as inside
/// or outside as a whole, by its centre.
pub fn fill_with(mesh: TetMesh, surface: &TriMesh, made_by: String) -> Result<Filling> {
    let embedding = Embedding::new(&mesh, &surface.points)?;
    let limit = -OUTSIDE * surface.diagonal() / mean_edge(&mesh);
    let lowest = |v: usize| embedding.weights[v].iter().copied().fold(f64::INFINITY, f64::min);
    if let Some(v) = (0..surface.points.len()).find(|&v| lowest(v) < limit) {
        return Err(Error::invalid(format!(
            "vertex {v} of the template lies far outside the tets; they belong to another surface, or to another unit"
        )));
    }
    let winding = WindingNumber::new(&surface.points, &surface.triangles);
    let centres: Vec<_> = (0..mesh.tets.len())
        .map(|t| mesh.corners(t).iter().sum::<crate::math::Vec3>() / 4.0)
        .collect();
    let inside_fraction =
        centres.iter().map(|c| if winding.at(c).abs() > 0.5 { 1.0 } else { 0.0 }).collect();
    Ok(Filling { mesh, embedding, inside_fraction, made_by, warnings: Vec::new() })
}

fn mean_edge(mesh: &TetMesh) -> f64 {
    let volume = mesh.total_volume() / mesh.tets.len().max(1) as f64;
    // A regular tet of edge a has the volume a^3 / (6 sqrt 2).
    (volume * 72_f64.sqrt()).cbrt().max(f64::MIN_POSITIVE)
}
