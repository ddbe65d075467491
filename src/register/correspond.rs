//! Where each template vertex wants to go: closest points both ways, weighted by areas.
//!
//! [G] section 3.1: "weighted sum of the resulting point-to-triangle vectors, template to target
//! and vice versa". The weights are areas, so that the density of either mesh does not matter.
//! Pairs whose normals disagree are dropped; far pairs may be trusted less (Geman-McClure).

use std::ops::Range;

use rayon::prelude::*;

use super::image::ImageTarget;
use super::samples::Samples;
use super::skeleton::Skeleton;
use super::surface::SearchedSurface;
use super::target::Target;
use crate::locate::{ClosestPoints, SurfacePoint};
use crate::math::Vec3;
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};

/// How pairs are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairRules {
    /// Pairs whose normals have a smaller cosine are dropped.
    pub min_cosine: f64,
    /// Distance scale of the robust weight as a multiple of the median pair distance; none =
    /// all pairs count the same.
    pub robust: Option<f64>,
    /// Smallest robust distance scale, template unit.
    pub robust_floor: f64,
    /// Target to template pairs are used as well (the published method does).
    pub both_ways: bool,
    /// A place of the target is another bone's when that one is nearer to it by this factor,
    pub taken: f64,
    /// unless the pair is shorter than this, template unit.
    pub near: f64,
    /// Distance to each side that is searched in an image, template unit.
    pub reach: f64,
}

/// Wanted positions of all template vertices.
#[derive(Clone, Debug, Default)]
pub struct Correspondences {
    /// Wanted position; the present one where there is no pair.
    pub wanted: Vec<Vec3>,
    /// Weight (area) of the kept pairs at each vertex: its mass in the fits that follow.
    pub weight: Vec<f64>,
    /// Share of the pairs' weight that was kept, 0 (no data) to 1.
    pub trust: Vec<f64>,
    /// Area at each vertex for which the target shows nothing.
    pub unseen: Vec<f64>,
    /// Weight of all pairs at each vertex, dropped ones too.
    pub offered: Vec<f64>,
    /// That weight times the squared pair distances.
    pub squares: Vec<f64>,
    /// Mean distance of the kept pairs, weighted by area.
    pub mean_distance: f64,
    /// Root mean square distance of all pairs, dropped ones too, weighted by area.
    pub rms_distance: f64,
    /// Unit normals of the present shape.
    pub normals: Vec<Vec3>,
}

impl Correspondences {
    /// Adds `share` of the part of `drift`, the last movement of every vertex, that runs along the
    /// surface. Closest points hardly pull a bone along its own surface; this keeps it going where it
    /// slides.
    pub fn slide_on(&mut self, drift: impl Iterator<Item = Vec3>, share: f64) {
        for ((wanted, normal), drift) in self.wanted.iter_mut().zip(&self.normals).zip(drift) {
            *wanted += share * (drift - normal * normal.dot(&drift));
        }
    }

    /// Lets vertices without a pair stay where `reference` has them.
    pub fn rest_on(&mut self, reference: &[Vec3]) {
        for ((wanted, weight), place) in self.wanted.iter_mut().zip(&self.weight).zip(reference) {
            if *weight <= 0.0 {
                *wanted = *place;
            }
        }
    }

    /// Root mean square distance of all pairs of some vertices; NaN without pairs.
    pub fn rms_over(&self, vertices: Range<usize>) -> f64 {
        let squares: f64 = self.squares[vertices.clone()].iter().sum();
        (squares / self.offered[vertices].iter().sum::<f64>()).sqrt()
    }
}

/// A surface of bones with vertices numbered from its own first.
#[derive(Clone, Debug)]
struct Bones {
    triangles: Vec<[u32; 3]>,
    /// The bone of each vertex, and a triangle there.
    bone_of: Vec<u32>,
    triangle_at: Vec<u32>,
    search: ClosestPoints,
}

