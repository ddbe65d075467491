//! The data terms: residual rows of all data.

use crate::fem::MaterialPoint;
use crate::math::Vec3;

use super::correspondences::Correspondences;
use super::rows::Rows;
use super::scene::Scene;
use super::weights::{OUTLIER, Weights};

/// Weight of the two tangential directions of a marker beside its normal one. They are zero at the
/// closest point and only hold the step back: [W]'s point-to-point ties markers to wrong
/// correspondences; none at all makes the iteration zig-zag.
const TANGENTIAL: f64 = 0.02;

/// Near the surface, one marker in this many has tangential rows, on behalf of the others.
const HOLDING: usize = 2;

/// All residual rows of a shape.
pub fn rows(
    scene: &Scene,
    correspondences: &Correspondences,
    weights: &Weights,
    x: &[Vec3],
) -> Rows {
    let mut rows = Rows::default();
    for (i, &weight) in weights.markers.iter().enumerate() {
        add_marker(&mut rows, scene, correspondences, i, weight, i % HOLDING == 0);
    }
    add_others(&mut rows, scene, correspondences, weights, x);
    rows
}

/// Fewer rows that stand for them, where the markers are many.
pub fn representatives(
    scene: &Scene,
    correspondences: &Correspondences,
    weights: &Weights,
    x: &[Vec3],
) -> Option<Rows> {
    let groups = scene.marker_groups.as_ref()?;
    let mut rows = Rows::default();
    for (i, group) in groups.iter().enumerate() {
        let weight = group.members.iter().map(|&m| weights.markers[m as usize]).sum();
        add_marker(
            &mut rows,
            scene,
            correspondences,
            group.middle as usize,
            weight,
            i % HOLDING == 0,
        );
    }
    add_others(&mut rows, scene, correspondences, weights, x);
    Some(rows)
}

fn add_marker(
    rows: &mut Rows,
    scene: &Scene,
    correspondences: &Correspondences,
    marker: usize,
    weight: f64,
    holds: bool,
) {
    let (hit, normal) = (&correspondences.hits[marker], correspondences.directions[marker]);
    let gap = hit.position - scene.markers[marker].0;
    let (t1, t2) = tangents(&normal);
    let far = hit.distance > OUTLIER * scene.marker_sigma;
    let holding = weight * TANGENTIAL * if far { 1.0 } else { HOLDING as f64 };
    let directions = [(normal, weight), (t1, holding), (t2, holding)];
    let count = if holds || far { 3 } else { 1 };
    let point = scene.surface_point(hit.triangle, &hit.barycentric);
    rows.add(&point, directions.into_iter().take(count).map(|(d, c)| (d, d.dot(&gap), c)));
}

/// Rows of the pairs, of the template's points that stick out, and of folds.
fn add_others(
    rows: &mut Rows,
    scene: &Scene,
    correspondences: &Correspondences,
    weights: &Weights,
    x: &[Vec3],
) {
    for (pairs, weights) in
        [(&scene.landmarks, &weights.landmarks), (&scene.attachments, &weights.attachments)]
    {
        for (pair, &weight) in pairs.iter().zip(weights) {
            let gap = pair.point.position(x) - pair.target;
            let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
            rows.add(&pair.point, axes.map(|d| (d, d.dot(&gap), weight)));
        }
    }
    for excess in scene.coverage.iter().flat_map(|c| c.excesses(x)) {
        let spacing = scene.coverage.as_ref().map_or(1.0, super::coverage::Coverage::spacing);
        let weight = 1.0 / (spacing * spacing);
        rows.add(excess.point, [(excess.direction, excess.residual * spacing, weight)]);
    }
    for fold in scene.folds.iter().flat_map(|folds| folds.excesses(&correspondences.points)) {
        let gradient = fold.corners.iter().zip(&fold.gradient).flat_map(|(&corner, gradient)| {
            let MaterialPoint(entries) = scene.surface_vertex(corner);
            entries.into_iter().map(move |(v, w)| (v, gradient * w))
        });
        rows.push(gradient, fold.residual, fold.weight);
    }
}

/// Two directions that complete the unit vector `n` to an orthonormal frame.
fn tangents(n: &Vec3) -> (Vec3, Vec3) {
    let axis = if n.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let t = n.cross(&axis).normalize();
    (t, n.cross(&t))
}
