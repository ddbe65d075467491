//! How a body's points go from the template to the person, both seen from the body.

use crate::math::Vec3;

/// The map of a body: scale factors along its axes for the whole bone, and what single places of its surface
/// do besides.
#[derive(Clone, Debug)]
pub struct BodyShape {
    /// Scale factors along the body's axes.
    pub scale: Vec3,
    shift: Vec3,
    /// Template's vertices, their areas, and how far each is from where the scale would take it.
    vertices: Vec<(Vec3, f64, Vec3)>,
}

impl BodyShape {
    /// The scale factors that fit best, weighted by area.
    pub fn new(before: &[Vec3], after: &[Vec3], areas: &[f64]) -> Self {
        let total: f64 = areas.iter().sum();
        let mean = |points: &[Vec3]| -> Vec3 {
            points.iter().zip(areas).map(|(p, area)| p * *area).sum::<Vec3>() / total
        };
        let (from, to) = (mean(before), mean(after));
        let (mut own, mut both) = (Vec3::zeros(), Vec3::zeros());
        for ((p, q), area) in before.iter().zip(after).zip(areas) {
            own += (p - from).component_mul(&(p - from)) * *area;
            both += (p - from).component_mul(&(q - to)) * *area;
        }
        let scale = Vec3::from_fn(|k, _| if own[k] > 0.0 { both[k] / own[k] } else { 1.0 });
        let shift = to - scale.component_mul(&from);
        let rest = |p: &Vec3, q: &Vec3| q - scale.component_mul(p) - shift;
        let vertices = before.iter().zip(after).zip(areas);
        let vertices = vertices.map(|((p, q), area)| (*p, *area, rest(p, q))).collect();
        Self { scale, shift, vertices }
    }

    /// The person's place of a point. Near the surface it goes with the surface, far away with the whole bone:
    /// what vertices do besides the scale is weighted by area / distance^4, whose sum over a surface is that
    /// of the patch below the point.
    pub fn point(&self, point: &Vec3) -> Vec3 {
        let (mut weight, mut rest) = (0.0, Vec3::zeros());
        for (vertex, area, own) in &self.vertices {
            let square = (vertex - point).norm_squared();
            if square == 0.0 {
                (weight, rest) = (1.0, *own);
                break;
            }
            let w = area / (square * square);
            weight += w;
            rest += own * w;
        }
        let rest = if weight > 0.0 { rest / weight } else { rest };
        self.scale.component_mul(point) + self.shift + rest
    }

    /// Factor of a length along a direction.
    pub fn along(&self, direction: &Vec3) -> f64 {
        self.scale.component_mul(direction).norm() / direction.norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_near_the_surface_go_with_it_and_far_ones_with_the_scale() {
        // A ball of points; the person's is longer, and has a bump where x is largest.
        let ball: Vec<Vec3> = (0..2000)
            .map(|k| {
                let z = 1.0 - (f64::from(k) + 0.5) / 1000.0;
                let angle = f64::from(k) * 2.399_963;
                Vec3::new(
                    (1.0 - z * z).sqrt() * libm::cos(angle),
                    (1.0 - z * z).sqrt() * libm::sin(angle),
                    z,
                )
            })
            .collect();
        let scale = Vec3::new(1.0, 1.5, 1.0);
        let bump = |p: &Vec3| if p.x > 0.95 { Vec3::x() * 0.1 } else { Vec3::zeros() };
        let after: Vec<Vec3> =
            ball.iter().map(|p| scale.component_mul(p) + bump(p) + Vec3::z()).collect();
        let shape = BodyShape::new(&ball, &after, &vec![1.0; ball.len()]);
        assert!((shape.scale - scale).amax() < 0.02, "{}", shape.scale);
        assert!((shape.along(&Vec3::new(0.0, 3.0, 0.0)) - 1.5).abs() < 1e-9);
        let near = shape.point(&Vec3::new(1.01, 0.0, 0.0)) - Vec3::z();
        assert!((near.x - 1.11).abs() < 0.01, "{near}");
        let far = shape.point(&Vec3::new(-10.0, 2.0, 0.0)) - Vec3::z();
        assert!((far - Vec3::new(-10.0, 3.0, 0.0)).norm() < 0.2, "{far}");
        assert_eq!(shape.point(&ball[7]), after[7]);
    }
}