/// A part of the template that is searched as one: everything, or one bone.
#[derive(Clone, Debug)]
struct Group {
    vertices: Range<usize>,
    /// Where its triangles stand among the template's.
    faces: Range<usize>,
    bones: Bones,
    forward: Samples,
    backward: Samples,
    /// The triangles found last, where the next search begins.
    forward_hits: Vec<u32>,
    backward_hits: Vec<u32>,
}

/// The search for correspondences at one sampling density.
#[derive(Clone, Debug)]
pub(super) struct Correspond<'a> {
    groups: Vec<(Group, &'a SearchedSurface)>,
    image: Option<(&'a ImageTarget, Vec<f64>)>,
    vertex_count: usize,
    /// Areas of the vertices of bones that the target has no surface for.
    without_data: Vec<f64>,
    triangles: &'a [[u32; 3]],
}

/// One pair: a vertex with its share of weight and its displacement to the wanted place.
type Pull = (u32, f64, Vec3);

/// A pair before its weight is known.
struct Pair {
    vertices: [u32; 3],
    shares: [f64; 3],
    area: f64,
    pull: Vec3,
    cosine: f64,
    side: Side,
}

/// Which surface's place the pair was sought for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Template,
    /// The template, where the target ends: not a pair.
    BeyondBorder,
    Target,
}

impl<'a> Correspond<'a> {
    /// Prepares the search with vertices of both sides about `spacing` apart (0 = all).
    pub(super) fn new(
        skeleton: &'a Skeleton,
        areas: &[f64],
        target: &'a Target,
        spacing: f64,
    ) -> Self {
        let triangles = &skeleton.triangles;
        let bone_of = skeleton.bone_of_vertex();
        let parts: Vec<_> = if target.labelled {
            skeleton.bones.iter().map(|b| (b.vertices.clone(), b.triangles.clone())).collect()
        } else {
            vec![(0..skeleton.points.len(), 0..triangles.len())]
        };
        let groups: Vec<(Group, _)> = parts
            .into_iter()
            .zip(&target.surfaces)
            .filter_map(|((vertices, range), surface)| {
                let surface = surface.as_ref()?;
                let first = vertices.start as u32;
                let local: Vec<[u32; 3]> =
                    triangles[range.clone()].iter().map(|t| t.map(|v| v - first)).collect();
                let points = &skeleton.points[vertices.clone()];
                let bones = Bones::new(points, local, bone_of[vertices.clone()].to_vec());
                let mut group = Group {
                    vertices: vertices.clone(),
                    faces: range,
                    bones,
                    forward: Samples::default(),
                    backward: Samples::default(),
                    forward_hits: Vec::new(),
                    backward_hits: Vec::new(),
                };
                group.sample(points, &areas[vertices], surface, spacing);
                Some((group, surface))
            })
            .collect();
        let image = target.image.as_ref().map(|image| (image, areas.to_vec()));
        let mut without_data =
            if image.is_some() { vec![0.0; areas.len()] } else { areas.to_vec() };
        for (group, _) in &groups {
            without_data[group.vertices.clone()].fill(0.0);
        }
        Self { groups, image, vertex_count: skeleton.points.len(), without_data, triangles }
    }

    /// The same search at another sampling density.
    pub(super) fn resampled(&self, points: &[Vec3], areas: &[f64], spacing: f64) -> Self {
        let mut other = self.clone();
        for (group, surface) in &mut other.groups {
            let vertices = group.vertices.clone();
            group.sample(&points[vertices.clone()], &areas[vertices], surface, spacing);
        }
        other
    }

    /// Whether the target is an image.
    pub(super) fn in_image(&self) -> bool {
        self.image.is_some()
    }

    /// Correspondences of the template at `points`.
    pub(super) fn at(&mut self, points: &[Vec3], rules: &PairRules) -> Correspondences {
        let mut pairs = Vec::new();
        let faces = area_vectors(points, self.triangles);
        let normals = vertex_normals(points.len(), self.triangles, &faces);
        for (group, surface) in &mut self.groups {
            let vertices = group.vertices.clone();
            let local = &points[vertices.clone()];
            group.bones.search.refit(local);
            pairs.par_extend(group.forward_pairs(local, &normals[vertices], surface, rules));
            if rules.both_ways {
                let faces = &faces[group.faces.clone()];
                pairs.par_extend(group.backward_pairs(faces, surface));
            }
        }
        if let Some((image, areas)) = &self.image {
            pairs.extend(image_pairs(image, areas, points, &normals, rules.reach));
        }
        Correspondences { normals, ..self.gather(points, &pairs, rules) }
    }

