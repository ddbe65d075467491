//! Static equilibrium at a given plastic strain, by Newton's method.

use nalgebra::Vector3;

use super::body::Body;
use super::element::Curvature;
use super::plastic::PlasticState;
use crate::error::Result;
use crate::material::IsotropicDensity;
use crate::math::Vec3;
use crate::solve::{Factor, Goal, RoundedFactor, backtrack, conjugate_gradients};

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
const NEAR: Goal = Goal { reduction: 0.02, max_steps: 20 };

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
            let lower = backtrack(energy, slope, |share| {
                let trial = subtract(&x, &step, share);
                let energy = self.energy(&trial, plastic);
                (trial, energy)
            });
            let Some(lower) = lower else {
                // At rounding level the energy no longer falls although the step is sound.
                let x = subtract(&x, &step, 1.0);
                let better = largest(&self.gradient(&x, plastic)) < options.tolerance;
                let outcome = if better { Outcome::Converged } else { Outcome::Stalled };
                return Ok(Equilibrium { x, outcome, steps });
            };
            (x, energy) = (lower.x, lower.value);
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
            let precondition = |r: &Vec<f64>| {
                let mut z: Vec<f32> = r.iter().map(|&r| r as f32).collect();
                near.solve_rows(&mut z, 1);
                z.into_iter().map(f64::from).collect()
            };
            let multiply = |p: &Vec<f64>| self.pattern().multiply(&k, p);
            let step = conjugate_gradients(multiply, precondition, g, NEAR);
            if step.reached {
                return Ok(step.x.chunks_exact(3).map(Vector3::from_column_slice).collect());
            }
        }
        Ok(solve_vectors(&self.factor_stiffness(x, plastic)?, gradient))
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
