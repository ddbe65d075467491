//! From a surface to a tet mesh.

mod given;
mod lattice;
mod simplify;
mod tetgen;
mod weld;

use std::path::PathBuf;

pub use self::given::given_tets;
pub use self::tetgen::find as find_tetgen;
use self::weld::Welded;
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Used {
    /// The program TetGen.
    TetGen,
    /// The built-in lattice.
    Lattice,
    /// Somebody else, such as the writer of a file of this name.
    Given(String),
}

impl std::fmt::Display for Used {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::TetGen => "TetGen",
            Self::Lattice => "the lattice",
            Self::Given(name) => name,
        })
    }
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

/// Which way to make tets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// TetGen where it is found and can fill the surface, else the lattice.
    #[default]
    Auto,
    /// The program TetGen, or an error.
    TetGen,
    /// The built-in lattice.
    Lattice,
}

/// How to make the tets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Which way.
    pub method: Method,
    /// About how many tets, 24 to 10 million. TetGen makes more where the surface's triangles ask
    /// for them.
    pub tet_count: usize,
    /// The program TetGen; None: the environment variable `MOULAGE_TETGEN`, else the search path.
    pub tetgen_path: Option<PathBuf>,
}

impl Default for Options {
    fn default() -> Self {
        Self { method: Method::Auto, tet_count: 15_000, tetgen_path: None }
    }
}

/// Fills a surface with tets that carry all its vertices.
///
/// Vertices at exactly the same place are taken as one. Fails for a surface without area, for a
/// count out of range, and with [`Method::TetGen`] where TetGen is missing or fails.
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
    let welded = Welded::new(surface);
    let mut result = match options.method {
        Method::Lattice => lattice::build(&welded.mesh, options.tet_count, run)?,
        Method::TetGen => with_tetgen(&welded, options, run)?,
        Method::Auto => with_any(&welded, options, run)?,
    };
    result.embedding = unwelded(&result, surface, &welded)?;
    Ok(result)
}

fn with_tetgen(surface: &Welded, options: &Options, run: &Run) -> Result<Tetrahedralization> {
    match tetgen::find(options.tetgen_path.as_deref())? {
        Some(program) => tetgen::build(&program, surface, options.tet_count, run),
        None => Err(Error::Unsupported(
            "TetGen was not found; install it, name it with MOULAGE_TETGEN, or use the lattice"
                .into(),
        )),
    }
}

fn with_any(surface: &Welded, options: &Options, run: &Run) -> Result<Tetrahedralization> {
    let Some(program) = tetgen::find(options.tetgen_path.as_deref())? else {
        return lattice::build(&surface.mesh, options.tet_count, run);
    };
    match tetgen::build(&program, surface, options.tet_count, run) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(failure) => {
            let mut result = lattice::build(&surface.mesh, options.tet_count, run)?;
            result.warnings.insert(0, format!("the lattice is used instead of TetGen: {failure}"));
            Ok(result)
        }
        result => result,
    }
}

/// The embedding of the original vertices; those that no triangle uses go with the nearest tet.
fn unwelded(result: &Tetrahedralization, surface: &TriMesh, welded: &Welded) -> Result<Embedding> {
    let of_welded = &result.embedding;
    let tets: Vec<Option<u32>> =
        welded.vertex_of.iter().map(|v| v.map(|v| of_welded.tets[v as usize])).collect();
    let mut embedding = Embedding::in_known_tets(&result.mesh, &surface.points, &tets)?;
    // Exact weights (a vertex of the tet mesh) stay exact.
    for (i, v) in welded.vertex_of.iter().enumerate() {
        if let Some(v) = v {
            embedding.weights[i] = of_welded.weights[*v as usize];
        }
    }
    Ok(embedding)
}
