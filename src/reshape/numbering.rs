//! The tet mesh renumbered: vertices in elimination order, so that solves need no permutation, tets by
//! their vertices, so that what stands together in the mesh stands together in memory.

use crate::locate::Embedding;
use crate::mesh::TetMesh;
use crate::mesh::adjacency::vertex_neighbours;
use crate::solve::nested_dissection;

/// The order of a tet mesh's vertices and tets in the solver and in the problem.
pub struct Numbering {
    problem_from_solver: Vec<usize>,
    solver_from_problem: Vec<u32>,
    problem_tet_from_solver: Vec<u32>,
    solver_tet_from_problem: Vec<u32>,
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
        let mut problem_tet_from_solver: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        problem_tet_from_solver.sort_by_key(|&t| {
            let mut corners = mesh.tets[t as usize].map(|v| solver_from_problem[v as usize]);
            corners.sort_unstable();
            corners
        });
        let mut solver_tet_from_problem = vec![0; mesh.tets.len()];
        for (new, &old) in problem_tet_from_solver.iter().enumerate() {
            solver_tet_from_problem[old as usize] = new as u32;
        }
        Self {
            problem_from_solver,
            solver_from_problem,
            problem_tet_from_solver,
            solver_tet_from_problem,
        }
    }

    /// The mesh in the solver's order.
    pub fn renumbered(&self, mesh: &TetMesh) -> TetMesh {
        TetMesh {
            points: self.problem_from_solver.iter().map(|&v| mesh.points[v]).collect(),
            tets: self.tets(&mesh.tets).iter().map(|tet| self.corners(tet)).collect(),
        }
    }

    /// An embedding in the renumbered mesh.
    pub fn renumbered_embedding(&self, embedding: &Embedding) -> Embedding {
        Embedding {
            tets: embedding
                .tets
                .iter()
                .map(|&t| self.solver_tet_from_problem[t as usize])
                .collect(),
            vertices: embedding.vertices.iter().map(|tet| self.corners(tet)).collect(),
            weights: embedding.weights.clone(),
        }
    }

    /// Values per vertex in the problem's order.
    pub fn restore<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.solver_from_problem.iter().map(|&v| values[v as usize].clone()).collect()
    }

    /// Values per tet in the solver's order.
    pub fn tets<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.problem_tet_from_solver.iter().map(|&t| values[t as usize].clone()).collect()
    }

    /// Values per tet in the problem's order.
    pub fn restore_tets<T: Clone>(&self, values: &[T]) -> Vec<T> {
        self.solver_tet_from_problem.iter().map(|&t| values[t as usize].clone()).collect()
    }

    fn corners(&self, tet: &[u32; 4]) -> [u32; 4] {
        tet.map(|v| self.solver_from_problem[v as usize])
    }
}
