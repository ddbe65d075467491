//! The smoothness of the plastic strain: R = weight * B M^-1 B per component of the strain.
//!
//! Default: B = L + kappa M with the P1 stiffness L and lumped mass M on the vertices, a consistent
//! bi-Laplacian whose weight does not depend on the mesh. kappa = 1/length^2 screens: far from
//! data the strain returns to its mean within that length, and the mean has a price of its own
//! ([`StrainMean`]). kappa = 0 leaves constants free.
//!
//! Published form: B = graph Laplacian of the tets, M = I ([W] Eqs. 4, 29), not consistent under
//! refinement (docs/papers.md).

use super::body::Body;
use super::plastic::{Carrier, StrainSpace};
use super::strain_mean::StrainMean;
use crate::error::Result;
use crate::material::IsotropicDensity;
use crate::math::Sym3;
use crate::math::symmetric3::MULTIPLICITY;
use crate::solve::{BlockMatrix, BlockPattern, Factor, Real, RoundedFactor, SymbolicFactor};

/// How a strain returns to its mean.
#[derive(Clone, Copy, Debug)]
pub struct Screening {
    /// Within this distance, in the mesh's unit.
    pub length: f64,
    /// Prior standard deviation of the mean; 0: it is zero.
    pub mean_sigma: f64,
}

/// The quadratic form 1/2 u^T R u and its inverse.
pub struct StrainSmoothness {
    pattern: BlockPattern,
    operator: BlockMatrix,
    factor: Factor,
    mass: Vec<f64>,
    weight: f64,
    /// `None`: constants are free.
    mean: Option<StrainMean>,
}

impl StrainSmoothness {
    /// For a field of `space` on the body.
    ///
    /// `weight`: dimensionless, multiplied by the body's length scale so that the form has no unit.
    /// `screening`: `None` leaves constant strains free.
    /// `tet_weight`: factor on each tet's volume (share of the tet inside the surface).
    pub fn new<M: IsotropicDensity>(
        body: &Body<M>,
        space: &StrainSpace,
        weight: f64,
        screening: Option<Screening>,
        tet_weight: &[f64],
    ) -> Result<Self> {
        let kappa = screening.map_or(0.0, |screening| screening.length.powi(-2));
        let (pattern, mut operator, mass) = match space.carrier {
            Carrier::Vertices => vertex_operator(body, tet_weight),
            Carrier::Tets => graph_operator(body),
        };
        for (v, m) in mass.iter().enumerate() {
            operator.values[pattern.col_ptr[v]] += kappa * m;
        }
        let mut grounded = operator.clone();
        if kappa == 0.0 {
            // One pinned vertex makes L definite; exact for right-hand sides of mean zero.
            grounded.values[0] *= 2.0;
        }
        let factor = SymbolicFactor::new(&pattern)?.factor(&grounded)?;
        let mean = screening.map(|screening| {
            let force = mass.iter().map(|m| weight * kappa * kappa * m).collect();
            StrainMean::new(screening.mean_sigma, force)
        });
        Ok(Self { pattern, operator, factor, mass, weight, mean })
    }

    /// Whether constant strains cost nothing.
    pub fn is_singular(&self) -> bool {
        self.mean.is_none()
    }

    /// The mean, where it has a price.
    pub fn mean(&self) -> Option<&StrainMean> {
        self.mean.as_ref()
    }

    /// Number of entries of the operator's factor.
    pub fn factor_fill(&self) -> usize {
        self.factor.fill()
    }

    /// 1/2 u^T R u.
    pub fn energy(&self, u: &[Sym3]) -> f64 {
        let mut sum = 0.0;
        for p in 0..6 {
            let b = self.component(u, p);
            sum += MULTIPLICITY[p] * b.iter().zip(&self.mass).map(|(b, m)| b * b / m).sum::<f64>();
        }
        0.5 * self.weight * sum - self.mean.as_ref().map_or(0.0, |mean| mean.energy(u))
    }

    /// R u.
    pub fn apply(&self, u: &[Sym3]) -> Vec<Sym3> {
        let mut out = vec![Sym3::zeros(); u.len()];
        for p in 0..6 {
            let mut b = self.component(u, p);
            b.iter_mut().zip(&self.mass).for_each(|(b, m)| *b /= m);
            let column = self.pattern.multiply(&self.operator, &b);
            for (out, value) in out.iter_mut().zip(column) {
                out[p] = self.weight * MULTIPLICITY[p] * value;
            }
        }
        if let Some(mean) = &self.mean {
            mean.take_from(&mut out, u);
        }
        out
    }

    /// R^+ b; for a singular form b must have mean zero in each component.
    pub fn solve(&self, b: &[Sym3]) -> Vec<Sym3> {
        // The six components side by side: one solve for all.
        let mut flat: Vec<f64> = b.iter().flat_map(|s| s.iter().copied()).collect();
        self.between_constants(&mut flat, 6, |b| self.factor.solve_rows(b, 6));
        for (row, mass) in flat.chunks_exact_mut(6).zip(&self.mass) {
            for value in row {
                *value *= mass;
            }
        }
        // The transpose of the first half, for a sum of zero: the two differ in the constant that they
        // take out, and only together give the form that [`HalfInverse`] factors.
        self.factor.solve_rows(&mut flat, 6);
        if self.is_singular() {
            Self::take_out(&mut flat, 6, |_| 1.0, |_| 1.0);
        }
        let mean = self.mean.as_ref().map_or_else(Sym3::zeros, |mean| mean.answer(b));
        let scaled =
            |row: &[f64]| Sym3::from_fn(|p, _| row[p] / (self.weight * MULTIPLICITY[p]) + mean[p]);
        flat.chunks_exact(6).map(scaled).collect()
    }

