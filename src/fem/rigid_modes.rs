//! Rigid motions: the six modes, a gauge that takes them out, their exact application.

use crate::math::{Mat3, Vec3};
use nalgebra::{Rotation3, Vector6};

/// A finite rigid motion from six numbers: rotation vector and translation about a centre.
#[derive(Clone, Copy, Debug)]
pub struct RigidMotion {
    /// Rotation.
    pub rotation: Mat3,
    /// Translation of the centre.
    pub translation: Vec3,
    /// Fixed centre of the rotation.
    pub center: Vec3,
}

impl RigidMotion {
    /// From translation (first three) and rotation vector (last three), about `center`.
    pub fn new(modes: &Vector6<f64>, center: Vec3) -> Self {
        let (t, w) = (modes.fixed_rows::<3>(0).into_owned(), modes.fixed_rows::<3>(3).into_owned());
        Self { rotation: Rotation3::new(w).into_inner(), translation: t, center }
    }

    /// R (x - c) + c + t.
    pub fn apply(&self, x: &Vec3) -> Vec3 {
        self.rotation * (x - self.center) + self.center + self.translation
    }
}

/// The six rigid velocities of a point: three translations, three rotations about `center`.
pub fn rigid_modes(x: &Vec3, center: &Vec3) -> [Vec3; 6] {
    let r = x - center;
    [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::x().cross(&r), Vec3::y().cross(&r), Vec3::z().cross(&r)]
}

/// Six scalar degrees of freedom (3 v + axis) that hold a body without reaction: the first six
/// pivots of a column-pivoted QR of the rigid modes' transpose. Springs on them make K positive
/// definite and leave K^-1 b exact for every b that has no net force and moment.
pub fn isostatic_gauge(points: &[Vec3]) -> [usize; 6] {
    let center = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let scale =
        points.iter().map(|p| (p - center).norm()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut rows: Vec<Vector6<f64>> = points
        .iter()
        .flat_map(|p| {
            let modes = rigid_modes(&((p - center) / scale), &Vec3::zeros());
            (0..3).map(move |axis| Vector6::from_fn(|k, _| modes[k][axis]))
        })
        .collect();
    std::array::from_fn(|_| {
        let pivot = (0..rows.len())
            .max_by(|&a, &b| {
                rows[a].norm_squared().total_cmp(&rows[b].norm_squared()).then(b.cmp(&a))
            })
            .expect("a mesh has points");
        let direction = rows[pivot].normalize();
        for row in &mut rows {
            *row -= direction * direction.dot(row);
        }
        pivot
    })
}
