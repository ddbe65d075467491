//! Who sees whom: how much of each bone the target shows, and how much of the target is explained.

use std::ops::Range;

use rayon::prelude::*;

use crate::locate::{ClosestPoints, NearestPoints};
use crate::math::{Vec3, median};
use crate::mesh::normals::{area_vectors, unit_or_zero, vertex_normals};
use crate::register::penetration::shares_inside_others;
use crate::register::samples::Samples;
use crate::register::skeleton::Skeleton;
use crate::register::surface::SearchedSurface;
use crate::register::target::{Part, Target};

/// Places of the target that are looked at, about, at most.
const MOST_PLACES: f64 = 60_000.0;
/// Surfaces see each other where their normals have at least this cosine: at an edge the nearest
/// triangle may stand upright.
const FACING: f64 = -0.2;
/// Distances up to so many times the middle one are the target's noise,
const NOISE_FACTOR: f64 = 4.0;
/// and up to this share of the skeleton's diagonal in any case.
const SMALLEST_TOLERANCE: f64 = 0.002;
/// A middle distance beyond this share of the diagonal is no noise.
const LARGEST_TOLERANCE: f64 = 0.008;

/// Where less than this share of a bone lies on the target, that is chance: a neighbour's surface.
const CHANCE: f64 = 0.05;

/// A place of one surface seen from the other one.
struct Sight {
    /// Vertex of the template, or of the target.
    at: usize,
    area: f64,
    distance: f64,
    facing: bool,
    /// It lies beyond the end of the target.
    beyond: bool,
    /// The bone: the vertex's own, or the one that is nearest.
    bone: usize,
    /// Vertex of the target that is nearest (template to target only).
    target: usize,
}

/// What the target and the bones see of each other; shares are 0 to 1.
#[derive(Clone, Debug, Default)]
pub(super) struct Coverage {
    pub(super) bones: Vec<BoneCoverage>,
    /// For each vertex of the skeleton 1 where it lies on the target, else 0.
    pub(super) seen: Vec<f64>,
    /// Share of the target's area that lies on a bone.
    pub(super) explained: f64,
    /// Middle distance of the target's places to the bones.
    pub(super) middle: f64,
}

/// The part of it that concerns one bone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BoneCoverage {
    /// Share of the bone that lies on the target.
    pub(super) seen: f64,
    /// Distance of the bone's places to the nearest of them that lies on the target (0 for those that do),
    /// root mean square; infinite where next to none does.
    pub(super) from_seen: f64,
    /// Share of the bone that lies on a place of the target on which another bone lies, nearer than it,
    /// beyond the share that lies inside other bones in the template.
    pub(super) shared: f64,
    /// Target that lies nearest to this bone but not on it, as a share of the bone's area.
    pub(super) unexplained: f64,
    /// Root mean square distance of the bone's surface to the target, as far as that goes.
    pub(super) forward: f64,
    /// Area of the bone that has target before it.
    faced: f64,
}

/// One surface of the target with the bones that are looked for in it.
struct Look<'a> {
    surface: &'a SearchedSurface,
    vertices: Range<usize>,
    triangles: Range<usize>,
}

/// `skeleton` is the result; `areas` are those of the template's vertices.
pub(super) fn coverage(
    template: &Skeleton,
    skeleton: &Skeleton,
    areas: &[f64],
    target: &Target,
) -> Coverage {
    let bone_of = skeleton.bone_of_vertex();
    let looks = looks(skeleton, target);
    let sights: Vec<_> = looks.iter().map(|look| look.sights(skeleton, areas, &bone_of)).collect();
    let diagonal = crate::mesh::bounding_box(&skeleton.points).map_or(0.0, |(a, b)| (b - a).norm());
    let facing = sights.iter().flat_map(|(_, back)| back).filter(|s| s.facing);
    let middle = median(facing.map(|s| s.distance)).unwrap_or(0.0);
    let tolerance =
        (NOISE_FACTOR * middle).clamp(SMALLEST_TOLERANCE * diagonal, LARGEST_TOLERANCE * diagonal);
    let lies_on = |s: &Sight| s.facing && s.distance <= tolerance;

    let mut bones = vec![BoneCoverage::default(); skeleton.bones.len()];
    let mut seen = vec![0.0; skeleton.points.len()];
    let (mut explained, mut whole) = (0.0, 0.0);
    for (look, (forward, backward)) in looks.iter().zip(&sights) {
        let mut owner = vec![usize::MAX; look.surface.mesh.points.len()];
        for sight in backward {
            whole += sight.area;
            let bone = &mut bones[sight.bone];
            if lies_on(sight) {
                owner[sight.at] = sight.bone;
                explained += sight.area;
            } else {
                bone.unexplained += sight.area;
            }
        }
        for sight in forward {
            let bone = &mut bones[sight.bone];
            if lies_on(sight) {
                seen[sight.at] = 1.0;
                bone.seen += sight.area;
                let nearest = owner[sight.target];
                if nearest != sight.bone && nearest != usize::MAX {
                    bone.shared += sight.area;
                }
            }
            if sight.facing && !sight.beyond {
                bone.forward += sight.area * sight.distance.powi(2);
                bone.faced += sight.area;
            }
        }
    }
    for (forward, _) in &sights {
        add_distances_from_seen(&mut bones, &skeleton.points, forward, &lies_on);
    }
    let overlapping = shares_inside_others(template, areas);
    for (b, bone) in bones.iter_mut().enumerate() {
        let area: f64 = areas[skeleton.bones[b].vertices.clone()].iter().sum();
        bone.seen /= area;
        let by_chance = bone.seen < CHANCE;
        bone.from_seen = if by_chance { f64::INFINITY } else { (bone.from_seen / area).sqrt() };
        bone.shared = (bone.shared / area - overlapping[b]).max(0.0);
        bone.unexplained /= area;
        bone.forward = if bone.faced > 0.0 { (bone.forward / bone.faced).sqrt() } else { 0.0 };
    }
    Coverage { bones, seen, explained: explained / whole, middle }
}

