//! Bodies that overlap are pushed apart: what is promised, checked by other means.
#![allow(clippy::unwrap_used)]

mod sphere;

use moulage::locate::{triangles_cross, winding_number};
use moulage::math::Vec3;
use moulage::separate::{Body, Ending, Obstacle, Options, Overlap, Separation, separate};
use moulage::tetrahedralize::{self, Method, tetrahedralize};
use moulage::{Run, TetMesh, TriMesh};
use sphere::sphere;

/// A bar of cubes, each cut into six tets, around `centre`.
fn bar(name: &str, cells: [usize; 3], size: f64, centre: Vec3) -> Body {
    let at = |i: usize, j: usize, k: usize| (i + (cells[0] + 1) * (j + (cells[1] + 1) * k)) as u32;
    let half = Vec3::new(cells[0] as f64, cells[1] as f64, cells[2] as f64) / 2.0;
    let (mut points, mut tets) = (Vec::new(), Vec::new());
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                points.push(centre + (Vec3::new(i as f64, j as f64, k as f64) - half) * size);
            }
        }
    }
    let ring = [[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]];
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                for r in 0..6 {
                    let [a, b] = [ring[r], ring[(r + 1) % 6]]
                        .map(|[x, y, z]: [usize; 3]| at(i + x, j + y, k + z));
                    tets.push([at(i, j, k), a, b, at(i + 1, j + 1, k + 1)]);
                }
            }
        }
    }
    Body::from_tets(name, TetMesh::new(points, tets).unwrap()).unwrap()
}

/// A ball of radius 1 whose surface lies in tets of the lattice.
fn ball(name: &str, centre: Vec3) -> Body {
    let surface = unit_sphere(centre);
    let options =
        tetrahedralize::Options { method: Method::Lattice, tet_count: 2500, tetgen_path: None };
    let made = tetrahedralize(&surface, &options, &Run::new()).unwrap();
    Body {
        name: name.into(),
        tets: made.mesh,
        embedding: made.embedding,
        triangles: surface.triangles,
        markers: Vec::new(),
    }
}

fn unit_sphere(centre: Vec3) -> TriMesh {
    sphere(centre, 1.0, 16, 24)
}

/// Every pair of triangles and every vertex, one by one.
fn assert_apart(first: (&[Vec3], &[[u32; 3]]), second: (&[Vec3], &[[u32; 3]])) {
    let corners = |(points, _): (&[Vec3], &[[u32; 3]]), t: [u32; 3]| t.map(|v| points[v as usize]);
    for &t in first.1 {
        for &u in second.1 {
            assert!(!triangles_cross(&corners(first, t), &corners(second, u)));
        }
    }
    for (of, within) in [(first, second), (second, first)] {
        for p in of.0 {
            assert!(winding_number(within.0, within.1, p).abs() < 0.5, "{p} is inside");
        }
    }
}

fn assert_no_tet_inverted(bodies: &[Body], result: &Separation) {
    for (body, points) in bodies.iter().zip(&result.tet_points) {
        let mesh = TetMesh { points: points.clone(), tets: body.tets.tets.clone() };
        assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.0));
    }
}

fn run(bodies: &[Body], obstacles: &[Obstacle]) -> Separation {
    let result = separate(bodies, obstacles, &Options::default(), &Run::new()).unwrap();
    assert_no_tet_inverted(bodies, &result);
    result
}

#[test]
fn two_balls_share_the_way_and_their_far_sides_stay() {
    let bodies = [ball("left", Vec3::zeros()), ball("right", Vec3::new(1.7, 0.1, 0.05))];
    let options = Options { rings: 2, ..Options::default() };
    let result = separate(&bodies, &[], &options, &Run::new()).unwrap();
    assert_no_tet_inverted(&bodies, &result);
    assert!(result.before[0].depth > 0.25, "{:?}", result.before);
    assert!(result.after.is_empty(), "{:?}", result.after);
    let [left, right] = [0, 1].map(|b| (&result.surface_points[b][..], &bodies[b].triangles[..]));
    assert_apart(left, right);
    let moved: Vec<f64> = result.moved.iter().map(|m| m.1).collect();
    assert!(moved.iter().all(|m| (0.08..0.3).contains(m)), "{moved:?}");
    let start = bodies[0].surface_points(&bodies[0].tets.points);
    // Overlaps begin at x = 0.7; an edge to the carrying tet's corner, two rings, an edge back.
    let longest = |t: &[u32; 4]| {
        let p = t.map(|v| bodies[0].tets.points[v as usize]);
        let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
        pairs.into_iter().map(|(a, b)| (p[a] - p[b]).norm()).fold(0.0, f64::max)
    };
    let reach = 4.0 * bodies[0].tets.tets.iter().map(longest).fold(0.0, f64::max);
    assert!(reach < 1.5, "{reach}: nothing would be left to look at");
    for (old, new) in start.iter().zip(&result.surface_points[0]) {
        assert!(old.x > 0.7 - reach || old == new, "{old} moved");
    }
}

