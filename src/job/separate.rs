//! One separation from files to files.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::io::stem;
use crate::io::{
    DataArray, SurfaceFile, check_writable, read_markers, read_surface, read_tets, write_json,
    write_ply, write_vtu,
};
use crate::mesh::{TetMesh, TriMesh};
use crate::run::Run;
use crate::separate::{Body, Obstacle, Options, Separation, Summary, separate};

/// All that describes one separation; also the flags of the command line. Lengths are in the
/// bodies' unit.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SeparateJob {
    /// Bodies in their present shape: .vtu (as `reshape --tets-out` writes them), .veg, .msh, .node
    #[cfg_attr(feature = "cli", arg(value_name = "BODY.vtu", required = true))]
    pub bodies: Vec<PathBuf>,
    /// Their surfaces, in the same order: .obj, .ply or .stl [default: the tets' boundaries]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub surfaces: Vec<PathBuf>,
    /// Bones and other things that do not move: .obj, .ply or .stl
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub fixed: Vec<PathBuf>,
    /// The bodies' markers, in the same order; surfaces are held where markers are met
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub markers: Vec<PathBuf>,
    /// Distance to leave between surfaces [default: the median diagonal of the bodies / 2000]
    #[cfg_attr(feature = "cli", arg(long, value_name = "LENGTH"))]
    pub gap: Option<f64>,
    /// Vertices up to this many edges away from an overlap may move [default: 5]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    pub rings: Option<usize>,
    /// Folder for the results: NAME.vtu and the surface of each body, separation.json
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER"))]
    pub out: PathBuf,
}

/// What a separation did. Lengths in the bodies' unit.
#[derive(Clone, Debug, Serialize)]
pub struct SeparationReport {
    /// Version of moulage.
    pub version: &'static str,
    /// All figures.
    #[serde(flatten)]
    pub summary: Summary,
    /// Seconds it took.
    pub seconds: f64,
    /// Files written.
    pub written: Vec<PathBuf>,
}

/// Where one body is read.
pub(crate) struct BodyFiles {
    /// Its name.
    pub name: String,
    /// Its tets in their present shape.
    pub tets: PathBuf,
    /// Its surface; the tets' boundary if there is none.
    pub surface: Option<PathBuf>,
    /// File name for its surface in the new shape.
    pub surface_name: Option<String>,
    /// Its markers.
    pub markers: Vec<PathBuf>,
}

/// Reads, separates and writes.
pub fn run_separate(job: &SeparateJob, run: &Run) -> Result<SeparationReport> {
    check_counts(job)?;
    let bodies: Vec<BodyFiles> = job
        .bodies
        .iter()
        .enumerate()
        .map(|(b, tets)| BodyFiles {
            name: stem(tets),
            tets: tets.clone(),
            surface: job.surfaces.get(b).cloned(),
            surface_name: (job.surfaces.get(b).and_then(|p| p.file_name()))
                .map(|name| name.to_string_lossy().into_owned()),
            markers: job.markers.get(b).cloned().into_iter().collect(),
        })
        .collect();
    let mut options = Options { gap: job.gap, ..Options::default() };
    options.rings = job.rings.unwrap_or(options.rings);
    separate_files(&bodies, &job.fixed, &options, &job.out, run)
}