/// Adds the squared distances of bones' places, seen from the template, to the nearest of the same bone that
/// lies on the target.
fn add_distances_from_seen(
    bones: &mut [BoneCoverage],
    points: &[Vec3],
    sights: &[Sight],
    lies_on: &impl Fn(&Sight) -> bool,
) {
    // A bone's places follow each other.
    for own in sights.chunk_by(|a, b| a.bone == b.bone) {
        let (seen, unseen): (Vec<_>, Vec<_>) = own.iter().partition(|sight| lies_on(sight));
        let seen = NearestPoints::new(&seen.iter().map(|s| points[s.at]).collect::<Vec<_>>());
        for sight in unseen {
            let distance = seen.nearest(&points[sight.at]).map_or(f64::INFINITY, |(_, d)| d);
            bones[sight.bone].from_seen += sight.area * distance.powi(2);
        }
    }
}

fn looks<'a>(skeleton: &Skeleton, target: &'a Target) -> Vec<Look<'a>> {
    let look = |Part { bones, surface }: Part<'a>| {
        let (&first, &last) = (bones.first()?, bones.last()?);
        let [from, to] = [first, last].map(|b| &skeleton.bones[b]);
        Some(Look {
            surface,
            vertices: from.vertices.start..to.vertices.end,
            triangles: from.triangles.start..to.triangles.end,
        })
    };
    target.parts(skeleton.bones.len()).into_iter().filter_map(look).collect()
}

