//! Pins: landmarks that end within a distance of their targets, whatever the markers say.

use crate::fem::MaterialPoint;
use crate::math::Vec3;

use super::rows::Rows;
use super::term::{Place, Term, Weighed, Weighting};

/// A marker's noise in that of a pin: so much better a pin is known.
const FIRMNESS: f64 = 30.0;

/// A pin.
pub struct Pin {
    /// The point of the body.
    pub point: MaterialPoint,
    /// Where it belongs.
    pub target: Vec3,
    /// How far from there it may be; inside nothing pulls.
    pub within: f64,
    /// The user's weight.
    pub weight: f64,
}

/// All pins.
pub struct Pins {
    pub list: Vec<Pin>,
    sigma: f64,
}

impl Pins {
    /// Beside markers of the noise `sigma`.
    pub fn new(list: Vec<Pin>, sigma: f64) -> Self {
        Self { list, sigma: sigma / FIRMNESS }
    }

    /// Whether one is still farther off than it may be, by more than a marker's noise.
    pub fn any_lags(&self, x: &[Vec3]) -> bool {
        self.list.iter().any(|pin| pin.excess(x) > FIRMNESS * self.sigma && pin.weight > 0.0)
    }
}

impl Pin {
    fn gap(&self, x: &[Vec3]) -> Vec3 {
        self.point.position(x) - self.target
    }

    fn excess(&self, x: &[Vec3]) -> f64 {
        self.gap(x).norm() - self.within
    }
}

impl Term for Pins {
    /// They gain weight as the markers do: a start that follows few points alone is skewed.
    fn weigh(&self, _: &Place, weighting: Weighting) -> Weighed {
        let scale = weighting.scale / self.sigma.powi(2);
        Weighed { weights: self.list.iter().map(|pin| pin.weight * scale).collect(), cost: None }
    }

    fn add_rows(&self, place: &Place, weights: &[f64], rows: &mut Rows) {
        for (pin, &weight) in self.list.iter().zip(weights) {
            let (gap, excess) = (pin.gap(place.x), pin.excess(place.x));
            if pin.within == 0.0 {
                let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
                rows.add(&pin.point, axes.map(|d| (d, d.dot(&gap), weight)));
            } else if excess > 0.0 {
                rows.add(&pin.point, [(gap.normalize(), excess, weight)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reshape::problem::{Landmark, Marker, Problem, TemplatePoint};
    use crate::reshape::test_problems::ball_to_ellipsoid;
    use crate::reshape::{Options, reshape, reshape_again};
    use crate::run::Run;

    /// A ball whose markers say that it stays, and a landmark at its tip that says otherwise.
    fn problem(target: Vec3, within: Option<f64>) -> Problem {
        let mut problem = ball_to_ellipsoid();
        problem.markers = problem.surface.points.iter().map(|&p| Marker::at(p)).collect();
        let template = TemplatePoint::Vertex(tip(&problem) as u32);
        let label = "tip".to_owned();
        problem.landmarks = vec![Landmark { label, template, target, weight: 1.0, within }];
        problem
    }

    fn tip(problem: &Problem) -> usize {
        let points = &problem.surface.points;
        (0..points.len()).max_by(|&a, &b| points[a].x.total_cmp(&points[b].x)).unwrap()
    }

    /// How far the tip ends from its target.
    fn off(within: Option<f64>) -> f64 {
        let target = Vec3::new(1.15, 0.02, 0.0);
        let problem = problem(target, within);
        let found = reshape(&problem, &Options::default(), &Run::new()).unwrap();
        (found.surface_points[tip(&problem)] - target).norm()
    }

    #[test]
    fn a_pin_is_met_where_a_landmark_gives_way_to_the_markers() {
        assert!(off(None) > 0.1, "{}", off(None));
        assert!(off(Some(0.0)) < 2e-3, "{}", off(Some(0.0)));
    }

    #[test]
    fn within_its_distance_nothing_pulls_and_beyond_it_the_markers_give_way() {
        let near = off(Some(0.05));
        assert!((near - 0.05).abs() < 2e-3, "{near}");
        // The markers leave it .15 away, which is allowed.
        assert!((off(Some(0.3)) - off(Some(0.5))).abs() < 1e-9);
    }

    #[test]
    fn a_pin_that_is_dragged_takes_its_vertex_along() {
        let first = problem(Vec3::x(), Some(0.0));
        let run = Run::new();
        let before = reshape(&first, &Options::default(), &run).unwrap();
        for drag in [Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 0.08, 0.05)] {
            let target = before.surface_points[tip(&first)] + drag;
            let mut moved = first.clone();
            moved.landmarks[0].target = target;
            let after = reshape_again(&before, &moved, &Options::default(), &run).unwrap();
            let left = (after.surface_points[tip(&first)] - target).norm();
            let tolerance = first.surface.diagonal() / 1000.0;
            assert!(left < tolerance, "{left} of {}", drag.norm());
        }
    }

    #[test]
    fn lengths_below_zero_are_refused() {
        let wrong = problem(Vec3::x(), Some(-1.0)).check().unwrap_err().to_string();
        assert!(wrong.contains("landmark 0 (tip) is to be held within -1"), "{wrong}");
    }
}
