//! `moulage tetrahedralize`.

use std::path::PathBuf;
use std::process::ExitCode;

use moulage::error::Shown;
use moulage::io::{DataArray, read_surface, write_vtu};
use moulage::job::{ReshapeJob, fill};
use moulage::mesh::TetQuality;
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

#[derive(clap::Args)]
pub struct Arguments {
    /// Surface to fill: .obj, .ply or .stl
    #[arg(value_name = "SURFACE")]
    surface: PathBuf,
    /// The tets, with the share of each that is inside the surface: .vtu
    #[arg(short, long, value_name = "FILE.vtu")]
    out: PathBuf,
    /// auto, tetgen or lattice [default: auto]
    #[arg(long, value_name = "HOW")]
    tets: Option<PathBuf>,
    /// About how many tets [default: 15000]
    #[arg(long, value_name = "N")]
    tet_count: Option<usize>,
    /// The program TetGen [default: $MOULAGE_TETGEN, else the search path]
    #[arg(long, value_name = "FILE")]
    tetgen: Option<PathBuf>,
}

/// Fills one surface.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let surface = read_surface(&arguments.surface)?.mesh()?;
    let job = ReshapeJob {
        tets: arguments.tets.clone(),
        tet_count: arguments.tet_count,
        tetgen: arguments.tetgen.clone(),
        ..ReshapeJob::default()
    };
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let filled = fill(&job, &surface, &run);
    drop(progress);
    let filled = filled?;
    let inside =
        DataArray { name: "inside_fraction", components: 1, values: &filled.inside_fraction };
    write_vtu(&arguments.out, &filled.mesh, &[inside], &[])?;
    for warning in &filled.warnings {
        eprintln!("note: {warning}");
    }
    println!("by {}: {}", filled.used, TetQuality::of_mesh(&filled.mesh));
    println!("written: {}", arguments.out.shown());
    Ok(ExitCode::SUCCESS)
}
