//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952) on unknowns of any kind.

/// What the method does with its vectors.
pub trait Unknowns: Clone {
    /// The inner product.
    fn dot(&self, other: &Self) -> f64;
    /// `self + factor other`, in place.
    fn add(&mut self, factor: f64, other: &Self);
    /// `factor self`, in place.
    fn scale(&mut self, factor: f64);
}

impl Unknowns for Vec<f64> {
    fn dot(&self, other: &Self) -> f64 {
        self.iter().zip(other).map(|(a, b)| a * b).sum()
    }

    fn add(&mut self, factor: f64, other: &Self) {
        self.iter_mut().zip(other).for_each(|(a, b)| *a += factor * b);
    }

    fn scale(&mut self, factor: f64) {
        for a in self {
            *a *= factor;
        }
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// The residual, measured by the preconditioner, falls to this share.
    pub reduction: f64,
    /// Steps at most.
    pub max_steps: usize,
}

/// The solution so far, and whether the goal was reached.
#[derive(Clone, Copy, Debug)]
pub struct Solved<V> {
    /// A direction of descent of the quadratic form, however far the method came.
    pub x: V,
    /// The residual fell as wanted, or the matrix turned out indefinite and no more can be had.
    pub reached: bool,
}

/// Solves A x = b for a symmetric positive definite A, given as products `multiply`, with products
/// `precondition` of an approximate inverse. Where A turns out indefinite, x is the sum so far, or the
/// first direction.
pub fn conjugate_gradients<V: Unknowns>(
    multiply: impl Fn(&V) -> V,
    precondition: impl Fn(&V) -> V,
    b: V,
    goal: Goal,
) -> Solved<V> {
    let mut r = b;
    let mut p = precondition(&r);
    let mut x = p.clone();
    x.scale(0.0);
    let mut rz = r.dot(&p);
    let small = goal.reduction * goal.reduction * rz;
    for step in 0..goal.max_steps {
        let ap = multiply(&p);
        let curvature = p.dot(&ap);
        if curvature <= 0.0 {
            return Solved { x: if step == 0 { p } else { x }, reached: true };
        }
        let alpha = rz / curvature;
        x.add(alpha, &p);
        r.add(-alpha, &ap);
        let z = precondition(&r);
        let next = r.dot(&z);
        if next.is_nan() || next <= small {
            return Solved { x, reached: !next.is_nan() };
        }
        p.scale(next / rz);
        p.add(1.0, &z);
        rz = next;
    }
    Solved { x, reached: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOAL: Goal = Goal { reduction: 1e-12, max_steps: 10 };

    fn multiply(diagonal: [f64; 3]) -> impl Fn(&Vec<f64>) -> Vec<f64> {
        move |x| vec![diagonal[0] * x[0] + x[1], x[0] + diagonal[1] * x[1], diagonal[2] * x[2]]
    }

    #[test]
    fn as_many_steps_as_unknowns_solve_a_definite_system() {
        let expected = vec![1.0, -2.0, 3.0];
        let a = multiply([4.0, 3.0, 2.0]);
        let solved = conjugate_gradients(&a, Vec::clone, a(&expected), GOAL);
        assert!(solved.reached);
        assert!(solved.x.iter().zip(&expected).all(|(x, e)| (x - e).abs() < 1e-12));
        let one = Goal { max_steps: 1, ..GOAL };
        assert!(!conjugate_gradients(&a, Vec::clone, a(&expected), one).reached);
    }

    #[test]
    fn an_indefinite_system_gives_a_direction_of_descent() {
        let b = vec![1.0, 1.0, 5.0];
        let solved = conjugate_gradients(multiply([4.0, 3.0, -2.0]), Vec::clone, b.clone(), GOAL);
        assert!(solved.reached && solved.x.dot(&b) > 0.0);
    }
}
