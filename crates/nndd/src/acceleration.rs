//! The update of λ: the paper's relaxation, Aitken's, Anderson's.

use crate::settings::Acceleration;
use nalgebra::{DMatrix, DVector};

/// Differences that Anderson's method keeps.
const WINDOW: usize = 6;
/// A step that raises the error by more than this factor makes Anderson's method forget its history.
const SAFEGUARD: f64 = 2.0;

/// Turns corrections into the next λ.
pub(crate) struct Accelerator {
    kind: Acceleration,
    base: f64,
    theta: f64,
    /// Previous λ and direction.
    previous: Option<(Vec<f64>, Vec<f64>)>,
    /// Differences of λ and of directions, newest last.
    history: Vec<(Vec<f64>, Vec<f64>)>,
    last_eta: f64,
}

impl Accelerator {
    pub(crate) fn new(kind: Acceleration, theta: f64) -> Self {
        Self { kind, base: theta, theta, previous: None, history: Vec::new(), last_eta: f64::INFINITY }
    }

    /// Chooses θ for the coming update.
    pub(crate) fn theta(&mut self, direction: &[f64]) -> f64 {
        if self.kind != Acceleration::None {
            self.theta = self.aitken(direction).unwrap_or(self.base);
        }
        if self.kind == Acceleration::Anderson && !self.history.is_empty() { self.base } else { self.theta }
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

    /// Computes the next λ.
    pub(crate) fn next(&mut self, lambda: &[f64], direction: Vec<f64>, eta: f64) -> Vec<f64> {
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
        let next = match self.kind {
            Acceleration::Anderson if !self.history.is_empty() => self.anderson(lambda, &direction),
            _ => lambda.iter().zip(&direction).map(|(l, z)| l + self.theta * z).collect(),
        };
        self.previous = Some((lambda.to_vec(), direction));
        next
    }

    /// λ + θz − Σ γ_j (Δλ_j + θ Δz_j), with γ minimising |z − Σ γ_j Δz_j| (Walker and Ni 2011).
    fn anderson(&self, lambda: &[f64], direction: &[f64]) -> Vec<f64> {
        let columns = DMatrix::from_fn(direction.len(), self.history.len(), |i, j| self.history[j].1[i]);
        let scales: Vec<f64> =
            columns.column_iter().map(|c| c.norm()).map(|s| if s > 0.0 { s } else { 1.0 }).collect();
        let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / scales[j]);
        let z = DVector::from_column_slice(direction);
        // Directions that the history repeats to round-off are left out.
        let gamma = scaled.svd(true, true).solve(&z, 1e-10).unwrap_or_else(|_| DVector::zeros(scales.len()));
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