#[test]
fn a_body_leaves_a_fixed_one_alone() {
    let bodies = [ball("muscle", Vec3::new(0.0, 0.0, 1.75))];
    let bone = Obstacle { name: "bone".into(), surface: unit_sphere(Vec3::zeros()) };
    let result = run(&bodies, std::slice::from_ref(&bone));
    assert!(result.after.is_empty(), "{:?}", result.after);
    let muscle = (&result.surface_points[0][..], &bodies[0].triangles[..]);
    assert_apart(muscle, (&bone.surface.points, &bone.surface.triangles));
    assert!(result.moved[0].1 > 0.2);
}

#[test]
fn bars_that_cross_edge_on_edge_are_parted_too() {
    // Corner down on corner up, along different axes: no vertex of one is inside the other.
    let turned = |mut body: Body, axis: Vec3| {
        let centre: Vec3 = body.tets.points.iter().sum::<Vec3>() / body.tets.points.len() as f64;
        let turn = nalgebra::Rotation3::from_axis_angle(
            &nalgebra::Unit::new_normalize(axis),
            std::f64::consts::FRAC_PI_4,
        );
        for p in &mut body.tets.points {
            *p = centre + turn * (*p - centre);
        }
        body
    };
    let height = 2.0_f64.sqrt() * 2.0 - 0.15;
    let lower = turned(bar("lower", [9, 2, 2], 1.0, Vec3::zeros()), Vec3::x());
    let upper = turned(bar("upper", [2, 9, 2], 1.0, Vec3::new(0.0, 0.0, height)), Vec3::y());
    let bodies = [lower, upper];
    let result = run(&bodies, &[]);
    assert_eq!(result.before[0].vertices_inside, 0, "{:?}", result.before);
    assert!(result.before[0].crossings > 0);
    assert!(result.after.is_empty(), "{:?}", result.after);
    let [a, b] = [0, 1].map(|b| (&result.surface_points[b][..], &bodies[b].triangles[..]));
    assert_apart(a, b);
}

#[test]
fn a_pile_of_three_between_fixed_walls_comes_apart_in_either_order() {
    let plate = |z: f64| Obstacle {
        name: format!("plate at {z}"),
        surface: {
            let body = bar("plate", [1, 1, 1], 4.0, Vec3::new(0.0, 0.0, z));
            TriMesh { points: body.surface_points(&body.tets.points), triangles: body.triangles }
        },
    };
    let walls = [plate(-3.4), plate(3.4)];
    let bars: Vec<Body> = [-1.0, 0.0, 1.0]
        .iter()
        .enumerate()
        .map(|(k, z)| bar(&format!("bar {k}"), [6, 6, 3], 0.35, Vec3::new(0.05 * z, 0.03, *z)))
        .collect();
    let forwards = run(&bars, &walls);
    assert_eq!(forwards.before.len(), 4, "{:?}", forwards.before);
    assert!(forwards.after.is_empty(), "{:?}", forwards.after);
    let reversed: Vec<Body> = bars.iter().rev().cloned().collect();
    let backwards = run(&reversed, &walls);
    assert!(backwards.after.is_empty(), "{:?}", backwards.after);
}

#[test]
fn markers_hold_their_body_so_that_the_other_one_yields() {
    let plain = [ball("left", Vec3::zeros()), ball("right", Vec3::new(1.8, 0.1, 0.05))];
    let mut marked = plain.clone();
    marked[0].markers = plain[0].surface_points(&plain[0].tets.points);
    let (plain_result, marked_result) = (run(&plain, &[]), run(&marked, &[]));
    assert!(plain_result.after.is_empty() && marked_result.after.is_empty());
    assert!(marked_result.moved[0].1 < 0.7 * plain_result.moved[0].1);
    assert!(marked_result.moved[1].1 > plain_result.moved[1].1);
}

#[test]
fn bodies_apart_keep_every_bit_and_threads_do_not_matter() {
    let apart = [ball("left", Vec3::zeros()), ball("right", Vec3::new(2.1, 0.0, 0.0))];
    let result = run(&apart, &[]);
    assert!(result.before.is_empty() && result.rounds == 0);
    assert_eq!(result.tet_points[0], apart[0].tets.points);
    let near = [ball("left", Vec3::zeros()), ball("right", Vec3::new(1.9, 0.1, 0.0))];
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&near, &[])).tet_points
    };
    assert_eq!(on(1), on(3));
}

