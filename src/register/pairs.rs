//! Pairs of places: each template vertex with the nearest place of the target, and the other way round.

use rayon::prelude::*;

use super::image::ImageTarget;
use super::samples::Samples;
use super::skeleton::Skeleton;
use super::surface::SearchedSurface;
use crate::locate::{ClosestPoints, SurfacePoint};
use crate::math::{Vec3, median};
use crate::mesh::normals::unit_or_zero;

/// Weight of a vertex without a pair against one with a pair of the same area: it holds its place
/// only where nothing else does.
pub(super) const UNSEEN_WEIGHT: f64 = 1e-6;
/// Weight of what the target does not show against what it shows: it follows its neighbour bone's motion, and
/// keeps its place in the reference, no more than lightly.
pub(super) const FOLLOWING: f64 = 0.02;

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

/// Bones that are searched as one; their vertices and triangles have numbers of their own.
#[derive(Clone, Debug)]
pub(super) struct Bones {
    /// The template's number of each vertex and of each triangle.
    vertices: Vec<u32>,
    faces: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    points: Vec<Vec3>,
    /// The bone of each vertex, and a triangle there.
    bone_of: Vec<u32>,
    triangle_at: Vec<u32>,
    search: ClosestPoints,
}

/// A part of the template that is searched as one: everything, one bone, or several.
#[derive(Clone, Debug)]
pub(super) struct Group {
    bones: Bones,
    forward: Samples,
    backward: Samples,
    /// The triangles found last, where the next search begins.
    forward_hits: Vec<u32>,
    backward_hits: Vec<u32>,
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
    fn new(skeleton: &Skeleton, chosen: &[usize]) -> Self {
        let [mut vertices, mut faces, mut bone_of] = [Vec::new(), Vec::new(), Vec::new()];
        let mut triangles = Vec::new();
        for &b in chosen {
            let bone = &skeleton.bones[b];
            let (first, own) = (bone.vertices.start as u32, vertices.len() as u32);
            vertices.extend(bone.vertices.clone().map(|v| v as u32));
            bone_of.resize(vertices.len(), b as u32);
            faces.extend(bone.triangles.clone().map(|t| t as u32));
            let of_bone = &skeleton.triangles[bone.triangles.clone()];
            triangles.extend(of_bone.iter().map(|t| t.map(|v| v - first + own)));
        }
        let mut triangle_at = vec![0; vertices.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                triangle_at[v as usize] = t as u32;
            }
        }
        let points: Vec<Vec3> = vertices.iter().map(|&v| skeleton.points[v as usize]).collect();
        let search = ClosestPoints::new(&points, &triangles);
        Self { vertices, faces, triangles, points, bone_of, triangle_at, search }
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
    pub(super) fn new(skeleton: &Skeleton, bones: &[usize]) -> Self {
        Self {
            bones: Bones::new(skeleton, bones),
            forward: Samples::default(),
            backward: Samples::default(),
            forward_hits: Vec::new(),
            backward_hits: Vec::new(),
        }
    }

    /// The template's numbers of its vertices.
    pub(super) fn vertices(&self) -> &[u32] {
        &self.bones.vertices
    }

    /// Chooses the vertices of both sides that are searched.
    pub(super) fn sample(
        &mut self,
        points: &[Vec3],
        areas: &[f64],
        surface: &SearchedSurface,
        spacing: f64,
    ) {
        let of = |&v: &u32| (points[v as usize], areas[v as usize]);
        let (points, areas): (Vec<Vec3>, Vec<f64>) = self.bones.vertices.iter().map(of).unzip();
        let (forward, denser) = Samples::of_bones(&points, &areas, &self.bones.bone_of, spacing);
        self.forward = forward;
        // The target, too, shows the small bones.
        self.backward = Samples::new(&surface.mesh.points, &surface.areas, spacing / denser.sqrt());
        self.forward_hits = vec![u32::MAX; self.forward.vertices.len()];
        self.backward_hits = vec![u32::MAX; self.backward.vertices.len()];
    }

    /// Puts the bones to where the template's `points` are.
    pub(super) fn refit(&mut self, points: &[Vec3]) {
        let Bones { vertices, points: own, search, .. } = &mut self.bones;
        for (own, &v) in own.iter_mut().zip(&*vertices) {
            *own = points[v as usize];
        }
        search.refit(own);
    }

    /// The triangle of the target that each chosen vertex found last: its bone, the triangle, its area.
    pub(super) fn met_by_bones(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        let found = self.forward.vertices.iter().zip(&self.forward_hits).zip(&self.forward.areas);
        let bone_of = |i: u32| self.bones.bone_of[i as usize];
        found
            .filter(|((_, hit), _)| **hit != u32::MAX)
            .map(move |((&i, &hit), &area)| (bone_of(i), hit, area))
    }

    /// The bone that each chosen vertex of the target found last: the vertex, the bone, its area.
    pub(super) fn met_by_target(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        let bone_at = |hit: u32| self.bones.bone_of[self.bones.triangles[hit as usize][0] as usize];
        let found =
            self.backward.vertices.iter().zip(&self.backward_hits).zip(&self.backward.areas);
        found
            .filter(|((_, hit), _)| **hit != u32::MAX)
            .map(move |((&q, &hit), &area)| (q, bone_at(hit), area))
    }

    /// Template vertices to the target surface.
    pub(super) fn forward_pairs<'b>(
        &'b mut self,
        normals: &'b [Vec3],
        surface: &'b SearchedSurface,
        rules: &'b PairRules,
    ) -> impl ParallelIterator<Item = Pair> + 'b {
        let (samples, bones) = (&self.forward, &self.bones);
        let hits = self.forward_hits.par_iter_mut();
        samples.vertices.par_iter().zip(&samples.areas).zip(hits).with_min_len(64).filter_map(
            move |((&i, &area), hit)| {
                let (v, at) = (bones.vertices[i as usize], &bones.points[i as usize]);
                let found = surface.search.closest_from(at, *hit)?;
                *hit = found.triangle;
                let beyond = surface.border.has(&surface.mesh, &found);
                let side = if beyond { Side::BeyondBorder } else { Side::Template };
                let normal = &surface.face_normals[found.triangle as usize];
                let cosine = if beyond || bones.is_taken(i, &found, rules) {
                    f64::NEG_INFINITY
                } else {
                    normals[v as usize].dot(normal)
                };
                let pull = found.position - at;
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
        let (samples, bones) = (&self.backward, &self.bones);
        let hits = self.backward_hits.par_iter_mut();
        samples.vertices.par_iter().zip(&samples.areas).zip(hits).with_min_len(64).filter_map(
            move |((&q, &area), hit)| {
                let goal = surface.mesh.points[q as usize];
                let SurfacePoint { triangle, barycentric, position, .. } =
                    bones.search.closest_from(&goal, *hit)?;
                *hit = triangle;
                let normal = unit_or_zero(&faces[bones.faces[triangle as usize] as usize]);
                let cosine = surface.vertex_normals[q as usize].dot(&normal);
                let corners = bones.triangles[triangle as usize];
                let vertices = corners.map(|v| bones.vertices[v as usize]);
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
