//! Tets that were not made here.

use super::{Tetrahedralization, Used};
use crate::error::{Error, Result};
use crate::locate::{Embedding, WindingNumber};
use crate::math::Vec3;
use crate::mesh::{TetMesh, TriMesh};

/// A surface vertex farther than this share of the diagonal outside a given tet mesh shows that
/// the mesh belongs to another surface.
const OUTSIDE: f64 = 0.1;

/// Takes tets that somebody else made, whose name serves reports; tets of another surface are an error.
/// A tet counts as inside or outside as a whole, by its centre.
pub fn given_tets(mesh: TetMesh, surface: &TriMesh, made_by: String) -> Result<Tetrahedralization> {
    let embedding = Embedding::new(&mesh, &surface.points)?;
    let limit = -OUTSIDE * surface.diagonal() / mean_edge(&mesh);
    let lowest = |v: usize| embedding.weights[v].iter().copied().fold(f64::INFINITY, f64::min);
    if let Some(v) = (0..surface.points.len()).find(|&v| lowest(v) < limit) {
        return Err(Error::invalid(format!(
            "vertex {v} of the template lies far outside the tets; they belong to another surface, or to another unit"
        )));
    }
    let winding = WindingNumber::new(&surface.points, &surface.triangles);
    let centres: Vec<_> =
        (0..mesh.tets.len()).map(|t| mesh.corners(t).iter().sum::<Vec3>() / 4.0).collect();
    let inside_fraction =
        centres.iter().map(|c| if winding.at(c).abs() > 0.5 { 1.0 } else { 0.0 }).collect();
    Ok(Tetrahedralization {
        mesh,
        embedding,
        inside_fraction,
        boundary_kept: false,
        used: Used::Given(made_by),
        warnings: Vec::new(),
    })
}

fn mean_edge(mesh: &TetMesh) -> f64 {
    let volume = mesh.total_volume() / mesh.tets.len().max(1) as f64;
    // A regular tet of edge a has the volume a^3 / (6 sqrt 2).
    libm::cbrt(volume * 72_f64.sqrt()).max(f64::MIN_POSITIVE)
}
