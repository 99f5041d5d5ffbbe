//! The spectrum of the interface operator, which determines the admissible θ.
//!
//! In full contact an iteration multiplies the error of λ by `I − θ B (S₁+S₂)`, with `B = ½(S₁⁻¹+S₂⁻¹)` for
//! the paper's weights and `B = d₁S₁⁻¹d₁ + d₂S₂⁻¹d₂` for nodal ones. The eigenvalues µ are real and positive
//! (`B(S₁+S₂)` is self-adjoint in the inner product of `S₁+S₂`): θ converges below `2/µ_max` and is best at
//! `2/(µ_min+µ_max)`. With unilateral contact every small enough θ converges: Haslinger, Kučera and Sassi 2009.

use nalgebra::{DMatrix, SymmetricEigen};
use neumann_neumann::dot;

/// The ends of the spectrum, estimated by a few Lanczos steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Smallest Ritz value: an upper bound of the smallest eigenvalue.
    pub smallest: f64,
    /// Largest Ritz value: a lower bound of the largest eigenvalue.
    pub largest: f64,
    /// Lanczos steps taken.
    pub steps: usize,
}

impl Spectrum {
    /// Returns the best fixed θ in full contact, `2/(µ_min+µ_max)` (14).
    pub fn best_theta(&self) -> f64 {
        2.0 / (self.smallest + self.largest)
    }

    /// Returns the limit of convergence in full contact, `2/µ_max`.
    pub fn theta_limit(&self) -> f64 {
        2.0 / self.largest
    }
}

/// Maximum number of Lanczos steps: the ends of the spectrum converge in a few.
const STEPS: usize = 12;

/// Chooses θ: the given one, or the best one for the spectrum, which is also returned.
///
/// * `fallback`: θ if there is no spectrum.
pub(crate) fn choose_theta(
    theta: Option<f64>,
    fallback: f64,
    estimate: impl FnOnce() -> Option<Spectrum>,
) -> (f64, Option<Spectrum>) {
    if let Some(theta) = theta {
        return (theta, None);
    }
    let spectrum = estimate();
    (spectrum.map_or(fallback, |s| s.best_theta()), spectrum)
}

/// Estimates the spectrum of `B A` on `n` unknowns by Lanczos steps in the inner product of `A`, the operator; `B` is the
/// preconditioner.
pub(crate) fn of_product(
    n: usize,
    operator: impl Fn(&[f64]) -> Vec<f64>,
    precondition: impl Fn(&[f64]) -> Vec<f64>,
) -> Option<Spectrum> {
    ends(&lanczos(n, operator, precondition))
}

/// The tridiagonal matrix of the Lanczos steps: its diagonal and off-diagonal.
#[derive(Default)]
struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

/// Runs the Lanczos steps of `B A` in the inner product of `A`, on `n` unknowns.
fn lanczos(
    n: usize,
    operator: impl Fn(&[f64]) -> Vec<f64>,
    precondition: impl Fn(&[f64]) -> Vec<f64>,
) -> Tridiagonal {
    // A fixed start vector that contains every frequency.
    let mut v: Vec<f64> = (0..n).map(|i| 1.0 + (1.7 * (i * i) as f64 + 0.3 * i as f64).sin()).collect();
    let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let mut found = Tridiagonal::default();
    for k in 0..STEPS.min(n) {
        let av = operator(&v);
        let norm = dot(&v, &av).sqrt();
        if !(norm > 0.0 && norm.is_finite()) {
            break;
        }
        if k > 0 {
            if norm <= 1e-10 * found.diagonal[k - 1] {
                break;
            }
            found.beside.push(norm);
        }
        let q: Vec<f64> = v.iter().map(|x| x / norm).collect();
        let aq: Vec<f64> = av.iter().map(|x| x / norm).collect();
        let mut next = precondition(&aq);
        found.diagonal.push(dot(&next, &aq));
        basis.push((q, aq));
        // Twice, so that the basis stays orthogonal to round-off.
        for _ in 0..2 {
            for (q, aq) in &basis {
                let c = dot(&next, aq);
                next.iter_mut().zip(q).for_each(|(x, q)| *x -= c * q);
            }
        }
        v = next;
    }
    found
}

/// Computes the smallest and the largest eigenvalue; `None` if the operator is not positive.
fn ends(matrix: &Tridiagonal) -> Option<Spectrum> {
    let steps = matrix.diagonal.len();
    if steps == 0 {
        return None;
    }
    let mut t = DMatrix::zeros(steps, steps);
    for k in 0..steps {
        t[(k, k)] = matrix.diagonal[k];
        if k + 1 < steps {
            t[(k, k + 1)] = matrix.beside[k];
            t[(k + 1, k)] = matrix.beside[k];
        }
    }
    let values = SymmetricEigen::new(t).eigenvalues;
    let spectrum = Spectrum { smallest: values.min(), largest: values.max(), steps };
    (spectrum.smallest > 0.0 && spectrum.largest.is_finite()).then_some(spectrum)
}
