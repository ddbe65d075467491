//! A rough placing of a template on markers, before any reshaping.
//!
//! From landmark pairs where there are enough; else the axes of inertia of both, in all 24 ways
//! they can be matched, each improved by iterated closest points (P. Besl, N. McKay, 1992) with the
//! worst pairs left out (D. Chetverikov et al., trimmed ICP, 2002).

use nalgebra::SymmetricEigen;
use rayon::prelude::*;

use super::rigid::{Similarity, best_rigid, best_similarity};
use crate::error::{Error, Result};
use crate::locate::{ClosestPoints, SurfacePoint};
use crate::math::{Mat3, Vec3};
use crate::mesh::TriMesh;

/// Share of the markers that count in each iteration: the closest ones.
const KEPT: f64 = 0.9;
/// Iterations for each of the 24 starts, and for the best ones of them.
const SHORT: usize = 12;
const LONG: usize = 100;
/// Starts that are followed to the end.
const FINALISTS: usize = 5;
/// Iterations end when the mean squared distance falls by less than this share.
const CONVERGED: f64 = 1e-6;
/// Markers on a part of the template only do not tell its size: the scale stays within this factor
/// of the one the extents suggest.
const SCALE_RANGE: f64 = 1.5;
/// Landmarks are collinear when the second extent is below this share of the first.
const COLLINEAR: f64 = 1e-3;

/// What a pre-alignment may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Place and direction.
    Rigid,
    /// Place, direction and size.
    Similarity,
}

/// Template points and the targets they belong to.
pub type LandmarkPairs<'a> = (&'a [Vec3], &'a [Vec3]);

/// Finds where to put the template so that the markers lie on its surface.
///
/// Three or more landmark pairs that are not on one line decide alone. Otherwise it needs three
/// markers, and pairs that are there count among them. Fails when neither is given or numbers are
/// not finite. A shape that looks the same from several sides may come out turned.
pub fn pre_align(
    template: &TriMesh,
    markers: &[Vec3],
    landmarks: Option<LandmarkPairs>,
    freedom: Freedom,
) -> Result<Similarity> {
    let (from, to) = landmarks.unwrap_or_default();
    if from.len() >= 3 && spans_a_plane(from) && spans_a_plane(to) {
        return fit(from, to, None, freedom);
    }
    // Checks the pairs, which the search below takes for granted.
    fit(from, to, None, Freedom::Rigid)?;
    if markers.len() < 3 || !markers.iter().flatten().all(|c| c.is_finite()) {
        return Err(Error::invalid(
            "pre-alignment needs three landmark pairs that are not on one line, or three markers with finite coordinates",
        ));
    }
    let problem = Icp::new(template, markers, (from, to), freedom)?;
    let mut ends: Vec<End> =
        problem.starts().into_par_iter().map(|start| problem.follow(start, SHORT)).collect();
    ends.sort_by(|a, b| a.error.total_cmp(&b.error));
    ends.truncate(FINALISTS);
    let ends: Vec<End> =
        ends.into_par_iter().map(|end| problem.follow(end.placing, LONG)).collect();
    let best = ends.into_iter().min_by(|a, b| a.error.total_cmp(&b.error));
    Ok(best.expect("there are 24 starts").placing)
}

fn fit(
    from: &[Vec3],
    to: &[Vec3],
    weights: Option<&[f64]>,
    freedom: Freedom,
) -> Result<Similarity> {
    match freedom {
        Freedom::Rigid => best_rigid(from, to, weights).map(Into::into),
        Freedom::Similarity => best_similarity(from, to, weights),
    }
}

fn spans_a_plane(points: &[Vec3]) -> bool {
    let cloud = Extent::of(points.iter().map(|p| (*p, 1.0)));
    cloud.sizes[1] > COLLINEAR * cloud.sizes[0]
}

/// Centre, principal axes and extents of a weighted cloud.
struct Extent {
    centre: Vec3,
    /// Columns, by falling extent, right-handed.
    axes: Mat3,
    /// Root mean squares along the axes.
    sizes: [f64; 3],
}

impl Extent {
    fn of(cloud: impl Iterator<Item = (Vec3, f64)> + Clone) -> Self {
        let total: f64 = cloud.clone().map(|(_, w)| w).sum();
        let centre = cloud.clone().map(|(p, w)| p * (w / total)).sum::<Vec3>();
        let spread: Mat3 =
            cloud.map(|(p, w)| (p - centre) * (p - centre).transpose() * (w / total)).sum();
        let eigen = SymmetricEigen::new(spread);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        let [i, j, _] = order;
        let (first, second) =
            (eigen.eigenvectors.column(i).into_owned(), eigen.eigenvectors.column(j).into_owned());
        let axes = Mat3::from_columns(&[first, second, first.cross(&second)]);
        Self { centre, axes, sizes: order.map(|k| eigen.eigenvalues[k].max(0.0).sqrt()) }
    }

