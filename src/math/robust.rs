//! Figures of many values that some wrong ones do not spoil.

/// The middle value, of an even number the upper one of the two; none of no values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The standard deviation of distances from zero by their median (1.4826 of it, as of a normal
/// distribution), never below `least`.
pub fn robust_deviation(distances: &[f64], least: f64) -> f64 {
    least.max(1.4826 * median(distances.iter().copied()).unwrap_or(0.0))
}

/// Huber's cost of a residual, 1/2 r^2 up to the limit and linear beyond it, and the weight cost'(r) / r.
pub fn huber(r: f64, limit: f64) -> (f64, f64) {
    if r <= limit { (0.5 * r * r, 1.0) } else { (limit * (r - 0.5 * limit), limit / r) }
}

/// The cost of Geman and McClure (1987), 1/2 r^2 for small residuals and never above 1/2 limit^2, and the
/// weight cost'(r) / r.
pub fn geman_mcclure(r: f64, limit: f64) -> (f64, f64) {
    let shrink = 1.0 / (1.0 + (r / limit).powi(2));
    (0.5 * r * r * shrink, shrink * shrink)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_value() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), Some(3.0));
        assert_eq!(median([]), None);
    }

    #[test]
    fn weights_are_the_derivative_of_the_cost_over_the_residual() {
        for (r, limit) in [(0.5, 2.0), (1.9, 2.0), (5.0, 2.0), (40.0, 2.0)] {
            for cost in [huber, geman_mcclure] {
                // Central differences: the error falls with the square of the step.
                let error = |h: f64| {
                    let slope = (cost(r + h, limit).0 - cost(r - h, limit).0) / (2.0 * h);
                    (slope / r - cost(r, limit).1).abs()
                };
                assert!(error(1e-3) < 1e-6, "{r}");
                assert!(error(1e-3) < 0.3 * error(2e-3) + 1e-12, "{r}");
            }
        }
    }

    #[test]
    fn one_wrong_value_does_not_widen_the_rest() {
        assert!((robust_deviation(&[1.0, 2.0, 1e9], 0.5) - 2.9652).abs() < 1e-12);
        assert!((robust_deviation(&[0.1], 0.5) - 0.5).abs() < 1e-12);
    }
}
