//! The tet mesh renumbered in elimination order, so that solves need no permutation.

use crate::locate::Embedding;
use crate::mesh::TetMesh;
use crate::mesh::adjacency::vertex_neighbours;
use crate::solve::nested_dissection;

/// The order of a tet mesh's vertices in the solver and in the problem.
pub struct Numbering {
    problem_from_solver: Vec<usize>,
    solver_from_problem: Vec<u32>,
}

impl Numbering {
    /// The elimination order of a mesh.
    pub fn new(mesh: &TetMesh) -> Self {
        let neighbours = vertex_neighbours(mesh.points.len(), &mesh.tets);
        let problem_from_solver = nested_dissection(&mesh.points, |v| neighbours.of(v));
        let mut solver_from_problem = vec![0; problem_from_solver.len()];
        for (new, &old) in problem_from_solver.iter().enumerate() {
            solver_from_problem[old] = new as u32;
        }
        Self { problem_from_solver, solver_from_problem }
    }

    /// The mesh in the solver's order.
    pub fn renumbered(&self, mesh: &TetMesh) -> TetMesh {
        TetMesh {
            points: self.problem_from_solver.iter().map(|&v| mesh.points[v]).collect(),
            tets: mesh.tets.iter().map(|tet| self.corners(tet)).collect(),
        }
    }

    /// An embedding in the renumbered mesh.
    pub fn renumbered_embedding(&self, embedding: &Embedding) -> Embedding {
        Embedding {
            tets: embedding.tets.clone(),
            vertices: embedding.vertices.iter().map(|tet| self.corners(tet)).collect(),
            weights: embedding.weights.clone(),
        }
    }

    /// Values per vertex in the problem's order.
    pub fn restore<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.solver_from_problem.iter().map(|&v| values[v as usize].clone()).collect()
    }

    fn corners(&self, tet: &[u32; 4]) -> [u32; 4] {
        tet.map(|v| self.solver_from_problem[v as usize])
    }
}
