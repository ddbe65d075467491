//! Rounds of finding contacts and solving for the shape that keeps them apart.

use serde::Serialize;

use super::contacts::{Detector, Found, Memory};
use super::energy::{Elasticity, Energy};
use super::options::Options;
use super::overlap::{Overlap, overlaps};
use super::patch::Patch;
use super::scene::{Body, Obstacle, Skin, surface_point};
use crate::error::{Error, Result};
use crate::fem::{MaterialPoint, Spring, solve_vectors};
use crate::locate::{ClosestPoints, Solid};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::mesh::adjacency::{Lists, edges, vertex_neighbours};
use crate::run::Run;

type Tissue = InversionBarrier<StableNeoHookean>;

/// Elements compressed below this share of their volume are held back by a barrier, so that none
/// inverts. Its strength is this share of the contacts' stiffness (in the same units, at least Young's
/// modulus): were it weaker, contacts would crush the tets next to them, and these then end each Newton
/// step long before the tissue behind them has moved.
const BARRIER_START: f64 = 0.6;
const BARRIER_SHARE: f64 = 0.5;

/// The gap, relative to the bodies' median diagonal.
const GAP: f64 = 1.0 / 2000.0;

/// A contact is opened by this share of the mean edge per round, so that deep overlaps are left in
/// small steps.
const OPENING: f64 = 0.35;

/// Stiffness of a contact in units of Young's modulus times the mean edge: at first, its growth per
/// round, at most.
const CONTACT_STIFFNESS: [f64; 3] = [20.0, 1.5, 2e4];

/// Stiffness of a marker's hold, in the same unit.
const MARKER_STIFFNESS: f64 = 1.0;

/// The pull back fades within this share of the cube root of a body's volume.
const FADING: f64 = 0.5;

/// Newton steps per round.
const NEWTON_STEPS: usize = 12;
/// Halvings of a step before it is given up.
const MAX_HALVINGS: usize = 25;
/// Fraction of the predicted decrease that a step must achieve.
const ARMIJO: f64 = 1e-4;
/// A round ends when no vertex moves farther than this share of the gap.
const SMALL_STEP: f64 = 0.02;

/// Rounds in which the overlap may stay as large as it was before the solver gives up.
const PATIENCE: usize = 20;
/// A round counts as progress if it leaves at most this share of the smallest overlap so far.
const PROGRESS: f64 = 0.98;

/// Why a separation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// No contact is left.
    Parted,
    /// Overlaps no longer shrink, or the rounds are used up; the shape with the least is kept.
    Stalled,
    /// It was cancelled; the shape with the least overlap so far is kept.
    Cancelled,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Separation {
    /// Tet vertices of each body.
    pub tet_points: Vec<Vec<Vec3>>,
    /// Surface vertices of each body.
    pub surface_points: Vec<Vec<Vec3>>,
    /// Overlaps before.
    pub before: Vec<Overlap>,
    /// Overlaps that are left; empty: no triangle of one surface is inside another one.
    pub after: Vec<Overlap>,
    /// Surface vertices of each body that moved, and the farthest move.
    pub moved: Vec<(usize, f64)>,
    /// Rounds of finding contacts and solving.
    pub rounds: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// Pushes bodies apart where they overlap each other or obstacles. Vertices that are not near an
/// overlap stay exactly where they are; no tet is inverted. What could not be resolved is told in
/// [`Separation::after`]. A run that is cancelled or stalls keeps the shape with the least overlap;
/// one that is cancelled before its first round gives [`Error::Cancelled`].
pub fn separate(
    bodies: &[Body],
    obstacles: &[Obstacle],
    options: &Options,
    run: &Run,
) -> Result<Separation> {
    options.check()?;
    if bodies.is_empty() {
        return Err(Error::invalid("there is nothing to separate"));
    }
    bodies.iter().try_for_each(Body::check)?;
    run.enter("looking for overlaps", 0.0);
    let start: Vec<Vec<Vec3>> = bodies.iter().map(|b| b.tets.points.clone()).collect();
    let before = overlaps(bodies, &start, obstacles);
    let mut solver = Solver::new(bodies, obstacles, options, run);
    let overlapping = !before.is_empty();
    let (rounds, ending) = if overlapping { solver.run_rounds()? } else { (0, Ending::Parted) };
    let tet_points = solver.split(&solver.x);
    let after = if overlapping { overlaps(bodies, &tet_points, obstacles) } else { Vec::new() };
    let surfaces = |points: &[Vec<Vec3>]| -> Vec<Vec<Vec3>> {
        bodies.iter().zip(points).map(|(b, x)| b.surface_points(x)).collect()
    };
    let surface_points = surfaces(&tet_points);
    let old = surfaces(&start);
    let moved = old.iter().zip(&surface_points).map(|(old, new)| moves(old, new)).collect();
    Ok(Separation { tet_points, surface_points, before, after, moved, rounds, ending })
}

/// How many points moved, and how far at most.
fn moves(old: &[Vec3], new: &[Vec3]) -> (usize, f64) {
    let far = old.iter().zip(new).map(|(a, b)| (b - a).norm()).filter(|&d| d > 0.0);
    far.fold((0, 0.0), |(count, most), d| (count + 1, f64::max(most, d)))
}

struct Solver<'a> {
    bodies: &'a [Body],
    obstacles: &'a [Obstacle],
    options: &'a Options,
    run: &'a Run,
    /// Number of each body's first vertex in the whole scene.
    first_vertex: Vec<u32>,
    tets: Vec<[u32; 4]>,
    places: Vec<Vec3>,
    x: Vec<Vec3>,
    gap: f64,
    mean_edge: f64,
}

