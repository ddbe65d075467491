//! A problem in the solver's own units: centred, scaled to volume 1, Young's modulus 1.

use std::sync::Arc;

use crate::error::Result;
use crate::fem::{Body, MaterialPoint, Spring};
use crate::locate::{ClosestPoints, Embedding, NearestPoints};
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::math::Vec3;
use crate::mesh::TetMesh;

use super::carried_surface::{CarriedSurface, embedded};
use super::coverage::Coverage;
use super::data_terms::DataTerms;
use super::earlier::{Earlier, Tissue};
use super::folds::Folds;
use super::formulation::Formulation;
use super::markers::Markers;
use super::numbering::Numbering;
use super::options::Options;
use super::paired_points::{PairedPoint, PairedPoints};
use super::pins::{Pin, Pins};
use super::problem::{Landmark, Marker, Problem, TemplatePoint};

/// Stiffness of the spring of one fixed point or hard attachment, in units of E l.
const FIRM: f64 = 100.0;

/// Total stiffness of all soft attachments' springs, in units of E l: enough to carry the body
/// along, too little to dent it.
const SOFT_TOTAL: f64 = 2.0;

/// A surface point has been seen when a datum lies within this distance, in units of l.
const SEEN_WITHIN: f64 = 0.25;

/// Screening length where nothing and where everything was seen, in units of l.
const SCREENING: [f64; 2] = [0.1, 0.3];

/// Elements compressed below this share of their plastic rest volume are held back by a barrier of
/// this strength (in units of Young's modulus), so that none inverts.
const BARRIER_START: f64 = 0.3;
const BARRIER_STRENGTH: f64 = 1.0;

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
    /// The data.
    pub data: DataTerms,
}

/// Where the solver's unit and origin are in the template's frame.
#[derive(Clone, Copy)]
struct Units {
    length: f64,
    center: Vec3,
}

impl Units {
    /// The body inside the surface has the volume 1.
    fn of(problem: &Problem) -> Self {
        let volume = |(t, fraction): (usize, &f64)| fraction * problem.tets.volume(t);
        let volume: f64 = problem.inside_fraction.iter().enumerate().map(volume).sum();
        let points = &problem.surface.points;
        let center = points.iter().sum::<Vec3>() / points.len() as f64;
        Self { length: libm::cbrt(volume), center }
    }

    fn inward(&self, p: &Vec3) -> Vec3 {
        (p - self.center) / self.length
    }
}

/// The template's points in its renumbered tets.
struct Places<'a> {
    units: Units,
    template: &'a [Vec3],
    tets: &'a TetMesh,
    /// Of the surface's vertices.
    embedding: &'a Embedding,
}

impl Places<'_> {
    fn pairs(&self, list: &[Landmark]) -> Result<Vec<PairedPoint>> {
        let positions: Vec<Vec3> =
            list.iter().map(|l| l.template.position(self.template)).collect();
        let anywhere = list.iter().any(|l| matches!(l.template, TemplatePoint::Position(_)));
        let embedding =
            if anywhere { Embedding::new(self.tets, &positions)? } else { Embedding::default() };
        let pair = |(i, l): (usize, &Landmark)| {
            let point = match l.template {
                TemplatePoint::Vertex(v) => embedded(self.embedding, v as usize),
                TemplatePoint::Position(_) => embedded(&embedding, i),
            };
            PairedPoint { point, target: self.units.inward(&l.target), weight: l.weight }
        };
        Ok(list.iter().enumerate().map(pair).collect())
    }

    fn pins(&self, list: &[Landmark]) -> Result<Vec<Pin>> {
        let pin = |(PairedPoint { point, target, weight }, landmark): (_, &Landmark)| {
            let within = landmark.within.unwrap_or_default() / self.units.length;
            Pin { point, target, within, weight }
        };
        Ok(self.pairs(list)?.into_iter().zip(list).map(pin).collect())
    }

    /// A vertex that stays.
    fn fixed(&self, vertex: u32) -> PairedPoint {
        let (point, target) = self.vertex(vertex as usize);
        PairedPoint { point, target, weight: 1.0 }
    }

    /// A surface vertex and where it is at rest.
    fn vertex(&self, v: usize) -> (MaterialPoint, Vec3) {
        (embedded(self.embedding, v), self.units.inward(&self.template[v]))
    }
}

