//! The rigid start: many rotations tried, the best one kept.
//!
//! The method itself wants an orientation within 90 degrees ([G] section 3). Here 24 turns of the
//! principal axes, and the orientation as given, are each refined by closest points both ways on a
//! coarse choice of vertices.

use nalgebra::{Isometry3, SymmetricEigen, Translation3, UnitQuaternion};
use rayon::prelude::*;

use super::pieces::main_part;
use super::pose::{BoneMoments, moved};
use super::rotation::{PairSums, best_rotation};
use super::samples::Samples;
use super::skeleton::Skeleton;
use super::surface::SearchedSurface;
use super::target::Target;
use crate::locate::{ClosestPoints, SurfacePoint};
use crate::math::{Mat3, Vec3};
use crate::mesh::diagonal;
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};

/// Vertices of each side at most, about.
const SAMPLE_COUNT: f64 = 350.0;
/// Closest-point rounds for every start, then for the best ones.
const FIRST_ROUNDS: usize = 8;
const LAST_ROUNDS: usize = 40;
/// Starts that are followed to the end.
const FINALISTS: usize = 4;
/// Places nearer than this share of the template's diagonal tell which of two starts is better.
const NEAR_SHARE: f64 = 0.05;

/// Starts nearer to each other than this share of the diagonal, root mean square, are one.
const DISTINCT: f64 = 0.1;

struct Alignment<'a> {
    template: &'a Skeleton,
    search: ClosestPoints,
    faces: Vec<Vec3>,
    normals: Vec<Vec3>,
    forward: Samples,
    surface: &'a SearchedSurface,
    backward: Samples,
}

/// Rigid motions that carry the template near the target, the best one first.
pub(super) fn rigid_starts(
    template: &Skeleton,
    areas: &[f64],
    target: &Target,
) -> Vec<Isometry3<f64>> {
    if let Some(motion) = from_labels(template, areas, target) {
        return vec![motion];
    }
    let mut parts = target.surfaces.iter().flatten();
    let Some(first) = parts.next() else { return vec![Isometry3::identity()] };
    let all = parts.next().map(|_| target.joined());
    let surface = all.as_ref().unwrap_or(first);
    let whole = Alignment::new(template, areas, surface);
    let mut found = whole.best(areas);
    // Something far away may not belong to the bones: is the rest found better without it?
    let diagonal = diagonal(&template.points);
    if let Some(main) = main_part(surface, diagonal) {
        let others = Alignment::new(template, areas, &main).best(areas);
        let near = |motions: &[Isometry3<f64>]| {
            motions.first().map(|motion| whole.share_near(motion, NEAR_SHARE * diagonal))
        };
        let better = near(&others) > near(&found);
        let rest = if better { std::mem::replace(&mut found, others) } else { others };
        found.extend(rest);
    }
    apart(found, &template.points, DISTINCT * diagonal)
}

/// Motions without those that carry the points nearly as one before them does.
fn apart(motions: Vec<Isometry3<f64>>, points: &[Vec3], distance: f64) -> Vec<Isometry3<f64>> {
    let mut chosen: Vec<Isometry3<f64>> = Vec::new();
    for motion in motions {
        let between = |other: &Isometry3<f64>| {
            let squares =
                points.iter().map(|p| (moved(&motion, p) - moved(other, p)).norm_squared());
            (squares.sum::<f64>() / points.len() as f64).sqrt()
        };
        if chosen.iter().all(|other| between(other) > distance) {
            chosen.push(motion);
        }
    }
    chosen
}

/// Bones' centres on their namesakes' centres, where the target tells three or more bones apart.
fn from_labels(template: &Skeleton, areas: &[f64], target: &Target) -> Option<Isometry3<f64>> {
    if !target.labelled || target.surfaces.iter().flatten().count() < 3 {
        return None;
    }
    let mut sums = PairSums::new(*template.points.first()?);
    for (bone, surface) in template.bones.iter().zip(&target.surfaces) {
        if let Some(surface) = surface {
            let range = bone.vertices.clone();
            let from = BoneMoments::new(&template.points[range.clone()], &areas[range]);
            let to = BoneMoments::new(&surface.mesh.points, &surface.areas);
            sums.add(&from.centre, &to.centre, from.mass);
        }
    }
    sums.best_rigid()
}

/// The orientation as given and the 24 that put one set of principal axes on the other, all with
/// the centres on each other.
fn starts(template: &Skeleton, areas: &[f64], surface: &SearchedSurface) -> Vec<Isometry3<f64>> {
    let from = BoneMoments::new(&template.points, areas);
    let to = BoneMoments::new(&surface.mesh.points, &surface.areas);
    let centred = |rotation: UnitQuaternion<f64>| {
        Isometry3::from_parts(Translation3::from(to.centre - rotation * from.centre), rotation)
    };
    let (from_axes, to_axes) = (principal_axes(&from.spread), principal_axes(&to.spread));
    let turned = cube_rotations()
        .into_iter()
        .filter_map(|cube| best_rotation(&(to_axes * cube * from_axes.transpose())))
        .map(centred);
    let as_given = centred(UnitQuaternion::identity());
    [Isometry3::identity(), as_given].into_iter().chain(turned).collect()
}

/// Principal axes as columns of a rotation, by falling spread.
fn principal_axes(spread: &Mat3) -> Mat3 {
    let eigen = SymmetricEigen::new(*spread);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let (a, b) = (eigen.eigenvectors.column(order[0]), eigen.eigenvectors.column(order[1]));
    Mat3::from_columns(&[a.into(), b.into(), a.cross(&b)])
}

