//! Pairs of places: each template vertex with the nearest place of the target, and the other way round.

use std::ops::Range;

use rayon::prelude::*;

use super::image::ImageTarget;
use super::samples::Samples;
use super::surface::SearchedSurface;
use crate::locate::{ClosestPoints, SurfacePoint};
use crate::math::{Vec3, median};
use crate::mesh::normals::unit_or_zero;

/// How pairs are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairRules {
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
    /// A landmark counts as much as a piece of surface of this radius, template unit.
    pub landmark_radius: f64,
}

/// One pair: a vertex with its share of weight and its displacement to the wanted place.
pub(super) type Pull = (u32, f64, Vec3);

/// A pair before its weight is known.
pub(super) struct Pair {
    pub(super) vertices: [u32; 3],
    pub(super) shares: [f64; 3],
    pub(super) area: f64,
    pub(super) pull: Vec3,
    pub(super) cosine: f64,
    pub(super) side: Side,
}

/// Which surface's place the pair was sought for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Template,
    /// The template, where the target ends: not a pair.
    BeyondBorder,
    Target,
    Landmark,
}

/// A surface of bones with vertices numbered from its own first.
#[derive(Clone, Debug)]
pub(super) struct Bones {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The bone of each vertex, and a triangle there.
    pub(super) bone_of: Vec<u32>,
    pub(super) triangle_at: Vec<u32>,
    pub(super) search: ClosestPoints,
}

/// A part of the template that is searched as one: everything, or one bone.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) vertices: Range<usize>,
    /// Where its triangles stand among the template's.
    pub(super) faces: Range<usize>,
    pub(super) bones: Bones,
    pub(super) forward: Samples,
    pub(super) backward: Samples,
    /// The triangles found last, where the next search begins.
    pub(super) forward_hits: Vec<u32>,
    pub(super) backward_hits: Vec<u32>,
}

/// Vertices to places along their normals. Vertices that find nothing like them are dropped pairs.
pub(super) fn image_pairs(
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
    pub(super) fn new(points: &[Vec3], triangles: Vec<[u32; 3]>, bone_of: Vec<u32>) -> Self {
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
    pub(super) fn new(vertices: Range<usize>, faces: Range<usize>, bones: Bones) -> Self {
        Self {
            vertices,
            faces,
            bones,
            forward: Samples::default(),
            backward: Samples::default(),
            forward_hits: Vec::new(),
            backward_hits: Vec::new(),
        }
    }

    /// Chooses the vertices of both sides that are searched.
    pub(super) fn sample(
        &mut self,
        points: &[Vec3],
        areas: &[f64],
        surface: &SearchedSurface,
        spacing: f64,
    ) {
        let (forward, denser) = Samples::of_bones(points, areas, &self.bones.bone_of, spacing);
        self.forward = forward;
        // The target, too, shows the small bones.
        self.backward = Samples::new(&surface.mesh.points, &surface.areas, spacing / denser.sqrt());
        self.forward_hits = vec![u32::MAX; self.forward.vertices.len()];
        self.backward_hits = vec![u32::MAX; self.backward.vertices.len()];
    }

    /// Template vertices to the target surface.
    pub(super) fn forward_pairs<'b>(
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
    pub(super) fn backward_pairs<'b>(
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
    pub(super) fn trust(&self, min_cosine: f64, scale: Option<f64>) -> f64 {
        if self.side == Side::Landmark {
            return 1.0;
        }
        if self.cosine < min_cosine {
            return 0.0;
        }
        scale.map_or(1.0, |s| {
            let s2 = s * s;
            (s2 / (s2 + self.pull.norm_squared())).powi(2)
        })
    }

    pub(super) fn pulls(&self) -> impl Iterator<Item = Pull> + '_ {
        (0..3)
            .filter(|&k| self.shares[k] > 0.0)
            .map(|k| (self.vertices[k], self.area * self.shares[k], self.pull))
    }
}

pub(super) fn median_distance(pairs: &[Pair], min_cosine: f64) -> f64 {
    let trusted = pairs.iter().filter(|p| p.cosine >= min_cosine && p.side != Side::Landmark);
    median(trusted.map(|p| p.pull.norm())).unwrap_or(0.0)
}