impl Scene {
    /// Scales and embeds a checked problem. What does not change from an earlier problem with the same
    /// template and options is taken from there.
    pub fn new(problem: &Problem, options: &Options, earlier: Option<&Earlier>) -> Result<Self> {
        let units = Units::of(problem);
        let Units { length, center } = units;
        let numbering =
            earlier.map_or_else(|| Numbering::new(&problem.tets).into(), |e| e.numbering.clone());
        let tets = numbering.renumbered(&problem.tets);
        let embedding = numbering.renumbered_embedding(&problem.embedding);
        let template = &problem.surface.points;
        let places = Places { units, template, tets: &tets, embedding: &embedding };
        let (pinned, weighed): (Vec<Landmark>, Vec<Landmark>) =
            problem.landmarks.iter().cloned().partition(|landmark| landmark.within.is_some());
        let landmarks = places.pairs(&weighed)?;
        let pins = places.pins(&pinned)?;
        let attachments = places.pairs(&problem.attachments)?;
        let fixed = problem.fixed.iter().map(|&v| places.fixed(v));
        let springs = springs(&attachments, fixed, options);
        let rest: Vec<(MaterialPoint, Vec3)> =
            (0..template.len()).map(|v| places.vertex(v)).collect();
        let at_rest: Vec<Vec3> = rest.iter().map(|vertex| vertex.1).collect();
        let positions: Vec<Vec3> =
            problem.markers.iter().map(|m| units.inward(&m.position)).collect();
        let sigma = options.tolerances(&problem.surface, length);
        let weights = problem.markers.iter().map(|m| m.weight).collect();
        let noise = |marker: &Marker| marker.sigma.map_or(1.0, |own| own / (sigma.marker * length));
        let noise = problem.markers.iter().map(noise).collect();
        let triangles = problem.surface.triangles.clone();
        // Without markers nothing speaks against a pair, however far it has to go.
        let doubted = !positions.is_empty();
        let hinges = Formulation::of(options).hinges;
        let data = DataTerms {
            coverage: options
                .reverse_term
                .then(|| Coverage::of_slices(&positions, &rest))
                .flatten(),
            folds: hinges.then(|| Folds::new(template, &triangles, sigma.marker * length)),
            markers: Markers::new(positions, weights, noise, sigma.marker),
            landmarks: PairedPoints::new(landmarks, sigma.landmark, doubted),
            pins: Pins::new(pins, sigma.marker),
            attachments: PairedPoints::new(
                attachments,
                sigma.attachment,
                doubted && !options.hard_attachments,
            ),
            surface: CarriedSurface {
                search: ClosestPoints::new(&at_rest, &triangles),
                embedding,
                triangles,
            },
        };
        let body = body(&tets, units, springs, options, earlier)?;
        Ok(Self { length, center, numbering, body, data })
    }

    /// Screening length for the part of the surface of the shape `x` that has data near by.
    pub fn default_screening(&self, x: &[Vec3]) -> f64 {
        let pairs = self.data.landmarks.list.iter().chain(&self.data.attachments.list);
        let markers = self.data.markers.positions.iter().copied();
        let pins = self.data.pins.list.iter().map(|pin| pin.target);
        let data: Vec<Vec3> = markers.chain(pairs.map(|pair| pair.target)).chain(pins).collect();
        let nearest = NearestPoints::new(&data);
        let surface = self.data.surface.embedding.apply(x);
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
}

/// The springs of the attachments, then of what is fixed.
fn springs(
    attachments: &[PairedPoint],
    fixed: impl Iterator<Item = PairedPoint>,
    options: &Options,
) -> Vec<Spring> {
    let soft =
        if options.hard_attachments { FIRM } else { SOFT_TOTAL / attachments.len().max(1) as f64 };
    let spring = |pair: &PairedPoint, stiffness: f64| Spring {
        point: pair.point.clone(),
        target: pair.target,
        stiffness: stiffness * pair.weight,
    };
    let attached = attachments.iter().map(|pair| spring(pair, soft));
    attached.chain(fixed.map(|pair| spring(&pair, FIRM))).collect()
}

/// The elastic body; an earlier one with the same springs serves again.
fn body(
    tets: &TetMesh,
    units: Units,
    springs: Vec<Spring>,
    options: &Options,
    earlier: Option<&Earlier>,
) -> Result<Arc<Tissue>> {
    if let Some(earlier) = earlier.filter(|e| e.body.springs == springs) {
        return Ok(earlier.body.clone());
    }
    let points = tets.points.iter().map(|p| units.inward(p)).collect();
    let material = InversionBarrier::new(
        StableNeoHookean::new(1.0, options.poisson),
        BARRIER_START,
        BARRIER_STRENGTH,
    );
    Ok(Arc::new(Body::new(TetMesh { points, tets: tets.tets.clone() }, material, springs)?))
}