impl Look<'_> {
    /// From the template's vertices to the target, and from the target's to the template.
    fn sights(
        &self,
        skeleton: &Skeleton,
        areas: &[f64],
        bone_of: &[u32],
    ) -> (Vec<Sight>, Vec<Sight>) {
        let first = self.vertices.start as u32;
        let points = &skeleton.points[self.vertices.clone()];
        let triangles: Vec<[u32; 3]> = skeleton.triangles[self.triangles.clone()]
            .iter()
            .map(|t| t.map(|v| v - first))
            .collect();
        let faces = area_vectors(points, &triangles);
        let normals = vertex_normals(points.len(), &triangles, &faces);
        let surface = self.surface;
        let forward = (0..points.len()).into_par_iter().filter_map(|i| {
            let hit = surface.search.closest(&points[i])?;
            let corners = surface.mesh.triangles[hit.triangle as usize];
            let heaviest =
                (0..3).max_by(|&a, &b| hit.barycentric[a].total_cmp(&hit.barycentric[b]));
            Some(Sight {
                at: self.vertices.start + i,
                area: areas[self.vertices.start + i],
                distance: (hit.position - points[i]).norm(),
                facing: normals[i].dot(&surface.face_normals[hit.triangle as usize]) > FACING,
                beyond: surface.border.has(&surface.mesh, &hit),
                bone: bone_of[self.vertices.start + i] as usize,
                target: corners[heaviest.unwrap_or(0)] as usize,
            })
        });
        let search = ClosestPoints::new(points, &triangles);
        let spacing = if surface.mesh.points.len() as f64 > MOST_PLACES {
            (surface.areas.iter().sum::<f64>() / MOST_PLACES).sqrt()
        } else {
            0.0
        };
        let samples = Samples::new(&surface.mesh.points, &surface.areas, spacing);
        let backward = samples.vertices.par_iter().zip(&samples.areas).filter_map(|(&q, &area)| {
            let point = surface.mesh.points[q as usize];
            let hit = search.closest(&point)?;
            let normal = unit_or_zero(&faces[hit.triangle as usize]);
            let corner = triangles[hit.triangle as usize][0] as usize;
            Some(Sight {
                at: q as usize,
                area,
                distance: (hit.position - point).norm(),
                facing: surface.vertex_normals[q as usize].dot(&normal) > FACING,
                beyond: false,
                bone: bone_of[self.vertices.start + corner] as usize,
                target: q as usize,
            })
        });
        (forward.collect(), backward.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use crate::register::areas::vertex_areas;
    use crate::register::skeleton::tests::block;

    #[test]
    fn a_bone_on_its_neighbours_place_is_seen_to_share_it_and_leaves_its_own_unexplained() {
        let half = Vec3::new(2.0, 1.0, 1.0);
        let at = |x: f64| block(Vec3::new(x, 0.0, 0.0), half, 6);
        let of = |second: f64| {
            let bones = vec![("a".into(), at(0.0)), ("b".into(), at(second))];
            Skeleton::new(bones, vec![]).unwrap()
        };
        let scan = of(10.0);
        let target = TriMesh::new(scan.points.clone(), scan.triangles.clone()).unwrap();
        let target = Target::whole(target).unwrap();
        let seen = |skeleton: &Skeleton| {
            let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
            coverage(&scan, skeleton, &areas, &target)
        };
        let right = seen(&scan);
        assert!((right.explained - 1.0).abs() < 1e-9, "{right:?}");
        assert!(right.bones.iter().all(|b| b.seen > 0.99 && b.shared < 0.01), "{right:?}");
        let wrong = seen(&of(0.0));
        assert!((wrong.explained - 0.5).abs() < 0.01, "{wrong:?}");
        let [first, second] = [0, 1].map(|b| wrong.bones[b]);
        assert!(first.shared + second.shared > 0.9, "{wrong:?}");
        assert!(first.unexplained + second.unexplained > 0.9, "{wrong:?}");
    }

    #[test]
    fn bones_that_lie_in_each_other_in_the_template_do_not_share_what_they_lie_on() {
        let skeleton = |small: f64| {
            let bone = |at: f64, half: f64| {
                block(Vec3::new(at, 0.0, 0.0), Vec3::repeat(half), (8.0 * half) as u32)
            };
            let bones = vec![("large".into(), bone(0.0, 4.0)), ("small".into(), bone(small, 0.5))];
            Skeleton::new(bones, vec![]).unwrap()
        };
        // The small one's end comes out of the large one; the result is off by a little.
        let (template, result, apart) = (skeleton(3.51), skeleton(3.53), skeleton(9.0));
        let areas = vertex_areas(&template.points, &template.triangles);
        let mesh = TriMesh::new(template.points.clone(), template.triangles.clone()).unwrap();
        let target = Target::whole(mesh).unwrap();
        let shared = |template| coverage(template, &result, &areas, &target).bones[1].shared;
        assert!(shared(&template) == 0.0 && shared(&apart) > 0.05, "{}", shared(&apart));
    }

    #[test]
    fn the_rest_of_a_bone_seen_in_part_lies_as_far_from_it_as_it_goes_on() {
        let bone = |long: f64| block(Vec3::new(long, 0.0, 0.0), Vec3::new(long, 1.0, 1.0), 20);
        let whole = Skeleton::new(vec![("a".into(), bone(10.0))], vec![]).unwrap();
        let areas = vertex_areas(&whole.points, &whole.triangles);
        let of = |shown: f64| {
            let mut part = bone(10.0);
            let points = part.points.clone();
            part.triangles.retain(|t| t.iter().all(|&v| points[v as usize].x <= shown));
            let target = Target::whole(part).unwrap();
            coverage(&whole, &whole, &areas, &target)
        };
        let from_seen = |shown: f64| of(shown).bones[0].from_seen;
        assert!(from_seen(20.0) < 1e-9);
        // Of a length of 20, 10 are not shown: the square root of 10^3 / 3 / 20.
        assert!((from_seen(10.0) - 4.08).abs() < 0.5, "{}", from_seen(10.0));
        assert!(from_seen(0.5).is_infinite());
        for (seen, p) in of(10.0).seen.iter().zip(&whole.points) {
            let beside = (p.x - 10.0).abs() < 0.6;
            assert!(beside || (*seen > 0.5) == (p.x < 10.0), "{p}");
        }
    }
}