    fn radius(&self) -> f64 {
        self.sizes.iter().map(|s| s * s).sum::<f64>().sqrt()
    }
}

/// Where a search ended, and the mean squared distance of the pairs that count.
struct End {
    placing: Similarity,
    error: f64,
}

struct Icp<'a> {
    surface: ClosestPoints,
    markers: &'a [Vec3],
    landmarks: LandmarkPairs<'a>,
    freedom: Freedom,
    template_extent: Extent,
    marker_extent: Extent,
    start_scale: f64,
}

impl<'a> Icp<'a> {
    fn new(
        template: &TriMesh,
        markers: &'a [Vec3],
        landmarks: LandmarkPairs<'a>,
        freedom: Freedom,
    ) -> Result<Self> {
        let by_area = (0..template.triangles.len()).map(|t| {
            let [a, b, c] = template.corners(t);
            ((a + b + c) / 3.0, (b - a).cross(&(c - a)).norm())
        });
        let template_extent = Extent::of(by_area);
        let marker_extent = Extent::of(markers.iter().map(|p| (*p, 1.0)));
        let ratio = marker_extent.radius() / template_extent.radius();
        if !(ratio.is_finite() && ratio > 0.0) {
            return Err(Error::invalid(
                "pre-alignment needs a template with an area and markers that are not all in one place",
            ));
        }
        let start_scale = if freedom == Freedom::Rigid { 1.0 } else { ratio };
        let surface = ClosestPoints::new(&template.points, &template.triangles);
        Ok(Self {
            surface,
            markers,
            landmarks,
            freedom,
            template_extent,
            marker_extent,
            start_scale,
        })
    }

    /// Template axes on marker axes in all 24 ways that are rotations.
    fn starts(&self) -> Vec<Similarity> {
        let mut starts = Vec::with_capacity(24);
        for first in 0..3 {
            for second in (0..3).filter(|&k| k != first) {
                for signs in 0..4 {
                    let sign = |bit: i32| if signs & bit == 0 { 1.0 } else { -1.0 };
                    let axis = |k: usize| self.marker_extent.axes.column(k).into_owned();
                    let (x, y) = (axis(first) * sign(1), axis(second) * sign(2));
                    let rotation = Mat3::from_columns(&[x, y, x.cross(&y)])
                        * self.template_extent.axes.transpose();
                    let centre = rotation * self.template_extent.centre * self.start_scale;
                    starts.push(Similarity {
                        scale: self.start_scale,
                        rotation,
                        translation: self.marker_extent.centre - centre,
                    });
                }
            }
        }
        starts
    }

    /// Iterated closest points from one start.
    fn follow(&self, start: Similarity, iterations: usize) -> End {
        let mut best = End { placing: start, error: f64::INFINITY };
        let mut placing = start;
        for _ in 0..iterations {
            let (from, weights, error) = self.pairs(&placing);
            let converged = error > best.error * (1.0 - CONVERGED);
            if error < best.error {
                best = End { placing, error };
            }
            if converged {
                break;
            }
            let to: Vec<Vec3> = self.markers.iter().chain(self.landmarks.1).copied().collect();
            match self.step(&from, &to, &weights) {
                Some(next) => placing = next,
                None => break,
            }
        }
        best
    }

    /// The template's points that belong to the markers and landmarks, their weights, and the mean
    /// squared distance.
    fn pairs(&self, placing: &Similarity) -> (Vec<Vec3>, Vec<f64>, f64) {
        let back = placing.inverse();
        let closest: Vec<SurfacePoint> =
            self.markers.iter().filter_map(|m| self.surface.closest(&back.apply(m))).collect();
        let mut order: Vec<usize> = (0..closest.len()).collect();
        order.sort_by(|&i, &j| closest[i].distance.total_cmp(&closest[j].distance));
        let kept = ((KEPT * order.len() as f64).ceil() as usize).max(3).min(order.len());
        let mut weights = vec![0.0; closest.len()];
        for &i in &order[..kept] {
            weights[i] = 1.0;
        }
        // A landmark says more than a marker: it knows its partner.
        let landmark_weight = (self.markers.len() as f64 / 10.0).max(1.0);
        let (from, to) = self.landmarks;
        let scale_squared = placing.scale * placing.scale;
        let of_markers: f64 =
            order[..kept].iter().map(|&i| closest[i].distance.powi(2) * scale_squared).sum();
        let of_landmarks: f64 = from
            .iter()
            .zip(to)
            .map(|(a, b)| (placing.apply(a) - b).norm_squared() * landmark_weight)
            .sum();
        weights.extend(from.iter().map(|_| landmark_weight));
        let total = kept as f64 + landmark_weight * from.len() as f64;
        let points = closest.iter().map(|c| c.position).chain(from.iter().copied()).collect();
        (points, weights, (of_markers + of_landmarks) / total)
    }