    fn gather(&self, points: &[Vec3], pairs: &[Pair], rules: &PairRules) -> Correspondences {
        let scale = rules.robust.map(|factor| {
            (factor * median_distance(pairs, rules.min_cosine)).max(rules.robust_floor)
        });
        let mut pull = vec![Vec3::zeros(); self.vertex_count];
        let mut kept = vec![0.0; self.vertex_count];
        let mut offered = vec![0.0; self.vertex_count];
        let (mut distance, mut weight_sum) = (0.0, 0.0);
        let mut squares = vec![0.0; self.vertex_count];
        let mut unseen = self.without_data.clone();
        for pair in pairs {
            let trust = pair.trust(rules.min_cosine, scale);
            if pair.side != Side::Target {
                unseen[pair.vertices[0] as usize] += (1.0 - trust) * pair.area;
            }
            if pair.side == Side::BeyondBorder {
                continue;
            }
            distance += trust * pair.area * pair.pull.norm();
            weight_sum += trust * pair.area;
            for (v, weight, vector) in pair.pulls() {
                let v = v as usize;
                offered[v] += weight;
                squares[v] += weight * vector.norm_squared();
                kept[v] += trust * weight;
                pull[v] += trust * weight * vector;
            }
        }
        let wanted = (0..self.vertex_count)
            .map(|i| if kept[i] > 0.0 { points[i] + pull[i] / kept[i] } else { points[i] })
            .collect();
        let share =
            |(kept, offered): (&f64, &f64)| if *offered > 0.0 { kept / offered } else { 0.0 };
        let trust: Vec<f64> = kept.iter().zip(&offered).map(share).collect();
        let mean_distance = if weight_sum > 0.0 { distance / weight_sum } else { f64::NAN };
        let area: f64 = offered.iter().sum();
        let rms_distance = (squares.iter().sum::<f64>() / area).sqrt();
        Correspondences {
            wanted,
            weight: kept,
            trust,
            unseen,
            offered,
            squares,
            mean_distance,
            rms_distance,
            normals: Vec::new(),
        }
    }
}

/// Vertices to places along their normals. Vertices that find nothing like them are dropped pairs.
fn image_pairs(
    image: &ImageTarget,
    areas: &[f64],
    points: &[Vec3],
    normals: &[Vec3],
    reach: f64,
) -> impl Iterator<Item = Pair> {
    let found = image.find(points, normals, reach);
    (0..points.len()).zip(found).map(|(i, found)| {
        let (shift, area, cosine) = match found {
            Some(found) => (found.shift, areas[i] * found.score, 1.0),
            None => (0.0, areas[i], f64::NEG_INFINITY),
        };
        let pull = normals[i] * shift;
        let side = Side::Template;
        Pair { vertices: [i as u32; 3], shares: [1.0, 0.0, 0.0], area, pull, cosine, side }
    })
}

impl Bones {
    fn new(points: &[Vec3], triangles: Vec<[u32; 3]>, bone_of: Vec<u32>) -> Self {
        let mut triangle_at = vec![0; points.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                triangle_at[v as usize] = t as u32;
            }
        }
        Self { search: ClosestPoints::new(points, &triangles), triangles, bone_of, triangle_at }
    }

    /// Whether another bone lies clearly nearer to a place of the target that vertex `i` found.
    fn is_taken(&self, i: u32, found: &SurfacePoint, rules: &PairRules) -> bool {
        if rules.taken <= 0.0 || found.distance < rules.near {
            return false;
        }
        let nearest = self.search.closest_from(&found.position, self.triangle_at[i as usize]);
        nearest.is_some_and(|nearest| {
            let other = self.triangles[nearest.triangle as usize][0];
            self.bone_of[other as usize] != self.bone_of[i as usize]
                && nearest.distance < rules.taken * found.distance
        })
    }
}

