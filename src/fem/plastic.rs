//! The plastic strain Fp of each tet from a field of six numbers.
//!
//! Default: the logarithm S of Fp at the vertices, averaged to the tets, Fp = exp(S): always
//! positive definite, five times fewer unknowns, twice as accurate. The published form has the six
//! numbers of the symmetric Fp itself, one set per tet ([W] Section 3.1).

use rayon::prelude::*;

use crate::math::symmetric3::{exp, exp_with_derivatives, from_matrix, to_matrix, unit};
use crate::math::{Mat3, Sym3};

/// Where the field lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// Six numbers per vertex, averaged to the tets.
    Vertices,
    /// Six numbers per tet ([W]).
    Tets,
}

/// What the six numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// Fp = exp(S).
    Logarithm,
    /// Fp itself ([W]).
    Matrix,
}

/// How six numbers per carrier become a plastic strain per tet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrainSpace {
    /// Where the field lives.
    pub carrier: Carrier,
    /// What the six numbers mean.
    pub chart: Chart,
}

/// Fp of one tet, as the elements need it.
#[derive(Clone, Copy, Debug)]
pub struct PlasticState {
    /// A = Fp^-1.
    pub inverse: Mat3,
    /// det Fp.
    pub determinant: f64,
    /// Y_p = dFp/ds_p.
    pub derivatives: [Mat3; 6],
}

impl PlasticState {
    /// Fp = exp(S).
    pub fn from_logarithm(s: &Sym3) -> Self {
        let (fp, derivatives) = exp_with_derivatives(s);
        Self::from_parts(fp, derivatives)
    }

    /// Fp = the matrix of the six numbers.
    pub fn from_matrix(s: &Sym3) -> Self {
        Self::from_parts(to_matrix(s), std::array::from_fn(unit))
    }

    fn from_parts(fp: Mat3, derivatives: [Mat3; 6]) -> Self {
        let inverse = fp.try_inverse().unwrap_or_else(|| Mat3::identity() * f64::NAN);
        Self { inverse, determinant: fp.determinant(), derivatives }
    }
}

impl StrainSpace {
    /// Logarithm at the vertices.
    pub const NODAL_LOGARITHM: Self = Self { carrier: Carrier::Vertices, chart: Chart::Logarithm };
    /// Fp per tet, as published.
    pub const PAPER: Self = Self { carrier: Carrier::Tets, chart: Chart::Matrix };

    /// The six numbers of Fp = exp(S).
    pub fn from_logarithm(&self, s: &Sym3) -> Sym3 {
        match self.chart {
            Chart::Logarithm => *s,
            Chart::Matrix => from_matrix(&exp(s)),
        }
    }

    /// Number of carriers of a mesh.
    pub fn carriers(&self, vertices: usize, tets: usize) -> usize {
        match self.carrier {
            Carrier::Vertices => vertices,
            Carrier::Tets => tets,
        }
    }

    /// The six numbers of tet `t`.
    pub fn at_tet(&self, field: &[Sym3], t: usize, tet: &[u32; 4]) -> Sym3 {
        match self.carrier {
            Carrier::Vertices => tet.iter().map(|&v| field[v as usize]).sum::<Sym3>() / 4.0,
            Carrier::Tets => field[t],
        }
    }

    /// Fp of every tet.
    pub fn states(&self, field: &[Sym3], tets: &[[u32; 4]]) -> Vec<PlasticState> {
        tets.par_iter()
            .enumerate()
            .map(|(t, tet)| {
                let s = self.at_tet(field, t, tet);
                match self.chart {
                    Chart::Logarithm => PlasticState::from_logarithm(&s),
                    Chart::Matrix => PlasticState::from_matrix(&s),
                }
            })
            .collect()
    }

    /// Fp of tet `t` as a matrix.
    pub fn plastic_strain(&self, field: &[Sym3], t: usize, tet: &[u32; 4]) -> Mat3 {
        let s = self.at_tet(field, t, tet);
        match self.chart {
            Chart::Logarithm => exp(&s),
            Chart::Matrix => to_matrix(&s),
        }
    }
}
