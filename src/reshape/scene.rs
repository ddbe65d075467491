//! A problem in the solver's own units: centred, scaled to volume 1, Young's modulus 1.

use std::sync::Arc;

use crate::error::Result;
use crate::fem::{Body, MaterialPoint, Spring};
use crate::locate::{ClosestPoints, Embedding, NearestPoints};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::Vec3;
use crate::mesh::TetMesh;

use super::coverage::Coverage;
use super::earlier::{Earlier, Tissue};
use super::folds::Folds;
use super::marker_groups::{MarkerGroup, marker_groups};
use super::numbering::Numbering;
use super::options::Options;
use super::problem::{Landmark, Problem, TemplatePoint};

/// Stiffness of the spring of one fixed point or hard attachment, in units of E l.
const FIRM: f64 = 100.0;

/// Total stiffness of all soft attachments' springs, in units of E l: enough to carry the body
/// along, too little to dent it.
const SOFT_TOTAL: f64 = 2.0;

/// A landmark is clicked less exactly than a marker: this many tolerances.
const LANDMARK_TOLERANCE: f64 = 5.0;

/// A surface point has been seen when a datum lies within this distance, in units of l.
const SEEN_WITHIN: f64 = 0.25;

/// Screening length where nothing and where everything was seen, in units of l.
const SCREENING: [f64; 2] = [0.1, 0.3];

/// Elements compressed below this share of their plastic rest volume are held back by a barrier of
/// this strength (in units of Young's modulus), so that none inverts.
const BARRIER_START: f64 = 0.3;
const BARRIER_STRENGTH: f64 = 1.0;

/// A paired point.
pub struct Pair {
    /// The point of the body.
    pub point: MaterialPoint,
    /// Where it belongs.
    pub target: Vec3,
    /// The user's weight.
    pub weight: f64,
}

/// The problem as the solver sees it.
pub struct Scene {
    /// Length of the solver's unit in the template's.
    pub length: f64,
    /// The solver's origin in the template's frame.
    pub center: Vec3,
    /// The order of the vertices here and in the problem.
    pub numbering: Arc<Numbering>,
    /// The elastic body; its first springs belong to the attachments, in order.
    pub body: Arc<Tissue>,
    /// Each surface vertex in the tets.
    pub embedding: Embedding,
    /// The surface's triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Search for points on the surface; to be refitted to the shape in question.
    pub surface_tree: ClosestPoints,
    /// Marker positions with the user's weights.
    pub markers: Vec<(Vec3, f64)>,
    /// Groups of the markers, where they are many.
    pub marker_groups: Option<Vec<MarkerGroup>>,
    /// Landmarks.
    pub landmarks: Vec<Pair>,
    /// Attachments.
    pub attachments: Vec<Pair>,
    /// Where the markers cover the person, when that can be known.
    pub coverage: Option<Coverage>,
    /// The surface's edges, which are kept from folding over; not by the published formulation.
    pub folds: Option<Folds>,
    /// Noise of a marker.
    pub marker_sigma: f64,
    /// Noise of a trusted landmark.
    pub landmark_sigma: f64,
    /// Noise of a trusted attachment.
    pub attachment_sigma: f64,
}

