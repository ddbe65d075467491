//! What a reshaping minimises over the plastic strain: its smoothness and the data terms of the shape in
//! equilibrium with it ([W] Eq. 3).

use std::sync::Arc;

use crate::error::Result;
use crate::fem::{PlasticState, Screening, Sensitivity, StrainSmoothness};
use crate::math::{Mat3, Sym3};
use crate::solve::Factor;

use super::affine_start::affine_start;
use super::correspondences::Correspondences;
use super::data_terms::DataEvaluation;
use super::earlier::{Earlier, State};
use super::formulation::{Formulation, MEAN_SIGMA};
use super::options::Options;
use super::problem::Problem;
use super::scene::Scene;
use super::term::Weighting;

/// Smallest share of a tet's volume that counts for the smoothness: nearly empty boundary tets
/// of a lattice would otherwise be free to invert.
const SMALLEST_TET_WEIGHT: f64 = 0.1;

/// The objective of one problem.
pub struct Objective<'a> {
    pub scene: Scene,
    pub options: &'a Options,
    pub formulation: Formulation,
    pub smoothness: Arc<StrainSmoothness>,
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
    /// Smoothness plus the robust cost of the data.
    pub objective: f64,
    pub data: DataEvaluation,
    /// Smoothness plus half the squares at these weights: what a step lowers, and the objective with it
    /// (iteratively reweighted least squares).
    pub majorizer: f64,
}

impl<'a> Objective<'a> {
    /// Comes with the strain and the shape to start from: one strain everywhere, fitted to the data, for
    /// a free body; rest for a held one.
    pub fn new(problem: &Problem, options: &'a Options) -> Result<(Self, State)> {
        let scene = Scene::new(problem, options, None)?;
        let formulation = Formulation::of(options);
        let space = formulation.space;
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
        let screens = formulation.screened && screening.is_finite();
        let mean_sigma = if scene.body.is_free() { MEAN_SIGMA } else { 0.0 };
        let screening = Screening { length: screening, mean_sigma };
        let smoothness = StrainSmoothness::new(
            &scene.body,
            &space,
            formulation.smoothness,
            screens.then_some(screening),
            &tet_weight,
        )?;
        let objective = Self { scene, options, formulation, smoothness: smoothness.into() };
        Ok((objective, State { s, x }))
    }

    /// Of a problem whose template was reshaped before; comes with the state reached then.
    pub fn again(problem: &Problem, earlier: &'a Earlier) -> Result<(Self, State)> {
        let options = &earlier.options;
        let mut scene = Scene::new(problem, options, Some(earlier))?;
        if earlier.attachment_gains.len() == scene.data.attachments.gains.len() {
            scene.data.attachments.gains.clone_from(&earlier.attachment_gains);
        }
        let objective = Self {
            scene,
            options,
            formulation: Formulation::of(options),
            smoothness: earlier.smoothness.clone(),
        };
        Ok((objective, earlier.state.clone()))
    }

    /// A state with its correspondences.
    pub fn shape(&self, state: State) -> Shape {
        Shape { correspondences: self.scene.data.correspondences(&state.x), state }
    }

    /// Weights, rows and objective of a shape.
    pub fn evaluate(&self, shape: Shape, weighting: Weighting) -> Evaluation {
        let data = self.scene.data.evaluate(&shape.state.x, &shape.correspondences, weighting);
        let prior = self.prior(&shape.state.s);
        Evaluation {
            shape,
            weighting,
            objective: prior + data.cost,
            majorizer: prior + data.rows.energy(),
            data,
        }
    }

    /// Factor of the stiffness at a state, and how its strain moves the forces: what a linearization needs.
    pub fn derivatives(&self, state: &State) -> Result<(Factor, Sensitivity)> {
        let (body, plastic) = (&self.scene.body, self.plastic(&state.s));
        let (stiffness, sensitivity) = rayon::join(
            || body.factor_stiffness(&state.x, &plastic),
            || Sensitivity::new(body, &self.formulation.space, &state.x, &plastic),
        );
        Ok((stiffness?, sensitivity))
    }

    /// Smoothness of a strain.
    pub fn prior(&self, s: &[Sym3]) -> f64 {
        self.smoothness.energy(s)
    }

    pub fn plastic(&self, s: &[Sym3]) -> Vec<PlasticState> {
        self.formulation.space.states(s, &self.scene.body.mesh.tets)
    }

    /// Fp of every tet.
    pub fn plastic_strain(&self, s: &[Sym3]) -> Vec<Mat3> {
        let tets = self.scene.body.mesh.tets.iter().enumerate();
        tets.map(|(t, tet)| self.formulation.space.plastic_strain(s, t, tet)).collect()
    }
}
