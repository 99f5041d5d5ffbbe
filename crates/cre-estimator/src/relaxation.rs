//! Conjugate gradients that lower the distance of a stress in equilibrium to the FE stress, and their end.

use crate::atomic_slots::AtomicSlots;
use crate::size::larger;

/// A gain below this fraction of the energies at hand is round-off: the gradient has vanished.
pub(crate) const ROUND_OFF: f64 = 1e-28;

/// All further steps are expected to lower `‖τ − σ̂‖²` by at most this many times what is measured: the larger one of the gain of the second half of `k`
/// steps, and `k` times the gain of the last one.
///
/// Both are about what is left if `k` steps leave a multiple of `1/k`, and more if each step leaves the same fraction. Measured on 54 example cases with
/// 120 bodies and a tolerance of 2 %, if steps do not run out: a factor of 1 leaves more than that in the bounds of 3 of them, at most 2.1 %, 1.25 in none. Twice the
/// first gain alone takes 12.6 steps in the mean and the best choice 6.3; this takes 9.7.
const SAFETY: f64 = 1.25;

/// A relaxation to a tolerance takes no fewer steps, unless the gradient vanishes.
pub(crate) const LEAST: usize = 2;

/// How far to relax.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// A fixed number of steps; 0 steps keep the EET stress unchanged.
    Steps(usize),
    /// Until all further steps can be expected to lower `‖τ − σ̂‖` by less than this fraction of it; at least two steps.
    ///
    /// The expectation is measured, by the gain of the second half of the steps and by that of the last step times their number. A large first gain
    /// does not count, and the longer the relaxation takes, the more steps must confirm its end: on hard problems the energy falls slowly, or in
    /// stairs.
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

    /// Returns the largest number of steps.
    pub fn max_steps(self) -> usize {
        match self {
            Self::Steps(steps) => steps,
            Self::Tolerance { max_steps, .. } => max_steps,
        }
    }

    /// Returns the same with fewer steps.
    pub(crate) fn at_most(self, steps: usize) -> Self {
        match self {
            Self::Steps(own) => Self::Steps(own.min(steps)),
            Self::Tolerance { tolerance, max_steps } => {
                Self::Tolerance { tolerance, max_steps: max_steps.min(steps) }
            }
        }
    }
}

impl Default for Relaxation {
    /// Less than 2 % left to gain, at most 100 steps: 3 to 12 steps on most problems, more if a material is
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
    // After an odd number of steps the middle is between two of them.
    let middle = history[steps / 2].sqrt() * history[steps.div_ceil(2)].sqrt();
    let last = steps as f64 * (history[steps - 1] - history[steps]);
    let left = SAFETY * larger(middle - history[steps], last);
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

    /// Returns `‖τ − σ̂‖²` at the end, J/m.
    pub(crate) fn energy(&self) -> f64 {
        self.energy_history.last().copied().unwrap_or(0.0)
    }
}

/// A preconditioner with the product of its answer: reads `r`, overwrites `z = M⁻¹ r` and `A z`.
pub(crate) type Operator<'a> = &'a dyn Fn(&AtomicSlots, &AtomicSlots, &AtomicSlots);

/// Lowers `‖τ − σ̂‖²` by preconditioned conjugate gradients for `A x = r`. Returns x and the record.
///
/// The directions `p = z + β p` and their products follow the same recurrence, `A p = A z + β A p`: a preconditioner that ends with exact
/// solutions on some patches knows the rows of `A z` there.
///
/// * `r`: the negative gradient of half the energy, over the unit of `A`; it is overwritten.
/// * `energies`: `‖τ − σ̂‖²` and `‖σ̂‖²`, J/m.
/// * `operator`: the preconditioner and A, over its unit.
pub(crate) fn conjugate_gradients(
    relaxation: Relaxation,
    (mut r, unit): (AtomicSlots, f64),
    [energy, of_elements]: [f64; 2],
    operator: Operator<'_>,
) -> (AtomicSlots, RelaxationReport) {
    let mut report = RelaxationReport { energy_history: vec![energy], ..RelaxationReport::default() };
    let floor = ROUND_OFF * (energy + of_elements);
    let [mut x, mut z, mut product, mut p, mut q] = std::array::from_fn(|_| AtomicSlots::zeros(r.len()));
    let mut energy = energy;
    let mut descent = 0.0;
    while report.steps < relaxation.max_steps() {
        operator(&r, &z, &product);
        let next = unit * r.dot(&mut z);
        // Also if it is NaN.
        if !(next > floor) {
            report.stationary = true;
            break;
        }
        let beta = if descent > 0.0 { next / descent } else { 0.0 };
        p.combine(&mut z, |p, z| z + beta * p);
        q.combine(&mut product, |q, product| product + beta * q);
        descent = next;
        let alpha = descent / (unit * p.dot(&mut q));
        if !(alpha > 0.0 && alpha.is_finite()) {
            report.stationary = true;
            break;
        }
        x.combine(&mut p, |x, p| x + alpha * p);
        energy = (energy - alpha * descent).max(0.0);
        report.steps += 1;
        report.energy_history.push(energy);
        if let Relaxation::Tolerance { tolerance, .. } = relaxation
            && left_to_gain(&report.energy_history) <= tolerance
        {
            break;
        }
        if report.steps < relaxation.max_steps() {
            r.combine(&mut q, |r, q| r - alpha * q);
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
        let is = |history: &[f64], left: f64| {
            let limit = history[history.len() - 1] - SAFETY * left;
            let found = left_to_gain(history);
            assert!(
                (found - ((history[history.len() - 1] / limit).sqrt() - 1.0)).abs() < 1e-12,
                "{history:?}: {found}"
            );
        };
        // The last two of four steps lower the square from 1.02 to 1, the last one alone by 0.005 or 0.008.
        is(&[9.0, 2.0, 1.02, 1.005, 1.0], 0.02);
        is(&[9.0, 2.0, 1.02, 1.008, 1.0], 4.0 * 0.008);
        // The middle of three steps is between the first and the second one.
        is(&[9.0, 1.0 / 0.98, 0.98, 0.979], 1.0 - 0.979);
        assert_eq!(left_to_gain(&[1.0, 0.5, 0.5]), 0.0);
    }
}
