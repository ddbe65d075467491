//! The as-rigid-as-possible filter: overlapping clusters follow rigidly, vertices blend them.
//!
//! [G] section 3.2. Each cluster takes the rigid motion that fits its vertices' wanted positions
//! best; a vertex goes where the mean of its clusters' motions sends it.
//! - exact form, one cluster at every vertex: [`FastSums`], Eq. (1) of the paper;
//! - sampled clusters with a smooth weight: [`SampledClusters`], some ten times faster.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rayon::prelude::*;

use super::fast_sums::FastSums;
use super::rotation::{PairSums, best_rotation};
use super::sampled_clusters::SampledClusters;
use crate::math::{Mat3, Vec3};

/// One level of the filter.
#[derive(Clone, Debug)]
pub enum Elastic {
    /// One rigid motion for everything (cluster radius infinite).
    Rigid,
    /// Clusters around sampled centres.
    Sampled(SampledClusters),
    /// A cluster around every vertex, uniform weights, as published.
    Exact(FastSums),
}

impl Elastic {
    /// Where the filter sends the vertices. All slices have one entry per vertex; `masses` are the
    /// vertex areas times the trust in the wanted position, positive.
    pub fn apply(&self, reference: &[Vec3], wanted: &[Vec3], masses: &[f64]) -> Vec<Vec3> {
        match self {
            Self::Rigid => {
                let motion = whole_motion(reference, wanted, masses);
                reference.par_iter().map(|p| super::pose::moved(&motion, p)).collect()
            }
            Self::Sampled(clusters) => clusters.apply(reference, wanted, masses),
            Self::Exact(sums) => exact(sums, reference, wanted, masses),
        }
    }
}

/// The best rigid motion of all vertices; the identity without mass.
pub fn whole_motion(reference: &[Vec3], wanted: &[Vec3], masses: &[f64]) -> Isometry3<f64> {
    let Some(&origin) = reference.first() else { return Isometry3::identity() };
    let mut sums = PairSums::new(origin);
    for ((from, to), &mass) in reference.iter().zip(wanted).zip(masses) {
        sums.add(from, to, mass);
    }
    sums.best_rigid().unwrap_or_else(Isometry3::identity)
}

/// Cluster sums of mass, reference, wanted and their product (16 numbers), then of the clusters'
/// motions (12 numbers). [G] Eq. (1).
fn exact(sums: &FastSums, reference: &[Vec3], wanted: &[Vec3], masses: &[f64]) -> Vec<Vec3> {
    let Some(&origin) = reference.first() else { return Vec::new() };
    let field: Vec<[f64; 16]> = (0..reference.len())
        .into_par_iter()
        .map(|i| pack_moments(masses[i], reference[i] - origin, wanted[i] - origin))
        .collect();
    let motions: Vec<[f64; 12]> =
        sums.sum(&field).par_iter().map(|moments| pack_motion(&cluster_motion(moments))).collect();
    let blended = sums.sum(&motions);
    (0..reference.len())
        .into_par_iter()
        .map(|i| {
            let size = f64::from(sums.cluster_size(i));
            let rotation = Mat3::from_column_slice(&blended[i][..9]) / size;
            let translation = Vec3::from_column_slice(&blended[i][9..]) / size;
            rotation * (reference[i] - origin) + translation + origin
        })
        .collect()
}

fn pack_moments(mass: f64, from: Vec3, to: Vec3) -> [f64; 16] {
    let mut packed = [0.0; 16];
    packed[0] = mass;
    packed[1..4].copy_from_slice((mass * from).as_slice());
    packed[4..7].copy_from_slice((mass * to).as_slice());
    packed[7..].copy_from_slice((mass * to * from.transpose()).as_slice());
    packed
}

/// The rigid motion of a cluster; a cluster too small to fix a rotation is only shifted.
fn cluster_motion(packed: &[f64; 16]) -> Isometry3<f64> {
    let mass = packed[0];
    if mass <= 0.0 {
        return Isometry3::identity();
    }
    let from = Vec3::from_column_slice(&packed[1..4]) / mass;
    let to = Vec3::from_column_slice(&packed[4..7]) / mass;
    let covariance = Mat3::from_column_slice(&packed[7..]) - mass * to * from.transpose();
    let rotation = best_rotation(&covariance).unwrap_or_else(UnitQuaternion::identity);
    Isometry3::from_parts(Translation3::from(to - rotation * from), rotation)
}

