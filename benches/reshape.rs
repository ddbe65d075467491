//! Times of reshaping a liver to a made-up person: `cargo bench --bench reshape [-- PART]`, PART one of
//! `direction`, `tets`, `markers`, `again`, or `large` for 100,000 and 300,000 tets.
#![allow(clippy::print_stdout, clippy::expect_used)]

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use moulage::Run;
use moulage::fem::{
    Body, Curvature, MaterialPoint, Screening, Sensitivity, StrainSmoothness, StrainSpace,
};
use moulage::io::read_surface;
use moulage::material::StableNeoHookean;
use moulage::math::{Sym3, Vec3};
use moulage::mesh::{TetMesh, TriMesh};
use moulage::reshape::{
    Landmark, Linearization, Marker, NormalEquations, Options, Problem, Rows, TemplatePoint,
    reshape, reshape_again,
};
use moulage::solve::{SymbolicFactor, nested_dissection};
use moulage::tetrahedralize::{self, Method, tetrahedralize};
use rayon::prelude::*;

/// Repetitions of a short measurement; the fastest counts.
const REPETITIONS: usize = 5;

/// Right-hand sides that are solved together.
const SIDES: usize = 50;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["one", tets, markers] => one_run(number(tets), number(markers)),
        ["direction"] => directions(),
        ["tets"] => scale(&[(5_000, 300), (10_000, 300), (30_000, 300)]),
        ["large"] => scale(&[(100_000, 400), (300_000, 400)]),
        ["markers"] => {
            scale(&[(15_000, 30), (15_000, 100), (15_000, 400), (15_000, 2000), (15_000, 10_000)]);
        }
        ["again"] => again(),
        ["matrix", path] => matrix(Path::new(path)),
        [] => {
            directions();
            scale(&[(5_000, 300), (10_000, 300), (30_000, 300)]);
            scale(&[(15_000, 30), (15_000, 100), (15_000, 400), (15_000, 2000), (15_000, 10_000)]);
            again();
        }
        _ => panic!("parts: direction, tets, large, markers, again, matrix FILE"),
    }
}

fn number(text: &str) -> usize {
    text.parse().expect("a number")
}

fn fastest(mut work: impl FnMut()) -> f64 {
    let once = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(|_| once(&mut work)).fold(f64::INFINITY, f64::min)
}

fn liver() -> TriMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/liver/template.obj");
    let surface = read_surface(&path).expect("part of the repository");
    surface.mesh().expect("a good mesh").clone()
}

/// The made-up person's liver: longer, thinner, bent.
fn person(p: &Vec3, diagonal: f64) -> Vec3 {
    let bend = 0.6 * p.x * p.x / diagonal;
    Vec3::new(1.2 * p.x, 0.85 * p.y + bend, p.z + 0.1 * p.x)
}

/// Markers spread over the person's surface by a low-discrepancy sequence over the triangles' area.
fn markers(surface: &TriMesh, count: usize) -> Vec<Marker> {
    let diagonal = surface.diagonal();
    let mut sums = vec![0.0];
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        sums.push(sums[t] + (b - a).cross(&(c - a)).norm());
    }
    let total = sums[surface.triangles.len()];
    let point = |k: usize| {
        let place = |step: f64| (0.5 + step * k as f64).fract();
        let along = total * (k as f64 + 0.5) / count as f64;
        let t = sums.partition_point(|&sum| sum <= along) - 1;
        let (mut u, mut v) = (place(0.754_877_666), place(0.569_840_291));
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = surface.corners(t);
        let position = person(&(a + (b - a) * u + (c - a) * v), diagonal);
        Marker::at(position)
    };
    (0..count).map(point).collect()
}

fn problem(tet_count: usize, marker_count: usize) -> Problem {
    let surface = liver();
    let options = tetrahedralize::Options { method: Method::Lattice, tet_count, tetgen_path: None };
    let filled = tetrahedralize(&surface, &options, &Run::new()).expect("it can be filled");
    let markers = markers(&surface, marker_count);
    let mut problem = Problem::new(surface, filled);
    problem.markers = markers;
    problem
}

fn options() -> Options {
    Options { tolerance: Some(0.3), ..Options::default() }
}

/// One whole run, in a process of its own for its peak memory.
fn one_run(tets: usize, markers: usize) {
    let problem = problem(tets, markers);
    let start = Instant::now();
    let result = reshape(&problem, &options(), &Run::new()).expect("it works");
    let seconds = start.elapsed().as_secs_f64();
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or("? kB").trim();
    let last = result.summary.iterations.last().expect("one is recorded");
    println!(
        "| {} | {markers} | {seconds:.1} | {peak} | {} | {} | {:.3}/{:.2} |",
        problem.tets.tets.len(),
        result.summary.iterations.len() - 1,
        result.summary.newton_steps,
        last.mean_marker_distance,
        last.max_marker_distance
    );
}

