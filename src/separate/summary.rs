//! What a separation did, in figures.

use std::collections::BTreeMap;

use serde::Serialize;

use super::overlap::Overlap;
use super::scene::{Body, Obstacle};
use super::solver::{Ending, Separation};
use crate::locate::WindingNumber;
use crate::math::Vec3;
use crate::measure::{Spread, marker_distances};
use crate::mesh::TetQuality;

/// Two surfaces that overlapped.
#[derive(Clone, Debug, Serialize)]
pub struct OverlapLine {
    /// Names of the two.
    pub between: [String; 2],
    /// Depth of the deepest vertex before and after.
    pub depth: [f64; 2],
    /// Vertices inside the other before and after.
    pub vertices_inside: [usize; 2],
    /// Pairs of crossing triangles before and after.
    pub crossings: [usize; 2],
}

/// What a separation did to one body.
#[derive(Clone, Debug, Serialize)]
pub struct MovedBody {
    /// Its name.
    pub name: String,
    /// Vertices of its surface.
    pub vertices: usize,
    /// Those that moved.
    pub moved: usize,
    /// The farthest move.
    pub largest_move: f64,
    /// Tets without or with negative volume.
    pub inverted_tets: usize,
    /// Distance of its markers before and after, of those that lie outside everything that does
    /// not move: a marker inside a bone cannot be met.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marker_distance: Option<[Spread; 2]>,
    /// Markers that lie inside something that does not move. They contradict it and hold nothing.
    pub contradicting_markers: Vec<ContradictingMarker>,
}

/// A marker that lies inside something that does not move.
#[derive(Clone, Debug, Serialize)]
pub struct ContradictingMarker {
    /// Its place among the body's markers, from 1.
    pub marker: usize,
    /// What it lies in.
    pub inside: String,
}

/// All figures. Lengths in the bodies' unit.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Nothing overlaps any more.
    pub separated: bool,
    /// Why it ended.
    pub ending: Ending,
    /// Every overlap there was or is.
    pub overlaps: Vec<OverlapLine>,
    /// Every body.
    pub bodies: Vec<MovedBody>,
    /// Rounds of finding contacts and solving.
    pub rounds: usize,
}

impl Summary {
    /// Measures a separation of `bodies`.
    pub fn new(bodies: &[Body], obstacles: &[Obstacle], separation: &Separation) -> Self {
        let wall = |o: &Obstacle| WindingNumber::new(&o.surface.points, &o.surface.triangles);
        let walls: Vec<(&str, WindingNumber)> =
            obstacles.iter().map(|o| (o.name.as_str(), wall(o))).collect();
        let moved =
            bodies.iter().enumerate().map(|(b, body)| moved_body(b, body, &walls, separation));
        Self {
            separated: separation.after.is_empty(),
            ending: separation.ending,
            overlaps: overlap_lines(&separation.before, &separation.after),
            bodies: moved.collect(),
            rounds: separation.rounds,
        }
    }
}

fn moved_body(
    b: usize,
    body: &Body,
    walls: &[(&str, WindingNumber)],
    separation: &Separation,
) -> MovedBody {
    let now = &separation.tet_points[b];
    let (mut contradicting_markers, mut free) = (Vec::new(), Vec::new());
    for (m, place) in body.markers.iter().enumerate() {
        match walls.iter().find(|(_, wall)| wall.is_inside(place)) {
            Some((name, _)) => contradicting_markers
                .push(ContradictingMarker { marker: m + 1, inside: (*name).to_owned() }),
            None => free.push(*place),
        }
    }
    let distances = |points: &[Vec3]| Spread::of(&marker_distances(points, &body.triangles, &free));
    MovedBody {
        name: body.name.clone(),
        vertices: body.embedding.len(),
        moved: separation.moved[b].0,
        largest_move: separation.moved[b].1,
        inverted_tets: TetQuality::of(&body.tets.tets, now).inverted,
        marker_distance: (!free.is_empty()).then(|| {
            [
                distances(&body.surface_points(&body.tets.points)),
                distances(&separation.surface_points[b]),
            ]
        }),
        contradicting_markers,
    }
}

fn overlap_lines(before: &[Overlap], after: &[Overlap]) -> Vec<OverlapLine> {
    let mut pairs: BTreeMap<(String, String), [Option<&Overlap>; 2]> = BTreeMap::new();
    for (when, list) in [before, after].into_iter().enumerate() {
        for overlap in list {
            let names = (overlap.first.clone(), overlap.second.clone());
            pairs.entry(names).or_default()[when] = Some(overlap);
        }
    }
    pairs
        .into_iter()
        .map(|((first, second), both)| OverlapLine {
            between: [first, second],
            depth: both.map(|o| o.map_or(0.0, |o| o.depth)),
            vertices_inside: both.map(|o| o.map_or(0, |o| o.vertices_inside)),
            crossings: both.map(|o| o.map_or(0, |o| o.crossings)),
        })
        .collect()
}
