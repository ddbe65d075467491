//! Values known at scattered points, carried over to others.

use rayon::prelude::*;

use crate::locate::NearestPoints;
use crate::math::Vec3;
use crate::mesh::bounding_box;

/// So many of the points that are nearest to a place count there.
const NEAREST: usize = 4;
/// Farther from its nearest point than so many times the points' usual spacing, a place has no value.
const REACH: f64 = 3.0;
/// Points as near as this share of the spacing count alike, so that no point alone decides around itself.
const SOFTNESS: f64 = 0.1;
/// The usual spacing is found from so many points.
const SAMPLES: usize = 500;
/// Least spacing, as a share of the points' extent: for points that all have a twin.
const LEAST_SPACING: f64 = 1e-6;

/// Shepard's interpolation (1968) of `values`, known at `known`, at each of `places`: the mean of the nearest ones,
/// weighted by the inverse square of their distance. NaN where none is near.
pub fn interpolate(known: &[Vec3], values: &[f64], places: &[Vec3]) -> Vec<f64> {
    let nearest = NearestPoints::new(known);
    let spacing = usual_spacing(&nearest, known);
    places.par_iter().map(|place| mean_near(&nearest, values, spacing, place)).collect()
}

/// The median distance of a point to the one nearest to it.
fn usual_spacing(nearest: &NearestPoints, known: &[Vec3]) -> f64 {
    let extent = bounding_box(known).map_or(0.0, |(low, high)| (high - low).norm());
    let sampled = known.iter().step_by((known.len() / SAMPLES).max(1));
    let mut gaps: Vec<f64> = sampled.map(|p| nearest.few_nearest::<2>(p)[1].1.sqrt()).collect();
    gaps.sort_by(f64::total_cmp);
    let median = gaps.get(gaps.len() / 2).copied().unwrap_or(f64::INFINITY);
    median.max(LEAST_SPACING * extent)
}

fn mean_near(nearest: &NearestPoints, values: &[f64], spacing: f64, place: &Vec3) -> f64 {
    let few = nearest.few_nearest::<NEAREST>(place);
    if few[0].1.sqrt() > REACH * spacing || few[0].1 == f64::INFINITY {
        return f64::NAN;
    }
    let softness = (SOFTNESS * spacing).powi(2);
    let (mut sum, mut total) = (0.0, 0.0);
    for (i, distance_squared) in few {
        if let Some(value) = values.get(i as usize) {
            // A single point has no spacing, and is alone.
            let weight =
                if spacing.is_finite() { 1.0 / (distance_squared + softness) } else { 1.0 };
            sum += weight * value;
            total += weight;
        }
    }
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Vec3> {
        (0..25).map(|i| Vec3::new(f64::from(i % 5), f64::from(i / 5), 0.0)).collect()
    }

    #[test]
    fn a_value_is_that_of_a_point_there_and_a_mean_between_points() {
        let values: Vec<f64> = (0..25).map(|i| f64::from(i % 5)).collect();
        let places = [Vec3::new(2.0, 2.0, 0.0), Vec3::new(2.5, 2.5, 0.0)];
        let found = interpolate(&grid(), &values, &places);
        assert!((found[0] - 2.0).abs() < 0.02, "{found:?}");
        assert!((found[1] - 2.5).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn where_no_point_is_near_there_is_no_value() {
        let found =
            interpolate(&grid(), &[1.0; 25], &[Vec3::new(2.0, 2.0, 2.9), Vec3::new(2.0, 2.0, 3.1)]);
        assert!((found[0] - 1.0).abs() < 1e-12 && found[1].is_nan(), "{found:?}");
    }

    #[test]
    fn one_point_counts_everywhere_and_none_nowhere() {
        let far = [Vec3::repeat(1e6)];
        assert_eq!(interpolate(&[Vec3::zeros()], &[3.0], &far), [3.0]);
        assert!(interpolate(&[], &[], &far)[0].is_nan());
    }

    #[test]
    fn points_that_all_have_a_twin_have_a_spacing() {
        let twins: Vec<Vec3> = grid().into_iter().chain(grid()).collect();
        let found = interpolate(&twins, &[2.0; 50], &[Vec3::zeros()]);
        assert!((found[0] - 2.0).abs() < 1e-12, "{found:?}");
    }
}