    /// The half of R^+ without the mean's part, in the precision T.
    pub fn half_inverse<T: Real>(&self) -> HalfInverse<'_, T> {
        HalfInverse { smoothness: self, factor: self.factor.rounded() }
    }

    /// B^+ b in place, `solve` being the grounded system: for a singular B, the mean is taken out before
    /// and the constant that the mass sees afterwards.
    fn between_constants<T: Real>(&self, b: &mut [T], width: usize, solve: impl Fn(&mut [T])) {
        if self.is_singular() {
            Self::take_out(b, width, |_| 1.0, |_| 1.0);
        }
        solve(b);
        if self.is_singular() {
            Self::take_out(b, width, |_| 1.0, |v| self.mass[v]);
        }
    }

    /// Subtracts from each column the multiple of `field` that makes its sum, weighted by `weight`, zero.
    /// With the two exchanged: the transpose.
    fn take_out<T: Real>(
        b: &mut [T],
        width: usize,
        field: impl Fn(usize) -> f64,
        weight: impl Fn(usize) -> f64,
    ) {
        let total: f64 = (0..b.len() / width).map(|v| weight(v) * field(v)).sum();
        let mut shares = vec![0.0; width];
        for (v, row) in b.chunks_exact(width).enumerate() {
            shares.iter_mut().zip(row).for_each(|(s, value)| *s += weight(v) * value.to_f64());
        }
        for share in &mut shares {
            *share /= total;
        }
        for (v, row) in b.chunks_exact_mut(width).enumerate() {
            let field = field(v);
            for (value, share) in row.iter_mut().zip(&shares) {
                *value -= T::from_f64(share * field);
            }
        }
    }

    /// B times component p of the field.
    fn component(&self, u: &[Sym3], p: usize) -> Vec<f64> {
        let column: Vec<f64> = u.iter().map(|s| s[p]).collect();
        self.pattern.multiply(&self.operator, &column)
    }
}

/// M^1/2 B^+, a factor of R^+ without the mean's part.
pub struct HalfInverse<'a, T: Real> {
    smoothness: &'a StrainSmoothness,
    factor: RoundedFactor<T>,
}

impl<T: Real> HalfInverse<'_, T> {
    /// H with H^T H = Z R^+ Z^T but for the mean's part, for a row-major Z^T with 6 rows per carrier and
    /// `width` columns, in place: H = (weight multiplicity)^-1/2 M^1/2 B^+ Z^T.
    pub fn apply(&self, z: &mut [T], width: usize) {
        let Self { smoothness, factor } = self;
        smoothness.between_constants(z, 6 * width, |z| factor.solve_rows(z, 6 * width));
        self.scale(z, width);
    }

    /// (weight multiplicity)^-1/2 B^+ M^1/2 z, in place: of independent numbers of variance 1, a strain of
    /// covariance R^+ but for the mean's part.
    pub fn transpose_apply(&self, z: &mut [T], width: usize) {
        let Self { smoothness, factor } = self;
        self.scale(z, width);
        if smoothness.is_singular() {
            StrainSmoothness::take_out(z, 6 * width, |v| smoothness.mass[v], |_| 1.0);
        }
        factor.solve_rows(z, 6 * width);
        if smoothness.is_singular() {
            StrainSmoothness::take_out(z, 6 * width, |_| 1.0, |_| 1.0);
        }
    }

    /// (weight multiplicity)^-1/2 M^1/2 z, in place.
    fn scale(&self, z: &mut [T], width: usize) {
        let smoothness = self.smoothness;
        for (rows, mass) in z.chunks_exact_mut(6 * width).zip(&smoothness.mass) {
            for (row, multiplicity) in rows.chunks_exact_mut(width).zip(MULTIPLICITY) {
                let scale = (mass / (smoothness.weight * multiplicity)).sqrt();
                let scale = T::from_f64(scale);
                for value in row {
                    *value *= scale;
                }
            }
        }
    }
}

/// P1 stiffness and lumped mass on the vertices.
fn vertex_operator<M: IsotropicDensity>(
    body: &Body<M>,
    tet_weight: &[f64],
) -> (BlockPattern, BlockMatrix, Vec<f64>) {
    let pattern = BlockPattern::of_tets(body.mesh.points.len(), &body.mesh.tets, 1);
    let operator = pattern.assemble(|t, a, b, _, _| {
        let element = &body.rest[t];
        tet_weight[t] * element.volume * element.gradients[a].dot(&element.gradients[b])
    });
    let mass = body
        .incident()
        .iter()
        .map(|tets| {
            tets.iter()
                .map(|&(t, _)| 0.25 * tet_weight[t as usize] * body.rest[t as usize].volume)
                .sum()
        })
        .collect();
    (pattern, operator, mass)
}

/// Graph Laplacian of the tets that share faces, with unit masses. [W] Eq. 4
fn graph_operator<M: IsotropicDensity>(body: &Body<M>) -> (BlockPattern, BlockMatrix, Vec<f64>) {
    let links = body.mesh.face_neighbours();
    let centers: Vec<_> = body
        .mesh
        .tets
        .iter()
        .map(|tet| {
            tet.iter().map(|&v| body.mesh.points[v as usize]).sum::<crate::math::Vec3>() / 4.0
        })
        .collect();
    let pattern = BlockPattern::of_links(&centers, &links, 1);
    let mut operator = BlockMatrix { values: vec![0.0; pattern.row_idx.len()] };
    for &(a, b) in &links {
        operator.values[pattern.entry(a.max(b), a.min(b), 0, 0)] = -1.0;
        for v in [a, b] {
            operator.values[pattern.entry(v, v, 0, 0)] += 1.0;
        }
    }
    (pattern, operator, vec![1.0; centers.len()])
}
