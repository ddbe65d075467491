//! One bone scaled along its principal axes, and what data say of its three scales.
//!
//! A surface tells where it ends, not how far a place has slid along it. So distances count along the
//! normals, and of what they say the part is taken out that the bone's pose could say as well: the shaft
//! of a bone whose ends were not seen knows its thickness and not its length.

use nalgebra::{SMatrix, SVector, SymmetricEigen};

use super::pose::{BoneMoments, moved};
use super::rotation::PairSums;
use crate::math::{Mat3, Vec3};
use crate::mesh::normals::unit_or_zero;

/// Weight by which the pose keeps its place where nothing holds it, as a round bone about its axis.
const LEAST_HOLD: f64 = 1e-9;

/// A bone of the template in its principal axes.
#[derive(Clone, Debug)]
pub(super) struct ScaledBone {
    centre: Vec3,
    /// World from principal axes.
    axes: Mat3,
    /// Its vertices and their normals along them.
    places: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// What its whole surface says of its scales, for each unit of mass on each unit of area.
    pub(super) weight: Mat3,
    pub(super) area: f64,
}

/// What data say of three scales s: half the sum of the squared distances, as far as no pose lowers it, is
/// s . weight s / 2 - s . pull, up to a constant.
#[derive(Clone, Debug)]
pub(super) struct ScaleData {
    pub(super) weight: Mat3,
    pub(super) pull: Vec3,
}

impl ScaledBone {
    pub(super) fn new(points: &[Vec3], normals: &[Vec3], areas: &[f64]) -> Self {
        let BoneMoments { mass: area, centre, spread } = BoneMoments::new(points, areas);
        let mut axes = SymmetricEigen::new(spread).eigenvectors;
        // A rotation, not a mirror image.
        axes *= axes.determinant().signum();
        let mut bone = Self {
            centre,
            axes,
            places: points.iter().map(|p| axes.tr_mul(&(p - centre))).collect(),
            normals: normals.iter().map(|n| axes.tr_mul(n)).collect(),
            weight: Mat3::zeros(),
            area,
        };
        bone.weight = bone.data(&Vec3::repeat(1.0), points, areas).weight;
        bone
    }

    /// Its vertices after scaling about the bone's centre.
    pub(super) fn shape(&self, scale: &Vec3) -> Vec<Vec3> {
        let scaled = |place: &Vec3| self.centre + self.axes * place.component_mul(scale);
        self.places.iter().map(scaled).collect()
    }

    /// What the places `wanted` of its vertices say under their `masses`, near the scales `scale`.
    pub(super) fn data(&self, scale: &Vec3, wanted: &[Vec3], masses: &[f64]) -> ScaleData {
        let mut sums = PairSums::new(Vec3::zeros());
        for ((place, to), &mass) in self.places.iter().zip(wanted).zip(masses) {
            sums.add(&place.component_mul(scale), &(to - self.centre), mass);
        }
        let Some(motion) = sums.best_rigid() else {
            return ScaleData { weight: Mat3::zeros(), pull: Vec3::zeros() };
        };
        let back = motion.inverse();
        // Unknowns: scales, shift, turn, all in the bone's axes.
        let (mut matrix, mut gradient) =
            (SMatrix::<f64, 9, 9>::zeros(), SVector::<f64, 9>::zeros());
        let surface = self.places.iter().zip(&self.normals).zip(wanted.iter().zip(masses));
        for ((place, normal), (to, &mass)) in surface {
            let at = place.component_mul(scale);
            let normal = unit_or_zero(&normal.component_div(scale));
            let distance = normal.dot(&(moved(&back, &(to - self.centre)) - at));
            let row = derivatives(place, &at, &normal);
            matrix += mass * row * row.transpose();
            gradient += mass * distance * row;
            for k in 0..3 {
                matrix[(3 + k, 3 + k)] += LEAST_HOLD * mass;
                matrix[(6 + k, 6 + k)] += LEAST_HOLD * mass * at.norm_squared();
            }
        }
        without_pose(&matrix, &gradient, scale)
    }
}

/// How the distance of the place `at` = scale x `place` along its `normal` falls with the bone's scales, its
/// shift and its turn about the centre.
fn derivatives(place: &Vec3, at: &Vec3, normal: &Vec3) -> SVector<f64, 9> {
    let mut row = SVector::<f64, 9>::zeros();
    row.fixed_rows_mut::<3>(0).copy_from(&normal.component_mul(place));
    row.fixed_rows_mut::<3>(3).copy_from(normal);
    row.fixed_rows_mut::<3>(6).copy_from(&at.cross(normal));
    row
}