/// The 24 rotations that map the coordinate axes onto each other.
fn cube_rotations() -> Vec<Mat3> {
    let axis = |k: usize| Vec3::ith(k % 3, if k < 3 { 1.0 } else { -1.0 });
    let pairs = (0..6).flat_map(|i| (0..6).map(move |j| (axis(i), axis(j))));
    pairs
        .filter(|(x, y)| x.dot(y) == 0.0)
        .map(|(x, y)| Mat3::from_columns(&[x, y, x.cross(&y)]))
        .collect()
}

impl<'a> Alignment<'a> {
    fn new(template: &'a Skeleton, areas: &[f64], surface: &'a SearchedSurface) -> Self {
        let spacing = |areas: &[f64]| (areas.iter().sum::<f64>() / SAMPLE_COUNT).sqrt();
        let faces = area_vectors(&template.points, &template.triangles);
        Self {
            template,
            search: ClosestPoints::new(&template.points, &template.triangles),
            normals: vertex_normals(template.points.len(), &template.triangles, &faces),
            faces: faces.iter().map(unit_or_zero).collect(),
            forward: Samples::new(&template.points, areas, spacing(areas)),
            surface,
            backward: Samples::new(&surface.mesh.points, &surface.areas, spacing(&surface.areas)),
        }
    }

    /// The best of all starts, refined, best first.
    fn best(&self, areas: &[f64]) -> Vec<Isometry3<f64>> {
        let by_error = |found: &mut Vec<(Isometry3<f64>, f64)>| {
            found.sort_by(|a, b| a.1.total_cmp(&b.1));
        };
        let refine = |start: &Isometry3<f64>, rounds| self.refined(*start, rounds);
        let mut found: Vec<(Isometry3<f64>, f64)> = starts(self.template, areas, self.surface)
            .par_iter()
            .map(|s| refine(s, FIRST_ROUNDS))
            .collect();
        by_error(&mut found);
        found.truncate(FINALISTS);
        let mut finals: Vec<_> = found.par_iter().map(|(s, _)| refine(s, LAST_ROUNDS)).collect();
        by_error(&mut finals);
        finals.into_iter().map(|(motion, _)| motion).collect()
    }

    /// The area of both sides that has the other side within `distance`, as a share.
    fn share_near(&self, motion: &Isometry3<f64>, distance: f64) -> f64 {
        let (mut near, mut whole) = (0.0, 0.0);
        let mut add = |found: bool, area: f64| {
            near += if found { area } else { 0.0 };
            whole += area;
        };
        for (&i, &area) in self.forward.vertices.iter().zip(&self.forward.areas) {
            let there = moved(motion, &self.template.points[i as usize]);
            add(self.surface.search.closest_within(&there, distance).is_some(), area);
        }
        let back = motion.inverse();
        for (&q, &area) in self.backward.vertices.iter().zip(&self.backward.areas) {
            let there = moved(&back, &self.surface.mesh.points[q as usize]);
            add(self.search.closest_within(&there, distance).is_some(), area);
        }
        near / whole
    }

    /// Rounds of closest points both ways; the motion and the root mean square distance left.
    fn refined(&self, start: Isometry3<f64>, rounds: usize) -> (Isometry3<f64>, f64) {
        let mut motion = start;
        let mut error = f64::INFINITY;
        let mut hits = [&self.forward, &self.backward].map(|of| vec![u32::MAX; of.vertices.len()]);
        for _ in 0..rounds {
            let (next, now) = self.round(&motion, &mut hits);
            let Some(next) = next else { break };
            if now > error * (1.0 - 1e-4) {
                break;
            }
            motion = next;
            error = now;
        }
        (motion, self.round(&motion, &mut hits).1)
    }

    /// `hits` are the triangles found last on both sides, where the search begins.
    fn round(
        &self,
        motion: &Isometry3<f64>,
        [ahead, behind]: &mut [Vec<u32>; 2],
    ) -> (Option<Isometry3<f64>>, f64) {
        let mut sums = PairSums::new(Vec3::zeros());
        let (mut squares, mut weight) = (0.0, 0.0);
        let mut add = |from: &Vec3, to: &Vec3, cosine: f64, area: f64| {
            // Pairs that face away from each other count as distant, so that a mirrored start loses.
            let penalty = if cosine < 0.0 { 4.0 } else { 1.0 };
            sums.add(from, to, area);
            squares += penalty * area * (moved(motion, from) - to).norm_squared();
            weight += area;
        };
        let places = self.forward.vertices.iter().zip(&self.forward.areas);
        for ((&i, &area), last) in places.zip(ahead) {
            let from = &self.template.points[i as usize];
            let hit = self.surface.search.closest_from(&moved(motion, from), *last);
            let seen = |hit: &SurfacePoint| !self.surface.border.has(&self.surface.mesh, hit);
            if let Some(hit) = hit.inspect(|hit| *last = hit.triangle).filter(seen) {
                let normal = motion.rotation * self.normals[i as usize];
                let cosine = normal.dot(&self.surface.face_normals[hit.triangle as usize]);
                add(from, &hit.position, cosine, area);
            }
        }
        let back = motion.inverse();
        let places = self.backward.vertices.iter().zip(&self.backward.areas);
        for ((&q, &area), last) in places.zip(behind) {
            let to = &self.surface.mesh.points[q as usize];
            if let Some(hit) = self.search.closest_from(&moved(&back, to), *last) {
                *last = hit.triangle;
                let normal = motion.rotation * self.faces[hit.triangle as usize];
                let cosine = normal.dot(&self.surface.vertex_normals[q as usize]);
                add(&hit.position, to, cosine, area);
            }
        }
        (sums.best_rigid(), if weight > 0.0 { (squares / weight).sqrt() } else { f64::INFINITY })
    }
}
