//! Static equilibrium at a given plastic strain, by Newton's method.

use nalgebra::Vector3;

use super::body::Body;
use super::element::Curvature;
use super::plastic::PlasticState;
use crate::error::Result;
use crate::material::IsotropicDensity;
use crate::math::Vec3;
use crate::solve::{Factor, RoundedFactor};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct EquilibriumOptions {
    /// Largest residual force allowed, relative to Young's modulus times length squared.
    pub tolerance: f64,
    /// Newton steps allowed.
    pub max_steps: usize,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The residual is below the tolerance.
    Converged,
    /// The steps ran out, no step lowered the energy, or the shape was hopeless.
    Stalled,
}

/// A shape in equilibrium (or as near as the solve came).
pub struct Equilibrium {
    /// Vertex positions.
    pub x: Vec<Vec3>,
    /// Whether the residual fell below the tolerance.
    pub outcome: Outcome,
    /// Newton steps taken.
    pub steps: usize,
}

/// Conjugate gradients end when the residual, measured by the preconditioner, has fallen to this share,
/// and give up after so many steps.
const CG_REDUCTION: f64 = 0.02;
const CG_STEPS: usize = 20;

/// Line-search halvings before a Newton step is given up.
const MAX_HALVINGS: usize = 25;

/// Fraction of the predicted decrease that a step must achieve.
const ARMIJO: f64 = 1e-4;

impl<M: IsotropicDensity> Body<M> {
    /// Minimises the energy from the shape `x`.
    pub fn equilibrate(
        &self,
        x: Vec<Vec3>,
        plastic: &[PlasticState],
        options: &EquilibriumOptions,
    ) -> Result<Equilibrium> {
        self.newton(x, plastic, options, None, &|_| false)
    }

    /// The same where the stiffness of a state near by is factored already: it preconditions
    /// conjugate gradients, which need no factor of their own. Stalls when after a step the shape is
    /// `hopeless`.
    pub fn equilibrate_near(
        &self,
        x: Vec<Vec3>,
        plastic: &[PlasticState],
        options: &EquilibriumOptions,
        near: &RoundedFactor<f32>,
        hopeless: &dyn Fn(&[Vec3]) -> bool,
    ) -> Result<Equilibrium> {
        self.newton(x, plastic, options, Some(near), hopeless)
    }

    fn newton(
        &self,
        mut x: Vec<Vec3>,
        plastic: &[PlasticState],
        options: &EquilibriumOptions,
        near: Option<&RoundedFactor<f32>>,
        hopeless: &dyn Fn(&[Vec3]) -> bool,
    ) -> Result<Equilibrium> {
        let mut energy = self.energy(&x, plastic);
        let mut gradient = self.gradient(&x, plastic);
        for steps in 0..=options.max_steps {
            let residual = largest(&gradient);
            if residual < options.tolerance {
                return Ok(Equilibrium { x, outcome: Outcome::Converged, steps });
            }
            if steps == options.max_steps || !energy.is_finite() || (steps > 0 && hopeless(&x)) {
                return Ok(Equilibrium { x, outcome: Outcome::Stalled, steps });
            }
            let step = self.newton_step(&x, plastic, &gradient, near)?;
            let slope: f64 = -step.iter().zip(&gradient).map(|(s, g)| s.dot(g)).sum::<f64>();
            let Some((trial, trial_energy)) = self.armijo(&x, &step, plastic, energy, slope) else {
                // At rounding level the energy no longer falls although the step is sound.
                let x = subtract(&x, &step, 1.0);
                let better = largest(&self.gradient(&x, plastic)) < options.tolerance;
                let outcome = if better { Outcome::Converged } else { Outcome::Stalled };
                return Ok(Equilibrium { x, outcome, steps });
            };
            (x, energy) = (trial, trial_energy);
            gradient = self.gradient(&x, plastic);
        }
        unreachable!("the last pass returns")
    }

    /// K^-1 g, or at least a direction of descent.
    fn newton_step(
        &self,
        x: &[Vec3],
        plastic: &[PlasticState],
        gradient: &[Vec3],
        near: Option<&RoundedFactor<f32>>,
    ) -> Result<Vec<Vec3>> {
        if let Some(near) = near {
            let k = self.stiffness(x, plastic, Curvature::True);
            let g: Vec<f64> = gradient.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
            let multiply = |p: &[f64]| self.pattern().multiply(&k, p);
            if let Some(step) = conjugate_gradients(multiply, near, &g) {
                return Ok(step.chunks_exact(3).map(Vector3::from_column_slice).collect());
            }
        }
        Ok(solve_vectors(&self.factor_stiffness(x, plastic)?, gradient))
    }

    /// Halves the step until the energy falls enough.
    fn armijo(
        &self,
        x: &[Vec3],
        step: &[Vec3],
        plastic: &[PlasticState],
        energy: f64,
        slope: f64,
    ) -> Option<(Vec<Vec3>, f64)> {
        let mut eta = 1.0;
        for _ in 0..MAX_HALVINGS {
            let trial = subtract(x, step, eta);
            let trial_energy = self.energy(&trial, plastic);
            if trial_energy <= energy + ARMIJO * eta * slope {
                return Some((trial, trial_energy));
            }
            eta *= 0.5;
        }
        None
    }
}

/// K^-1 g for one field of vectors.
pub fn solve_vectors(factor: &Factor, g: &[Vec3]) -> Vec<Vec3> {
    let mut flat: Vec<f64> = g.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    factor.solve(&mut flat);
    flat.chunks_exact(3).map(Vector3::from_column_slice).collect()
}

fn subtract(x: &[Vec3], step: &[Vec3], eta: f64) -> Vec<Vec3> {
    x.iter().zip(step).map(|(x, s)| x - s * eta).collect()
}

fn largest(g: &[Vec3]) -> f64 {
    g.iter().map(Vec3::norm).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Conjugate gradients on A x = b, preconditioned. Where A turns out indefinite, the sum so far,
/// which still goes downhill; `None` when it takes too many steps.
fn conjugate_gradients(
    multiply: impl Fn(&[f64]) -> Vec<f64>,
    preconditioner: &RoundedFactor<f32>,
    b: &[f64],
) -> Option<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let precondition = |r: &[f64]| {
        let mut z: Vec<f32> = r.iter().map(|&r| r as f32).collect();
        preconditioner.solve_rows(&mut z, 1);
        z.into_iter().map(f64::from).collect::<Vec<f64>>()
    };
    let (mut x, mut r) = (vec![0.0; b.len()], b.to_vec());
    let z = precondition(&r);
    let mut rz = dot(&r, &z);
    let mut p = z;
    let goal = CG_REDUCTION * CG_REDUCTION * rz;
    for step in 0..CG_STEPS {
        let ap = multiply(&p);
        let curvature = dot(&p, &ap);
        if curvature <= 0.0 {
            return Some(if step == 0 { p } else { x });
        }
        let alpha = rz / curvature;
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
        r.iter_mut().zip(&ap).for_each(|(r, ap)| *r -= alpha * ap);
        let z = precondition(&r);
        let next = dot(&r, &z);
        if next <= goal {
            return Some(x);
        }
        let beta = next / rz;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + beta * *p);
        rz = next;
    }
    None
}
