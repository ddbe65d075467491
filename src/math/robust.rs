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
    fn one_wrong_value_does_not_widen_the_rest() {
        assert!((robust_deviation(&[1.0, 2.0, 1e9], 0.5) - 2.9652).abs() < 1e-12);
        assert!((robust_deviation(&[0.1], 0.5) - 0.5).abs() < 1e-12);
    }
}
