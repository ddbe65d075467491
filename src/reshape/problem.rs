//! What is reshaped, and to what: a template with its tets, markers, landmarks, attachments.

use crate::error::{Error, Result};
use crate::locate::Embedding;
use crate::math::Vec3;
use crate::mesh::{TetMesh, TriMesh};
use crate::tetrahedralize::{self, Method, Tetrahedralization, Used};

/// A point of the template.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TemplatePoint {
    /// A vertex of the surface.
    Vertex(u32),
    /// A position on or in the template at rest.
    Position(Vec3),
}

impl TemplatePoint {
    /// Where it is at rest; `vertices`: of the template's surface.
    pub fn position(&self, vertices: &[Vec3]) -> Vec3 {
        match *self {
            Self::Vertex(v) => vertices[v as usize],
            Self::Position(position) => position,
        }
    }
}

/// A point on the person's surface, without correspondence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// Where it was seen.
    pub position: Vec3,
    /// How much it counts beside the others; 1 is usual, 0 leaves it out.
    pub weight: f64,
    /// Standard deviation of its own noise; `None`: the tolerance of all.
    pub sigma: Option<f64>,
}

impl Marker {
    /// A usual one.
    pub fn at(position: Vec3) -> Self {
        Self { position, weight: 1.0, sigma: None }
    }
}

/// A point of the template and where the person has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Name for the report.
    pub label: String,
    /// The point of the template.
    pub template: TemplatePoint,
    /// Where it was seen.
    pub target: Vec3,
    /// How much it counts beside the others; 1 is usual, 0 leaves it out.
    pub weight: f64,
    /// Of a pin: how far it may end from its target, whatever the markers say; 0: not at all. `None`: it is
    /// weighed against the markers by the tolerance of all. Attachments have none.
    pub within: Option<f64>,
}

/// Fails if so many points of a weight above 0 do not determine a shape.
pub fn check_amount(markers: usize, landmarks: usize, attachments: usize) -> Result<()> {
    if markers + landmarks + attachments >= 3 {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "{markers} markers, {landmarks} landmarks and {attachments} attachments do not determine a shape; give at least three points of a weight above 0"
    )))
}

/// One reshaping problem. All lengths are in the template's unit.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The template's surface at rest.
    pub surface: TriMesh,
    /// The tets that carry it.
    pub tets: TetMesh,
    /// Each surface vertex in the tets.
    pub embedding: Embedding,
    /// Share of each tet that lies inside the surface, 0 to 1.
    pub inside_fraction: Vec<f64>,
    /// What made the tets.
    pub made_by: Used,
    /// How new ones are made where these become too flat.
    pub new_tets: tetrahedralize::Options,
    /// Points of the person's surface.
    pub markers: Vec<Marker>,
    /// Paired points, found on template and person.
    pub landmarks: Vec<Landmark>,
    /// Paired points that hold the body mechanically too, e.g. where a muscle grows on a bone.
    pub attachments: Vec<Landmark>,
    /// Surface vertices that stay where they are.
    pub fixed: Vec<u32>,
}

impl Problem {
    /// A problem without any data yet. New tets would be as many, made in the same way if it is known.
    pub fn new(surface: TriMesh, tets: Tetrahedralization) -> Self {
        let method = if tets.used == Used::Lattice { Method::Lattice } else { Method::Auto };
        let tet_count = tets.mesh.tets.len();
        Self {
            surface,
            tets: tets.mesh,
            embedding: tets.embedding,
            inside_fraction: tets.inside_fraction,
            made_by: tets.used,
            new_tets: tetrahedralize::Options { method, tet_count, ..Default::default() },
            markers: Vec::new(),
            landmarks: Vec::new(),
            attachments: Vec::new(),
            fixed: Vec::new(),
        }
    }

    /// Checks counts, indices and numbers; says what is missing.
    pub fn check(&self) -> Result<()> {
        if self.embedding.len() != self.surface.points.len() {
            return Err(Error::invalid(
                "the embedding does not belong to this surface: their vertex counts differ",
            ));
        }
        if self.inside_fraction.len() != self.tets.tets.len() {
            return Err(Error::invalid(
                "the inside fractions do not belong to this tet mesh: their counts differ",
            ));
        }
        if self.surface.triangles.is_empty() || self.tets.tets.is_empty() {
            return Err(Error::invalid("the template has no triangles or no tets"));
        }
        let of_weight = |pairs: &[Landmark]| pairs.iter().filter(|p| p.weight > 0.0).count();
        let markers = self.markers.iter().filter(|m| m.weight > 0.0).count();
        let (landmarks, attachments) = (of_weight(&self.landmarks), of_weight(&self.attachments));
        check_amount(markers, landmarks, attachments)?;
        self.check_numbers()
    }

    fn check_numbers(&self) -> Result<()> {
        for (i, marker) in self.markers.iter().enumerate() {
            check_number(&marker.position, marker.weight, || format!("marker {i}"))?;
            if let Some(sigma) = marker.sigma.filter(|sigma| !(sigma.is_finite() && *sigma > 0.0)) {
                return Err(Error::invalid(format!(
                    "marker {i} has the noise (sigma) {sigma}; it must be above 0, or be left out"
                )));
            }
        }
        let vertices = self.surface.points.len();
        for (kind, list) in [("landmark", &self.landmarks), ("attachment", &self.attachments)] {
            for (i, pair) in list.iter().enumerate() {
                let name = || format!("{kind} {i} ({})", pair.label);
                check_number(&pair.target, pair.weight, name)?;
                check_within(pair.within, name)?;
                match pair.template {
                    TemplatePoint::Vertex(v) if v as usize >= vertices => {
                        return Err(Error::invalid(format!(
                            "{} names vertex {v}, but the template has {vertices} vertices (numbered from 0)",
                            name()
                        )));
                    }
                    TemplatePoint::Position(p) => check_number(&p, 1.0, name)?,
                    TemplatePoint::Vertex(_) => {}
                }
            }
        }
        match self.fixed.iter().find(|&&v| v as usize >= vertices) {
            Some(v) => Err(Error::invalid(format!(
                "fixed vertex {v} does not exist: the template has {vertices} vertices (numbered from 0)"
            ))),
            None => Ok(()),
        }
    }
}

fn check_within(within: Option<f64>, name: impl Fn() -> String) -> Result<()> {
    match within.filter(|within| !(within.is_finite() && *within >= 0.0)) {
        Some(within) => Err(Error::invalid(format!(
            "{} is to be held within {within}; a length of 0 or more is needed",
            name()
        ))),
        None => Ok(()),
    }
}

fn check_number(p: &Vec3, weight: f64, name: impl Fn() -> String) -> Result<()> {
    if !p.iter().all(|c| c.is_finite()) {
        return Err(Error::invalid(format!(
            "{} has a coordinate that is not a finite number",
            name()
        )));
    }
    if !(weight.is_finite() && weight >= 0.0) {
        return Err(Error::invalid(format!(
            "{} has the weight {weight}; it must be 0 or more",
            name()
        )));
    }
    Ok(())
}
