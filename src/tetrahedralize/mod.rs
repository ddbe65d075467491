//! From a surface to a tet mesh.

mod lattice;

use crate::error::{Error, Result};
use crate::locate::Embedding;
use crate::mesh::{TetMesh, TetQuality, TriMesh};
use crate::run::Run;

/// Fewer do not close around anything.
const MIN_TETS: usize = 24;
/// More do not fit the solvers.
const MAX_TETS: usize = 10_000_000;

/// A tet mesh that carries a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Tetrahedralization {
    /// The tets.
    pub mesh: TetMesh,
    /// Where each vertex of the surface lies in them.
    pub embedding: Embedding,
    /// Share of each tet that is inside the surface: 1 throughout when the boundary is kept, 0 for
    /// tets that only carry vertices.
    pub inside_fraction: Vec<f64>,
    /// Whether the surface's own vertices and triangles are the boundary of the tets.
    pub boundary_kept: bool,
    /// What made the tets.
    pub used: Used,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// What made a tet mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Used {
    /// The program TetGen.
    TetGen,
    /// The built-in lattice.
    Lattice,
}

impl Tetrahedralization {
    /// Volume inside the surface: the tets' volumes weighted by their inside fractions.
    pub fn inside_volume(&self) -> f64 {
        let volume = |t: usize| self.mesh.volume(t) * self.inside_fraction[t];
        (0..self.mesh.tets.len()).map(volume).sum()
    }

    /// Shapes of the tets.
    pub fn quality(&self) -> TetQuality {
        TetQuality::of_mesh(&self.mesh)
    }
}

/// How to make the tets.
#[derive(Clone, Debug)]
pub struct Options {
    /// About how many tets.
    pub tet_count: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { tet_count: 15_000 }
    }
}

/// Fills a surface with tets.
pub fn tetrahedralize(
    surface: &TriMesh,
    options: &Options,
    run: &Run,
) -> Result<Tetrahedralization> {
    if !(MIN_TETS..=MAX_TETS).contains(&options.tet_count) {
        return Err(Error::invalid(format!(
            "a tet count of {} cannot be met; ask for {MIN_TETS} to {MAX_TETS} (15000 is plenty for most organs)",
            options.tet_count
        )));
    }
    lattice::build(surface, options.tet_count, run)
}
