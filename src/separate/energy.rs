//! The energy of a separation and its derivatives, in units of Young's modulus.
//!
//! E = elastic energy of the tets at free vertices, their present shape being at rest
//!   + 1/2 k (target - d)^2 of every contact whose distance d is below its target
//!   + springs that hold surface points where markers were met
//!   + a weak pull of every free vertex back to its place, which fades within half a body's size.

use std::sync::Arc;

use rayon::prelude::*;

use super::contacts::Contact;
use crate::error::Result;
use crate::fem::{Curvature, PlasticState, RestElement, Spring};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{BlockMatrix, BlockPattern, Factor, SymbolicFactor};

const HELD: u32 = u32::MAX;

/// Shifts where the Hessian is not definite, as shares of the mean of its diagonal.
const SHIFTS: [f64; 2] = [1e-9, 1.0];

/// Elasticity around the overlaps; vertices of all bodies are numbered through.
pub(super) struct Elasticity<'a, M> {
    pub material: M,
    /// Tets at free vertices.
    pub tets: Vec<[u32; 4]>,
    pub rest: Vec<RestElement>,
    pub springs: Vec<&'a Spring>,
    /// Where each vertex was, and the stiffness that pulls it back.
    pub places: &'a [Vec3],
    pub pull: &'a [f64],
    /// Number of each vertex among the free ones.
    unknown: Vec<u32>,
    free: Vec<u32>,
    plastic: PlasticState,
}

impl<'a, M: IsotropicDensity> Elasticity<'a, M> {
    pub fn new(
        material: M,
        all_tets: &[[u32; 4]],
        springs: &'a [Spring],
        places: &'a [Vec3],
        pull: &'a [f64],
        is_free: &[bool],
    ) -> Self {
        let moves = |tet: &&[u32; 4]| tet.iter().any(|&v| is_free[v as usize]);
        let tets: Vec<[u32; 4]> = all_tets.iter().filter(moves).copied().collect();
        let rest = tets.iter().map(|t| RestElement::new(t.map(|v| places[v as usize]))).collect();
        let free: Vec<u32> = (0..places.len() as u32).filter(|&v| is_free[v as usize]).collect();
        let mut unknown = vec![HELD; places.len()];
        for (i, &v) in free.iter().enumerate() {
            unknown[v as usize] = i as u32;
        }
        let is_felt = |s: &&Spring| s.point.0.iter().any(|e| is_free[e.0 as usize]);
        Self {
            springs: springs.iter().filter(is_felt).collect(),
            plastic: PlasticState::from_logarithm(&Sym3::zeros()),
            material,
            tets,
            rest,
            places,
            pull,
            unknown,
            free,
        }
    }

    fn corners(&self, t: usize, x: &[Vec3]) -> [Vec3; 4] {
        self.tets[t].map(|v| x[v as usize])
    }
}

/// Elasticity with the contacts of one round.
pub(super) struct Energy<'a, M> {
    pub elasticity: &'a Elasticity<'a, M>,
    pub contacts: &'a [&'a Contact],
    /// Wanted distance of each contact.
    pub targets: Vec<f64>,
    /// Stiffness of a contact.
    pub stiffness: f64,
}

