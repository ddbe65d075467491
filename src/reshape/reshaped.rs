//! The result of a reshaping, through all its legs.

use std::sync::Arc;

use super::earlier::Earlier;
use super::problem::Problem;
use super::summary::Summary;
use crate::error::Result;
use crate::fem::deformation_gradients;
use crate::locate::Embedding;
use crate::math::{Mat3, Vec3};
use crate::mesh::TetMesh;

/// A reshaped template.
#[derive(Clone, Debug)]
pub struct Reshaped {
    /// The surface's vertices, in the template's order.
    pub surface_points: Vec<Vec3>,
    /// The problem on the tets that the run ended with: the caller's, unless new ones were made
    /// ([`Summary::remeshes`]); then surface and tets at rest are the shape that the old ones had reached.
    pub problem: Problem,
    /// The vertices of these tets.
    pub tet_points: Vec<Vec3>,
    /// Plastic strain Fp of each of these tets, from the template to the person (symmetric positive
    /// definite).
    pub plastic_strain: Vec<Mat3>,
    /// What happened.
    pub summary: Summary,
    /// Those before the last.
    pub(super) legs: Vec<Leg>,
    /// Deformation of each tet before the last leg; empty for the first.
    pub(super) before: Vec<Mat3>,
    /// For [`super::reshape_again`].
    pub(super) earlier: Arc<Earlier>,
}

/// Tets and where they went, of a leg that is over.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    /// The surface's vertices at its start.
    pub surface: Vec<Vec3>,
    /// The tets at its start.
    pub rest: TetMesh,
    /// Their vertices at its end.
    pub now: Vec<Vec3>,
    /// The smoothness of its strain.
    pub strain_energy: f64,
}

impl Reshaped {
    /// Where points of the template went; those outside the tets go with the nearest one.
    pub fn carry(&self, points: &[Vec3]) -> Result<Vec<Vec3>> {
        carry(&self.problem.tets, &self.tet_points, &carry_through(&self.legs, points)?)
    }

    /// Where the tets' vertices are in the template.
    pub fn rest_positions(&self) -> Result<Vec<Vec3>> {
        let mut points = self.problem.tets.points.clone();
        for leg in self.legs.iter().rev() {
            let now = TetMesh { points: leg.now.clone(), tets: leg.rest.tets.clone() };
            points = carry(&now, &leg.rest.points, &points)?;
        }
        Ok(points)
    }

    /// The tets in the person's shape.
    pub fn deformed_tets(&self) -> TetMesh {
        TetMesh { points: self.tet_points.clone(), tets: self.problem.tets.tets.clone() }
    }

    /// Deformation gradient of each tet, from the template to the person.
    pub fn gradients(&self) -> Vec<Mat3> {
        let last = deformation_gradients(&self.problem.tets, &self.tet_points);
        self.with_earlier_deformation(last)
    }

    /// The smoothness of the strains of all legs.
    pub(super) fn strain_energy(&self) -> f64 {
        let over: f64 = self.legs.iter().map(|leg| leg.strain_energy).sum();
        over + self.earlier.strain_energy()
    }

    /// Gradients of the last leg, after those of the legs before it.
    pub(super) fn with_earlier_deformation(&self, last: Vec<Mat3>) -> Vec<Mat3> {
        if self.before.is_empty() {
            return last;
        }
        last.iter().zip(&self.before).map(|(f, before)| f * before).collect()
    }

    /// Surface and tets of the template.
    pub(super) fn template(&self) -> (&[Vec3], &TetMesh) {
        let last = (&self.problem.surface.points[..], &self.problem.tets);
        self.legs.first().map_or(last, |leg| (&leg.surface, &leg.rest))
    }
}

/// Where points of the template were when these legs were over.
pub(super) fn carry_through(legs: &[Leg], points: &[Vec3]) -> Result<Vec<Vec3>> {
    let mut points = points.to_vec();
    for leg in legs {
        points = carry(&leg.rest, &leg.now, &points)?;
    }
    Ok(points)
}

fn carry(from: &TetMesh, to: &[Vec3], points: &[Vec3]) -> Result<Vec<Vec3>> {
    Ok(Embedding::new(from, points)?.apply(to))
}
