//! The ways to one Gauss-Newton direction agree: dual, Woodbury ([W]), dense Hessian. Samples about it have
//! the covariance that the dense matrices have.
#![allow(clippy::unwrap_used)]

use moulage::fem::{
    Body, MaterialPoint, PlasticState, Screening, Sensitivity, Spring, StrainSmoothness,
    StrainSpace, rigid_modes,
};
use moulage::material::StableNeoHookean;
use moulage::math::{Sym3, Vec3};
use moulage::mesh::TetMesh;
use moulage::reshape::{Linearization, NormalEquations, Posterior, Rows};
use moulage::solve::Factor;
use nalgebra::{DMatrix, DVector};

const SCREENING: Screening = Screening { length: 0.7, mean_sigma: 0.5 };

/// A block of 2 x 2 x 2 cells, five tets each.
fn block() -> TetMesh {
    let id = |i: u32, j: u32, k: u32| i + 3 * j + 9 * k;
    let mut points = Vec::new();
    for k in 0..3 {
        for j in 0..3 {
            for i in 0..3 {
                let jitter = 0.05 * f64::from((7 * i + 5 * j + 3 * k) % 4);
                points.push(Vec3::new(f64::from(i) + jitter, f64::from(j) - jitter, f64::from(k)));
            }
        }
    }
    let mut tets = Vec::new();
    for (i, j, k) in (0..8).map(|c| (c & 1, c >> 1 & 1, c >> 2)) {
        let flip = (i + j + k) % 2 == 1;
        let corner = |a: u32, b: u32, c: u32| id(i + if flip { 1 - a } else { a }, j + b, k + c);
        let [a, b, c, d] = [corner(0, 0, 0), corner(1, 1, 0), corner(1, 0, 1), corner(0, 1, 1)];
        tets.push([a, b, c, d]);
        tets.push([corner(1, 0, 0), a, b, c]);
        tets.push([corner(0, 1, 0), a, b, d]);
        tets.push([corner(0, 0, 1), a, c, d]);
        tets.push([corner(1, 1, 1), b, c, d]);
    }
    TetMesh::new(points, tets).unwrap()
}

/// A loaded block with a field of strains near rest.
struct Setup {
    body: Body<StableNeoHookean>,
    space: StrainSpace,
    s: Vec<Sym3>,
    x: Vec<Vec3>,
    plastic: Vec<PlasticState>,
    rows: Rows,
}

impl Setup {
    fn new(space: StrainSpace) -> Self {
        Self::held_at(space, &[0, 2, 6, 8, 13])
    }

    fn held_at(space: StrainSpace, held: &[u32]) -> Self {
        let mesh = block();
        let hold = |v: u32| Spring {
            point: MaterialPoint(vec![(v, 1.0)]),
            target: mesh.points[v as usize] + Vec3::new(0.05, 0.02, 0.1) * f64::from(v % 3),
            stiffness: 3.0,
        };
        let springs = held.iter().map(|&v| hold(v)).collect();
        let carriers = space.carriers(mesh.points.len(), mesh.tets.len());
        let wave = |c: usize, p: usize| 0.1 * libm::sin((3 * c + 5 * p + 1) as f64);
        let s: Vec<Sym3> = (0..carriers)
            .map(|c| space.from_logarithm(&Sym3::from_fn(|p, _| wave(c, p))))
            .collect();
        let plastic = space.states(&s, &mesh.tets);
        let body = Body::new(mesh, StableNeoHookean::new(1.0, 0.3), springs).unwrap();
        let options = moulage::fem::EquilibriumOptions { tolerance: 1e-11, max_steps: 50 };
        let x = body.equilibrate(body.mesh.points.clone(), &plastic, &options).unwrap().x;
        let mut rows = Rows::default();
        for v in 18_u32..27 {
            let point = MaterialPoint(vec![(v, 0.7), (v - 9, 0.3)]);
            let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
            let residual = |d: &Vec3| 0.1 * libm::cos(f64::from(v) + d.y);
            rows.add(&point, axes.map(|d| (d, residual(&d), 20.0 + f64::from(v))));
        }
        Self { body, space, s, x, plastic, rows }
    }

    fn smoothness(&self, screening: Option<Screening>) -> StrainSmoothness {
        StrainSmoothness::new(
            &self.body,
            &self.space,
            0.5,
            screening,
            &vec![1.0; self.body.rest.len()],
        )
        .unwrap()
    }

