//! The update of λ: the paper's relaxation, or Anderson's method.

use crate::settings::Acceleration;
use fem_core::dense::least_squares;
use nalgebra::{DMatrix, DVector};

/// Differences that Anderson's method keeps.
const WINDOW: usize = 6;

/// Turns corrections into the next λ.
pub(crate) struct Accelerator {
    kind: Acceleration,
    theta: f64,
    /// λ and direction of the last iteration.
    previous: Option<(Vec<f64>, Vec<f64>)>,
    /// Differences of λ and of directions, newest last.
    history: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Accelerator {
    pub(crate) fn new(kind: Acceleration, theta: f64) -> Self {
        Self { kind, theta, previous: None, history: Vec::new() }
    }

    /// Updates λ from the direction `(w¹ − w²)·n` of an iteration: `λ + θz − Σ γ_j (Δλ_j + θ Δz_j)` with γ minimising `|z − Σ γ_j Δz_j|`
    /// (Walker and Ni 2011); without a history, which only Anderson's method has, `λ + θz`.
    pub(crate) fn step(&mut self, lambda: &[f64], direction: Vec<f64>) -> Vec<f64> {
        let mut next: Vec<f64> = lambda.iter().zip(&direction).map(|(l, z)| l + self.theta * z).collect();
        if self.kind == Acceleration::None {
            return next;
        }
        if let Some((old_lambda, old_direction)) = &self.previous {
            let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
            self.history.push((difference(lambda, old_lambda), difference(&direction, old_direction)));
            if self.history.len() > WINDOW {
                self.history.remove(0);
            }
        }
        if !self.history.is_empty() {
            for ((dl, dz), gamma) in self.history.iter().zip(&self.gamma(&direction)) {
                let changes = dl.iter().zip(dz).map(|(dl, dz)| gamma * (dl + self.theta * dz));
                next.iter_mut().zip(changes).for_each(|(next, change)| *next -= change);
            }
        }
        self.previous = Some((lambda.to_vec(), direction));
        next
    }

    /// Computes γ.
    fn gamma(&self, direction: &[f64]) -> DVector<f64> {
        let columns = DMatrix::from_fn(direction.len(), self.history.len(), |i, j| self.history[j].1[i]);
        let scales = columns.column_iter().map(|c| c.norm()).map(|s| if s > 0.0 { s } else { 1.0 });
        let scales = DVector::from_iterator(self.history.len(), scales);
        let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / scales[j]);
        let z = DVector::from_column_slice(direction);
        // Directions that are linearly dependent to round-off are ignored.
        let gamma = least_squares(scaled, &z, 1e-10).unwrap_or_else(|| DVector::zeros(scales.len()));
        gamma.component_div(&scales)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The changes of λ beyond `θz` in steps on `z = b − A λ` with A = diag(1, ½).
    fn mixed(kind: Acceleration) -> Vec<Vec<f64>> {
        let mut update = Accelerator::new(kind, 0.4);
        let mut lambda = vec![0.0, 0.0];
        let step = |_| {
            let direction = vec![1.0 - lambda[0], 1.0 - 0.5 * lambda[1]];
            let next = update.step(&lambda, direction.clone());
            let mixed = (0..2).map(|i| next[i] - lambda[i] - 0.4 * direction[i]).collect();
            lambda = next;
            mixed
        };
        (0..4).map(step).collect()
    }

    #[test]
    fn only_anderson_mixes_from_the_second_step_on() {
        for (kind, steps) in [(Acceleration::None, 4), (Acceleration::Anderson, 1)] {
            assert!(mixed(kind)[..steps].iter().flatten().all(|e| e.abs() < 1e-15), "{kind:?}");
        }
        let found = mixed(Acceleration::Anderson);
        assert!(found[1].iter().any(|e| e.abs() > 1e-3), "{found:?}");
        // Two unknowns: three steps find the solution.
        assert!(found[3].iter().all(|e| e.abs() < 1e-12), "{found:?}");
    }
}
