//! Rounds of finding contacts and solving for the shape that keeps them apart.

use rayon::prelude::*;
use serde::Serialize;

use super::contacts::{Contact, Detector, Found, Memory};
use super::energy::{Elasticity, Energy};
use super::holds::{marker_springs, pull};
use super::islands::{Island, overlapping_islands};
use super::options::Options;
use super::overlap::{Overlap, overlaps};
use super::patch::Patch;
use super::scene::{Body, Obstacle, Skin};
use crate::error::{Error, Result};
use crate::fem::{Spring, solve_vectors};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::{Vec3, median};
use crate::mesh::TriMesh;
use crate::mesh::adjacency::{Lists, edges, vertex_neighbours};
use crate::run::Run;
use crate::solve::backtrack;

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

/// Stiffness of a contact in units of Young's modulus times the mean edge: at first, its growth after
/// a round that helped little, at most. Stiffer than needed, and bodies slip out sideways like soap.
const CONTACT_STIFFNESS: [f64; 3] = [20.0, 1.5, 2e4];
/// Contacts yield by force over stiffness, often by more than the gap: after a round that helped
/// little they aim farther apart by this factor, up to this share of the mean edge.
const REACH_GROWTH: f64 = 1.5;
const LARGEST_REACH: f64 = 0.1;
/// A round helped little if it leaves more than this share of the overlap.
const LITTLE_HELP: f64 = 0.8;

/// Newton steps per round.
const NEWTON_STEPS: usize = 12;
/// A round ends when no vertex moves farther than this share of the gap.
const SMALL_STEP: f64 = 0.02;

/// Rounds in which the overlap may stay as large as it was before the solver gives up.
const PATIENCE: usize = 20;
/// A round counts as progress if it leaves at most this share of the smallest overlap so far.
const PROGRESS: f64 = 0.98;