impl Group {
    /// Chooses the vertices of both sides that are searched.
    fn sample(&mut self, points: &[Vec3], areas: &[f64], surface: &SearchedSurface, spacing: f64) {
        self.forward = Samples::new(points, areas, spacing);
        self.backward = Samples::new(&surface.mesh.points, &surface.areas, spacing);
        self.forward_hits = vec![u32::MAX; self.forward.vertices.len()];
        self.backward_hits = vec![u32::MAX; self.backward.vertices.len()];
    }

    /// Template vertices to the target surface.
    fn forward_pairs<'b>(
        &'b mut self,
        local: &'b [Vec3],
        normals: &'b [Vec3],
        surface: &'b SearchedSurface,
        rules: &'b PairRules,
    ) -> impl ParallelIterator<Item = Pair> + 'b {
        let (samples, first, bones) = (&self.forward, self.vertices.start as u32, &self.bones);
        let hits = self.forward_hits.par_iter_mut();
        samples.vertices.par_iter().zip(&samples.areas).zip(hits).with_min_len(64).filter_map(
            move |((&i, &area), hit)| {
                let found = surface.search.closest_from(&local[i as usize], *hit)?;
                *hit = found.triangle;
                let beyond = surface.border.has(&surface.mesh, &found);
                let side = if beyond { Side::BeyondBorder } else { Side::Template };
                let normal = &surface.face_normals[found.triangle as usize];
                let cosine = if beyond || bones.is_taken(i, &found, rules) {
                    f64::NEG_INFINITY
                } else {
                    normals[i as usize].dot(normal)
                };
                let v = i + first;
                let pull = found.position - local[i as usize];
                Some(Pair { vertices: [v; 3], shares: [1.0, 0.0, 0.0], area, pull, cosine, side })
            },
        )
    }

    /// Target vertices to the template surface, shared out to the corners of the triangle hit.
    fn backward_pairs<'b>(
        &'b mut self,
        faces: &'b [Vec3],
        surface: &'b SearchedSurface,
    ) -> impl ParallelIterator<Item = Pair> + 'b {
        let (samples, first) = (&self.backward, self.vertices.start as u32);
        let (search, triangles) = (&self.bones.search, &self.bones.triangles);
        let hits = self.backward_hits.par_iter_mut();
        samples.vertices.par_iter().zip(&samples.areas).zip(hits).with_min_len(64).filter_map(
            move |((&q, &area), hit)| {
                let goal = surface.mesh.points[q as usize];
                let SurfacePoint { triangle, barycentric, position, .. } =
                    search.closest_from(&goal, *hit)?;
                *hit = triangle;
                let normal = unit_or_zero(&faces[triangle as usize]);
                let cosine = surface.vertex_normals[q as usize].dot(&normal);
                let vertices = triangles[triangle as usize].map(|v| v + first);
                let (pull, side) = (goal - position, Side::Target);
                Some(Pair { vertices, shares: barycentric, area, pull, cosine, side })
            },
        )
    }
}

impl Pair {
    fn trust(&self, min_cosine: f64, scale: Option<f64>) -> f64 {
        if self.cosine < min_cosine {
            return 0.0;
        }
        scale.map_or(1.0, |s| {
            let s2 = s * s;
            (s2 / (s2 + self.pull.norm_squared())).powi(2)
        })
    }

    fn pulls(&self) -> impl Iterator<Item = Pull> + '_ {
        (0..3)
            .filter(|&k| self.shares[k] > 0.0)
            .map(|k| (self.vertices[k], self.area * self.shares[k], self.pull))
    }
}

fn median_distance(pairs: &[Pair], min_cosine: f64) -> f64 {
    let mut distances: Vec<f64> =
        pairs.iter().filter(|p| p.cosine >= min_cosine).map(|p| p.pull.norm()).collect();
    if distances.is_empty() {
        return 0.0;
    }
    let middle = distances.len() / 2;
    *distances.select_nth_unstable_by(middle, f64::total_cmp).1
}
