//! An independent implementation's inputs and outputs (tests/golden) are reproduced.
#![allow(clippy::unwrap_used)]

use std::collections::HashMap;
use std::path::Path;

use moulage::fem::{
    Body, Carrier, Chart, Curvature, EquilibriumOptions, MaterialPoint, Outcome, PlasticState,
    RestElement, Sensitivity, Spring, StrainSmoothness, StrainSpace, rigid_modes,
};
use moulage::material::StableNeoHookean;
use moulage::math::{Sym3, Vec3};
use moulage::mesh::TetMesh;
use moulage::reshape::{Direction, Linearization, NormalEquations, Rows};

/// A file of named flat arrays.
struct Golden(HashMap<String, Vec<f64>>);

impl Golden {
    fn open(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
        Self(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
    }

    fn numbers(&self, name: &str) -> Vec<f64> {
        self.0[name].clone()
    }

    fn integers(&self, name: &str) -> Vec<u32> {
        self.0[name].iter().map(|&i| i as u32).collect()
    }

    fn vectors(&self, name: &str) -> Vec<Vec3> {
        self.numbers(name).chunks_exact(3).map(Vec3::from_column_slice).collect()
    }

    fn strains(&self, name: &str) -> Vec<Sym3> {
        self.numbers(name).chunks_exact(6).map(Sym3::from_column_slice).collect()
    }

    fn tets(&self) -> Vec<[u32; 4]> {
        self.integers("tets").chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect()
    }
}

fn relative(difference: f64, size: f64) -> f64 {
    difference / size
}

#[test]
fn elements() {
    let golden = Golden::open("element.json");
    let (rest, x, s, tets) =
        (golden.vectors("X"), golden.vectors("x"), golden.strains("s"), golden.tets());
    let (energy, gradient) = (golden.numbers("E"), golden.vectors("grad"));
    let (k, k_spd, dgds) = (golden.numbers("Ke"), golden.numbers("Ke_spd"), golden.numbers("dgds"));
    let material = StableNeoHookean::new(1.0, 0.45);
    for (t, tet) in tets.iter().enumerate() {
        let element = RestElement::new(tet.map(|v| rest[v as usize]));
        let corners = tet.map(|v| x[v as usize]);
        let plastic = PlasticState::from_matrix(&s[t]);
        let e = element.energy(&corners, &plastic, &material);
        assert!(relative((e - energy[t]).abs(), energy[t].abs()) < 1e-10, "energy of tet {t}");
        let g = element.gradient(&corners, &plastic, &material);
        for a in 0..4 {
            let expected = gradient[tet[a] as usize];
            assert!(
                (g[a] - expected).norm() < 1e-10 * expected.norm().max(1e-3),
                "gradient of tet {t}"
            );
        }
        for (curvature, expected) in [(Curvature::True, &k), (Curvature::Projected, &k_spd)] {
            let expected =
                nalgebra::SMatrix::<f64, 12, 12>::from_row_slice(&expected[144 * t..][..144]);
            let found = element.stiffness(&corners, &plastic, &material, curvature);
            assert!(
                relative((found - expected).norm(), expected.norm()) < 1e-10,
                "{curvature:?} stiffness of tet {t}"
            );
        }
        let expected = nalgebra::SMatrix::<f64, 12, 6>::from_row_slice(&dgds[72 * t..][..72]);
        let found = element.strain_sensitivity(&corners, &plastic, &material);
        assert!(
            relative((found - expected).norm(), expected.norm()) < 1e-10,
            "sensitivity of tet {t}"
        );
    }
}

const LINEAR_NODAL: StrainSpace = StrainSpace { carrier: Carrier::Vertices, chart: Chart::Matrix };

/// Surface points given by triangle and barycentric coordinates, each pulled to a target.
fn landmark_points(golden: &Golden) -> (Vec<MaterialPoint>, Vec<Vec3>) {
    let tris = golden.integers("tris");
    let (tri, b, y) = (golden.integers("lm_tri"), golden.vectors("lm_b"), golden.vectors("lm_y"));
    let points = tri
        .iter()
        .zip(&b)
        .map(|(&t, b)| MaterialPoint((0..3).map(|k| (tris[3 * t as usize + k], b[k])).collect()));
    (points.collect(), y)
}

fn add_rows(rows: &mut Rows, x: &[Vec3], point: &MaterialPoint, target: Vec3, weight: f64) {
    let gap = point.position(x) - target;
    rows.add(point, [Vec3::x(), Vec3::y(), Vec3::z()].map(|d| (d, d.dot(&gap), weight)));
}

struct Beam {
    golden: Golden,
    body: Body<StableNeoHookean>,
    attachments: Vec<(MaterialPoint, Vec3)>,
    landmarks: (Vec<MaterialPoint>, Vec<Vec3>),
}

impl Beam {
    fn load() -> Self {
        let golden = Golden::open("beam_small.json");
        let mesh = TetMesh::new(golden.vectors("X"), golden.tets()).unwrap();
        let vertices = golden.integers("att_v");
        let targets = golden.vectors("att_y");
        let attachments: Vec<_> = vertices
            .iter()
            .zip(targets)
            .map(|(&v, y)| (MaterialPoint(vec![(v, 1.0)]), y))
            .collect();
        let springs = attachments
            .iter()
            .map(|(p, y)| Spring { point: p.clone(), target: *y, stiffness: 10.0 })
            .collect();
        let landmarks = landmark_points(&golden);
        Self {
            golden,
            body: Body::new(mesh, StableNeoHookean::new(1.0, 0.45), springs).unwrap(),
            attachments,
            landmarks,
        }
    }

