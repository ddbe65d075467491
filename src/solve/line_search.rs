//! Backtracking along a direction of descent.

/// Halvings before a step is given up.
const MAX_HALVINGS: usize = 25;

/// Fraction of the decrease predicted by the slope that a step must achieve (Armijo 1966).
const ARMIJO: f64 = 1e-4;

/// A place that is low enough.
#[derive(Clone, Copy, Debug)]
pub struct Lower<X> {
    /// The place.
    pub x: X,
    /// The function there.
    pub value: f64,
    /// Share of the step that leads there.
    pub share: f64,
}

/// Halves a step until the function falls enough: `at` gives the place at a share of the step and the
/// function there. `value` and `slope`, below 0, are those at its beginning. None where it does not fall.
pub fn backtrack<X>(
    value: f64,
    slope: f64,
    mut at: impl FnMut(f64) -> (X, f64),
) -> Option<Lower<X>> {
    let mut share = 1.0;
    for _ in 0..MAX_HALVINGS {
        let (x, there) = at(share);
        if there <= value + ARMIJO * share * slope {
            return Some(Lower { x, value: there, share });
        }
        share *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_is_too_long_is_halved_and_one_uphill_refused() {
        let parabola = |x: f64| (x, (x - 1.0) * (x - 1.0));
        let found = backtrack(1.0, -16.0, |share| parabola(8.0 * share)).unwrap();
        assert!((found.share - 0.125).abs() < 1e-15 && found.value < 1e-15);
        assert!(backtrack(1.0, -2.0, |share| parabola(-share)).is_none());
    }
}
