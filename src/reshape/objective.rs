//! What a reshaping minimises over the plastic strain: its smoothness and the data terms of the shape in
//! equilibrium with it ([W] Eq. 3).

use std::sync::Arc;

use crate::error::Result;
use crate::fem::{PlasticState, StrainSmoothness, StrainSpace};
use crate::math::{Mat3, Sym3, Vec3};

use super::affine_start::affine_start;
use super::correspondences::Correspondences;
use super::data_terms::rows;
use super::earlier::{Earlier, State};
use super::options::Options;
use super::problem::Problem;
use super::rows::Rows;
use super::scene::Scene;
use super::weights::{Weighting, Weights};

/// Smallest share of a tet's volume that counts for the smoothness: nearly empty boundary tets
/// of a lattice would otherwise be free to invert.
const SMALLEST_TET_WEIGHT: f64 = 0.1;

/// Weight of the graph Laplacian in the published formulation.
const PAPER_SMOOTHNESS: f64 = 1.0;

/// The terms of one problem.
pub struct Objective<'a> {
    pub scene: Scene,
    pub space: StrainSpace,
    pub options: &'a Options,
    pub smoothness: Arc<StrainSmoothness>,
    /// The strain that costs nothing.
    pub anchor: Arc<Vec<Sym3>>,
    /// What each attachment's weight is multiplied by.
    pub attachment_gains: Vec<f64>,
}

/// A state and where the markers touch it.
#[derive(Clone)]
pub struct Shape {
    pub state: State,
    pub correspondences: Correspondences,
}

/// All that the data say about a shape under one weighting.
pub struct Evaluation {
    pub shape: Shape,
    pub weighting: Weighting,
    pub weights: Weights,
    pub rows: Rows,
    /// Smoothness plus data terms at these weights.
    pub objective: f64,
}

impl<'a> Objective<'a> {
    /// Comes with the strain and the shape to start from: one strain everywhere, fitted to the data, for
    /// a free body; rest for a held one.
    pub fn new(problem: &Problem, options: &'a Options) -> Result<(Self, State)> {
        let scene = Scene::new(problem, options, None)?;
        let space = strain_space(options);
        let (strain, x) = if scene.body.is_free() {
            let start = affine_start(&scene);
            (start.strain, start.x)
        } else {
            (Sym3::zeros(), scene.body.mesh.points.clone())
        };
        let carriers = space.carriers(scene.body.mesh.points.len(), scene.body.mesh.tets.len());
        let s = vec![space.from_logarithm(&strain); carriers];
        let screening = options.screening.unwrap_or_else(|| scene.default_screening(&x));
        let floor = |fraction: &f64| fraction.max(SMALLEST_TET_WEIGHT);
        let tet_weight: Vec<f64> =
            scene.numbering.tets(&problem.inside_fraction).iter().map(floor).collect();
        let smoothness = StrainSmoothness::new(
            &scene.body,
            &space,
            if options.paper { PAPER_SMOOTHNESS } else { options.smoothness },
            (screening.is_finite() && !options.paper).then_some(screening),
            &tet_weight,
        )?;
        let objective = Self {
            attachment_gains: vec![1.0; scene.attachments.len()],
            scene,
            space,
            options,
            smoothness: smoothness.into(),
            anchor: s.clone().into(),
        };
        Ok((objective, State { s, x }))
    }

    /// Of a problem whose template was reshaped before; comes with the state reached then.
    pub fn again(problem: &Problem, earlier: &'a Earlier) -> Result<(Self, State)> {
        let options = &earlier.options;
        let scene = Scene::new(problem, options, Some(earlier))?;
        let same = earlier.attachment_gains.len() == scene.attachments.len();
        let gains = same.then(|| earlier.attachment_gains.clone());
        let objective = Self {
            attachment_gains: gains.unwrap_or_else(|| vec![1.0; scene.attachments.len()]),
            scene,
            space: strain_space(options),
            options,
            smoothness: earlier.smoothness.clone(),
            anchor: earlier.anchor.clone(),
        };
        Ok((objective, earlier.state.clone()))
    }

    /// A state with its correspondences.
    pub fn shape(&self, state: State) -> Shape {
        Shape { correspondences: Correspondences::new(&self.scene, &state.x), state }
    }

    /// Weights and rows of a shape.
    pub fn evaluate(&self, shape: Shape, weighting: Weighting) -> Evaluation {
        let Shape { state, correspondences } = &shape;
        let gains = &self.attachment_gains;
        let weights = Weights::new(&self.scene, correspondences, &state.x, weighting, gains);
        let rows = rows(&self.scene, correspondences, &weights, &state.x);
        let objective = rows.energy() + self.prior(&state.s);
        Evaluation { shape, weighting, weights, rows, objective }
    }

    /// The data terms of a shape at given weights.
    pub fn data(&self, x: &[Vec3], correspondences: &Correspondences, weights: &Weights) -> f64 {
        rows(&self.scene, correspondences, weights, x).energy()
    }

    /// Smoothness of a strain.
    pub fn prior(&self, s: &[Sym3]) -> f64 {
        let u: Vec<Sym3> = s.iter().zip(self.anchor.iter()).map(|(s, a)| s - a).collect();
        self.smoothness.energy(&u)
    }

    pub fn plastic(&self, s: &[Sym3]) -> Vec<PlasticState> {
        self.space.states(s, &self.scene.body.mesh.tets)
    }

    /// Fp of every tet.
    pub fn plastic_strain(&self, s: &[Sym3]) -> Vec<Mat3> {
        let tets = self.scene.body.mesh.tets.iter().enumerate();
        tets.map(|(t, tet)| self.space.plastic_strain(s, t, tet)).collect()
    }
}

fn strain_space(options: &Options) -> StrainSpace {
    if options.paper { StrainSpace::PAPER } else { StrainSpace::NODAL_LOGARITHM }
}
