//! A barrier that keeps elements from inverting, added to any density.

use super::elastic::{Density, IsotropicDensity};

/// psi + kappa b(J), b = -(1 - J/J0)^2 ln(J/J0) for J < J0, zero above, infinite at J <= 0. Twice
/// continuously differentiable; without effect on states that keep their volume above J0.
#[derive(Clone, Copy, Debug)]
pub struct InversionBarrier<M> {
    inner: M,
    start: f64,
    strength: f64,
}

impl<M> InversionBarrier<M> {
    /// `start`: J0, the volume ratio below which it acts; `strength`: kappa, in the unit of stress.
    pub fn new(inner: M, start: f64, strength: f64) -> Self {
        Self { inner, start, strength }
    }
}

impl<M: IsotropicDensity> IsotropicDensity for InversionBarrier<M> {
    fn density(&self, i: f64, j: f64) -> Density {
        let mut density = self.inner.density(i, j);
        if j <= 0.0 {
            density.value = f64::INFINITY;
        } else if j < self.start {
            let y = j / self.start;
            let (gap, log) = (1.0 - y, libm::log(y));
            density.value -= self.strength * gap * gap * log;
            density.d_j += self.strength / self.start * (2.0 * gap * log - gap * gap / y);
            density.d_jj += self.strength / (self.start * self.start)
                * (-2.0 * log + 4.0 * gap / y + gap * gap / (y * y));
        }
        density
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector1;

    use super::*;
    use crate::material::StableNeoHookean;
    use crate::math::derivative_check::order_of_convergence;

    #[test]
    fn derivatives_converge_at_second_order() {
        let barrier = InversionBarrier::new(StableNeoHookean::new(1.0, 0.3), 0.5, 2.0);
        for j in [0.1, 0.3, 0.45, 0.7] {
            let at = barrier.density(2.0, j);
            let value = |h: f64| barrier.density(2.0, j + 0.1 * h).value;
            let slope = |h: f64| barrier.density(2.0, j + 0.1 * h).d_j;
            assert!(
                order_of_convergence(|h| Vector1::new((value(h) - value(-h)) / (0.2 * h) - at.d_j))
                    > 1.9
            );
            assert!(
                order_of_convergence(|h| Vector1::new(
                    (slope(h) - slope(-h)) / (0.2 * h) - at.d_jj
                )) > 1.9
            );
        }
    }
}
