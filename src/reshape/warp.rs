//! Shapes from linear displacements. A rotation, taken as linear, makes a body larger: so each tet is turned
//! and stretched by what the displacement's gradient says, and the tets are put together again
//! (Huang et al. 2011, rotation-strain coordinates).

use nalgebra::Rotation3;
use rayon::prelude::*;

use crate::error::Result;
use crate::fem::Body;
use crate::material::IsotropicDensity;
use crate::math::{Mat3, Vec3};
use crate::solve::{BlockPattern, Factor, SymbolicFactor};

/// Displacements of one body at one shape.
pub struct Warp<'a, M> {
    body: &'a Body<M>,
    x: &'a [Vec3],
    /// Of the Laplacian at rest, with one vertex held.
    factor: Factor,
}

impl<'a, M: IsotropicDensity> Warp<'a, M> {
    /// At the shape `x` of the body.
    pub fn new(body: &'a Body<M>, x: &'a [Vec3]) -> Result<Self> {
        let pattern = BlockPattern::of_tets(x.len(), &body.mesh.tets, 1);
        let mut laplacian = pattern.assemble(|t, a, b, _, _| {
            let element = &body.rest[t];
            element.volume * element.gradients[a].dot(&element.gradients[b])
        });
        // Exact, as no force sums to anything.
        laplacian.values[0] *= 2.0;
        Ok(Self { body, x, factor: SymbolicFactor::new(&pattern)?.factor(&laplacian)? })
    }

    /// The displacement that turns and stretches each tet as the linear one `dx` says.
    pub fn apply(&self, dx: &[Vec3]) -> Vec<Vec3> {
        let tets = &self.body.mesh.tets;
        let gradients: Vec<Mat3> = (0..tets.len())
            .into_par_iter()
            .map(|t| {
                let f = self.body.rest[t].deformation_gradient(&self.body.corners(self.x, t));
                let change = self.body.rest[t].deformation_gradient(&self.body.corners(dx, t));
                // A tet without a volume is not turned.
                let spatial = f.try_inverse().map_or_else(Mat3::zeros, |inverse| change * inverse);
                let (stretch, turn) =
                    ((spatial + spatial.transpose()) / 2.0, (spatial - spatial.transpose()) / 2.0);
                let axis = Vec3::new(turn[(2, 1)], turn[(0, 2)], turn[(1, 0)]);
                Rotation3::new(axis).into_inner() * (Mat3::identity() + stretch) * f
            })
            .collect();
        let mut force = vec![0.0; 3 * self.x.len()];
        for (t, tet) in tets.iter().enumerate() {
            let element = &self.body.rest[t];
            for (&v, g) in tet.iter().zip(&element.gradients) {
                let pull = gradients[t] * g * element.volume;
                for axis in 0..3 {
                    force[3 * v as usize + axis] += pull[axis];
                }
            }
        }
        self.factor.solve_rows(&mut force, 3);
        let found: Vec<Vec3> = force.chunks_exact(3).map(Vec3::from_column_slice).collect();
        let warped: Vec<Vec3> = found.iter().zip(self.x).map(|(now, x)| now - x).collect();
        let shift = shift(&warped, dx);
        warped.iter().map(|moved| moved + shift).collect()
    }
}

/// The translation from one displacement to another, above all where the latter is small: what is held stays.
fn shift(from: &[Vec3], to: &[Vec3]) -> Vec3 {
    let mean_square = to.iter().map(Vec3::norm_squared).sum::<f64>() / to.len() as f64;
    let least = 1e-3 * mean_square + f64::MIN_POSITIVE;
    let weights: Vec<f64> = to.iter().map(|to| 1.0 / (to.norm_squared() + least)).collect();
    let sum: Vec3 = from.iter().zip(to).zip(&weights).map(|((from, to), w)| (to - from) * *w).sum();
    sum / weights.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::StableNeoHookean;
    use crate::reshape::test_problems::ball_to_ellipsoid;

    fn ball() -> Body<StableNeoHookean> {
        let mesh = ball_to_ellipsoid().tets;
        Body::new(mesh, StableNeoHookean::new(1.0, 0.3), Vec::new()).unwrap()
    }

    #[test]
    fn a_linear_rotation_becomes_one() {
        let body = ball();
        // Stretched along x before.
        let x: Vec<Vec3> =
            body.mesh.points.iter().map(|p| p.component_mul(&Vec3::new(1.5, 1.0, 0.8))).collect();
        let (axis, shift) = (Vec3::new(0.2, -0.9, 0.5), Vec3::new(0.3, 0.0, 1.0));
        let dx: Vec<Vec3> = x.iter().map(|x| axis.cross(x) + shift).collect();
        let warped = Warp::new(&body, &x).unwrap().apply(&dx);
        let now: Vec<Vec3> = x.iter().zip(&warped).map(|(x, moved)| x + moved).collect();
        let turned = Rotation3::new(axis);
        for (a, b) in [(0, 7), (3, 100), (20, 60)] {
            assert!((now[b] - now[a] - turned * (x[b] - x[a])).norm() < 1e-9);
        }
    }

    #[test]
    fn small_displacements_stay_what_they_are() {
        let body = ball();
        let x = &body.mesh.points;
        let warp = Warp::new(&body, x).unwrap();
        let error = |size: f64| -> f64 {
            let dx: Vec<Vec3> =
                x.iter().map(|p| Vec3::new(p.y * p.y, p.x.sin(), p.x * p.z) * size).collect();
            let off = warp.apply(&dx).into_iter().zip(&dx).map(|(a, b)| (a - b).norm());
            off.fold(0.0, f64::max)
        };
        let order = (error(2e-2) / error(1e-2)).log2();
        assert!((1.8..2.2).contains(&order), "{order}");
    }

    #[test]
    fn what_is_held_stays() {
        let body = ball();
        let x = &body.mesh.points;
        let dx: Vec<Vec3> =
            x.iter().map(|p| Vec3::new(0.0, 0.0, 0.1 * (p.x + 1.0).max(0.0).powi(3))).collect();
        let warped = Warp::new(&body, x).unwrap().apply(&dx);
        for (p, moved) in x.iter().zip(&warped).filter(|(p, _)| p.x < -0.7) {
            assert!(moved.norm() < 0.03, "{p} {moved}");
        }
    }
}
