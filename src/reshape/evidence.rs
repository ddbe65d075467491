//! What the data say about a shape: correspondences, weights, residual rows.

use crate::fem::MaterialPoint;
use crate::locate::SurfacePoint;
use crate::math::{Vec3, robust_deviation};
use crate::mesh::TriMesh;

use super::rows::Rows;
use super::scene::{Pair, Scene};

/// Weight of the two tangential directions of a marker beside its normal one. They are zero at the
/// closest point and only hold the step back: [W]'s point-to-point ties markers to wrong
/// correspondences; none at all makes the iteration zig-zag.
const TANGENTIAL: f64 = 0.02;

/// Near the surface, one marker of so many has tangential rows, for all of them.
const HOLDING: usize = 2;

/// Residuals beyond this many sigmas are taken for outliers.
pub const OUTLIER: f64 = 3.0;

/// 1 / sigma^2 of every datum, robust factors included.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// Per marker.
    pub markers: Vec<f64>,
    /// Per landmark.
    pub landmarks: Vec<f64>,
    /// Per attachment.
    pub attachments: Vec<f64>,
}

/// How far the markers are believed.
#[derive(Clone, Copy, Debug)]
pub struct Belief {
    /// Multiplies their weight.
    pub scale: f64,
    /// Whether those far beyond the others lose weight.
    pub robust: bool,
}

impl Belief {
    /// At the weight that the tolerance gives, but for outliers.
    pub const ROBUST: Self = Self { scale: 1.0, robust: true };
    /// Every one at its word.
    pub const LITERAL: Self = Self { scale: 1.0, robust: false };
}

/// The surface of a shape and where the markers touch it.
pub struct Contact {
    /// Closest surface point of each marker.
    pub hits: Vec<SurfacePoint>,
    /// Direction of the distance: towards the marker while it is far, the surface normal when it
    /// is near. At edges and tips the two differ, and only the first leads there.
    normals: Vec<Vec3>,
    /// The surface's vertices.
    points: Vec<Vec3>,
}

impl Contact {
    /// Finds the closest points of all markers on the surface of the shape `x`.
    pub fn new(scene: &Scene, x: &[Vec3]) -> Self {
        let points = scene.embedding.apply(x);
        let mut tree = scene.surface_tree.clone();
        tree.refit(&points);
        let positions: Vec<Vec3> = scene.markers.iter().map(|m| m.0).collect();
        let hits: Vec<SurfacePoint> = tree
            .closest_many(&positions)
            .into_iter()
            .map(|hit| hit.expect("the surface has triangles and the markers are finite"))
            .collect();
        let surface = TriMesh { points, triangles: scene.triangles.clone() };
        let vertex_normals = surface.vertex_normals();
        let normals = hits
            .iter()
            .zip(&positions)
            .map(|(hit, position)| {
                let corners = surface.triangles[hit.triangle as usize];
                let blend: Vec3 =
                    (0..3).map(|k| vertex_normals[corners[k] as usize] * hit.barycentric[k]).sum();
                let gap = position - hit.position;
                let side = if gap.dot(&blend) < 0.0 { -1.0 } else { 1.0 };
                (blend * scene.marker_sigma + gap * side)
                    .try_normalize(1e-12)
                    .unwrap_or_else(Vec3::z)
            })
            .collect();
        Self { hits, normals, points: surface.points }
    }

    /// Distances of the markers to the surface.
    pub fn distances(&self) -> Vec<f64> {
        self.hits.iter().map(|hit| hit.distance).collect()
    }
}

impl Weights {
    /// From the present residuals.
    pub fn new(
        scene: &Scene,
        contact: &Contact,
        x: &[Vec3],
        belief: Belief,
        hard_attachments: bool,
    ) -> Self {
        let distances = contact.distances();
        let c = belief.scale / scene.marker_sigma.powi(2);
        let limit = if belief.robust {
            OUTLIER * robust_deviation(&distances, scene.marker_sigma)
        } else {
            f64::INFINITY
        };
        let markers = scene
            .markers
            .iter()
            .zip(&distances)
            .map(|((_, weight), d)| c * weight * (limit / d).min(1.0))
            .collect();
        // Without markers nothing speaks against a pair, however far it has to go.
        let doubted = !scene.markers.is_empty();
        let group = |pairs: &[Pair], sigma: f64, doubted: bool| {
            if doubted { group_weights(pairs, x, sigma) } else { plain_weights(pairs, sigma) }
        };
        Self {
            markers,
            landmarks: group(&scene.landmarks, scene.landmark_sigma, doubted),
            attachments: group(
                &scene.attachments,
                scene.attachment_sigma,
                doubted && !hard_attachments,
            ),
        }
    }
}

/// Pairs that are taken at their word.
fn plain_weights(pairs: &[Pair], tolerance: f64) -> Vec<f64> {
    pairs.iter().map(|pair| pair.weight / tolerance.powi(2)).collect()
}

/// Pairs are weighed by what their group turns out to be worth: its noise is estimated from the
/// residuals (never below the tolerance), and single ones far beyond it fade out (Geman-McClure).
/// So bad landmarks lose to the markers, good ones are met exactly.
fn group_weights(pairs: &[Pair], x: &[Vec3], tolerance: f64) -> Vec<f64> {
    let residuals: Vec<f64> =
        pairs.iter().map(|p| (p.point.position(x) - p.target).norm()).collect();
    let sigma = robust_deviation(&residuals, tolerance);
    pairs
        .iter()
        .zip(&residuals)
        .map(|(pair, r)| pair.weight / (sigma * (1.0 + (r / (OUTLIER * sigma)).powi(2))).powi(2))
        .collect()
}

/// All residual rows of a shape.
pub fn rows(scene: &Scene, contact: &Contact, weights: &Weights, x: &[Vec3]) -> Rows {
    let mut rows = Rows::default();
    for (i, &weight) in weights.markers.iter().enumerate() {
        add_marker(&mut rows, scene, contact, i, weight, i % HOLDING == 0);
    }
    add_others(&mut rows, scene, contact, weights, x);
    rows
}

/// Fewer rows that stand for them, where the markers are many.
pub fn representatives(
    scene: &Scene,
    contact: &Contact,
    weights: &Weights,
    x: &[Vec3],
) -> Option<Rows> {
    let groups = scene.marker_groups.as_ref()?;
    let mut rows = Rows::default();
    for (i, group) in groups.iter().enumerate() {
        let weight = group.members.iter().map(|&m| weights.markers[m as usize]).sum();
        add_marker(&mut rows, scene, contact, group.middle as usize, weight, i % HOLDING == 0);
    }
    add_others(&mut rows, scene, contact, weights, x);
    Some(rows)
}

fn add_marker(
    rows: &mut Rows,
    scene: &Scene,
    contact: &Contact,
    marker: usize,
    weight: f64,
    holds: bool,
) {
    let (hit, normal) = (&contact.hits[marker], contact.normals[marker]);
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
fn add_others(rows: &mut Rows, scene: &Scene, contact: &Contact, weights: &Weights, x: &[Vec3]) {
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
    for fold in scene.folds.iter().flat_map(|folds| folds.excesses(&contact.points)) {
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