    fn with<T>(&self, work: impl FnOnce(&Linearization<'_, StableNeoHookean>) -> T) -> T {
        let stiffness: Factor = self.body.factor_stiffness(&self.x, &self.plastic).unwrap();
        let sensitivity = Sensitivity::new(&self.body, &self.space, &self.x, &self.plastic);
        work(&Linearization::new(&self.body, &stiffness, &sensitivity, &self.x))
    }

    /// The strain that is 1 in one number and 0 in all others.
    fn unit(&self, k: usize) -> Vec<Sym3> {
        let mut e = vec![Sym3::zeros(); self.s.len()];
        e[k / 6][k % 6] = 1.0;
        e
    }

    /// R, assembled.
    fn precision(&self, prior: &StrainSmoothness) -> DMatrix<f64> {
        let n = 6 * self.s.len();
        let mut r = DMatrix::zeros(n, n);
        for k in 0..n {
            for (c, column) in prior.apply(&self.unit(k)).iter().enumerate() {
                r.view_mut((6 * c, k), (6, 1)).copy_from(column);
            }
        }
        r
    }

    /// The covariance of all vertices' coordinates, given the rows: all matrices assembled, the strains
    /// that the prior leaves free and rigid motions with a prior deviation of 1.
    fn dense_covariance(
        &self,
        at: &Linearization<'_, StableNeoHookean>,
        prior: &StrainSmoothness,
    ) -> DMatrix<f64> {
        let (n, coordinates) = (6 * self.s.len(), 3 * self.x.len());
        let flat = |field: &[Vec3]| {
            DVector::from_iterator(coordinates, field.iter().flat_map(|v| [v.x, v.y, v.z]))
        };
        let (mut j, r) = (DMatrix::zeros(coordinates, n), self.precision(prior));
        for k in 0..n {
            j.set_column(k, &flat(&at.shape_change(&self.unit(k))));
        }
        let largest = r.diagonal().max();
        let mut strains = r.pseudo_inverse(1e-9 * largest).unwrap();
        if prior.is_singular() {
            for (row, column) in
                (0..n).flat_map(|row| (row % 6..n).step_by(6).map(move |c| (row, c)))
            {
                strains[(row, column)] += 1.0;
            }
        }
        let mut before = &j * strains * j.transpose();
        if self.body.is_free() {
            for k in 0..6 {
                let mode: Vec<Vec3> =
                    self.x.iter().map(|x| rigid_modes(x, &at.center)[k]).collect();
                let mode = flat(&mode);
                before += &mode * mode.transpose();
            }
        }
        let mut a = DMatrix::zeros(self.rows.rows.len(), coordinates);
        for (i, row) in self.rows.rows.iter().enumerate() {
            for &(v, g) in self.rows.gradient(row) {
                for axis in 0..3 {
                    a[(i, 3 * v as usize + axis)] += g[axis] * row.weight.sqrt();
                }
            }
        }
        let seen = &a * &before * a.transpose();
        let capacity = DMatrix::identity(seen.nrows(), seen.ncols()) + seen;
        let gain = capacity.cholesky().unwrap().solve(&(&a * &before));
        &before - (&a * &before).transpose() * gain
    }

    /// The minimiser by the assembled Hessian (1 + damping) R + Z^T Z.
    fn dense(
        &self,
        at: &Linearization<'_, StableNeoHookean>,
        prior: &StrainSmoothness,
        damping: f64,
    ) -> Vec<Sym3> {
        let n = 6 * self.s.len();
        let (mut z, r) = (DMatrix::zeros(self.rows.rows.len(), n), self.precision(prior));
        for k in 0..n {
            z.set_column(k, &DVector::from_vec(self.rows.measure(&at.shape_change(&self.unit(k)))));
        }
        let s = DVector::from_iterator(n, self.s.iter().flat_map(|s| s.iter().copied()));
        let residual = DVector::from_iterator(
            self.rows.rows.len(),
            self.rows.rows.iter().map(|row| row.weight.sqrt() * row.residual),
        );
        let gradient = &r * s + z.transpose() * residual;
        let ds = (r * (1.0 + damping) + z.transpose() * &z).lu().solve(&-gradient).unwrap();
        ds.as_slice().chunks_exact(6).map(Sym3::from_column_slice).collect()
    }
}

fn relative(found: &[Sym3], expected: &[Sym3]) -> f64 {
    let error: f64 = found.iter().zip(expected).map(|(a, b)| (a - b).norm_squared()).sum();
    (error / expected.iter().map(Sym3::norm_squared).sum::<f64>()).sqrt()
}

#[test]
fn dual_equals_dense_hessian_screened_and_free() {
    let setup = Setup::new(StrainSpace::NODAL_LOGARITHM);
    for screening in [None, Some(SCREENING)] {
        let prior = setup.smoothness(screening);
        setup.with(|at| {
            let equations = NormalEquations::new(at, &setup.rows, None, &prior);
            for damping in [0.0, 3.0] {
                let found = equations.direction(&setup.s, damping, 1e-10).unwrap();
                let dense = setup.dense(at, &prior, damping);
                assert!(relative(&found.ds, &dense) < 1e-8, "{screening:?}, {damping}");
            }
        });
    }
}

#[test]
fn a_smoothness_its_gradient_and_its_inverse_agree() {
    let setup = Setup::new(StrainSpace::NODAL_LOGARITHM);
    let prior = setup.smoothness(Some(SCREENING));
    let gradient = prior.apply(&setup.s);
    let product: f64 = gradient.iter().zip(&setup.s).map(|(g, s)| g.dot(s)).sum();
    assert!((prior.energy(&setup.s) - 0.5 * product).abs() < 1e-12 * product);
    assert!(relative(&prior.solve(&gradient), &setup.s) < 1e-10);
}

#[test]
fn a_mean_strain_has_its_own_price() {
    let setup = Setup::new(StrainSpace::NODAL_LOGARITHM);
    let constant = Sym3::new(0.1, 0.0, 0.02, 0.03, 0.0, -0.2);
    let squares = constant.component_mul(&constant).dot(&Sym3::new(1.0, 2.0, 2.0, 1.0, 2.0, 1.0));
    // A field that is screened over a short distance can hardly follow by itself.
    let screening = Screening { length: 0.01, mean_sigma: 0.3 };
    let energy = setup.smoothness(Some(screening)).energy(&vec![constant; setup.s.len()]);
    assert!((energy / (0.5 * squares / 0.09) - 1.0).abs() < 1e-4, "{energy}");
}

#[test]
fn conjugate_gradients_over_representatives_equal_the_dual() {
    for held in [&[0, 2, 6, 8, 13][..], &[]] {
        let setup = Setup::held_at(StrainSpace::NODAL_LOGARITHM, held);
        // Five of the nine points, counted double.
        let mut few = Rows::default();
        for row in setup.rows.rows.chunks(3).step_by(2).flatten() {
            few.push(setup.rows.gradient(row).to_vec(), row.residual, 2.0 * row.weight);
        }
        for (screening, damping) in [(None, 0.0), (Some(SCREENING), 0.0), (Some(SCREENING), 3.0)] {
            let prior = setup.smoothness(screening);
            setup.with(|at| {
                let direct = NormalEquations::new(at, &setup.rows, None, &prior);
                let iterated = NormalEquations::new(at, &setup.rows, Some(&few), &prior);
                let direct = direct.direction(&setup.s, damping, 1e-10).unwrap();
                let iterated = iterated.direction(&setup.s, damping, 1e-8).unwrap();
                let error = relative(&iterated.ds, &direct.ds);
                assert!(error < 1e-6, "{held:?}, {screening:?}, {damping}: {error:e}");
                assert_eq!(direct.rigid.is_some(), held.is_empty());
                if let (Some(a), Some(b)) = (direct.rigid, iterated.rigid) {
                    assert!((a - b).norm() < 1e-5 * a.norm(), "{a} {b}");
                }
            });
        }
    }
}

#[test]
fn published_woodbury_equals_dual_and_dense_hessian() {
    let setup = Setup::new(StrainSpace::PAPER);
    let prior = setup.smoothness(None);
    setup.with(|at| {
        let dense = setup.dense(at, &prior, 0.0);
        let equations = NormalEquations::new(at, &setup.rows, None, &prior);
        let dual = equations.direction(&setup.s, 0.0, 1e-10).unwrap();
        let woodbury = at.woodbury_direction(&setup.rows, &prior, &setup.s, 1e-10);
        assert!(relative(&dual.ds, &dense) < 1e-8);
        assert!(relative(&woodbury.ds, &dense) < 1e-6);
    });
}

#[test]
fn samples_have_the_covariance_of_the_dense_posterior() {
    const SAMPLES: usize = 3000;
    for held in [&[0, 2, 6, 8, 13][..], &[]] {
        let setup = Setup::held_at(StrainSpace::NODAL_LOGARITHM, held);
        for screening in [None, Some(SCREENING)] {
            let prior = setup.smoothness(screening);
            setup.with(|at| {
                let dense = setup.dense_covariance(at, &prior);
                let posterior = Posterior::new(at, &setup.rows, &prior).unwrap();
                let samples = posterior.samples(0..SAMPLES);
                let coordinate = |field: &[Vec3], k: usize| field[k / 3][k % 3];
                let mut found = DMatrix::zeros(dense.nrows(), dense.ncols());
                for field in &samples {
                    let x = DVector::from_fn(dense.nrows(), |k, _| coordinate(field, k));
                    found += &x * x.transpose() / SAMPLES as f64;
                }
                let error = (&found - &dense).norm() / dense.norm();
                assert!(error < 0.1, "{held:?}, {screening:?}: {error}");
                // A variance is known to a share of sqrt(2 / samples): five times that for the worst.
                for k in 0..dense.nrows() {
                    let ratio = found[(k, k)] / dense[(k, k)];
                    assert!((ratio - 1.0).abs() < 0.13, "{held:?}, {screening:?}: {k} {ratio}");
                }
            });
        }
    }
}
