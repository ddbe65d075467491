//! The values of a joint's coordinates that come nearest to a pose.

use nalgebra::{DMatrix, DVector, UnitQuaternion};

use crate::io::osim::joint::{OsimCoordinate, OsimJoint, Values};
use crate::register::rotation::rotation_vector;

/// Gauss-Newton steps at most.
const MOST_STEPS: usize = 100;
/// Step of the differences, radians.
const DIFFERENCE: f64 = 1e-6;
/// Largest change of a coordinate in one step, radians.
const LONGEST_STEP: f64 = 0.5;

/// Sets the coordinates in `free` to the values that bring the joint's rotation nearest to `wanted`, each
/// within its range if `within`.
pub fn fit_coordinates(
    joint: &OsimJoint,
    free: &[&OsimCoordinate],
    wanted: &UnitQuaternion<f64>,
    within: bool,
    values: &mut Values,
) {
    let error =
        |values: &Values| rotation_vector(&(joint.transform(values).rotation.inverse() * wanted));
    if free.is_empty() {
        return;
    }
    for _ in 0..MOST_STEPS {
        let here = error(values);
        let mut jacobian = DMatrix::zeros(3, free.len());
        for (k, coordinate) in free.iter().enumerate() {
            let mut beside = values.clone();
            *beside.entry(coordinate.name.clone()).or_default() += DIFFERENCE;
            jacobian.set_column(k, &((error(&beside) - here) / DIFFERENCE));
        }
        // A coordinate at the end of its range that wants to go on stays there.
        let gradient = jacobian.transpose() * DVector::from_column_slice(here.as_slice());
        let held: Vec<bool> = free
            .iter()
            .zip(gradient.iter())
            .map(|(c, slope)| {
                let (at, [low, high]) = (values[&c.name], c.range);
                within && ((at <= low && *slope > 0.0) || (at >= high && *slope < 0.0))
            })
            .collect();
        for (k, _) in held.iter().enumerate().filter(|(_, held)| **held) {
            jacobian.column_mut(k).fill(0.0);
        }
        // Directions without effect, such as that of a translation, stay.
        let normal = jacobian.transpose() * &jacobian;
        let damped = &normal + DMatrix::identity(free.len(), free.len()) * 1e-12;
        let right = -jacobian.transpose() * DVector::from_column_slice(here.as_slice());
        let Some(step) = damped.lu().solve(&right) else { return };
        let mut moved: f64 = 0.0;
        for (coordinate, step) in free.iter().zip(step.iter()) {
            let Some(value) = values.get_mut(&coordinate.name) else { continue };
            let mut next = *value + step.clamp(-LONGEST_STEP, LONGEST_STEP);
            if within {
                next = next.clamp(coordinate.range[0], coordinate.range[1]);
            }
            moved = moved.max((next - *value).abs());
            *value = next;
        }
        if moved < 1e-13 {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::osim::model::OsimModel;
    use crate::io::osim::model::tests::LEG;
    use std::path::Path;

    fn fitted(text: &str, wanted: &Values, within: bool) -> Values {
        let model = OsimModel::parse(text, Path::new("leg.osim")).unwrap();
        let joint = &model.joints[0];
        let wanted = joint.transform(wanted).rotation;
        let free: Vec<&OsimCoordinate> = joint.coordinates.iter().collect();
        let mut values = model.default_values();
        fit_coordinates(joint, &free, &wanted, within, &mut values);
        values
    }

    #[test]
    fn the_coordinates_of_a_pose_are_found_again_within_their_ranges() {
        // A knee that turns about its second axis, too, as it bends.
        let text = LEG.replace(
            "<coordinates></coordinates><axis>0 1 0</axis><Constant><value>0</value></Constant>",
            "<coordinates>knee_angle</coordinates><axis>0 1 0</axis><SimmSpline><x>-2 -1 0 1</x><y>0.3 0.1 0 0</y></SimmSpline>",
        );
        assert!(text.contains("SimmSpline"));
        for angle in [-1.9, -0.7, 0.05] {
            let wanted = Values::from([("knee_angle".into(), angle)]);
            assert!((fitted(&text, &wanted, true)["knee_angle"] - angle).abs() < 1e-6);
        }
        let beyond = Values::from([("knee_angle".into(), 0.4)]);
        assert!((fitted(&text, &beyond, false)["knee_angle"] - 0.4).abs() < 1e-6);
        assert!((fitted(&text, &beyond, true)["knee_angle"] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn two_axes_of_which_one_is_at_its_end() {
        let text = LEG
            .replace("</Coordinate></coordinates>\n        <frames>", "</Coordinate><Coordinate name=\"turn\"><range>-1 1</range></Coordinate></coordinates>\n        <frames>")
            .replace(
                "<coordinates></coordinates><axis>0 1 0</axis><Constant><value>0</value></Constant>",
                "<coordinates>turn</coordinates><axis>0 1 0</axis><LinearFunction><coefficients>1 0</coefficients></LinearFunction>",
            );
        let wanted = Values::from([("knee_angle".into(), -1.2), ("turn".into(), 0.6)]);
        let found = fitted(&text, &wanted, true);
        assert!((found["knee_angle"] + 1.2).abs() < 1e-6 && (found["turn"] - 0.6).abs() < 1e-6);
        let wanted = Values::from([("knee_angle".into(), 0.5), ("turn".into(), 0.6)]);
        let found = fitted(&text, &wanted, true);
        assert!((found["knee_angle"] - 0.1).abs() < 1e-12);
        assert!((found["turn"] - 0.6).abs() < 0.05, "{found:?}");
    }
}