impl Scene {
    /// Scales and embeds a checked problem. What does not change from an earlier problem with the same
    /// template and options is taken from there.
    pub fn new(problem: &Problem, options: &Options, earlier: Option<&Earlier>) -> Result<Self> {
        let volume: f64 = problem
            .inside_fraction
            .iter()
            .enumerate()
            .map(|(t, fraction)| fraction * problem.tets.volume(t))
            .sum();
        let length = volume.cbrt();
        let points = &problem.surface.points;
        let center = points.iter().sum::<Vec3>() / points.len() as f64;
        let inward = |p: &Vec3| (p - center) / length;
        let numbering =
            earlier.map_or_else(|| Numbering::new(&problem.tets).into(), |e| e.numbering.clone());
        let template_tets = numbering.renumbered(&problem.tets);
        let surface_embedding = numbering.renumbered_embedding(&problem.embedding);
        let pairs = |list: &[Landmark]| -> Result<Vec<Pair>> {
            let positions: Vec<Vec3> = list
                .iter()
                .map(|l| match l.template {
                    TemplatePoint::Vertex(v) => points[v as usize],
                    TemplatePoint::Position(p) => p,
                })
                .collect();
            let anywhere = list.iter().any(|l| matches!(l.template, TemplatePoint::Position(_)));
            let embedding = if anywhere {
                Embedding::new(&template_tets, &positions)?
            } else {
                Embedding::default()
            };
            let pair = |(i, l): (usize, &Landmark)| {
                let point = match l.template {
                    TemplatePoint::Vertex(v) => embedded(&surface_embedding, v as usize),
                    TemplatePoint::Position(_) => embedded(&embedding, i),
                };
                Pair { point, target: inward(&l.target), weight: l.weight }
            };
            Ok(list.iter().enumerate().map(pair).collect())
        };
        let (landmarks, attachments) = (pairs(&problem.landmarks)?, pairs(&problem.attachments)?);
        let fixed: Vec<Pair> = problem
            .fixed
            .iter()
            .map(|&v| Pair {
                point: embedded(&surface_embedding, v as usize),
                target: inward(&points[v as usize]),
                weight: 1.0,
            })
            .collect();
        let soft = if options.hard_attachments {
            FIRM
        } else {
            SOFT_TOTAL / attachments.len().max(1) as f64
        };
        let springs: Vec<Spring> = attachments
            .iter()
            .map(|pair| spring(pair, soft))
            .chain(fixed.iter().map(|pair| spring(pair, FIRM)))
            .collect();
        let tolerance = options.tolerance.unwrap_or(problem.surface.diagonal() / 1000.0) / length;
        let markers: Vec<(Vec3, f64)> =
            problem.markers.iter().map(|m| (inward(&m.position), m.weight)).collect();
        let positions: Vec<Vec3> = markers.iter().map(|m| m.0).collect();
        let coverage = if options.reverse_term {
            let surface: Vec<(Vec3, MaterialPoint)> = points
                .iter()
                .enumerate()
                .map(|(v, p)| (inward(p), embedded(&surface_embedding, v)))
                .collect();
            Coverage::of_slices(&positions, &surface)
        } else {
            None
        };
        let body = match earlier.filter(|e| e.body.springs == springs) {
            Some(earlier) => earlier.body.clone(),
            None => Arc::new(Body::new(
                TetMesh {
                    points: template_tets.points.iter().map(inward).collect(),
                    tets: template_tets.tets,
                },
                InversionBarrier::new(
                    StableNeoHookean::new(1.0, options.poisson),
                    BARRIER_START,
                    BARRIER_STRENGTH,
                ),
                springs,
            )?),
        };
        Ok(Self {
            length,
            center,
            body,
            numbering,
            embedding: surface_embedding,
            surface_tree: ClosestPoints::new(
                &points.iter().map(inward).collect::<Vec<_>>(),
                &problem.surface.triangles,
            ),
            triangles: problem.surface.triangles.clone(),
            marker_groups: marker_groups(&positions),
            markers,
            coverage,
            folds: (!options.paper)
                .then(|| Folds::new(points, &problem.surface.triangles, tolerance * length)),
            landmarks,
            attachments,
            marker_sigma: tolerance,
            landmark_sigma: options
                .landmark_tolerance
                .map_or(LANDMARK_TOLERANCE * tolerance, |t| t / length),
            attachment_sigma: options.attachment_tolerance.map_or(tolerance, |t| t / length),
        })
    }

    /// Screening length for the part of the surface of the shape `x` that has data near by.
    pub fn default_screening(&self, x: &[Vec3]) -> f64 {
        let targets = self.landmarks.iter().chain(&self.attachments).map(|pair| pair.target);
        let data: Vec<Vec3> = self.markers.iter().map(|m| m.0).chain(targets).collect();
        let nearest = NearestPoints::new(&data);
        let surface = self.embedding.apply(x);
        let seen = surface
            .iter()
            .filter(|p| nearest.nearest(p).is_some_and(|(_, distance)| distance < SEEN_WITHIN))
            .count();
        let [least, most] = SCREENING;
        least + (most - least) * seen as f64 / surface.len() as f64
    }

    /// Positions in the template's unit and frame.
    pub fn outward(&self, x: &[Vec3]) -> Vec<Vec3> {
        x.iter().map(|x| x * self.length + self.center).collect()
    }

    /// The body's point that a surface vertex is.
    pub fn surface_vertex(&self, vertex: u32) -> MaterialPoint {
        embedded(&self.embedding, vertex as usize)
    }

    /// The body's point that a surface point is.
    pub fn surface_point(&self, triangle: u32, barycentric: &[f64; 3]) -> MaterialPoint {
        let mut entries: Vec<(u32, f64)> = Vec::with_capacity(12);
        for (&v, b) in self.triangles[triangle as usize].iter().zip(barycentric) {
            for (&w, weight) in
                self.embedding.vertices[v as usize].iter().zip(self.embedding.weights[v as usize])
            {
                match entries.iter_mut().find(|(vertex, _)| *vertex == w) {
                    Some((_, sum)) => *sum += b * weight,
                    None => entries.push((w, b * weight)),
                }
            }
        }
        entries.retain(|(_, w)| *w != 0.0);
        MaterialPoint(entries)
    }
}

fn embedded(embedding: &Embedding, i: usize) -> MaterialPoint {
    let entries = embedding.vertices[i].into_iter().zip(embedding.weights[i]);
    MaterialPoint(entries.filter(|(_, w)| *w != 0.0).collect())
}

fn spring(pair: &Pair, stiffness: f64) -> Spring {
    Spring { point: pair.point.clone(), target: pair.target, stiffness: stiffness * pair.weight }
}