fn pack_motion(motion: &Isometry3<f64>) -> [f64; 12] {
    let mut packed = [0.0; 12];
    packed[..9].copy_from_slice(motion.rotation.to_rotation_matrix().matrix().as_slice());
    packed[9..].copy_from_slice(motion.translation.vector.as_slice());
    packed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    /// Two blocks, their neighbour lists and masses.
    fn shape() -> (Vec<Vec3>, Vec<[u32; 3]>, Vec<f64>, Vec<u32>) {
        let mut a = block(Vec3::new(500.0, -700.0, 90.0), Vec3::new(3.0, 1.0, 1.0), 6);
        let b = block(Vec3::new(507.0, -700.0, 90.0), Vec3::new(3.0, 1.0, 1.0), 5);
        let bone_of: Vec<u32> =
            a.points.iter().map(|_| 0).chain(b.points.iter().map(|_| 1)).collect();
        a.append(&b);
        let masses = vertex_areas(&a.points, &a.triangles);
        (a.points, a.triangles, masses, bone_of)
    }

    fn levels() -> Vec<Elastic> {
        let (points, triangles, _, bone_of) = shape();
        vec![
            Elastic::Rigid,
            Elastic::Sampled(SampledClusters::new(&points, 2.5, 0.5, None)),
            Elastic::Sampled(SampledClusters::new(&points, 2.5, 0.5, Some(&bone_of))),
            Elastic::Exact(FastSums::new(&points, &triangles, 2.0).unwrap()),
        ]
    }

    #[test]
    fn a_rigid_motion_passes_unchanged_and_the_filter_turns_with_its_input() {
        let (points, _, masses, _) = shape();
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let turn = |p: &Vec3| crate::register::pose::moved(&motion, p);
        let moved: Vec<Vec3> = points.iter().map(turn).collect();
        let bent: Vec<Vec3> =
            points.iter().map(|p| p + Vec3::new(0.0, libm::sin(p.x * 0.7), 0.1 * p.y)).collect();
        let bent_moved: Vec<Vec3> = bent.iter().map(turn).collect();
        for level in levels() {
            let found = level.apply(&points, &moved, &masses);
            let worst = found.iter().zip(&moved).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{worst}");
            let plain = level.apply(&points, &bent, &masses);
            let turned = level.apply(&points, &bent_moved, &masses);
            let worst =
                plain.iter().zip(&turned).map(|(a, b)| (turn(a) - b).norm()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{worst}");
        }
    }

    #[test]
    fn smaller_clusters_follow_more_and_bone_clusters_do_not_glue() {
        let (points, triangles, masses, bone_of) = shape();
        // The second block opens away from the first one.
        let wanted: Vec<Vec3> = points
            .iter()
            .zip(&bone_of)
            .map(|(p, &b)| p + Vec3::new(f64::from(b), f64::from(b) * 0.5 * (p.x - 504.0), 0.0))
            .collect();
        let miss = |level: &Elastic| -> f64 {
            let found = level.apply(&points, &wanted, &masses);
            found.iter().zip(&wanted).map(|(a, b)| (a - b).norm_squared()).sum::<f64>()
        };
        let exact = |s| Elastic::Exact(FastSums::new(&points, &triangles, s).unwrap());
        assert!(miss(&Elastic::Rigid) > miss(&exact(4.0)));
        assert!(miss(&exact(4.0)) > miss(&exact(2.0)));
        let sampled = |bones| Elastic::Sampled(SampledClusters::new(&points, 3.0, 0.5, bones));
        assert!(miss(&sampled(None)) > 2.0 * miss(&sampled(Some(&bone_of))));
    }

    #[test]
    fn the_result_has_the_same_bits_at_any_thread_count() {
        let (points, _, masses, _) = shape();
        let wanted: Vec<Vec3> =
            points.iter().map(|p| p + Vec3::new(0.0, libm::sin(p.x), 0.0)).collect();
        for level in levels() {
            let run = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| level.apply(&points, &wanted, &masses))
            };
            assert_eq!(run(1), run(2));
            assert_eq!(run(1), run(8));
        }
    }
}