/// The same for bodies whose files are listed.
pub(crate) fn separate_files(
    bodies: &[BodyFiles],
    fixed: &[PathBuf],
    options: &Options,
    out: &Path,
    run: &Run,
) -> Result<SeparationReport> {
    let started = std::time::Instant::now();
    run.enter("reading", 0.0);
    let files = bodies;
    let surfaces = files
        .iter()
        .map(|f| f.surface.as_deref().map(read_surface).transpose())
        .collect::<Result<Vec<_>>>()?;
    let bodies: Vec<Body> = files
        .iter()
        .zip(&surfaces)
        .map(|(files, surface)| read_body(files, surface.as_ref()))
        .collect::<Result<_>>()?;
    let obstacles = read_obstacles(fixed)?;
    check_names(&bodies)?;
    check_writable(&out.join("separation.json"))?;
    let separation = separate(&bodies, &obstacles, options, run)?;
    run.enter("writing", 1.0);
    let mut written = Vec::new();
    for (b, body) in bodies.iter().enumerate() {
        let surface = surfaces[b].as_ref().zip(files[b].surface_name.as_deref());
        written.extend(write_body(out, body, surface, b, &separation)?);
    }
    let path = out.join("separation.json");
    written.push(path.clone());
    let report = SeparationReport {
        version: env!("CARGO_PKG_VERSION"),
        summary: Summary::new(&bodies, &obstacles, &separation),
        seconds: started.elapsed().as_secs_f64(),
        written,
    };
    write_json(&path, &report)?;
    Ok(report)
}

fn check_counts(job: &SeparateJob) -> Result<()> {
    for (list, what) in [(&job.surfaces, "surfaces"), (&job.markers, "marker files")] {
        if !list.is_empty() && list.len() != job.bodies.len() {
            return Err(Error::invalid(format!(
                "{} {what} are given for {} bodies; give one for each, in their order",
                list.len(),
                job.bodies.len()
            )));
        }
    }
    Ok(())
}

fn check_names(bodies: &[Body]) -> Result<()> {
    for (b, body) in bodies.iter().enumerate() {
        if bodies[..b].iter().any(|other| other.name == body.name) {
            return Err(Error::invalid(format!(
                "two bodies are named '{}', and their results would be one file; rename one",
                body.name
            )));
        }
    }
    Ok(())
}

fn read_body(files: &BodyFiles, surface: Option<&SurfaceFile>) -> Result<Body> {
    let tets = read_tets(&files.tets)?;
    let name = files.name.clone();
    let mut body = match surface {
        Some(file) => Body::with_surface(name, tets, &file.mesh()?)?,
        None => Body::from_tets(name, tets)?,
    };
    for path in &files.markers {
        body.markers.extend(read_markers(path)?.iter().map(|m| m.position));
    }
    Ok(body)
}

/// Surfaces that do not move, named by their files.
fn read_obstacles(paths: &[PathBuf]) -> Result<Vec<Obstacle>> {
    let read =
        |path: &PathBuf| Ok(Obstacle { name: stem(path), surface: read_surface(path)?.mesh()? });
    paths.iter().map(read).collect()
}

fn write_body(
    folder: &Path,
    body: &Body,
    surface: Option<(&SurfaceFile, &str)>,
    b: usize,
    separation: &Separation,
) -> Result<Vec<PathBuf>> {
    let tets = folder.join(format!("{}.vtu", body.name));
    let now = &separation.tet_points[b];
    let moves: Vec<f64> = body
        .tets
        .points
        .iter()
        .zip(now)
        .flat_map(|(a, b)| {
            let d = b - a;
            [d.x, d.y, d.z]
        })
        .collect();
    let deformed = TetMesh { points: now.clone(), tets: body.tets.tets.clone() };
    write_vtu(
        &tets,
        &deformed,
        &[],
        &[DataArray { name: "displacement", components: 3, values: &moves }],
    )?;
    let points = &separation.surface_points[b];
    let surface = if let Some((file, name)) = surface {
        let out = folder.join(name);
        file.write_with_points(&out, points)?;
        out
    } else {
        let out = folder.join(format!("{}.ply", body.name));
        let old = body.surface_points(&body.tets.points);
        let moved: Vec<f64> = old.iter().zip(points).map(|(a, b)| (b - a).norm()).collect();
        let mesh = TriMesh { points: points.clone(), triangles: body.triangles.clone() };
        write_ply(&out, &mesh, &[("moved", &moved)])?;
        out
    };
    Ok(vec![tets, surface])
}