    fn rows(&self, x: &[Vec3]) -> Rows {
        let mut rows = Rows::default();
        for (point, target) in self.landmarks.0.iter().zip(&self.landmarks.1) {
            add_rows(&mut rows, x, point, *target, 1000.0);
        }
        for (point, target) in &self.attachments {
            add_rows(&mut rows, x, point, *target, 100.0);
        }
        rows
    }

    /// The undamped Gauss-Newton step at the strain `s` and its equilibrium `x`.
    fn step(
        &self,
        space: &StrainSpace,
        smoothness: &StrainSmoothness,
        s: &[Sym3],
        x: &[Vec3],
    ) -> Direction {
        let plastic = space.states(s, &self.body.mesh.tets);
        let factor = self.body.factor_stiffness(x, &plastic).unwrap();
        let sensitivity = Sensitivity::new(&self.body, space, x, &plastic);
        let at = Linearization::new(&self.body, &factor, &sensitivity, x);
        let rows = self.rows(x);
        let equations = NormalEquations::new(&at, &rows, None, smoothness);
        equations.direction(s, 0.0, 1e-13).unwrap()
    }
}

fn largest_distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn relative_difference(found: &[Sym3], expected: &[Sym3]) -> f64 {
    let error: f64 = found.iter().zip(expected).map(|(a, b)| (a - b).norm_squared()).sum();
    (error / expected.iter().map(Sym3::norm_squared).sum::<f64>()).sqrt()
}

const TIGHT: EquilibriumOptions = EquilibriumOptions { tolerance: 1e-10, max_steps: 60 };

/// The smoothness of the reference: weight 1 times the length scale for the nodal form.
fn smoothness(body: &Body<StableNeoHookean>, space: &StrainSpace) -> StrainSmoothness {
    let weight = if space.carrier == Carrier::Tets { 1.0 } else { libm::cbrt(body.rest_volume()) };
    StrainSmoothness::new(body, space, weight, None, &vec![1.0; body.rest.len()]).unwrap()
}

#[test]
fn beam_equilibrium_step_and_energies() {
    let beam = Beam::load();
    for (name, space) in [
        ("graph_linear", StrainSpace::PAPER),
        ("nodal_linear", LINEAR_NODAL),
        ("nodal_log", StrainSpace::NODAL_LOGARITHM),
    ] {
        let s = beam.golden.strains(&format!("{name}_s_in"));
        let expected_x = beam.golden.vectors(&format!("{name}_x_eq"));
        let plastic = space.states(&s, &beam.body.mesh.tets);
        let found = beam.body.equilibrate(beam.body.mesh.points.clone(), &plastic, &TIGHT).unwrap();
        assert_eq!(found.outcome, Outcome::Converged);
        assert!(largest_distance(&found.x, &expected_x) < 1e-8, "{name}: equilibrium");

        let smoothness = smoothness(&beam.body, &space);
        let step = beam.step(&space, &smoothness, &s, &found.x);
        let expected = beam.golden.strains(&format!("{name}_ds"));
        assert!(relative_difference(&step.ds, &expected) < 1e-6, "{name}: step");

        let phi = beam.golden.numbers(&format!("{name}_phi_reg_data"));
        let regularization = smoothness.energy(&beam.golden.strains(&format!("{name}_s_final")));
        let data = beam.rows(&beam.golden.vectors(&format!("{name}_x_final"))).energy();
        assert!((regularization - phi[1]).abs() < 1e-9 * phi[0], "{name}: smoothness energy");
        assert!((data - phi[2]).abs() < 1e-9 * phi[0], "{name}: data energy");
    }
}

/// Gauss-Newton from the reference's constant strain to its converged shape.
#[test]
fn beam_converges_to_the_same_shape() {
    let beam = Beam::load();
    for (name, space) in [
        ("graph_linear", StrainSpace::PAPER),
        ("nodal_linear", LINEAR_NODAL),
        ("nodal_log", StrainSpace::NODAL_LOGARITHM),
    ] {
        let golden = |what: &str| format!("{name}_{what}");
        let smoothness = smoothness(&beam.body, &space);
        let reach = |s: &[Sym3], x: &[Vec3]| {
            let plastic = space.states(s, &beam.body.mesh.tets);
            beam.body.equilibrate(x.to_vec(), &plastic, &TIGHT).unwrap()
        };
        let objective = |s: &[Sym3], x: &[Vec3]| smoothness.energy(s) + beam.rows(x).energy();

        let constant = beam.golden.strains(&golden("const_s"))[0];
        let mut s = vec![constant; beam.golden.strains(&golden("s_in")).len()];
        let mut x = reach(&s, &beam.body.mesh.points).x;
        let expected = beam.golden.vectors(&golden("const_x"));
        assert!(largest_distance(&x, &expected) < 1e-8, "{name}: constant strain");

        let mut value = objective(&s, &x);
        for _ in 0..60 {
            let step = beam.step(&space, &smoothness, &s, &x);
            let lower = (0..8).find_map(|k| {
                let eta = 0.5_f64.powi(k);
                let s: Vec<Sym3> = s.iter().zip(&step.ds).map(|(s, ds)| s + ds * eta).collect();
                let reached = reach(&s, &x);
                let lower = objective(&s, &reached.x);
                (reached.outcome == Outcome::Converged && lower < value)
                    .then_some((s, reached.x, lower))
            });
            let Some((next_s, next_x, lower)) = lower else { break };
            let settled = lower > value * (1.0 - 1e-10);
            (s, x, value) = (next_s, next_x, lower);
            if settled {
                break;
            }
        }
        let phi = beam.golden.numbers(&golden("phi_reg_data"))[0];
        let off = largest_distance(&x, &beam.golden.vectors(&golden("x_final")));
        assert!(relative((value - phi).abs(), phi) < 1e-3, "{name}: {value} beside {phi}");
        assert!(off < 1e-3, "{name}: {off} off");
    }
}

/// What is left of a field of small displacements when its rigid part is taken out.
fn without_rigid_part(field: &[Vec3], x: &[Vec3], center: &Vec3) -> Vec<Vec3> {
    let modes: Vec<_> = x.iter().map(|x| rigid_modes(x, center)).collect();
    let gram =
        nalgebra::Matrix6::from_fn(|j, k| modes.iter().map(|m| m[j].dot(&m[k])).sum::<f64>());
    let right = nalgebra::Vector6::from_fn(|j, _| {
        field.iter().zip(&modes).map(|(f, m)| f.dot(&m[j])).sum()
    });
    let part = gram.cholesky().unwrap().solve(&right);
    field
        .iter()
        .zip(&modes)
        .map(|(f, m)| f - (0..6).map(|k| m[k] * part[k]).sum::<Vec3>())
        .collect()
}

#[test]
fn joint_step_of_a_free_body() {
    let golden = Golden::open("free_step.json");
    let mesh = TetMesh::new(golden.vectors("X"), golden.tets()).unwrap();
    let body = Body::new(mesh, StableNeoHookean::new(1.0, 0.45), Vec::new()).unwrap();
    let (s, x) = (golden.strains("s_in"), golden.vectors("x_eq"));
    let plastic = LINEAR_NODAL.states(&s, &body.mesh.tets);
    let mut rows = Rows::default();
    let (points, targets) = landmark_points(&golden);
    for (point, target) in points.iter().zip(targets) {
        add_rows(&mut rows, &x, point, target, 1000.0);
    }
    let factor = body.factor_stiffness(&x, &plastic).unwrap();
    let sensitivity = Sensitivity::new(&body, &LINEAR_NODAL, &x, &plastic);
    let center = x.iter().sum::<Vec3>() / x.len() as f64;
    let at = Linearization::new(&body, &factor, &sensitivity, &x);
    let smoothness = smoothness(&body, &LINEAR_NODAL);
    let equations = NormalEquations::new(&at, &rows, None, &smoothness);
    let step = equations.direction(&s, 0.0, 1e-13).unwrap();
    assert!(relative_difference(&step.ds, &golden.strains("ds")) < 1e-6);
    assert!(step.rigid.is_some());
    // The gauges differ; the change of shape does not.
    let found = without_rigid_part(&at.shape_change(&step.ds), &x, &center);
    let expected = without_rigid_part(&golden.vectors("dx_modulo_gauge"), &x, &center);
    assert!(
        largest_distance(&found, &expected)
            < 1e-6 * expected.iter().map(Vec3::norm).fold(0.0, f64::max)
    );
}
