//! Stable neo-Hookean elasticity (Smith, de Goes, Kim 2018): finite under inversion.

use super::elastic::{Density, IsotropicDensity};

/// psi = mu/2 (I - 3) + lambda/2 (J - alpha)^2 - mu/2 log(I + 1) - psi0, zero and stress-free at rest.
#[derive(Clone, Copy, Debug)]
pub struct StableNeoHookean {
    mu: f64,
    lambda: f64,
    alpha: f64,
    psi0: f64,
}

impl StableNeoHookean {
    /// From Young's modulus (any unit of stress) and Poisson's ratio in (-1, 0.5).
    pub fn new(young: f64, poisson: f64) -> Self {
        let mu_lame = young / (2.0 * (1.0 + poisson));
        let lambda_lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let mu = 4.0 / 3.0 * mu_lame;
        let lambda = lambda_lame + 5.0 / 6.0 * mu_lame;
        let alpha = 1.0 + 3.0 * mu / (4.0 * lambda);
        let psi0 = 0.5 * lambda * (1.0 - alpha).powi(2) - 0.5 * mu * libm::log(4.0_f64);
        Self { mu, lambda, alpha, psi0 }
    }
}

impl IsotropicDensity for StableNeoHookean {
    fn density(&self, i: f64, j: f64) -> Density {
        let Self { mu, lambda, alpha, psi0 } = *self;
        let excess = j - alpha;
        Density {
            value: 0.5 * mu * (i - 3.0) + 0.5 * lambda * excess * excess
                - 0.5 * mu * libm::log(i + 1.0)
                - psi0,
            d_i: 0.5 * mu * (1.0 - 1.0 / (i + 1.0)),
            d_j: lambda * excess,
            d_ii: 0.5 * mu / (i + 1.0).powi(2),
            d_ij: 0.0,
            d_jj: lambda,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::stress;
    use crate::math::Mat3;

    #[test]
    fn rest_state_has_no_energy_and_no_stress() {
        let material = StableNeoHookean::new(2.0, 0.3);
        let d = material.at(&Mat3::identity());
        assert!(d.value.abs() < 1e-14);
        assert!(stress(&d, &Mat3::identity()).norm() < 1e-14);
    }
}
