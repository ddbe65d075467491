//! A derivative is right when the error of its difference quotient falls as theory says.

use nalgebra::{Dim, Matrix, RawStorage, Storage};

/// Order at which `error(h)` falls when `h` is halved: 2 for a central difference against a right
/// derivative, 0 against a wrong one. Infinite when the error is at rounding level throughout.
pub fn order_of_convergence<R: Dim, C: Dim, S: RawStorage<f64, R, C> + Storage<f64, R, C>>(
    error: impl Fn(f64) -> Matrix<f64, R, C, S>,
) -> f64 {
    let (coarse, fine) = (error(2e-3).norm(), error(1e-3).norm());
    if coarse < 1e-12 {
        return f64::INFINITY;
    }
    libm::log2(coarse / fine)
}
