//! Cases whose true shape is known everywhere, interior included: a bent and widened beam, a spike,
//! an organ made by the model itself, a free ellipsoid, a uniform stretch. Figures:
//! `cargo test --release --test known_truth -- --nocapture`.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::f64::consts::{FRAC_PI_2, PI};

use moulage::fem::{
    Body, EquilibriumOptions, MaterialPoint, Outcome, PlasticState, Spring, StrainSpace,
};
use moulage::locate::ClosestPoints;
use moulage::material::{InversionBarrier, StableNeoHookean};
use moulage::math::{Mat3, Sym3, Vec3};
use moulage::mesh::{TetMesh, TriMesh};
use moulage::reshape::{Landmark, Marker, Options, Problem, Reshaped, TemplatePoint, reshape};
use moulage::tetrahedralize::{self, Method, tetrahedralize};
use moulage::{Run, mesh::signed_volume};
use nalgebra::{Rotation3, Vector3};

/// A box of `size` centred at the origin, its faces in squares of about `spacing`.
fn cuboid(size: Vec3, spacing: f64) -> TriMesh {
    let counts = size.map(|s| (s / spacing).round() as i32);
    let mut index = std::collections::BTreeMap::new();
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for end in [0, counts[axis]] {
            for i in 0..counts[u] {
                for j in 0..counts[v] {
                    let mut corner = |di: i32, dj: i32| {
                        let mut key = [0; 3];
                        (key[axis], key[u], key[v]) = (end, i + di, j + dj);
                        *index.entry(key).or_insert_with(|| {
                            let share =
                                Vec3::from_fn(|k, _| f64::from(key[k]) / f64::from(counts[k]));
                            points.push(size.component_mul(&share.add_scalar(-0.5)));
                            points.len() as u32 - 1
                        })
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    if end == 0 {
                        triangles.extend([[a, c, b], [a, d, c]]);
                    } else {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
    }
    TriMesh::new(points, triangles).unwrap()
}

/// An ellipsoid: a cuboid's surface blown up.
fn ellipsoid(radii: Vec3, squares: f64) -> TriMesh {
    let mut surface = cuboid(Vec3::repeat(2.0), 2.0 / squares);
    for p in &mut surface.points {
        // Evens out the squares near the cube's edges.
        *p = p.map(|c| libm::tan(c * PI / 4.0)).normalize().component_mul(&radii);
    }
    surface
}

/// The template filled by TetGen, without data.
fn filled(surface: TriMesh, tet_count: usize) -> Problem {
    let options =
        tetrahedralize::Options { method: Method::TetGen, tet_count, ..Default::default() };
    let tets = tetrahedralize(&surface, &options, &Run::new()).unwrap();
    Problem::new(surface, tets)
}

/// True places of `count` of the points, without their correspondence. Scattered, as clicks are: rows
/// of a grid would leave edges unseen.
fn markers(points: &[Vec3], count: usize, truth: impl Fn(&Vec3) -> Vec3) -> Vec<Marker> {
    // SplitMix64's mixing: neighbours get unrelated keys.
    let key = |v: usize| {
        let z = (v as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB)
    };
    let mut chosen: Vec<usize> = (0..points.len()).collect();
    chosen.sort_by_key(|&i| key(i));
    let place = |&i: &usize| Marker::at(truth(&points[i]));
    chosen.iter().take(count).map(place).collect()
}

/// Surface vertices that `chosen` picks, with their true places.
fn pairs(
    problem: &Problem,
    chosen: impl Fn(usize, &Vec3) -> bool,
    truth: impl Fn(usize, &Vec3) -> Vec3,
) -> Vec<Landmark> {
    let vertices = problem.surface.points.iter().enumerate().filter(|(i, p)| chosen(*i, p));
    vertices
        .map(|(i, p)| Landmark {
            label: i.to_string(),
            template: TemplatePoint::Vertex(i as u32),
            target: truth(i, p),
            weight: 1.0,
            within: None,
        })
        .collect()
}

/// Mean and largest value.
fn mean_max(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    (values.iter().sum::<f64>() / values.len() as f64, values.iter().copied().fold(0.0, f64::max))
}

fn distances(a: &[Vec3], b: impl Iterator<Item = Vec3>) -> (f64, f64) {
    mean_max(a.iter().zip(b).map(|(a, b)| (a - b).norm()))
}

/// Distances of points to the reshaped surface.
fn off_surface(problem: &Problem, result: &Reshaped, points: &[Vec3]) -> (f64, f64) {
    let tree = ClosestPoints::new(&result.surface_points, &problem.surface.triangles);
    mean_max(tree.closest_many(points).into_iter().map(|hit| hit.unwrap().distance))
}

fn marker_errors(problem: &Problem, result: &Reshaped) -> (f64, f64) {
    let points: Vec<Vec3> = problem.markers.iter().map(|m| m.position).collect();
    off_surface(problem, result, &points)
}

fn inverted(problem: &Problem, result: &Reshaped) -> usize {
    let volume = |tet: &[u32; 4]| signed_volume(tet.map(|v| result.tet_points[v as usize]));
    problem.tets.tets.iter().filter(|tet| volume(tet) <= 0.0).count()
}

fn run(problem: &Problem, tolerance: f64) -> Reshaped {
    let options = Options { tolerance: Some(tolerance), ..Options::default() };
    reshape(problem, &options, &Run::new()).unwrap()
}

fn effort(result: &Reshaped) -> String {
    let last = result.summary.iteration_count();
    format!("{last} iterations, {} Newton steps", result.summary.newton_steps)
}

/// A beam of 40 x 10 x 10 bent to a quarter circle, its middle widened `stretch` times.
fn bent(p: &Vec3, stretch: f64) -> Vec3 {
    let (radius, along) = (40.0 / FRAC_PI_2, p.x / 40.0);
    let wide = 1.0 + (stretch - 1.0) * libm::cos(PI * along).powi(2);
    let angle = FRAC_PI_2 * along;
    let from_center = radius + p.z;
    Vec3::new(from_center * libm::sin(angle), wide * p.y, from_center * libm::cos(angle) - radius)
}

/// [W] Figure 4: held at both ends, everything else from markers without correspondence. Nothing in them
/// tells where along the beam they belong; a stiffer field without screening slides least.
#[test]
fn a_beam_is_bent_and_widened_two_and_three_times() {
    let default = Options { tolerance: Some(0.02), ..Options::default() };
    let stiff = Options { smoothness: 3.0, screening: Some(f64::INFINITY), ..default.clone() };
    for (name, options, stretch, largest_mean) in [
        ("defaults", &default, 2.0, 0.35),
        ("defaults", &default, 3.0, 0.7),
        ("smoothness 3, no screening", &stiff, 2.0, 0.25),
        ("smoothness 3, no screening", &stiff, 3.0, 0.4),
    ] {
        let mut problem = filled(cuboid(Vec3::new(40.0, 10.0, 10.0), 2.0), 2600);
        let truth = |p: &Vec3| bent(p, stretch);
        problem.markers = markers(&problem.surface.points, 100, truth);
        problem.attachments = pairs(&problem, |_, p| p.x.abs() > 19.9, |_, p| truth(p));
        let result = reshape(&problem, options, &Run::new()).unwrap();
        let (mean, max) = distances(&result.tet_points, problem.tets.points.iter().map(truth));
        let (marker_mean, marker_max) = marker_errors(&problem, &result);
        println!(
            "beam {stretch}x, {name}, {} tets, {} markers: markers {marker_mean:.4}/{marker_max:.3}, \
             all vertices {mean:.3}/{max:.2}, {}",
            problem.tets.tets.len(),
            problem.markers.len(),
            effort(&result)
        );
        assert_eq!(inverted(&problem, &result), 0);
        assert!(marker_mean < 0.05, "{marker_mean}");
        assert!(mean < largest_mean, "{mean}");
    }
}

/// One point of a ball held at its foot is pulled out. [W] Figure 2: elastic statics makes a spike, the
/// thinner the finer the mesh; plastic strain makes the same bulge on every mesh.
#[test]
fn one_pulled_landmark_makes_a_bulge_and_not_a_spike() {
    let mut ratios = Vec::new();
    for (squares, tet_count) in [(10.0, 4_000), (14.0, 6_500)] {
        let mut problem = filled(ellipsoid(Vec3::repeat(50.0), squares), tet_count);
        let points = problem.surface.points.clone();
        let top = (0..points.len()).max_by(|&a, &b| points[a].z.total_cmp(&points[b].z)).unwrap();
        problem.fixed =
            (0..points.len() as u32).filter(|&v| points[v as usize].z < -35.0).collect();
        let target = points[top] + Vec3::z() * 30.0;
        problem.landmarks = pairs(&problem, |i, _| i == top, |_, _| target);
        // A problem wants three points: two that stay, at the foot.
        let foot = |i: usize| problem.fixed.iter().take(2).any(|&v| v as usize == i);
        let stay = pairs(&problem, |i, _| foot(i), |_, p| *p);
        problem.landmarks.extend(stay);
        let result = run(&problem, 0.1);
        let statics = pulled_statically(&problem, top, &target);
        // Displacement 10 mm (10 % of the size) away from the landmark, beside the landmark's own.
        let share = |moved: &[Vec3]| {
            let at = |p: &Vec3| (p - points[top]).norm();
            let ring = (0..points.len()).filter(|&v| (8.0..12.0).contains(&at(&points[v])));
            let (mean, _) = mean_max(ring.map(|v| (moved[v] - points[v]).norm()));
            mean / (moved[top] - points[top]).norm()
        };
        let (plastic, elastic) = (share(&result.surface_points), share(&statics));
        println!(
            "spike, {} tets: displacement 10 mm away {plastic:.3}, elastic statics {elastic:.3}; \
             landmark off by {:.3}; {}",
            problem.tets.tets.len(),
            (result.surface_points[top] - target).norm(),
            effort(&result)
        );
        assert_eq!(inverted(&problem, &result), 0);
        assert!(plastic > 2.0 * elastic, "{plastic} {elastic}");
        ratios.push([plastic, elastic]);
    }
    let [plastic, elastic] = [0, 1].map(|k| ratios[1][k] / ratios[0][k]);
    assert!((plastic - 1.0).abs() < 0.05, "the bulge depends on the mesh: {ratios:?}");
    assert!(elastic < 0.5, "the spike does not: {ratios:?}");
}

/// Where the surface goes when the landmark is held by a stiff spring and nothing is plastic.
fn pulled_statically(problem: &Problem, top: usize, target: &Vec3) -> Vec<Vec3> {
    let material_point = |v: usize| {
        let (corners, weights) = (problem.embedding.vertices[v], problem.embedding.weights[v]);
        MaterialPoint(corners.into_iter().zip(weights).filter(|(_, w)| *w != 0.0).collect())
    };
    let spring =
        |v: usize, target: Vec3| Spring { point: material_point(v), target, stiffness: 1e4 };
    let mut springs: Vec<Spring> = problem
        .fixed
        .iter()
        .map(|&v| spring(v as usize, problem.surface.points[v as usize]))
        .collect();
    springs.push(spring(top, *target));
    let body = Body::new(problem.tets.clone(), StableNeoHookean::new(1.0, 0.49), springs).unwrap();
    let plastic = vec![PlasticState::from_logarithm(&Sym3::zeros()); problem.tets.tets.len()];
    let options = EquilibriumOptions { tolerance: 1e-6, max_steps: 200 };
    let rest = problem.tets.points.clone();
    let statics = body.equilibrate(rest, &plastic, &options).unwrap();
    assert_eq!(statics.outcome, Outcome::Converged);
    problem.embedding.apply(&statics.x)
}

/// A smooth logarithmic strain whose stretches run from 0.4 to 2.2.
fn wild_strain(p: &Vec3) -> Sym3 {
    let wave = |k: f64, phase: f64| libm::sin(0.03 * k * (p.x + 0.7 * p.y - 0.4 * p.z) + phase);
    Sym3::new(
        0.8 * wave(1.0, 0.3),
        0.36 * wave(1.4, 1.1),
        0.29 * wave(0.8, 2.0),
        0.72 * wave(1.2, 2.9),
        0.36 * wave(1.1, 4.0),
        0.72 * wave(0.9, 5.1),
    )
}

/// [W] Figure 21: the truth is made by the model from a known plastic strain, stretches
/// from 0.4 to 2.2; exact landmarks bring it back.
#[test]
fn a_known_plastic_strain_is_found_again() {
    let mut problem = filled(ellipsoid(Vec3::new(50.0, 22.0, 12.0), 14.0), 5300);
    problem.fixed = (0..problem.surface.points.len() as u32)
        .filter(|&v| problem.surface.points[v as usize].z < -10.0)
        .collect();
    let rest = &problem.tets.points;
    let strain: Vec<Sym3> = rest.iter().map(wild_strain).collect();
    let springs = problem.fixed.iter().map(|&v| {
        let (corners, weights) =
            (problem.embedding.vertices[v as usize], problem.embedding.weights[v as usize]);
        let entries = corners.into_iter().zip(weights).filter(|(_, w)| *w != 0.0).collect();
        let target = problem.surface.points[v as usize];
        Spring { point: MaterialPoint(entries), target, stiffness: 3800.0 }
    });
    // Without the barrier a tet of the truth inverts; no run may find that again.
    let material = InversionBarrier::new(StableNeoHookean::new(1.0, 0.3), 0.3, 1.0);
    let body = Body::new(problem.tets.clone(), material, springs.collect()).unwrap();
    let space = StrainSpace::NODAL_LOGARITHM;
    let mut x = rest.clone();
    for share in 1..=10 {
        let part: Vec<Sym3> = strain.iter().map(|s| s * (f64::from(share) / 10.0)).collect();
        let plastic = space.states(&part, &problem.tets.tets);
        let options = EquilibriumOptions { tolerance: 1e-6, max_steps: 200 };
        let found = body.equilibrate(x, &plastic, &options).unwrap();
        assert_eq!(found.outcome, Outcome::Converged);
        x = found.x;
    }
    let truth = problem.embedding.apply(&x);
    let step = truth.len() / 200;
    problem.landmarks = pairs(&problem, |i, _| i % step == 0, |i, _| truth[i]);
    let options =
        Options { tolerance: Some(0.001), landmark_tolerance: Some(0.001), ..Options::default() };
    let result = reshape(&problem, &options, &Run::new()).unwrap();
    let (mean, max) = distances(&result.tet_points, x.iter().copied());
    let (surface_mean, surface_max) = distances(&result.surface_points, truth.iter().copied());
    let (moved, farthest) = distances(rest, x.iter().copied());
    let (strain_error, strain_size) = strain_errors(&problem, &result, &strain);
    println!(
        "known strain, {} tets, {} landmarks: surface {surface_mean:.3}/{surface_max:.2}, all \
         vertices {mean:.3}/{max:.2} of a motion of {moved:.1}/{farthest:.1}, Fp off by {:.2}, {}",
        problem.tets.tets.len(),
        problem.landmarks.len(),
        strain_error / strain_size,
        effort(&result)
    );
    assert_eq!(inverted(&problem, &result), 0);
    assert!(mean < 0.05 && max < 0.39, "{mean} {max}");
}

/// Size of the error of Fp - 1, and of Fp - 1, over the body.
fn strain_errors(problem: &Problem, result: &Reshaped, strain: &[Sym3]) -> (f64, f64) {
    let space = StrainSpace::NODAL_LOGARITHM;
    let (mut error, mut size) = (0.0, 0.0);
    for (t, tet) in problem.tets.tets.iter().enumerate() {
        let (volume, truth) = (problem.tets.volume(t), space.plastic_strain(strain, t, tet));
        error += volume * (result.plastic_strain[t] - truth).norm_squared();
        size += volume * (truth - Mat3::identity()).norm_squared();
    }
    (error.sqrt(), size.sqrt())
}

/// Bends, tapers, adds a lobe and a groove, turns and moves.
fn liver_like(p: &Vec3) -> Vec3 {
    let along = p.x / 100.0;
    let taper = 1.0 - 0.35 * along;
    let lobe = 1.0 + 0.4 * libm::exp(-((p.x + 45.0).powi(2) + (p.y - 20.0).powi(2)) / 900.0);
    let groove = 6.0 * libm::exp(-(p.x - 15.0).powi(2) / 800.0) * (p.z / 30.0).max(0.0);
    let q = Vec3::new(p.x, taper * p.y * lobe, taper * p.z * lobe - groove);
    let angle = 0.6 * along;
    let bend =
        Vec3::new((160.0 + q.z) * libm::sin(angle), q.y, (160.0 + q.z) * libm::cos(angle) - 160.0);
    Rotation3::new(Vector3::new(0.1, 0.3, 0.15)) * bend + Vec3::new(12.0, -10.0, 12.0)
}

/// A free body follows markers without correspondence through a rotation and a large change of shape.
#[test]
fn a_free_ellipsoid_becomes_a_liver() {
    let mut problem = filled(ellipsoid(Vec3::new(100.0, 55.0, 40.0), 12.0), 4000);
    let dense: Vec<Vec3> =
        ellipsoid(Vec3::new(100.0, 55.0, 40.0), 30.0).points.iter().map(liver_like).collect();
    problem.markers = markers(&dense, 200, |p| *p);
    let result = run(&problem, 0.1);
    let (mean, max) = off_surface(&problem, &result, &dense);
    let (marker_mean, marker_max) = marker_errors(&problem, &result);
    println!(
        "free ellipsoid, {} tets, {} markers: markers {marker_mean:.3}/{marker_max:.3}, \
         surface {mean:.3}/{max:.2}, {}",
        problem.tets.tets.len(),
        problem.markers.len(),
        effort(&result)
    );
    assert_eq!(inverted(&problem, &result), 0);
    assert!(marker_mean < 0.02, "{marker_mean}");
    assert!(mean < 0.324 && max < 2.29, "{mean} {max}");
}

/// A patch test: a uniform plastic strain is met exactly and without stress on any mesh.
#[test]
fn a_uniform_plastic_strain_leaves_no_stress() {
    let problem = filled(cuboid(Vec3::new(3.0, 2.0, 2.0), 0.5), 500);
    let mesh: TetMesh = problem.tets;
    let strain = Sym3::new(0.3, 0.1, -0.2, -0.25, 0.15, 0.2);
    let state = PlasticState::from_logarithm(&strain);
    let stretch = state.inverse.try_inverse().unwrap();
    let body = Body::new(mesh.clone(), StableNeoHookean::new(1.0, 0.3), Vec::new()).unwrap();
    let plastic = vec![state; mesh.tets.len()];
    let options = EquilibriumOptions { tolerance: 1e-12, max_steps: 100 };
    let found = body.equilibrate(mesh.points.clone(), &plastic, &options).unwrap();
    assert_eq!(found.outcome, Outcome::Converged);
    assert!(body.energy(&found.x, &plastic).abs() < 1e-14 * body.rest_volume());
    // Up to a rigid motion, x = Fp X: all lengths agree.
    for tet in &mesh.tets {
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let edge = |x: &[Vec3]| x[tet[a] as usize] - x[tet[b] as usize];
            let wanted = (stretch * edge(&mesh.points)).norm();
            assert!((edge(&found.x).norm() - wanted).abs() < 1e-9);
        }
    }
}
