//! The update of λ: the paper's relaxation, Aitken's, Anderson's.

use crate::settings::Acceleration;
use fem_core::dense::least_squares;
use nalgebra::{DMatrix, DVector};

/// Differences that Anderson's method keeps.
const WINDOW: usize = 6;
/// A step that raises the error by more than this factor makes Anderson's method discard its history.
const SAFEGUARD: f64 = 2.0;

/// One update `λ ← λ + θ (w¹ − w²)·n`.
pub(crate) struct Step {
    /// θ of this update.
    pub(crate) theta: f64,
    /// The next λ, m.
    pub(crate) lambda: Vec<f64>,
}

/// Turns corrections into the next λ.
pub(crate) struct Accelerator {
    kind: Acceleration,
    base: f64,
    theta: f64,
    /// λ and direction of the last iteration.
    previous: Option<(Vec<f64>, Vec<f64>)>,
    /// Differences of λ and of directions, newest last.
    history: Vec<(Vec<f64>, Vec<f64>)>,
    last_eta: f64,
}

impl Accelerator {
    pub(crate) fn new(kind: Acceleration, theta: f64) -> Self {
        Self { kind, base: theta, theta, previous: None, history: Vec::new(), last_eta: f64::INFINITY }
    }

    /// Updates λ from the direction `(w¹ − w²)·n` of an iteration and its η_NNDD.
    pub(crate) fn step(&mut self, lambda: &[f64], direction: Vec<f64>, eta: f64) -> Step {
        if self.kind != Acceleration::None {
            self.theta = self.aitken(&direction).unwrap_or(self.base);
        }
        if self.kind == Acceleration::Anderson {
            if eta > SAFEGUARD * self.last_eta {
                self.history.clear();
                self.previous = None;
            }
            if let Some((old_lambda, old_direction)) = &self.previous {
                let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
                self.history.push((difference(lambda, old_lambda), difference(&direction, old_direction)));
                if self.history.len() > WINDOW {
                    self.history.remove(0);
                }
            }
        }
        self.last_eta = eta;
        // Only Anderson's method has a history.
        let step = if self.history.is_empty() {
            let next = lambda.iter().zip(&direction).map(|(l, z)| l + self.theta * z).collect();
            Step { theta: self.theta, lambda: next }
        } else {
            Step { theta: self.base, lambda: self.anderson(lambda, &direction) }
        };
        self.previous = Some((lambda.to_vec(), direction));
        step
    }

    /// Aitken's Δ²: θ ← −θ z₋·(z − z₋)/|z − z₋|², kept within sensible limits of the base.
    fn aitken(&self, direction: &[f64]) -> Option<f64> {
        let (_, old) = self.previous.as_ref()?;
        let (mut product, mut square) = (0.0, 0.0);
        for (z, y) in direction.iter().zip(old) {
            product += y * (z - y);
            square += (z - y) * (z - y);
        }
        let theta = -self.theta * product / square;
        (theta.is_finite() && theta > 0.0).then(|| theta.clamp(1e-3 * self.base, 4.0 * self.base))
    }

    /// λ + θz − Σ γ_j (Δλ_j + θ Δz_j), with γ minimising |z − Σ γ_j Δz_j| (Walker and Ni 2011).
    fn anderson(&self, lambda: &[f64], direction: &[f64]) -> Vec<f64> {
        let columns = DMatrix::from_fn(direction.len(), self.history.len(), |i, j| self.history[j].1[i]);
        let scales: Vec<f64> =
            columns.column_iter().map(|c| c.norm()).map(|s| if s > 0.0 { s } else { 1.0 }).collect();
        let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / scales[j]);
        let z = DVector::from_column_slice(direction);
        // Directions that are linearly dependent to round-off are ignored.
        let gamma = least_squares(scaled, &z, 1e-10).unwrap_or_else(|| DVector::zeros(scales.len()));
        (0..lambda.len())
            .map(|i| {
                let mut next = lambda[i] + self.base * direction[i];
                for (j, (dl, dz)) in self.history.iter().enumerate() {
                    next -= gamma[j] / scales[j] * (dl[i] + self.base * dz[i]);
                }
                next
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps on `z = b − A λ` with A = diag(1, ½); after each, the reported θ and the change of λ.
    fn steps(kind: Acceleration, etas: [f64; 4]) -> Vec<(f64, Vec<f64>)> {
        let mut update = Accelerator::new(kind, 0.4);
        let mut lambda = vec![0.0, 0.0];
        let mut found = Vec::new();
        for eta in etas {
            let direction = vec![1.0 - lambda[0], 1.0 - 0.5 * lambda[1]];
            let Step { theta, lambda: next } = update.step(&lambda, direction.clone(), eta);
            let error = (0..2).map(|i| next[i] - lambda[i] - theta * direction[i]).collect();
            found.push((theta, error));
            lambda = next;
        }
        found
    }

    #[test]
    fn the_theta_named_is_the_one_of_the_step() {
        for kind in [Acceleration::None, Acceleration::Aitken] {
            for (theta, error) in steps(kind, [1.0; 4]) {
                assert!(error.iter().all(|e| e.abs() < 1e-15), "{kind:?} {theta} {error:?}");
            }
        }
        // Anderson's steps mix with the base θ; the first step, and a step after a restart by the safeguard, do not
        // mix.
        let found = steps(Acceleration::Anderson, [1.0, 0.5, 2.0, 1.0]);
        assert_eq!(found[1].0, 0.4);
        assert!(found[1].1.iter().any(|e| e.abs() > 1e-3));
        for k in [0, 2] {
            assert!(found[k].1.iter().all(|e| e.abs() < 1e-15), "{k}: {found:?}");
        }
        assert_ne!(found[2].0, 0.4);
    }
}
