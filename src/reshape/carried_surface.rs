//! The template's surface as the tets carry it.

use crate::fem::MaterialPoint;
use crate::locate::{ClosestPoints, Embedding};

/// The surface's triangles and where its vertices lie in the tets.
pub struct CarriedSurface {
    /// Each vertex in the tets.
    pub embedding: Embedding,
    /// The triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Search for points on it; to be refitted to the shape in question.
    pub search: ClosestPoints,
}

impl CarriedSurface {
    /// The body's point that a vertex is.
    pub fn vertex(&self, vertex: u32) -> MaterialPoint {
        embedded(&self.embedding, vertex as usize)
    }

    /// The body's point that a point of a triangle is.
    pub fn point(&self, triangle: u32, barycentric: &[f64; 3]) -> MaterialPoint {
        let mut entries: Vec<(u32, f64)> = Vec::with_capacity(12);
        for (&v, b) in self.triangles[triangle as usize].iter().zip(barycentric) {
            for (&w, weight) in
                self.embedding.vertices[v as usize].iter().zip(self.embedding.weights[v as usize])
            {
                match entries.iter_mut().find(|(vertex, _)| *vertex == w) {
                    Some((_, sum)) => *sum += b * weight,
                    None => entries.push((w, b * weight)),
                }
            }
        }
        entries.retain(|(_, w)| *w != 0.0);
        MaterialPoint(entries)
    }
}

/// The body's point that is the `i`-th of an embedding.
pub fn embedded(embedding: &Embedding, i: usize) -> MaterialPoint {
    let entries = embedding.vertices[i].into_iter().zip(embedding.weights[i]);
    MaterialPoint(entries.filter(|(_, w)| *w != 0.0).collect())
}