impl<M: IsotropicDensity> Energy<'_, M> {
    pub fn value(&self, x: &[Vec3]) -> f64 {
        let e = self.elasticity;
        let parts: Vec<f64> = (0..e.tets.len())
            .into_par_iter()
            .map(|t| e.rest[t].energy(&e.corners(t, x), &e.plastic, &e.material))
            .collect();
        let contacts = self.contacts.iter().zip(&self.targets).map(|(c, target)| {
            let lack = (target - c.distance_at(x)).max(0.0);
            0.5 * self.stiffness * lack * lack
        });
        let springs = e
            .springs
            .iter()
            .map(|s| 0.5 * s.stiffness * (s.point.position(x) - s.target).norm_squared());
        let pull = e.free.iter().map(|&v| {
            0.5 * e.pull[v as usize] * (x[v as usize] - e.places[v as usize]).norm_squared()
        });
        parts.iter().sum::<f64>() + contacts.sum::<f64>() + springs.sum::<f64>() + pull.sum::<f64>()
    }

    /// Derivative by each free vertex.
    pub fn gradient(&self, x: &[Vec3]) -> Vec<Vec3> {
        let e = self.elasticity;
        let parts: Vec<[Vec3; 4]> = (0..e.tets.len())
            .into_par_iter()
            .map(|t| e.rest[t].gradient(&e.corners(t, x), &e.plastic, &e.material))
            .collect();
        let mut gradient: Vec<Vec3> = e
            .free
            .iter()
            .map(|&v| (x[v as usize] - e.places[v as usize]) * e.pull[v as usize])
            .collect();
        let mut add = |v: u32, force: Vec3| {
            let i = e.unknown[v as usize];
            if i != HELD {
                gradient[i as usize] += force;
            }
        };
        for (tet, forces) in e.tets.iter().zip(parts) {
            for (&v, force) in tet.iter().zip(forces) {
                add(v, force);
            }
        }
        for (contact, target) in self.contacts.iter().zip(&self.targets) {
            let lack = target - contact.distance_at(x);
            if lack > 0.0 {
                for &(v, w) in &contact.weights {
                    add(v, contact.normal * (-self.stiffness * lack * w));
                }
            }
        }
        for spring in &e.springs {
            let force = (spring.point.position(x) - spring.target) * spring.stiffness;
            for &(v, w) in &spring.point.0 {
                add(v, force * w);
            }
        }
        gradient
    }

    /// The pattern of the second derivative, analysed.
    pub fn pattern(&self) -> Result<(BlockPattern, Arc<SymbolicFactor>)> {
        let e = self.elasticity;
        let mut links = Vec::new();
        let mut link = |vertices: &mut dyn Iterator<Item = u32>| {
            let free: Vec<u32> =
                vertices.map(|v| e.unknown[v as usize]).filter(|&i| i != HELD).collect();
            for (k, &i) in free.iter().enumerate() {
                links.extend(free[..k].iter().filter(|&&j| j != i).map(|&j| (i, j)));
            }
        };
        e.tets.iter().for_each(|tet| link(&mut tet.iter().copied()));
        self.contacts.iter().for_each(|c| link(&mut c.weights.iter().map(|w| w.0)));
        e.springs.iter().for_each(|s| link(&mut s.point.0.iter().map(|w| w.0)));
        links.sort_unstable();
        links.dedup();
        let points: Vec<Vec3> = e.free.iter().map(|&v| e.places[v as usize]).collect();
        let pattern = BlockPattern::of_links(&points, &links, 3);
        let symbolic = SymbolicFactor::new(&pattern)?;
        Ok((pattern, symbolic))
    }

    /// Cholesky factor of the second derivative, each tet's part made positive semidefinite. Squeezed tets
    /// are so much stiffer than the pull back that rounding may win; then it is shifted.
    pub fn factor(
        &self,
        (pattern, symbolic): &(BlockPattern, Arc<SymbolicFactor>),
        x: &[Vec3],
    ) -> Result<Factor> {
        let h = self.hessian(pattern, x);
        symbolic.factor(&h).or_else(|_| symbolic.factor_shifted(pattern, &h, SHIFTS))
    }

    fn hessian(&self, pattern: &BlockPattern, x: &[Vec3]) -> BlockMatrix {
        let e = self.elasticity;
        let parts: Vec<_> = (0..e.tets.len())
            .into_par_iter()
            .map(|t| {
                let corners = e.corners(t, x);
                e.rest[t].stiffness(&corners, &e.plastic, &e.material, Curvature::Projected)
            })
            .collect();
        let mut h = BlockMatrix { values: vec![0.0; pattern.row_idx.len()] };
        let mut add = |v: u32, w: u32, block: &dyn Fn(usize, usize) -> f64| {
            let (i, j) = (e.unknown[v as usize], e.unknown[w as usize]);
            if i == HELD || j == HELD || i < j {
                return;
            }
            for c in 0..3 {
                for r in if i == j { c } else { 0 }..3 {
                    h.values[pattern.entry(i, j, r, c)] += block(r, c);
                }
            }
        };
        for (tet, part) in e.tets.iter().zip(&parts) {
            for (a, &v) in tet.iter().enumerate() {
                for (b, &w) in tet.iter().enumerate() {
                    add(v, w, &|r, c| part[(3 * a + r, 3 * b + c)]);
                }
            }
        }
        for (contact, target) in self.contacts.iter().zip(&self.targets) {
            if contact.distance_at(x) < *target {
                let n = contact.normal;
                for &(v, a) in &contact.weights {
                    for &(w, b) in &contact.weights {
                        add(v, w, &|r, c| self.stiffness * a * b * n[r] * n[c]);
                    }
                }
            }
        }
        let diagonal =
            |stiffness: f64| move |r: usize, c: usize| if r == c { stiffness } else { 0.0 };
        for spring in &e.springs {
            for &(v, a) in &spring.point.0 {
                for &(w, b) in &spring.point.0 {
                    add(v, w, &diagonal(spring.stiffness * a * b));
                }
            }
        }
        for &v in &e.free {
            add(v, v, &diagonal(e.pull[v as usize]));
        }
        h
    }

    /// `x` with each free vertex moved by `eta` times its step.
    pub fn stepped(&self, x: &[Vec3], step: &[Vec3], eta: f64) -> Vec<Vec3> {
        let mut moved = x.to_vec();
        for (&v, s) in self.elasticity.free.iter().zip(step) {
            moved[v as usize] -= s * eta;
        }
        moved
    }
}
