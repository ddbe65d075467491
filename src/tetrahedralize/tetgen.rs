//! Tets from the program TetGen, the surface kept where it has few enough triangles.

mod program;

use std::path::Path;

use self::program::{Program, Tets};
use super::simplify::simplify;
use super::weld::Welded;
use super::{Tetrahedralization, Used};
use crate::error::{Error, Result, Shown};
use crate::locate::{Embedding, WindingNumber};
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, TetMesh, TriMesh, boundary_triangles};
use crate::run::Run;

pub use self::program::find;

/// A surface with more triangles than this share of the wished tets is carried by a simplified
/// one: TetGen makes about four tets per boundary triangle whatever size is asked for.
const MOST_TRIANGLES: f64 = 0.4;
/// Triangles of the simplified surface per wished tet.
const ENVELOPE_TRIANGLES: f64 = 1.0 / 6.0;
/// The wish for a tet count counts as met within this share.
const COUNT_TOLERANCE: f64 = 0.08;
/// Runs with a size limit at most.
const MAX_RUNS: usize = 4;
/// TetGen's tolerances fit a box of about this diagonal.
const WORKING_SIZE: f64 = 100.0;

/// Fills a welded surface; the embedding is that of its vertices.
pub fn build(
    path: &Path,
    surface: &Welded,
    tet_count: usize,
    run: &Run,
) -> Result<Tetrahedralization> {
    let check = SurfaceCheck::new(&surface.mesh);
    if !check.is_closed() {
        return Err(Error::invalid(format!(
            "TetGen needs a closed surface, but {}; close it or use the lattice",
            check.sentences(&surface.mesh).join(", ")
        )));
    }
    let full = &surface.mesh;
    let most = MOST_TRIANGLES * tet_count as f64;
    if full.triangles.len() as f64 <= most {
        let mesh = fill(path, full, tet_count, run)?;
        let vertices: Vec<u32> = (0..full.points.len() as u32).collect();
        let embedding = Embedding::at_vertices(&mesh, &vertices)?;
        let kept = same_triangles(&boundary_triangles(&mesh), &full.triangles);
        return Ok(result(mesh, embedding, kept, Vec::new()));
    }
    let wish = (ENVELOPE_TRIANGLES * tet_count as f64).max(4.0) as usize;
    let envelope = simplify(full, wish);
    let mesh = fill(path, &envelope, tet_count, run)?;
    let embedding = Embedding::new(&mesh, &full.points)?;
    let note = format!(
        "{} triangles are many for {tet_count} tets: the surface is carried by one of {} triangles",
        full.triangles.len(),
        envelope.triangles.len()
    );
    Ok(result(mesh, embedding, false, vec![note]))
}

fn result(
    mesh: TetMesh,
    embedding: Embedding,
    boundary_kept: bool,
    warnings: Vec<String>,
) -> Tetrahedralization {
    let inside_fraction = vec![1.0; mesh.tets.len()];
    Tetrahedralization {
        mesh,
        embedding,
        inside_fraction,
        boundary_kept,
        used: Used::TetGen,
        warnings,
    }
}

/// Tets in a closed surface, whose vertices come first and stay where they are.
fn fill(path: &Path, surface: &TriMesh, tet_count: usize, run: &Run) -> Result<TetMesh> {
    // A power of two changes no digit.
    let scale = libm::exp2(libm::log2(WORKING_SIZE / surface.diagonal()).round());
    let scaled = TriMesh {
        points: surface.points.iter().map(|p| p * scale).collect(),
        triangles: surface.triangles.clone(),
    };
    let program = Program::new(path, &scaled)?;
    let (points, tets) = with_count(&program, scaled.volume().abs(), tet_count, run)?;
    let given = scaled.points.len();
    if points.len() < given {
        return Err(Error::ExternalProgram {
            program: path.shown(),
            message: format!(
                "{} of {given} vertices are missing in its result",
                given - points.len()
            ),
        });
    }
    let mut points: Vec<_> = points.iter().map(|p| p / scale).collect();
    points[..given].copy_from_slice(&surface.points);
    let mesh = TetMesh::new(points, tets)?;
    Ok(without_cavities(mesh, surface))
}

/// Runs TetGen with smaller and smaller tets until there are about as many as wished.
fn with_count(program: &Program, volume: f64, tet_count: usize, run: &Run) -> Result<Tets> {
    let wish = tet_count as f64;
    let miss = |tets: &Tets| libm::log(tets.1.len() as f64 / wish).abs();
    let mut best = program.fill(None, run)?;
    let fewest = best.1.len() as f64;
    if fewest > wish * (1.0 - COUNT_TOLERANCE) {
        return Ok(best);
    }
    // The boundary's tets are there already; a tet fills some .87 of the largest one allowed.
    let mut max_volume = 1.15 * volume / (wish - 0.65 * fewest);
    for _ in 0..MAX_RUNS {
        let tets = program.fill(Some(max_volume), run)?;
        let ratio = tets.1.len() as f64 / wish;
        if miss(&tets) < miss(&best) {
            best = tets;
        }
        if (ratio - 1.0).abs() < COUNT_TOLERANCE {
            break;
        }
        max_volume *= libm::pow(ratio, 1.3).clamp(0.2, 5.0);
    }
    Ok(best)
}

