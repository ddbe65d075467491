//! An elastic body with plastic strain and springs: energy, gradient, stiffness of the whole mesh.

use std::sync::Arc;

use rayon::prelude::*;

use super::element::{Curvature, RestElement, Stiffness};
use super::plastic::PlasticState;
use super::rigid_modes::isostatic_gauge;
use crate::error::Result;
use crate::material::IsotropicDensity;
use crate::math::Vec3;
use crate::mesh::TetMesh;
use crate::solve::{BlockMatrix, BlockPattern, Factor, Memory, SymbolicFactor};

/// Shifts of an indefinite stiffness, as shares of the mean of its diagonal.
const SHIFTS: [f64; 2] = [1e-8, 1e3];

/// A point of the body: an affine combination of vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialPoint(pub Vec<(u32, f64)>);

impl MaterialPoint {
    /// Where the point is when the vertices are at `x`.
    pub fn position(&self, x: &[Vec3]) -> Vec3 {
        self.0.iter().map(|&(v, w)| x[v as usize] * w).sum()
    }
}

/// A spring of zero length between a point of the body and a fixed target. The point's vertices
/// must share one tet. Energy stiffness/2 |x - target|^2.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// The point that is held.
    pub point: MaterialPoint,
    /// Where it is held.
    pub target: Vec3,
    /// Force per length.
    pub stiffness: f64,
}

/// A tet mesh ready for statics; its pattern is analysed once. Its vertices are eliminated by
/// number: fast when they are numbered by [`crate::solve::nested_dissection`].
pub struct Body<M> {
    /// The mesh at rest.
    pub mesh: TetMesh,
    /// Each tet at rest.
    pub rest: Vec<RestElement>,
    /// What it is made of.
    pub material: M,
    /// Springs that hold it. Without any, it is free.
    pub springs: Vec<Spring>,
    /// Degrees of freedom held by the gauge of a free body.
    gauge: Option<[usize; 6]>,
    pattern: BlockPattern,
    symbolic: Arc<SymbolicFactor>,
    incident: Vec<Vec<(u32, u8)>>,
    /// For the elements' stiffness matrices.
    elements: Memory<Stiffness>,
}

impl<M: IsotropicDensity> Body<M> {
    /// Analyses the mesh. A body without springs is free and gets a gauge.
    pub fn new(mesh: TetMesh, material: M, springs: Vec<Spring>) -> Result<Self> {
        let rest = (0..mesh.tets.len()).map(|t| RestElement::new(mesh.corners(t))).collect();
        let pattern = BlockPattern::of_tets(mesh.points.len(), &mesh.tets, 3);
        let symbolic = SymbolicFactor::new(&pattern)?;
        let gauge = springs.is_empty().then(|| isostatic_gauge(&mesh.points));
        let mut incident = vec![Vec::new(); mesh.points.len()];
        for (t, tet) in mesh.tets.iter().enumerate() {
            for (a, &v) in tet.iter().enumerate() {
                incident[v as usize].push((t as u32, a as u8));
            }
        }
        let elements = Memory::default();
        Ok(Self { mesh, rest, material, springs, gauge, pattern, symbolic, incident, elements })
    }

    /// Whether no spring holds the body, so that it may move rigidly.
    pub fn is_free(&self) -> bool {
        self.gauge.is_some()
    }

    /// Tets around each vertex, each with the corner that the vertex is.
    pub fn incident(&self) -> &[Vec<(u32, u8)>] {
        &self.incident
    }

    /// Pattern and ordering of the stiffness matrix.
    pub fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    /// Number of entries of the stiffness factor.
    pub fn factor_fill(&self) -> usize {
        self.symbolic.fill()
    }

    /// Corner positions of tet `t` in the shape `x`.
    pub fn corners(&self, x: &[Vec3], t: usize) -> [Vec3; 4] {
        self.mesh.tets[t].map(|v| x[v as usize])
    }

    /// Elastic energy and springs' energy.
    pub fn energy(&self, x: &[Vec3], plastic: &[PlasticState]) -> f64 {
        let parts: Vec<f64> = (0..self.rest.len())
            .into_par_iter()
            .map(|t| self.rest[t].energy(&self.corners(x, t), &plastic[t], &self.material))
            .collect();
        let springs = self
            .springs
            .iter()
            .map(|s| 0.5 * s.stiffness * (s.point.position(x) - s.target).norm_squared());
        parts.iter().sum::<f64>() + springs.sum::<f64>()
    }

    /// Derivative of the energy by each vertex.
    pub fn gradient(&self, x: &[Vec3], plastic: &[PlasticState]) -> Vec<Vec3> {
        let parts: Vec<[Vec3; 4]> = (0..self.rest.len())
            .into_par_iter()
            .map(|t| self.rest[t].gradient(&self.corners(x, t), &plastic[t], &self.material))
            .collect();
        let mut gradient: Vec<Vec3> = self
            .incident
            .par_iter()
            .map(|tets| tets.iter().map(|&(t, a)| parts[t as usize][a as usize]).sum())
            .collect();
        for spring in &self.springs {
            let force = (spring.point.position(x) - spring.target) * spring.stiffness;
            for &(v, w) in &spring.point.0 {
                gradient[v as usize] += force * w;
            }
        }
        gradient
    }

    /// Stiffness with springs or gauge.
    pub fn stiffness(
        &self,
        x: &[Vec3],
        plastic: &[PlasticState],
        curvature: Curvature,
    ) -> BlockMatrix {
        let mut parts = self.elements.take(self.rest.len());
        let part = |t: usize| {
            self.rest[t].stiffness(&self.corners(x, t), &plastic[t], &self.material, curvature)
        };
        (0..self.rest.len()).into_par_iter().map(part).collect_into_vec(&mut parts);
        let mut k = self.pattern.assemble(|t, a, b, r, c| parts[t][(3 * a + r, 3 * b + c)]);
        self.elements.give(parts);
        for spring in &self.springs {
            self.add_spring(&mut k, spring);
        }
        if let Some(gauge) = self.gauge {
            let stiffness = self.pattern.mean_diagonal(&k);
            for dof in gauge {
                let (v, axis) = ((dof / 3) as u32, dof % 3);
                k.values[self.pattern.entry(v, v, axis, axis)] += stiffness;
            }
        }
        k
    }

    /// Cholesky factor of the true stiffness or, where that is indefinite, of the projected one.
    pub fn factor_stiffness(&self, x: &[Vec3], plastic: &[PlasticState]) -> Result<Factor> {
        if let Ok(factor) = self.symbolic.factor(&self.stiffness(x, plastic, Curvature::True)) {
            return Ok(factor);
        }
        let projected = self.stiffness(x, plastic, Curvature::Projected);
        self.symbolic.factor_shifted(&self.pattern, &projected, SHIFTS)
    }

    fn add_spring(&self, k: &mut BlockMatrix, spring: &Spring) {
        for &(i, wi) in &spring.point.0 {
            for &(j, wj) in spring.point.0.iter().filter(|&&(j, _)| j <= i) {
                for axis in 0..3 {
                    k.values[self.pattern.entry(i, j, axis, axis)] += spring.stiffness * wi * wj;
                }
            }
        }
    }

    /// Volume of the body at rest.
    pub fn rest_volume(&self) -> f64 {
        self.rest.iter().map(|e| e.volume).sum()
    }
}