impl<'a> Solver<'a> {
    fn new(
        bodies: &'a [Body],
        obstacles: &'a [Obstacle],
        options: &'a Options,
        run: &'a Run,
    ) -> Self {
        let (mut first_vertex, mut tets, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for body in bodies {
            let first = places.len() as u32;
            first_vertex.push(first);
            tets.extend(body.tets.tets.iter().map(|t| t.map(|v| first + v)));
            places.extend_from_slice(&body.tets.points);
        }
        let mut diagonals: Vec<f64> = bodies
            .iter()
            .map(|b| TriMesh { points: b.tets.points.clone(), triangles: Vec::new() }.diagonal())
            .collect();
        diagonals.sort_by(f64::total_cmp);
        let gap = options.gap.unwrap_or(GAP * diagonals[diagonals.len() / 2]);
        let x = places.clone();
        let mean_edge = mean_edge(bodies);
        Self { bodies, obstacles, options, run, first_vertex, tets, places, x, gap, mean_edge }
    }

    /// Until nothing overlaps, nothing improves, or the rounds run out; returns their number.
    fn run_rounds(&mut self) -> Result<(usize, Ending)> {
        let mut patch = Patch::new(self.bodies, self.options.rings);
        let mut memory = Memory::default();
        let graphs = self.graphs();
        let [first, growth, most] = CONTACT_STIFFNESS;
        let most_rounds = self.options.max_rounds;
        let mut best = (f64::INFINITY, self.x.clone());
        let mut idle = 0;
        let mut round = 0;
        loop {
            if self.run.is_cancelled() && round == 0 {
                return Err(Error::Cancelled);
            }
            self.run.enter("pushing apart", round as f64 / (most_rounds + 1) as f64);
            let points = self.split(&self.x);
            let skins = Skin::all(self.bodies, &points, self.obstacles);
            let margin = 0.25 * self.mean_edge + 2.0 * self.gap;
            let shapes = skins.iter().filter(|s| s.body.is_some()).flat_map(|s| &s.points);
            self.run.publish_preview(&shapes.copied().collect::<Vec<_>>());
            self.run.update(|p| p.iteration = round);
            let detector = Detector {
                bodies: self.bodies,
                first_vertex: &self.first_vertex,
                graphs: &graphs,
                margin,
            };
            let found = detector.look(&skins, &mut memory);
            if found.is_clear() {
                return Ok((round, Ending::Parted));
            }
            let overlap = found.overlap();
            idle = if overlap < PROGRESS * best.0 { 0 } else { idle + 1 };
            if overlap < best.0 {
                best = (overlap, self.x.clone());
            }
            for (b, seeds) in found.seeds.iter().enumerate() {
                patch.add(b, seeds);
            }
            let stiffness = (first * growth.powi(round as i32)).min(most) * self.mean_edge;
            let stuck = idle >= PATIENCE || round == most_rounds;
            let cancelled = self.run.is_cancelled();
            // Where shapes contradict each other tets are squeezed until a solution has no digits.
            if stuck || cancelled || self.relax(&patch, &found, stiffness).is_err() {
                self.x = best.1;
                return Ok((round, if cancelled { Ending::Cancelled } else { Ending::Stalled }));
            }
            round += 1;
        }
    }

    /// Neighbours of each vertex of each surface, in the order of the skins.
    fn graphs(&self) -> Vec<Lists> {
        let soft = self.bodies.iter().map(|b| (b.embedding.len(), &b.triangles));
        let hard = self.obstacles.iter().map(|o| (o.surface.points.len(), &o.surface.triangles));
        soft.chain(hard).map(|(count, triangles)| vertex_neighbours(count, triangles)).collect()
    }

    /// Newton's method for the contacts of one round.
    fn relax(&mut self, patch: &Patch, found: &Found, stiffness: f64) -> Result<()> {
        let elasticity = self.elasticity(patch, stiffness);
        let opening = OPENING * self.mean_edge;
        let energy = Energy {
            elasticity: &elasticity,
            contacts: &found.contacts,
            targets: found.contacts.iter().map(|c| self.gap.min(c.distance + opening)).collect(),
            stiffness,
        };
        let pattern = energy.pattern()?;
        let mut value = energy.value(&self.x);
        for _ in 0..NEWTON_STEPS {
            let gradient = energy.gradient(&self.x);
            let step = solve_vectors(&energy.factor(&pattern, &self.x)?, &gradient);
            let slope: f64 = -step.iter().zip(&gradient).map(|(s, g)| s.dot(g)).sum::<f64>();
            let mut eta = 1.0;
            let accepted = (0..MAX_HALVINGS).find_map(|_| {
                let trial = energy.stepped(&self.x, &step, eta);
                let trial_value = energy.value(&trial);
                if trial_value <= value + ARMIJO * eta * slope {
                    return Some((trial, trial_value));
                }
                eta *= 0.5;
                None
            });
            let Some((x, lower)) = accepted else { return Ok(()) };
            (self.x, value) = (x, lower);
            let farthest = step.iter().map(Vec3::norm).fold(0.0, f64::max) * eta;
            if farthest < SMALL_STEP * self.gap || self.run.is_cancelled() {
                return Ok(());
            }
        }
        Ok(())
    }

    fn elasticity(&self, patch: &Patch, stiffness: f64) -> Elasticity<Tissue> {
        let material = InversionBarrier::new(
            StableNeoHookean::new(1.0, self.options.poisson),
            BARRIER_START,
            (BARRIER_SHARE * stiffness / self.mean_edge).max(1.0),
        );
        let is_free: Vec<bool> = patch.free.iter().flatten().copied().collect();
        let springs = self.marker_springs();
        let (places, pull) = (self.places.clone(), self.pull());
        Elasticity::new(material, &self.tets, springs, places, pull, &is_free)
    }

    /// The surface points nearest to the markers are held where they are. Markers inside an obstacle
    /// hold nothing: the obstacle is right.
    fn marker_springs(&self) -> Vec<Spring> {
        let mut springs = Vec::new();
        let walls: Vec<Solid> = self
            .obstacles
            .iter()
            .map(|o| Solid::new(&o.surface.points, &o.surface.triangles))
            .collect();
        for (body, &first) in self.bodies.iter().zip(&self.first_vertex) {
            let surface = body.surface_points(&body.tets.points);
            let closest = ClosestPoints::new(&surface, &body.triangles);
            let in_wall = |p: &&Vec3| walls.iter().any(|wall| wall.holds(p));
            let markers: Vec<Vec3> = body.markers.iter().filter(|p| !in_wall(p)).copied().collect();
            for hit in closest.closest_many(&markers).into_iter().flatten() {
                let MaterialPoint(mut entries) =
                    surface_point(body, hit.triangle, &hit.barycentric);
                for entry in &mut entries {
                    entry.0 += first;
                }
                springs.push(Spring {
                    point: MaterialPoint(entries),
                    target: hit.position,
                    stiffness: MARKER_STIFFNESS * self.mean_edge,
                });
            }
        }
        springs
    }

    /// Stiffness of each vertex' pull back to its place: its share of the volume over the squared
    /// distance within which a displacement fades.
    fn pull(&self) -> Vec<f64> {
        let mut pull = vec![0.0; self.places.len()];
        for (body, &first) in self.bodies.iter().zip(&self.first_vertex) {
            let fading = FADING * body.tets.total_volume().cbrt();
            for (t, tet) in body.tets.tets.iter().enumerate() {
                for &v in tet {
                    pull[(first + v) as usize] += body.tets.volume(t) / 4.0 / (fading * fading);
                }
            }
        }
        pull
    }

    /// Vertices of each body.
    fn split(&self, x: &[Vec3]) -> Vec<Vec<Vec3>> {
        let parts = self.bodies.iter().zip(&self.first_vertex);
        parts.map(|(b, &first)| x[first as usize..][..b.tets.points.len()].to_vec()).collect()
    }
}

/// Mean length of the edges of all bodies' surfaces.
fn mean_edge(bodies: &[Body]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for body in bodies {
        let points = body.surface_points(&body.tets.points);
        let edges = edges(&body.triangles);
        sum += edges
            .iter()
            .map(|&[a, b]| (points[a as usize] - points[b as usize]).norm())
            .sum::<f64>();
        count += edges.len();
    }
    sum / count.max(1) as f64
}