/// TetGen fills the cavities of nested surfaces too; those tets go, and their points with them.
fn without_cavities(mesh: TetMesh, surface: &TriMesh) -> TetMesh {
    if SurfaceCheck::new(surface).components < 2 {
        return mesh;
    }
    let winding = WindingNumber::new(&surface.points, &surface.triangles);
    let inside = |t: &usize| winding.is_inside(&(mesh.corners(*t).iter().sum::<Vec3>() / 4.0));
    let kept: Vec<[u32; 4]> = (0..mesh.tets.len()).filter(inside).map(|t| mesh.tets[t]).collect();
    let mut used = vec![false; mesh.points.len()];
    used[..surface.points.len()].fill(true);
    for &v in kept.iter().flatten() {
        used[v as usize] = true;
    }
    let mut number = vec![0; mesh.points.len()];
    let mut points = Vec::new();
    for v in (0..mesh.points.len()).filter(|&v| used[v]) {
        number[v] = points.len() as u32;
        points.push(mesh.points[v]);
    }
    TetMesh { points, tets: kept.iter().map(|t| t.map(|v| number[v as usize])).collect() }
}

/// Whether two lists hold the same triangles, in any order and orientation.
fn same_triangles(a: &[[u32; 3]], b: &[[u32; 3]]) -> bool {
    let sorted = |triangles: &[[u32; 3]]| {
        let mut all: Vec<[u32; 3]> = triangles.to_vec();
        for triangle in &mut all {
            triangle.sort_unstable();
        }
        all.sort_unstable();
        all
    };
    sorted(a) == sorted(b)
}

/// These need the program; `tests/run.sh` installs it. Without it they have nothing to show.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::tetrahedralize::{Method, Options, tetrahedralize};

    fn ball(radius: f64, rings: u32) -> TriMesh {
        let (points, triangles) = sphere(rings, 2 * rings);
        TriMesh::new(points.iter().map(|p| p * radius).collect(), triangles).unwrap()
    }

    fn add(surface: &mut TriMesh, other: &TriMesh, by: Vec3, turned: bool) {
        let first = surface.points.len() as u32;
        surface.points.extend(other.points.iter().map(|p| p + by));
        let order = if turned { [1, 0, 2] } else { [0, 1, 2] };
        let renumbered = other.triangles.iter().map(|t| order.map(|k| t[k] + first));
        surface.triangles.extend(renumbered);
    }

    fn with(method: Method, surface: &TriMesh, tet_count: usize) -> Result<Tetrahedralization> {
        let options = Options { method, tet_count, tetgen_path: None };
        tetrahedralize(surface, &options, &Run::new())
    }

    fn is_missing() -> bool {
        find(None).unwrap().is_none()
    }

    #[test]
    fn keeps_the_boundary_in_any_unit_and_meets_the_count() {
        if is_missing() {
            return;
        }
        let surface = ball(1.0, 10);
        let result = with(Method::TetGen, &surface, 4000).unwrap();
        assert!(result.boundary_kept);
        assert_eq!(result.embedding.apply(&result.mesh.points), surface.points);
        assert!((result.mesh.total_volume() / surface.volume() - 1.0).abs() < 1e-12);
        assert!((result.mesh.tets.len() as f64 / 4000.0 - 1.0).abs() < 0.1);
        let large = with(Method::TetGen, &ball(1024.0, 10), 4000).unwrap();
        assert_eq!(large.mesh.tets, result.mesh.tets);
    }

    #[test]
    fn many_triangles_are_carried_by_fewer() {
        if is_missing() {
            return;
        }
        let surface = ball(3.0, 40);
        let result = with(Method::TetGen, &surface, 3000).unwrap();
        assert!(!result.boundary_kept && result.warnings.len() == 1);
        assert!((result.mesh.total_volume() / surface.volume() - 1.0).abs() < 1e-3);
        for (p, q) in surface.points.iter().zip(result.embedding.apply(&result.mesh.points)) {
            assert!((p - q).norm() < 1e-12);
        }
    }

    #[test]
    fn cavities_stay_empty_and_every_point_is_used() {
        if is_missing() {
            return;
        }
        let mut surface = ball(2.0, 10);
        add(&mut surface, &ball(1.0, 8), Vec3::zeros(), true);
        let result = with(Method::TetGen, &surface, 6000).unwrap();
        assert!((result.mesh.total_volume() / surface.volume() - 1.0).abs() < 1e-12);
        let mut used = vec![false; result.mesh.points.len()];
        result.mesh.tets.iter().flatten().for_each(|&v| used[v as usize] = true);
        assert!(used.iter().all(|&u| u));
    }

    #[test]
    fn faults_are_named_and_the_lattice_steps_in() {
        if is_missing() {
            return;
        }
        let mut crossing = ball(1.0, 6);
        add(&mut crossing, &ball(1.0, 6), Vec3::new(0.9, 0.2, 0.1), false);
        let message = with(Method::TetGen, &crossing, 5000).unwrap_err().to_string();
        assert!(message.contains("cuts itself in"), "{message}");
        let mut open = ball(1.0, 6);
        open.triangles.pop();
        let message = with(Method::TetGen, &open, 5000).unwrap_err().to_string();
        assert!(message.contains("border a hole"), "{message}");
        let result = with(Method::Auto, &open, 5000).unwrap();
        assert_eq!(result.used, Used::Lattice);
        assert!(result.warnings[0].contains("border a hole"));
    }
}
