//! Colours of pages: of what has no value, and of values.

use serde::{Serialize, Serializer};

/// A colour, red, green and blue, 0 to 1 each.
pub type Colour = [f64; 3];

/// A surface that shows nothing but its shape.
pub(crate) const SKIN: Colour = [0.86, 0.80, 0.74];
/// What may be wrong, and what is.
pub(crate) const DOUBTFUL: Colour = [0.95, 0.65, 0.10];
pub(crate) const FAILED: Colour = [0.80, 0.10, 0.10];
/// What the data do not show.
pub(crate) const UNSEEN: Colour = [0.35, 0.55, 0.80];
/// Where a value is not known.
pub(crate) const UNKNOWN: Colour = [0.55; 3];

/// Colours at some values, and in between by their distance.
#[derive(Clone, Debug)]
pub(crate) struct Ramp(Vec<(f64, Colour)>);

impl Ramp {
    /// `stops`: rising values from 0 to 1 or beyond, each with its colour; they are stretched by `scale`.
    pub(crate) fn scaled(stops: &[(f64, Colour)], scale: f64) -> Self {
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { f64::MIN_POSITIVE.sqrt() };
        Self(stops.iter().map(|&(value, colour)| (scale * value, colour)).collect())
    }

    /// The colour of a value; beyond the ends that of the end.
    pub(crate) fn colour(&self, value: f64) -> Colour {
        if value.is_nan() {
            return UNKNOWN;
        }
        let above = self.0.partition_point(|(stop, _)| *stop <= value);
        if above == 0 || above == self.0.len() {
            return self.0[above.saturating_sub(1)].1;
        }
        let ((low, from), (high, to)) = (self.0[above - 1], self.0[above]);
        let share = (value - low) / (high - low);
        [0, 1, 2].map(|k| from[k] + share * (to[k] - from[k]))
    }

    /// The colours of many values.
    pub(crate) fn colours(&self, values: &[f64]) -> Vec<Colour> {
        values.iter().map(|&value| self.colour(value)).collect()
    }
}

impl Serialize for Ramp {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_stops_the_colour_is_between_theirs() {
        let [black, white] = [[0.0; 3], [1.0; 3]];
        let ramp = Ramp::scaled(&[(0.0, black), (1.0, white)], 4.0);
        assert_eq!(
            ramp.colours(&[-1.0, 0.0, 1.0, 4.0, 9.0, f64::NAN]),
            [black, black, [0.25; 3], white, white, UNKNOWN]
        );
    }

    #[test]
    fn a_scale_of_zero_tells_zero_from_more() {
        let ramp = Ramp::scaled(&[(0.0, [0.0; 3]), (1.0, [1.0; 3])], 0.0);
        assert_eq!(ramp.colours(&[0.0, 1e-9]), [[0.0; 3], [1.0; 3]]);
    }
}
