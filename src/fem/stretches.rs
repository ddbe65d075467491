//! How far the tets of a body are stretched.

use crate::locate::Embedding;
use crate::math::{Mat3, Vec3};
use crate::mesh::TetMesh;

/// Principal stretches of a deformation, largest first.
pub fn principal_stretches(deformation: &Mat3) -> Vec3 {
    let values = deformation.singular_values();
    let mut sorted = [values[0], values[1], values[2]];
    sorted.sort_by(|a, b| b.total_cmp(a));
    sorted.into()
}

/// Deformation gradient of every tet from its rest shape to its present one.
pub fn deformation_gradients(rest: &TetMesh, now: &[Vec3]) -> Vec<Mat3> {
    let edges = |[a, b, c, d]: [Vec3; 4]| Mat3::from_columns(&[b - a, c - a, d - a]);
    rest.tets
        .iter()
        .enumerate()
        .map(|(t, tet)| {
            let from = edges(rest.corners(t)).try_inverse().unwrap_or_else(Mat3::zeros);
            edges(tet.map(|v| now[v as usize])) * from
        })
        .collect()
}

/// Largest and smallest principal stretch at each surface vertex, interpolated between the nodes of
/// the tet mesh, each of which has the volume-weighted mean of its tets' gradients.
pub fn stretches_of(
    gradients: &[Mat3],
    rest: &TetMesh,
    embedding: &Embedding,
) -> (Vec<f64>, Vec<f64>) {
    let mut at_nodes = vec![(Vec3::zeros(), 0.0); rest.points.len()];
    for (t, tet) in rest.tets.iter().enumerate() {
        let (stretches, volume) = (principal_stretches(&gradients[t]), rest.volume(t));
        for &v in tet {
            let (sum, weight) = &mut at_nodes[v as usize];
            *sum += stretches * volume;
            *weight += volume;
        }
    }
    let nodes: Vec<Vec3> = at_nodes.iter().map(|(sum, w)| sum / w.max(f64::MIN_POSITIVE)).collect();
    let at_vertices = embedding.apply(&nodes);
    (at_vertices.iter().map(|s| s[0]).collect(), at_vertices.iter().map(|s| s[2]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tet() -> TetMesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TetMesh::new(points.map(Vec3::from).to_vec(), vec![[0, 1, 2, 3]]).unwrap()
    }

    #[test]
    fn a_stretched_and_turned_tet_has_its_stretches() {
        let map = Mat3::new(0.0, -0.5, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 2.0);
        let now: Vec<Vec3> = tet().points.iter().map(|p| map * p).collect();
        let gradient = deformation_gradients(&tet(), &now)[0];
        assert!((gradient - map).norm() < 1e-14);
        let stretches = principal_stretches(&gradient);
        assert!((stretches - Vec3::new(3.0, 2.0, 0.5)).norm() < 1e-14);
        let embedding = Embedding::new(&tet(), &[Vec3::new(0.2, 0.2, 0.2)]).unwrap();
        let (largest, smallest) = stretches_of(&[gradient], &tet(), &embedding);
        assert!((largest[0] - 3.0).abs() < 1e-14 && (smallest[0] - 0.5).abs() < 1e-14);
    }
}
