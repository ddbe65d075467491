//! Where each template vertex wants to go: closest points both ways, weighted by areas.
//!
//! [G] section 3.1: "weighted sum of the resulting point-to-triangle vectors, template to target
//! and vice versa". The weights are areas, so that the density of either mesh does not matter.
//! Pairs whose normals disagree are dropped; far pairs may be trusted less (Geman-McClure).

use std::ops::Range;

use rayon::prelude::*;

use super::image::ImageTarget;
use super::landmarks::PlacedLandmark;
use super::pairs::{Group, Pair, PairRules, Side, image_pairs, median_distance};
use super::skeleton::Skeleton;
use super::surface::SearchedSurface;
use super::target::{Part, Target};
use crate::math::Vec3;
use crate::mesh::normals::{area_vectors, vertex_normals};

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

    /// Lets vertices without a pair stay where `reference` has them, and holds there with the weight `hold` what
    /// the target does not show: a cluster that reaches the shown part with its rim alone would turn as that rim does,
    /// and a vertex on which only triangles of the target pull would drift off.
    pub fn rest_on(&mut self, reference: &[Vec3], hold: f64, masses: &mut [f64]) {
        for (i, mass) in masses.iter_mut().enumerate() {
            let held = hold * self.unseen[i];
            if self.weight[i] + held > 0.0 {
                let share = held / (self.weight[i] + held);
                self.wanted[i] = self.wanted[i].lerp(&reference[i], share);
            } else {
                self.wanted[i] = reference[i];
            }
            *mass += held;
        }
    }

    /// Root mean square distance of all pairs of some vertices; NaN without pairs.
    pub fn rms_over(&self, vertices: Range<usize>) -> f64 {
        let squares: f64 = self.squares[vertices.clone()].iter().sum();
        (squares / self.offered[vertices].iter().sum::<f64>()).sqrt()
    }
}