/// The six unknowns of the pose eliminated: the Schur complement of their block.
fn without_pose(
    matrix: &SMatrix<f64, 9, 9>,
    gradient: &SVector<f64, 9>,
    scale: &Vec3,
) -> ScaleData {
    let coupling = matrix.fixed_view::<6, 3>(3, 0).into_owned();
    let pose = matrix.fixed_view::<6, 6>(3, 3).into_owned();
    let Some(pose) = pose.cholesky() else {
        return ScaleData { weight: Mat3::zeros(), pull: Vec3::zeros() };
    };
    let of_pose = pose.solve(&gradient.fixed_rows::<6>(3).into_owned());
    let weight = matrix.fixed_view::<3, 3>(0, 0) - coupling.tr_mul(&pose.solve(&coupling));
    let gradient = gradient.fixed_rows::<3>(0) - coupling.tr_mul(&of_pose);
    ScaleData { weight, pull: weight * scale + gradient }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::mesh::normals::{area_vectors, vertex_normals};
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    fn bone() -> (ScaledBone, Vec<Vec3>, Vec<f64>) {
        let surface = block(Vec3::new(50.0, 0.0, 0.0), Vec3::new(10.0, 2.0, 1.0), 8);
        let areas = vertex_areas(&surface.points, &surface.triangles);
        let faces = area_vectors(&surface.points, &surface.triangles);
        let normals = vertex_normals(surface.points.len(), &surface.triangles, &faces);
        (ScaledBone::new(&surface.points, &normals, &areas), surface.points, areas)
    }

    #[test]
    fn derivatives_converge_with_the_square_of_the_step() {
        let (place, scale) = (Vec3::new(3.0, -1.0, 2.0), Vec3::new(1.1, 0.9, 1.2));
        let normal = Vec3::new(0.3, 0.8, -0.5).normalize();
        let moved_along_normal = |u: SVector<f64, 9>| {
            let part = |k| Vec3::new(u[k], u[k + 1], u[k + 2]);
            let at = place.component_mul(&(scale + part(0)));
            normal.dot(&moved(&Isometry3::new(part(3), part(6)), &at))
        };
        let row = derivatives(&place, &place.component_mul(&scale), &normal);
        let error = |h: f64, k: usize| {
            let mut step = SVector::<f64, 9>::zeros();
            step[k] = h;
            let slope = (moved_along_normal(step) - moved_along_normal(-step)) / (2.0 * h);
            (slope - row[k]).abs()
        };
        for k in 0..9 {
            let (coarse, fine) = (error(0.1, k), error(0.01, k));
            assert!(fine < 0.011 * coarse + 1e-12, "{k}: {coarse} {fine}");
        }
    }

    #[test]
    fn one_step_tells_scales_from_a_pose() {
        let (bone, _, areas) = bone();
        let truth = Vec3::new(0.9, 1.2, 1.05);
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let wanted: Vec<Vec3> = bone.shape(&truth).iter().map(|p| moved(&motion, p)).collect();
        let data = bone.data(&Vec3::repeat(1.0), &wanted, &areas);
        let scale = data.weight.cholesky().unwrap().solve(&data.pull);
        assert!((scale - truth).norm() < 1e-6, "{scale}");
    }

    #[test]
    fn a_shaft_without_its_ends_knows_its_thickness_and_not_its_length() {
        let (bone, points, areas) = bone();
        let masses: Vec<f64> = points
            .iter()
            .zip(&areas)
            .map(|(p, area)| if (p.x - 50.0).abs() < 9.0 { *area } else { 0.0 })
            .collect();
        // Closest points of a shaft that is thicker; along it they have slid outwards.
        let wanted: Vec<Vec3> = points
            .iter()
            .map(|p| Vec3::new(p.x + 0.3 * (p.x - 50.0), 1.1 * p.y, 1.1 * p.z))
            .collect();
        let data = bone.data(&Vec3::repeat(1.0), &wanted, &masses);
        let long = bone.axes.transpose().column(0).iamax();
        assert!(data.weight[(long, long)] < 1e-6 * bone.weight[(long, long)], "{}", data.weight);
        let scale = (data.weight + 1e-6 * bone.weight).cholesky().unwrap();
        let scale = scale.solve(&(data.pull + 1e-6 * bone.weight * Vec3::repeat(1.0)));
        for k in (0..3).filter(|k| *k != long) {
            assert!((scale[k] - 1.1).abs() < 0.02, "{scale}");
        }
    }
}
