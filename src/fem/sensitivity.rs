//! G = d(gradient)/ds as a sparse matrix of blocks: how the plastic strain moves the forces.
//!
//! K J = -G ([W] Eq. 8): with G and a factor of K, the Jacobian J = dx/ds is never formed.

use rayon::prelude::*;

use super::body::Body;
use super::element::StrainSensitivity;
use super::plastic::{Carrier, PlasticState, StrainSpace};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::Real;

/// Columns that are computed together.
const LANES: usize = 16;

/// G transposed: a row of 6 per carrier, 6 x 3 blocks, one per coupled vertex.
pub struct Sensitivity<T = f64> {
    row_ptr: Vec<usize>,
    vertex: Vec<u32>,
    /// Row-major 6 x 3.
    blocks: Vec<[T; 18]>,
    vertices: usize,
}

impl Sensitivity {
    /// At the shape `x` with the plastic strain `plastic`.
    pub fn new<M: IsotropicDensity>(
        body: &Body<M>,
        space: &StrainSpace,
        x: &[Vec3],
        plastic: &[PlasticState],
    ) -> Self {
        let parts: Vec<StrainSensitivity> = (0..body.rest.len())
            .into_par_iter()
            .map(|t| {
                body.rest[t].strain_sensitivity(&body.corners(x, t), &plastic[t], &body.material)
            })
            .collect();
        let rows: Vec<Vec<(u32, [f64; 18])>> = match space.carrier {
            Carrier::Tets => parts
                .par_iter()
                .enumerate()
                .map(|(t, g)| {
                    (0..4).map(|a| (body.mesh.tets[t][a], transposed_block(g, a, 1.0))).collect()
                })
                .collect(),
            Carrier::Vertices => {
                body.incident().par_iter().map(|tets| gather(body, &parts, tets)).collect()
            }
        };
        let mut row_ptr = vec![0];
        for row in &rows {
            row_ptr.push(row_ptr.last().copied().unwrap_or(0) + row.len());
        }
        let (vertex, blocks) = rows.into_iter().flatten().unzip();
        Self { row_ptr, vertex, blocks, vertices: x.len() }
    }

    /// Number of carriers.
    pub fn carriers(&self) -> usize {
        self.row_ptr.len() - 1
    }

    /// Number of 6 x 3 blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// A copy with rounded values.
    pub fn rounded<T: Real>(&self) -> Sensitivity<T> {
        Sensitivity {
            row_ptr: self.row_ptr.clone(),
            vertex: self.vertex.clone(),
            blocks: self.blocks.iter().map(|block| block.map(T::from_f64)).collect(),
            vertices: self.vertices,
        }
    }

    /// G ds: the change of the gradient for a change of the strain.
    pub fn multiply(&self, ds: &[Sym3]) -> Vec<Vec3> {
        let mut out = vec![Vec3::zeros(); self.vertices];
        for (carrier, ds) in ds.iter().enumerate() {
            for k in self.row_ptr[carrier]..self.row_ptr[carrier + 1] {
                let block = nalgebra::Matrix3x6::from_column_slice(&self.blocks[k]);
                out[self.vertex[k] as usize] += block * ds;
            }
        }
        out
    }
}

impl<T: Real> Sensitivity<T> {
    /// z = G^T Y for a row-major Y of 3 rows per vertex and `width` columns; 6 rows per carrier.
    pub fn transpose_multiply(&self, y: &[T], width: usize, z: &mut [T]) {
        // The instruction set of the machine, not of the build: four to sixteen columns at a time.
        pulp::Arch::new().dispatch(|| {
            for (carrier, rows) in z.chunks_exact_mut(6 * width).enumerate() {
                for first in (0..width).step_by(LANES) {
                    if first + LANES <= width {
                        self.multiply_lanes::<LANES>(carrier, y, width, first, rows);
                    } else {
                        for column in first..width {
                            self.multiply_lanes::<1>(carrier, y, width, column, rows);
                        }
                    }
                }
            }
        });
    }

    /// G Z for a row-major Z of 6 rows per carrier and `width` columns; 3 rows per vertex.
    pub fn multiply_rows(&self, z: &[T], width: usize) -> Vec<T> {
        let mut out = vec![T::from_f64(0.0); 3 * self.vertices * width];
        for (carrier, z) in z.chunks_exact(6 * width).enumerate() {
            for k in self.row_ptr[carrier]..self.row_ptr[carrier + 1] {
                let y = &mut out[3 * self.vertex[k] as usize * width..][..3 * width];
                for (z, g) in z.chunks_exact(width).zip(self.blocks[k].chunks_exact(3)) {
                    for (y, &g) in y.chunks_exact_mut(width).zip(g) {
                        y.iter_mut().zip(z).for_each(|(y, &z)| *y += g * z);
                    }
                }
            }
        }
        out
    }

    /// Columns first .. first + N of one carrier's six rows.
    // Only inlined code is compiled for the machine's instruction set.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    fn multiply_lanes<const N: usize>(
        &self,
        carrier: usize,
        y: &[T],
        width: usize,
        first: usize,
        rows: &mut [T],
    ) {
        let mut sums = [[T::from_f64(0.0); N]; 6];
        for k in self.row_ptr[carrier]..self.row_ptr[carrier + 1] {
            let start = 3 * self.vertex[k] as usize * width + first;
            let part: [&[T; N]; 3] = std::array::from_fn(|axis| {
                y[start + axis * width..].first_chunk().expect("Y has three rows per vertex")
            });
            for (sum, g) in sums.iter_mut().zip(self.blocks[k].chunks_exact(3)) {
                for c in 0..N {
                    sum[c] += g[0] * part[0][c] + g[1] * part[1][c] + g[2] * part[2][c];
                }
            }
        }
        for (p, sum) in sums.iter().enumerate() {
            rows[p * width + first..][..N].copy_from_slice(sum);
        }
    }
}

/// The part of corner `a`, transposed to row-major 6 x 3, times `scale`.
fn transposed_block(g: &StrainSensitivity, a: usize, scale: f64) -> [f64; 18] {
    std::array::from_fn(|k| g[(3 * a + k % 3, k / 3)] * scale)
}

/// The row of one vertex: a quarter of each tet around it (the tet's strain is the mean of four).
fn gather<M: IsotropicDensity>(
    body: &Body<M>,
    parts: &[StrainSensitivity],
    tets: &[(u32, u8)],
) -> Vec<(u32, [f64; 18])> {
    let mut row: Vec<(u32, [f64; 18])> = Vec::with_capacity(16);
    for &(t, _) in tets {
        for a in 0..4 {
            let block = transposed_block(&parts[t as usize], a, 0.25);
            let vertex = body.mesh.tets[t as usize][a];
            match row.iter_mut().find(|(v, _)| *v == vertex) {
                Some((_, sum)) => sum.iter_mut().zip(block).for_each(|(s, b)| *s += b),
                None => row.push((vertex, block)),
            }
        }
    }
    row.sort_unstable_by_key(|(v, _)| *v);
    row
}
