//! One linear tet with plastic strain: energy, gradient, stiffness, sensitivity to the strain.
//!
//! The same code as ordinary FEM with the plastic rest shape Fp Dm: F = sum_a x_a (x) g_a,
//! A = Fp^-1, h_a = A g_a, Fe = F A, V = V0 det Fp. [W] Section 3.2 and Eqs. 33-38.
//!
//! - `energy`             - E = V psi(Fe)
//! - `gradient`           - dE/dx_a = V P h_a
//! - `stiffness`          - d2E/dx_a dx_b
//! - `strain_sensitivity` - d(dE/dx_a)/ds_p

use nalgebra::SMatrix;

use super::plastic::PlasticState;
use crate::material::{
    Density, IsotropicDensity, Mat9, cofactor, stiffness_spd, stress, stress_change,
};
use crate::math::{Mat3, Vec3};

/// 12 x 12: three rows per corner.
pub type Stiffness = SMatrix<f64, 12, 12>;
/// 12 x 6: three rows per corner, one column per number of the plastic strain.
pub type StrainSensitivity = SMatrix<f64, 12, 6>;

/// A tet at rest.
#[derive(Clone, Copy, Debug)]
pub struct RestElement {
    /// Gradients g_a of the four shape functions.
    pub gradients: [Vec3; 4],
    /// Volume V0.
    pub volume: f64,
}

/// Which stiffness to assemble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// The true second derivative.
    True,
    /// Its nearest positive semidefinite neighbour, element by element.
    Projected,
}

impl RestElement {
    /// From the rest positions of the corners; the volume must be positive.
    pub fn new(corners: [Vec3; 4]) -> Self {
        let [o, a, b, c] = corners;
        let edges = Mat3::from_columns(&[a - o, b - o, c - o]);
        let inverse = edges.try_inverse().expect("rest tets have a volume");
        let rows = [0, 1, 2].map(|r| inverse.row(r).transpose());
        Self {
            gradients: [-(rows[0] + rows[1] + rows[2]), rows[0], rows[1], rows[2]],
            volume: edges.determinant() / 6.0,
        }
    }

    /// F = sum_a x_a (x) g_a.
    pub fn deformation_gradient(&self, x: &[Vec3; 4]) -> Mat3 {
        (0..4).map(|a| x[a] * self.gradients[a].transpose()).sum()
    }

    /// E = V psi(Fe).
    pub fn energy(
        &self,
        x: &[Vec3; 4],
        plastic: &PlasticState,
        material: &impl IsotropicDensity,
    ) -> f64 {
        let fe = self.deformation_gradient(x) * plastic.inverse;
        self.volume * plastic.determinant * material.at(&fe).value
    }

    /// dE/dx_a = V P h_a.
    pub fn gradient(
        &self,
        x: &[Vec3; 4],
        plastic: &PlasticState,
        material: &impl IsotropicDensity,
    ) -> [Vec3; 4] {
        let fe = self.deformation_gradient(x) * plastic.inverse;
        let p = stress(&material.at(&fe), &fe) * (self.volume * plastic.determinant);
        self.plastic_gradients(plastic).map(|h| p * h)
    }

    /// K_ab = d2E/dx_a dx_b, all sixteen blocks.
    pub fn stiffness(
        &self,
        x: &[Vec3; 4],
        plastic: &PlasticState,
        material: &impl IsotropicDensity,
        curvature: Curvature,
    ) -> Stiffness {
        let fe = self.deformation_gradient(x) * plastic.inverse;
        let density = material.at(&fe);
        let volume = self.volume * plastic.determinant;
        let h = self.plastic_gradients(plastic);
        match curvature {
            Curvature::True => true_stiffness(&density, &fe, &h, volume),
            Curvature::Projected => contracted(&(stiffness_spd(&density, &fe) * volume), &h),
        }
    }

    /// d(dE/dx_a)/ds_p = V [ tr(A Y_p) P h_a + (D : dFe_p) h_a + P dh_a,p ],
    /// dFe_p = -Fe Y_p A, dh_a,p = -A Y_p h_a, Y_p = dFp/ds_p.  [W] Eqs. 36-38
    pub fn strain_sensitivity(
        &self,
        x: &[Vec3; 4],
        plastic: &PlasticState,
        material: &impl IsotropicDensity,
    ) -> StrainSensitivity {
        let fe = self.deformation_gradient(x) * plastic.inverse;
        let density = material.at(&fe);
        let p = stress(&density, &fe);
        let h = self.plastic_gradients(plastic);
        let mut g = StrainSensitivity::zeros();
        for (q, y) in plastic.derivatives.iter().enumerate() {
            let y_a = y * plastic.inverse;
            let dp = stress_change(&density, &fe, &(-fe * y_a)) + p * y_a.trace();
            let a_y = plastic.inverse * y;
            for a in 0..4 {
                let column = (dp * h[a] - p * (a_y * h[a])) * (self.volume * plastic.determinant);
                g.fixed_view_mut::<3, 1>(3 * a, q).copy_from(&column);
            }
        }
        g
    }

    /// h_a = A g_a: the shape functions' gradients on the plastic rest shape.
    fn plastic_gradients(&self, plastic: &PlasticState) -> [Vec3; 4] {
        self.gradients.map(|g| plastic.inverse * g)
    }
}