/// The search for correspondences at one sampling density.
#[derive(Clone, Debug)]
pub(super) struct Correspond<'a> {
    groups: Vec<(Group, &'a SearchedSurface)>,
    image: Option<(&'a ImageTarget, Vec<f64>)>,
    landmarks: &'a [PlacedLandmark],
    vertex_count: usize,
    /// Areas of the vertices of bones that the target has no surface for.
    without_data: Vec<f64>,
    triangles: &'a [[u32; 3]],
    /// Distance between the chosen vertices.
    spacing: f64,
}

impl<'a> Correspond<'a> {
    /// Prepares the search with vertices of both sides about `spacing` apart (0 = all).
    pub(super) fn new(
        skeleton: &'a Skeleton,
        areas: &[f64],
        target: &'a Target,
        spacing: f64,
    ) -> Self {
        let parts = target.parts(skeleton.bones.len());
        Self::of_parts(skeleton, areas, target, parts, spacing)
    }

    /// The same, with the bones that are sought on each part of the target's surface.
    pub(super) fn of_parts(
        skeleton: &'a Skeleton,
        areas: &[f64],
        target: &'a Target,
        parts: Vec<Part<'a>>,
        spacing: f64,
    ) -> Self {
        let group = |Part { bones, surface }| {
            let mut group = Group::new(skeleton, &bones);
            group.sample(&skeleton.points, areas, surface, spacing);
            (group, surface)
        };
        let groups: Vec<(Group, _)> = parts.into_par_iter().map(group).collect();
        let image = target.image.as_ref().map(|image| (image, areas.to_vec()));
        let mut without_data =
            if image.is_some() { vec![0.0; areas.len()] } else { areas.to_vec() };
        for &v in groups.iter().flat_map(|(group, _)| group.vertices()) {
            without_data[v as usize] = 0.0;
        }
        let (vertex_count, landmarks) = (skeleton.points.len(), target.landmarks.as_slice());
        let triangles = &skeleton.triangles;
        Self { groups, image, landmarks, vertex_count, without_data, triangles, spacing }
    }

    /// The same search at another sampling density.
    pub(super) fn resampled(&self, points: &[Vec3], areas: &[f64], spacing: f64) -> Self {
        let mut other = Self { spacing, ..self.clone() };
        other.groups.par_iter_mut().for_each(|(group, surface)| {
            group.sample(points, areas, surface, spacing);
        });
        other
    }

    /// Distance between the chosen vertices; 0 where all are.
    pub(super) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// What the bones met last, see [`Group::met_by_bones`].
    pub(super) fn met_by_bones(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        self.groups.iter().flat_map(|(group, _)| group.met_by_bones())
    }

    /// What the target met last, see [`Group::met_by_target`].
    pub(super) fn met_by_target(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        self.groups.iter().flat_map(|(group, _)| group.met_by_target())
    }

    /// The image that is searched, where the target is one.
    pub(super) fn image(&self) -> Option<&'a ImageTarget> {
        self.image.as_ref().map(|(image, _)| *image)
    }

    /// Correspondences of the template at `points`.
    pub(super) fn at(&mut self, points: &[Vec3], rules: &PairRules) -> Correspondences {
        let faces = area_vectors(points, self.triangles);
        let normals = vertex_normals(points.len(), self.triangles, &faces);
        let of_group = |(group, surface): &mut (Group, &SearchedSurface)| {
            let mut pairs = Vec::new();
            group.refit(points);
            pairs.par_extend(group.forward_pairs(&normals, surface, rules));
            if rules.both_ways {
                pairs.par_extend(group.backward_pairs(&faces, surface));
            }
            pairs
        };
        let of_groups: Vec<Vec<Pair>> = self.groups.par_iter_mut().map(of_group).collect();
        let mut pairs: Vec<Pair> = of_groups.into_iter().flatten().collect();
        if let Some((image, areas)) = &self.image {
            pairs.extend(image_pairs(image, areas, points, &normals, rules.reach));
        }
        if rules.landmark_radius > 0.0 {
            pairs.extend(self.landmarks.iter().map(|l| l.pair(points, rules.landmark_radius)));
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
            if matches!(pair.side, Side::Template | Side::BeyondBorder) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::areas::vertex_areas;
    use crate::register::pairs::{FOLLOWING, UNSEEN_WEIGHT};
    use crate::register::pose::moved;
    use crate::register::rotation::turned_about;
    use crate::register::sampled_clusters::SampledClusters;
    use crate::register::skeleton::tests::block;
    use nalgebra::{Isometry3, UnitQuaternion};

    #[test]
    fn what_is_not_shown_does_not_turn_with_the_rim_of_what_is() {
        let bar = block(Vec3::zeros(), Vec3::new(10.0, 1.0, 1.0), 20);
        let areas = vertex_areas(&bar.points, &bar.triangles);
        // Shown up to the middle, where the last of it wants to turn.
        let turn = UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, 0.3));
        let bend = turned_about(&Isometry3::identity(), &Vec3::new(-2.0, 0.0, 0.0), turn);
        let bent = |p: &Vec3| if p.x > -2.0 { moved(&bend, p) } else { *p };
        let shown = |p: &Vec3| p.x <= 0.0;
        let area = |keep: bool| {
            let of = |(p, area): (&Vec3, &f64)| if shown(p) == keep { *area } else { 0.0 };
            bar.points.iter().zip(&areas).map(of).collect::<Vec<f64>>()
        };
        let mut pairs = Correspondences {
            wanted: bar.points.iter().map(bent).collect(),
            weight: area(true),
            unseen: area(false),
            ..Correspondences::default()
        };
        let least = areas.iter().map(|area| UNSEEN_WEIGHT * area);
        let free: Vec<f64> = pairs.weight.iter().zip(least).map(|(w, least)| w + least).collect();
        let mut held = free.clone();
        pairs.rest_on(&bar.points, FOLLOWING, &mut held);
        let clusters = SampledClusters::new(&bar.points, 8.0, 0.5, None);
        let [free, held] = [free, held].map(|masses| {
            let found = clusters.apply(&bar.points, &pairs.wanted, &masses);
            let far = found.iter().zip(&bar.points).filter(|(_, p)| p.x > 2.0);
            far.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
        });
        assert!(held < 0.5 * free, "{held} {free}");
    }
}