    fn step(&self, from: &[Vec3], to: &[Vec3], weights: &[f64]) -> Option<Similarity> {
        let rigid = best_rigid(from, to, Some(weights)).ok()?;
        if self.freedom == Freedom::Rigid {
            return Some(rigid.into());
        }
        let mut next = best_similarity(from, to, Some(weights)).ok()?;
        let allowed =
            next.scale.clamp(self.start_scale / SCALE_RANGE, self.start_scale * SCALE_RANGE);
        // The rotation does not depend on the scale; the centres stay on each other.
        let total: f64 = weights.iter().sum();
        let centre = from.iter().zip(weights).map(|(p, w)| p * (w / total)).sum::<Vec3>();
        next.translation += next.rotation * centre * (next.scale - allowed);
        next.scale = allowed;
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};
    use nalgebra::Rotation3;

    /// An ellipsoid, 6 long, with a bump, so that it looks different from all sides.
    fn bean() -> TriMesh {
        let (points, triangles) = sphere(20, 30);
        let bump = |p: &Vec3| {
            let near = libm::exp(-4.0 * (p - Vec3::new(0.6, 0.6, 0.5)).norm_squared());
            Vec3::new(3.0 * p.x, 2.0 * p.y, p.z) + p * near
        };
        TriMesh::new(points.iter().map(bump).collect(), triangles).unwrap()
    }

    fn truth(seed: u64, scale: f64) -> Similarity {
        let mut noise = Noise::new(seed);
        Similarity {
            scale,
            rotation: Rotation3::from_scaled_axis(noise.vector() * 3.0).into_inner(),
            translation: noise.vector() * 100.0,
        }
    }

    #[test]
    fn finds_the_placing_from_markers_alone_from_any_side() {
        let template = bean();
        for seed in 1..5 {
            for (freedom, scale) in [(Freedom::Rigid, 1.0), (Freedom::Similarity, 0.2)] {
                let truth = truth(seed, scale);
                let mut markers: Vec<Vec3> =
                    template.points.iter().step_by(5).map(|p| truth.apply(p)).collect();
                // Two markers far off must not matter.
                markers[7] += Vec3::repeat(1.5 * scale);
                markers[50] -= Vec3::repeat(1.5 * scale);
                let found = pre_align(&template, &markers, None, freedom).unwrap();
                let worst = template
                    .points
                    .iter()
                    .map(|p| (found.apply(p) - truth.apply(p)).norm())
                    .fold(0.0, f64::max);
                assert!(worst < 0.15 * scale, "seed {seed}, {freedom:?}: {worst}");
            }
        }
    }

    #[test]
    fn landmarks_decide_where_they_can() {
        let template = bean();
        let truth = truth(9, 2.0);
        let from: Vec<Vec3> = template.points.iter().step_by(150).copied().collect();
        let to: Vec<Vec3> = from.iter().map(|p| truth.apply(p)).collect();
        let found = pre_align(&template, &[], Some((&from, &to)), Freedom::Similarity).unwrap();
        assert!(
            (found.apply(&template.points[3]) - truth.apply(&template.points[3])).norm() < 1e-10
        );
        assert!(
            pre_align(&template, &to[..2], Some((&from[..2], &to[..2])), Freedom::Rigid).is_err()
        );
    }

    #[test]
    fn one_landmark_tells_the_ends_of_a_symmetric_shape_apart() {
        let (points, triangles) = sphere(20, 30);
        let points = points.iter().map(|p| Vec3::new(3.0 * p.x, 2.0 * p.y, p.z)).collect();
        let template = TriMesh::new(points, triangles).unwrap();
        let tip = [Vec3::new(3.0, 0.0, 0.0)];
        for turned in [Vec3::x() * 3.0, Vec3::x() * -3.0] {
            let found =
                pre_align(&template, &template.points, Some((&tip, &[turned])), Freedom::Rigid);
            assert!((found.unwrap().apply(&tip[0]) - turned).norm() < 1e-6);
        }
    }

    #[test]
    fn what_cannot_be_aligned_is_refused() {
        let template = bean();
        let one_place = [Vec3::x(); 5];
        assert!(pre_align(&template, &one_place, None, Freedom::Similarity).is_err());
        assert!(pre_align(&template, &[], None, Freedom::Rigid).is_err());
        assert!(pre_align(&TriMesh::default(), &template.points, None, Freedom::Rigid).is_err());
        let bad = [Vec3::repeat(f64::NAN); 3];
        assert!(pre_align(&template, &bad, None, Freedom::Rigid).is_err());
    }
}