/// V d2 psi / dx_a dx_b without the 9 x 9 matrix: with f_a = Fe h_a and c_a = cof(Fe) h_a,
///
///   K_ab / V = 2 psi_I (h_a . h_b) 1 + 4 psi_II f_a f_b^T + psi_JJ c_a c_b^T
///            + 2 psi_IJ (f_a c_b^T + c_a f_b^T) - psi_J [Fe (h_a x h_b)]x.
fn true_stiffness(d: &Density, fe: &Mat3, h: &[Vec3; 4], volume: f64) -> Stiffness {
    let cof = cofactor(fe);
    let (f, c) = (h.map(|h| fe * h), h.map(|h| cof * h));
    let mut k = Stiffness::zeros();
    for a in 0..4 {
        for b in 0..=a {
            let twist = fe * h[a].cross(&h[b]) * d.d_j;
            let mut block = f[a] * (f[b] * (4.0 * d.d_ii) + c[b] * (2.0 * d.d_ij)).transpose()
                + c[a] * (c[b] * d.d_jj + f[b] * (2.0 * d.d_ij)).transpose()
                - twist.cross_matrix();
            let isotropic = 2.0 * d.d_i * h[a].dot(&h[b]);
            for axis in 0..3 {
                block[(axis, axis)] += isotropic;
            }
            block *= volume;
            k.fixed_view_mut::<3, 3>(3 * a, 3 * b).copy_from(&block);
            k.fixed_view_mut::<3, 3>(3 * b, 3 * a).copy_from(&block.transpose());
        }
    }
    k
}

/// K_ab[i,k] = sum_jl h_a[j] D[ij,kl] h_b[l].
fn contracted(d: &Mat9, h: &[Vec3; 4]) -> Stiffness {
    // b = dFe/dx: Fe[i,j] depends on x_a[i] through h_a[j].
    let d_b: [SMatrix<f64, 9, 3>; 4] = h.map(|h| contract_right(d, &h));
    let mut k = Stiffness::zeros();
    for a in 0..4 {
        for b in 0..4 {
            let block: Mat3 = (0..3).map(|j| d_b[b].fixed_view::<3, 3>(3 * j, 0) * h[a][j]).sum();
            k.fixed_view_mut::<3, 3>(3 * a, 3 * b).copy_from(&block);
        }
    }
    k
}

/// (D : (e_k (x) h)) for k = 0, 1, 2.
fn contract_right(d: &Mat9, h: &Vec3) -> SMatrix<f64, 9, 3> {
    d.fixed_columns::<3>(0) * h[0] + d.fixed_columns::<3>(3) * h[1] + d.fixed_columns::<3>(6) * h[2]
}

#[cfg(test)]
mod tests {
    use nalgebra::{SVector, Vector1};

    use super::*;
    use crate::material::StableNeoHookean;
    use crate::math::Sym3;
    use crate::math::derivative_check::order_of_convergence;

    const STEEL: (f64, f64) = (1.0, 0.45);

    fn case() -> (RestElement, [Vec3; 4], Sym3) {
        let rest = RestElement::new([
            Vec3::zeros(),
            Vec3::x() * 1.1,
            Vec3::new(0.2, 0.9, 0.1),
            Vec3::new(0.1, 0.3, 1.2),
        ]);
        let x = [
            Vec3::new(0.1, 0.0, 0.2),
            Vec3::new(1.3, 0.4, -0.1),
            Vec3::new(-0.2, 1.1, 0.3),
            Vec3::new(0.4, 0.1, 0.9),
        ];
        (rest, x, Sym3::new(0.3, -0.1, 0.2, -0.2, 0.15, 0.1))
    }

    fn moved(x: &[Vec3; 4], direction: &SVector<f64, 12>, h: f64) -> [Vec3; 4] {
        std::array::from_fn(|a| x[a] + direction.fixed_rows::<3>(3 * a) * h)
    }

    fn flat(g: [Vec3; 4]) -> SVector<f64, 12> {
        SVector::from_fn(|i, _| g[i / 3][i % 3])
    }

    #[test]
    fn gradient_and_stiffness_converge_at_second_order() {
        let (rest, x, s) = case();
        let material = StableNeoHookean::new(STEEL.0, STEEL.1);
        let plastic = PlasticState::from_logarithm(&s);
        let dx = SVector::<f64, 12>::from_fn(|i, _| libm::sin((3 * i + 1) as f64));
        let slope = flat(rest.gradient(&x, &plastic, &material)).dot(&dx);
        let energy = |h| rest.energy(&moved(&x, &dx, h), &plastic, &material);
        assert!(
            order_of_convergence(|h| Vector1::new((energy(h) - energy(-h)) / (2.0 * h) - slope))
                > 1.9
        );
        let k = rest.stiffness(&x, &plastic, &material, Curvature::True) * dx;
        let gradient = |h| flat(rest.gradient(&moved(&x, &dx, h), &plastic, &material));
        assert!(order_of_convergence(|h| (gradient(h) - gradient(-h)) / (2.0 * h) - k) > 1.9);
    }

    #[test]
    fn strain_sensitivity_converges_at_second_order_in_both_charts() {
        let (rest, x, s) = case();
        let material = StableNeoHookean::new(STEEL.0, STEEL.1);
        let ds = Sym3::new(0.2, 0.5, -0.4, 0.3, 0.1, -0.6);
        let linear = s + Sym3::new(1.0, 0.0, 0.0, 1.0, 0.0, 1.0);
        for (s, state) in [
            (s, PlasticState::from_logarithm as fn(&Sym3) -> PlasticState),
            (linear, PlasticState::from_matrix),
        ] {
            let slope = rest.strain_sensitivity(&x, &state(&s), &material) * ds;
            let gradient = |h: f64| flat(rest.gradient(&x, &state(&(s + ds * h)), &material));
            assert!(
                order_of_convergence(|h| (gradient(h) - gradient(-h)) / (2.0 * h) - slope) > 1.9
            );
        }
    }
}
