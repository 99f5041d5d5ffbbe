//! Conjugate gradients that lower the distance of a stress in equilibrium to the FE stress, and their end.

use crate::atomic_slots::AtomicSlots;

/// A gain below this fraction of the energies at hand is round-off: the gradient has vanished.
pub(crate) const ROUND_OFF: f64 = 1e-28;

/// All further steps are expected to lower `‖τ − σ̂‖²` by this many times what the second half of the steps did.
///
/// If `k` steps leave a multiple of `1/k`, the factor is 1; of `1/√k`, 2.4; if each step leaves the same fraction, it is below 1. Measured on
/// 564 bounds with a tolerance of 2 %: 1.5 leaves more than that in 5 of them, 1.75 and 2 in one (2.2 %).
const HALVES: f64 = 2.0;

/// A relaxation to a tolerance takes no fewer steps, unless the gradient vanishes.
pub(crate) const LEAST: usize = 2;

/// How far to relax.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// A fixed number of steps; 0 steps keep the EET stress unchanged.
    Steps(usize),
    /// Until all further steps can be expected to lower `‖τ − σ̂‖` by less than this fraction of it; at least two steps.
    ///
    /// The expectation is measured: twice what the second half of the steps gained. A large first gain does not count, and the longer the
    /// relaxation takes, the more steps must confirm its end: on hard problems the energy falls slowly, or in stairs.
    Tolerance {
        /// The fraction.
        tolerance: f64,
        /// Largest number of steps.
        max_steps: usize,
    },
}

impl Relaxation {
    /// EET alone.
    pub const NONE: Self = Self::Steps(0);

    pub(crate) fn max_steps(self) -> usize {
        match self {
            Self::Steps(steps) => steps,
            Self::Tolerance { max_steps, .. } => max_steps,
        }
    }
}

impl Default for Relaxation {
    /// Less than 2 % left to gain, at most 100 steps: 4 to 14 steps on most problems, more if a material is
    /// nearly incompressible or strongly anisotropic, or cells are flat.
    fn default() -> Self {
        Self::Tolerance { tolerance: 0.02, max_steps: 100 }
    }
}

/// Predicts by which fraction of its limit `‖τ − σ̂‖` exceeds it, from its squares before the first step and after each.
pub(crate) fn left_to_gain(history: &[f64]) -> f64 {
    let steps = history.len() - 1;
    if steps < LEAST {
        return f64::INFINITY;
    }
    let left = HALVES * (history[steps / 2] - history[steps]);
    let limit = history[steps] - left;
    if limit > 0.0 { (history[steps] / limit).sqrt() - 1.0 } else { f64::INFINITY }
}

/// Record of a relaxation.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RelaxationReport {
    /// Number of steps.
    pub steps: usize,
    /// `‖τ − σ̂‖²` before the first step and after each, J/m; never increasing. The steps compute their gain in single
    /// precision: to about 1e-6 of the remaining value. [`crate::cre`] computes the bound from the stress itself. The last one includes what the
    /// columns gained after the last step.
    pub energy_history: Vec<f64>,
    /// Number of columns: stresses that no step reaches, since they pass wrenches between supports or around holes. The minimum over them
    /// follows the last step.
    pub columns: usize,
    /// Whether it ended because the gradient vanished: the stress is the best of its space to round-off.
    pub stationary: bool,
}

impl RelaxationReport {
    /// The record of no step.
    pub(crate) fn unrelaxed(energy: f64) -> Self {
        Self { energy_history: vec![energy], ..Self::default() }
    }
}

/// A linear map of vectors: reads the first, overwrites the second.
pub(crate) type Operator<'a> = &'a dyn Fn(&AtomicSlots, &AtomicSlots);

/// Lowers `‖τ − σ̂‖²` by preconditioned conjugate gradients for `A x = r`. Returns x and the record.
///
/// * `r`: the negative gradient of half the energy, over the unit of `A`; it is overwritten.
/// * `energies`: `‖τ − σ̂‖²` and `‖σ̂‖²`, J/m.
/// * `operators`: the preconditioner, and A over its unit.
pub(crate) fn conjugate_gradients(
    relaxation: Relaxation,
    (r, unit): (&AtomicSlots, f64),
    [energy, of_elements]: [f64; 2],
    [precondition, multiply]: [Operator<'_>; 2],
) -> (AtomicSlots, RelaxationReport) {
    let mut report = RelaxationReport { energy_history: vec![energy], ..RelaxationReport::default() };
    let floor = ROUND_OFF * (energy + of_elements);
    let [x, z, p] = std::array::from_fn(|_| AtomicSlots::zeros(r.len()));
    let mut energy = energy;
    let mut descent = 0.0;
    while report.steps < relaxation.max_steps() {
        precondition(r, &z);
        let next = unit * r.dot(&z);
        // Also if it is NaN.
        if !(next > floor) {
            report.stationary = true;
            break;
        }
        let beta = if descent > 0.0 { next / descent } else { 0.0 };
        p.update(|i, p| z.get(i) + beta * p);
        descent = next;
        // z is no longer needed: its memory takes A p.
        multiply(&p, &z);
        let alpha = descent / (unit * p.dot(&z));
        if !(alpha > 0.0 && alpha.is_finite()) {
            report.stationary = true;
            break;
        }
        x.update(|i, x| x + alpha * p.get(i));
        energy = (energy - alpha * descent).max(0.0);
        report.steps += 1;
        report.energy_history.push(energy);
        if let Relaxation::Tolerance { tolerance, .. } = relaxation
            && left_to_gain(&report.energy_history) <= tolerance
        {
            break;
        }
        if report.steps < relaxation.max_steps() {
            r.update(|i, r| r - alpha * z.get(i));
        }
    }
    (x, report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_large_gain_predicts_no_end() {
        // Gains of 50 % and 10 %: a geometric series of their ratio would promise 2.5 % more.
        assert!(left_to_gain(&[1.0, 0.25, 0.25 * 0.81]) > 0.3);
        assert!(left_to_gain(&[1.0, 0.25]).is_infinite() && left_to_gain(&[1.0, 0.9, 0.1]).is_infinite());
        // The last two of four steps lower the square from 1.02 to 1: by 0.04 more.
        assert!((left_to_gain(&[9.0, 2.0, 1.02, 1.01, 1.0]) - (0.96f64.sqrt().recip() - 1.0)).abs() < 1e-12);
        assert_eq!(left_to_gain(&[1.0, 0.5, 0.5]), 0.0);
    }
}