/// A bone runs lengthwise through a flat muscle; in places nearly all of the muscle lies inside it. The
/// muscle leaves on the near side, and is not thrown about.
#[test]
fn a_muscle_leaves_a_bone_that_runs_through_it() {
    let mut muscle = ball("muscle", Vec3::zeros());
    for p in &mut muscle.tets.points {
        *p = Vec3::new(0.35 * p.x, 0.6 * p.y, 2.0 * p.z);
    }
    let mut bone = Obstacle { name: "bone".into(), surface: unit_sphere(Vec3::zeros()) };
    for p in &mut bone.surface.points {
        *p = Vec3::new(0.4 * p.x + 0.2, 0.4 * p.y, 1.6 * p.z + 0.3);
    }
    let result = run(std::slice::from_ref(&muscle), std::slice::from_ref(&bone));
    assert!(result.after.is_empty(), "{:?}", result.after);
    let soft = (&result.surface_points[0][..], &muscle.triangles[..]);
    assert_apart(soft, (&bone.surface.points, &bone.surface.triangles));
    // The muscle reaches to x = -0.35 and 0.35, the bone to -0.2: leaving takes 0.55.
    let (moved, farthest) = result.moved[0];
    assert!((0.4..0.75).contains(&farthest), "{moved} vertices by {farthest}");
}

/// Bones that overlap leave no room between them: there is no solution to find.
#[test]
fn what_cannot_be_parted_ends_with_no_worse_overlap() {
    let bodies = [ball("muscle", Vec3::zeros())];
    let side = |x: f64, name: &str| Obstacle {
        name: name.into(),
        surface: unit_sphere(Vec3::new(x, 0.02, 0.01)),
    };
    let bones = [side(-0.9, "left bone"), side(0.9, "right bone")];
    let options = Options { rings: 2, max_rounds: 20, ..Options::default() };
    let result = separate(&bodies, &bones, &options, &Run::new()).unwrap();
    assert_no_tet_inverted(&bodies, &result);
    assert_eq!(result.ending, Ending::Stalled);
    assert!(!result.after.is_empty());
    let depth = |list: &[Overlap]| list.iter().map(|o| o.depth).fold(0.0, f64::max);
    assert!(depth(&result.after) <= depth(&result.before), "{:?}", result.after);
}

/// The first look is cancelled when the solver begins to push.
#[test]
fn a_cancelled_run_keeps_the_least_overlap() {
    let bodies = [ball("left", Vec3::zeros()), ball("right", Vec3::new(1.5, 0.1, 0.05))];
    let run = Run::new();
    let result = std::thread::scope(|scope| {
        let solver = scope.spawn(|| separate(&bodies, &[], &Options::default(), &run));
        while run.progress().stage != "pushing apart" && !solver.is_finished() {
            std::thread::yield_now();
        }
        run.cancel();
        solver.join().unwrap()
    });
    match result {
        Ok(result) => {
            assert!(matches!(result.ending, Ending::Cancelled | Ending::Parted));
            assert_no_tet_inverted(&bodies, &result);
            assert!(result.after.iter().all(|o| o.depth <= result.before[0].depth));
        }
        Err(error) => assert!(matches!(error, moulage::Error::Cancelled)),
    }
}

#[test]
fn what_cannot_be_worked_with_is_named() {
    let mut folded = bar("folded", [2, 2, 2], 1.0, Vec3::zeros());
    folded.tets.points[13] = Vec3::new(9.0, 0.0, 0.0);
    let error = separate(&[folded], &[], &Options::default(), &Run::new()).unwrap_err();
    assert!(error.to_string().contains("of 'folded' is inverted"), "{error}");
    let error = separate(&[], &[], &Options::default(), &Run::new()).unwrap_err();
    assert!(error.to_string().contains("nothing to separate"), "{error}");
    let options = Options { gap: Some(0.0), ..Options::default() };
    let good = [bar("good", [2, 2, 2], 1.0, Vec3::zeros())];
    let error = separate(&good, &[], &options, &Run::new()).unwrap_err();
    assert!(error.to_string().contains("gap"), "{error}");
    let run = Run::new();
    run.cancel();
    let overlapping = [good[0].clone(), bar("b", [2, 2, 2], 1.0, Vec3::new(1.5, 0.2, 0.1))];
    let error = separate(&overlapping, &[], &Options::default(), &run).unwrap_err();
    assert!(matches!(error, moulage::Error::Cancelled));
}