/// How contacts push.
#[derive(Clone, Copy)]
struct Push {
    /// In units of Young's modulus times the mean edge.
    stiffness: f64,
    /// The distance they aim at.
    reach: f64,
}

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
    /// What holds surface points where markers were met.
    springs: Vec<Spring>,
    /// Stiffness of each vertex' pull back to its place.
    pull: Vec<f64>,
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
        let diagonals = bodies
            .iter()
            .map(|b| TriMesh { points: b.tets.points.clone(), triangles: Vec::new() }.diagonal());
        let gap = options.gap.unwrap_or(GAP * median(diagonals).unwrap_or(0.0));
        let x = places.clone();
        let mean_edge = mean_edge(bodies);
        let springs = marker_springs(bodies, obstacles, &first_vertex, mean_edge);
        let pull = bodies.iter().flat_map(pull).collect();
        Self {
            bodies,
            obstacles,
            options,
            run,
            first_vertex,
            tets,
            places,
            x,
            springs,
            pull,
            gap,
            mean_edge,
        }
    }

    /// Until nothing overlaps, nothing improves, or the rounds run out; returns their number.
    fn run_rounds(&mut self) -> Result<(usize, Ending)> {
        let mut patch = Patch::new(self.bodies, self.options.rings);
        let mut memory = Memory::default();
        let graphs = self.graphs();
        let [stiffness, growth, most] = CONTACT_STIFFNESS;
        let mut push = Push { stiffness, reach: self.gap };
        let farthest = self.gap.max(LARGEST_REACH * self.mean_edge);
        let mut best = (f64::INFINITY, self.x.clone());
        let mut overlap_before = f64::INFINITY;
        let mut idle = 0;
        let mut round = 0;
        loop {
            if self.run.is_cancelled() && round == 0 {
                return Err(Error::Cancelled);
            }
            let found = self.look(round, &graphs, &mut memory);
            if found.is_clear() {
                return Ok((round, Ending::Parted));
            }
            let overlap = found.overlap();
            idle = if overlap < PROGRESS * best.0 { 0 } else { idle + 1 };
            if overlap < best.0 {
                best = (overlap, self.x.clone());
            }
            if overlap > LITTLE_HELP * overlap_before {
                push.stiffness = most.min(push.stiffness * growth);
                push.reach = farthest.min(push.reach * REACH_GROWTH);
            }
            overlap_before = overlap;
            for (b, seeds) in found.seeds.iter().enumerate() {
                patch.add(b, seeds);
            }
            let stuck = idle >= PATIENCE || round == self.options.max_rounds;
            let cancelled = self.run.is_cancelled();
            if stuck || cancelled || !self.relax_all(&patch, &found, push) {
                self.x = best.1;
                return Ok((round, if cancelled { Ending::Cancelled } else { Ending::Stalled }));
            }
            round += 1;
        }
    }

    /// Shows the present shape and finds its contacts.
    fn look(&self, round: usize, graphs: &[Lists], memory: &mut Memory) -> Found {
        self.run.enter("pushing apart", round as f64 / (self.options.max_rounds + 1) as f64);
        self.run.update(|p| p.iteration = round);
        let points = self.split(&self.x);
        let skins = Skin::all(self.bodies, &points, self.obstacles);
        let shapes = skins.iter().filter(|s| s.body.is_some()).flat_map(|s| &s.points);
        self.run.publish_preview(&shapes.copied().collect::<Vec<_>>());
        let detector = Detector {
            bodies: self.bodies,
            first_vertex: &self.first_vertex,
            graphs,
            margin: 0.25 * self.mean_edge + 2.0 * self.gap,
        };
        detector.look(&skins, memory)
    }

    /// Neighbours of each vertex of each surface, in the order of the skins.
    fn graphs(&self) -> Vec<Lists> {
        let soft = self.bodies.iter().map(|b| (b.embedding.len(), &b.triangles));
        let hard = self.obstacles.iter().map(|o| (o.surface.points.len(), &o.surface.triangles));
        soft.chain(hard).map(|(count, triangles)| vertex_neighbours(count, triangles)).collect()
    }

    /// One round for everything that overlaps; whether anything could be solved for.
    fn relax_all(&mut self, patch: &Patch, found: &Found, push: Push) -> bool {
        let islands = overlapping_islands(found, &self.first_vertex);
        let solved: Vec<_> = islands
            .par_iter()
            .map(|island| self.relax(patch, island, push).map(|x| (island, x)))
            .collect();
        let any = solved.iter().any(Result::is_ok);
        // Where shapes contradict each other tets are squeezed until a solution has no digits: these
        // bodies stay as they are.
        for (island, x) in solved.into_iter().flatten() {
            for &b in &island.bodies {
                let first = self.first_vertex[b] as usize;
                let own = first..first + self.bodies[b].tets.points.len();
                self.x[own.clone()].copy_from_slice(&x[own]);
            }
        }
        any
    }

    /// Newton's method for the contacts of one island in one round.
    fn relax(&self, patch: &Patch, island: &Island, push: Push) -> Result<Vec<Vec3>> {
        let stiffness = push.stiffness * self.mean_edge;
        let elasticity = self.elasticity(patch, &island.bodies, stiffness);
        let opening = OPENING * self.mean_edge;
        let target = |c: &&Contact| push.reach.min(c.distance + opening);
        let energy = Energy {
            elasticity: &elasticity,
            contacts: &island.contacts,
            targets: island.contacts.iter().map(target).collect(),
            stiffness,
        };
        let pattern = energy.pattern()?;
        let mut x = self.x.clone();
        let mut value = energy.value(&x);
        for _ in 0..NEWTON_STEPS {
            let gradient = energy.gradient(&x);
            let step = solve_vectors(&energy.factor(&pattern, &x)?, &gradient);
            let slope: f64 = -step.iter().zip(&gradient).map(|(s, g)| s.dot(g)).sum::<f64>();
            let lower = backtrack(value, slope, |share| {
                let trial = energy.stepped(&x, &step, share);
                let value = energy.value(&trial);
                (trial, value)
            });
            let Some(lower) = lower else { break };
            (x, value) = (lower.x, lower.value);
            let farthest = step.iter().map(Vec3::norm).fold(0.0, f64::max) * lower.share;
            if farthest < SMALL_STEP * self.gap || self.run.is_cancelled() {
                break;
            }
        }
        Ok(x)
    }

    fn elasticity(
        &self,
        patch: &Patch,
        bodies: &[usize],
        stiffness: f64,
    ) -> Elasticity<'_, Tissue> {
        let material = InversionBarrier::new(
            StableNeoHookean::new(1.0, self.options.poisson),
            BARRIER_START,
            (BARRIER_SHARE * stiffness / self.mean_edge).max(1.0),
        );
        let mut is_free = vec![false; self.x.len()];
        for &b in bodies {
            let first = self.first_vertex[b] as usize;
            is_free[first..][..patch.free[b].len()].copy_from_slice(&patch.free[b]);
        }
        Elasticity::new(material, &self.tets, &self.springs, &self.places, &self.pull, &is_free)
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