fn scale(sizes: &[(usize, usize)]) {
    println!(
        "\n| tets | markers | seconds | peak memory | iterations | Newton steps | markers, mean/max mm |"
    );
    println!("|---|---|---|---|---|---|---|");
    let program = std::env::current_exe().expect("this program");
    for (tets, markers) in sizes {
        let sizes = [tets.to_string(), markers.to_string()];
        let ended = Command::new(&program).arg("one").args(sizes).status();
        assert!(ended.is_ok_and(|status| status.success()), "{tets} tets, {markers} markers");
    }
}

/// The parts of one Gauss-Newton direction, and the share of the machine's dense rate they reach.
fn directions() {
    println!(
        "\n| tets | rows | entries of L | stiffness | its factor | system | direction | of dense rate | published form |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let rate = dense_rate();
    for tets in [15_000, 30_000, 45_000] {
        direction(tets, 424, rate);
    }
    println!("\nSeconds. Dense rate here, single precision: {:.1} Gflop/s.", rate / 1e9);
}

/// Flops per second of a large product of dense matrices in single precision on all threads.
fn dense_rate() -> f64 {
    let n = 2000;
    let a = Mat::<f32>::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f32);
    let mut c = Mat::<f32>::zeros(n, n);
    let threads = Par::rayon(0);
    2.0 * (n as f64).powi(3)
        / fastest(|| matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, threads))
}

/// The problem's tets in elimination order, in units of the cube root of the volume; with it the new
/// number of each vertex.
fn renumbered(problem: &Problem) -> (TetMesh, Vec<u32>) {
    let neighbours =
        moulage::mesh::adjacency::vertex_neighbours(problem.tets.points.len(), &problem.tets.tets);
    let order = nested_dissection(&problem.tets.points, |v| neighbours.of(v));
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new as u32;
    }
    let length = libm::cbrt(problem.surface.volume().abs());
    let mesh = TetMesh {
        points: order.iter().map(|&v| problem.tets.points[v] / length).collect(),
        tets: problem.tets.tets.iter().map(|t| t.map(|v| place[v as usize])).collect(),
    };
    (mesh, place)
}

/// Writes the stiffness matrix at 45,000 tets for other solvers (`benches/solvers.py`), and prints the
/// seconds of its factor and of 200 right-hand sides.
fn matrix(path: &Path) {
    let (mesh, _) = renumbered(&problem(45_000, 10));
    let (x, space) = (mesh.points.clone(), StrainSpace::NODAL_LOGARITHM);
    let body = Body::new(mesh, StableNeoHookean::new(1.0, 0.3), Vec::new()).expect("it fits");
    let plastic = space.states(&vec![Sym3::zeros(); x.len()], &body.mesh.tets);
    let stiffness = body.stiffness(&x, &plastic, Curvature::True);
    let (pattern, mut text) =
        (body.pattern(), String::from("%%MatrixMarket matrix coordinate real symmetric\n"));
    let n = pattern.size();
    writeln!(text, "{n} {n} {}", stiffness.values.len()).expect("memory");
    for column in 0..n {
        for k in pattern.col_ptr[column]..pattern.col_ptr[column + 1] {
            let (row, value) = (pattern.row_idx[k] + 1, stiffness.values[k]);
            writeln!(text, "{row} {} {value:e}", column + 1).expect("memory");
        }
    }
    std::fs::write(path, text).expect("a place to write to");
    let symbolic = SymbolicFactor::new(pattern).expect("it fits");
    let mut factor = None;
    let factoring = fastest(|| factor = symbolic.factor(&stiffness).ok());
    let factor = factor.expect("definite at rest");
    let sides: Vec<f64> = (0..n * SIDES).map(|i| ((i * 37) % 101) as f64 - 50.0).collect();
    let solving = fastest(|| {
        let solved: Vec<Vec<f64>> = (0..200 / SIDES)
            .into_par_iter()
            .map(|_| {
                let mut block = sides.clone();
                factor.solve_rows(&mut block, SIDES);
                block
            })
            .collect();
        drop(solved);
    });
    println!("{factoring} {solving}");
}

fn direction(tets: usize, marker_count: usize, rate: f64) {
    let problem = problem(tets, 10);
    let (mesh, place) = renumbered(&problem);
    let x = mesh.points.clone();
    let body = Body::new(mesh, StableNeoHookean::new(1.0, 0.3), Vec::new()).expect("it fits");
    let space = StrainSpace::NODAL_LOGARITHM;
    let s = vec![Sym3::zeros(); x.len()];
    let plastic = space.states(&s, &body.mesh.tets);
    let ones = vec![1.0; body.mesh.tets.len()];
    let smoothness = StrainSmoothness::new(
        &body,
        &space,
        0.08,
        Some(Screening { length: 0.2, mean_sigma: 0.5 }),
        &ones,
    )
    .expect("it is definite");
    let mut rows = Rows::default();
    let vertices = problem.surface.points.len();
    for k in 0..marker_count {
        let v = k * vertices / marker_count;
        let embedding = &problem.embedding;
        let entries = embedding.vertices[v].iter().zip(embedding.weights[v]);
        let point =
            MaterialPoint(entries.map(|(&w, weight)| (place[w as usize], weight)).collect());
        // A normal row each, and two tangential ones for every second.
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let count = if k % 2 == 0 { 3 } else { 1 };
        rows.add(&point, axes.into_iter().take(count).map(|d| (d, 0.01, 1e4)));
    }
    let stiffness = fastest(|| drop(body.stiffness(&x, &plastic, Curvature::True)));
    let mut factor = None;
    let factoring = fastest(|| factor = body.factor_stiffness(&x, &plastic).ok()) - stiffness;
    let factor = factor.expect("definite at rest");
    let sensitivity = Sensitivity::new(&body, &space, &x, &plastic);
    let at = Linearization::new(&body, &factor, &sensitivity, &x);
    let mut equations = None;
    let system = fastest(|| equations = Some(NormalEquations::new(&at, &rows, None, &smoothness)));
    let equations = equations.expect("made above");
    let solving = fastest(|| drop(equations.direction(&s, 0.0, 1e-3)));
    drop(equations);
    let published = published_direction(&at, &rows);
    let (q, n) = (rows.rows.len() as f64, x.len() as f64);
    let fill = body.factor_fill() as f64;
    let pairs: f64 = sensitivity.blocks() as f64;
    let flops = q * (4.0 * fill + 36.0 * pairs + 6.0 * 4.0 * smoothness.factor_fill() as f64)
        + q * q * 6.0 * n;
    println!(
        "| {} | {q} | {:.1} M | {stiffness:.3} | {factoring:.3} | {system:.3} | {solving:.3} | {:.0} % | {published:.2} |",
        body.mesh.tets.len(),
        fill / 1e6,
        100.0 * flops / system / rate
    );
}

/// Seconds for one direction in the published form: a strain for each tet, graph Laplacian, Woodbury.
fn published_direction(at: &Linearization<StableNeoHookean>, rows: &Rows) -> f64 {
    let (body, space) = (at.body, StrainSpace::PAPER);
    let tets = &body.mesh.tets;
    let smoothness = StrainSmoothness::new(body, &space, 1.0, None, &vec![1.0; tets.len()]);
    let smoothness = smoothness.expect("it is definite");
    let s = vec![space.from_logarithm(&Sym3::zeros()); tets.len()];
    let sensitivity = Sensitivity::new(body, &space, at.x, &space.states(&s, tets));
    let at = Linearization::new(body, at.stiffness, &sensitivity, at.x);
    let start = Instant::now();
    drop(at.woodbury_direction(rows, &smoothness, &s, 1e-3));
    start.elapsed().as_secs_f64()
}

/// A landmark is moved by 5 mm after a whole run.
fn again() {
    println!("\n| tets | whole run | after a landmark moved | iterations |\n|---|---|---|---|");
    for tets in [3_000, 10_000] {
        let mut problem = problem(tets, 150);
        let diagonal = problem.surface.diagonal();
        let vertices = problem.surface.points.len();
        problem.landmarks = (0..8)
            .map(|k| {
                let v = k * vertices / 8;
                let target = person(&problem.surface.points[v], diagonal);
                let template = TemplatePoint::Vertex(v as u32);
                Landmark { label: k.to_string(), template, target, weight: 1.0, within: None }
            })
            .collect();
        let start = Instant::now();
        let first = reshape(&problem, &options(), &Run::new()).expect("it works");
        let whole = start.elapsed().as_secs_f64();
        problem.landmarks[3].target += Vec3::new(0.0, 5.0, 0.0);
        let mut iterations = 0;
        let seconds = fastest(|| {
            let result = reshape_again(&first, &problem, &options(), &Run::new());
            iterations = result.expect("it works").summary.iterations.len() - 1;
        });
        println!("| {} | {whole:.2} s | {seconds:.2} s | {iterations} |", problem.tets.tets.len());
    }
}
