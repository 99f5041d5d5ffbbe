//! Watches η_NNDD for divergence and stagnation.

use crate::solution::NnddStatus;

/// Growth over the best iteration that counts as divergence.
const GROWTH: f64 = 1e3;
/// So many rises in a row do as well, where the method is a plain relaxation.
const RISES: usize = 6;
/// Reduction of η below which it is round-off.
const ROUND_OFF: f64 = 1e-11;
/// Iterations without progress at round-off, and above it.
const PATIENCE: [usize; 2] = [6, 60];

/// The course of η_NNDD so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Monitor {
    largest: f64,
    best: Option<f64>,
    last: f64,
    rises: usize,
    idle: usize,
}

impl Monitor {
    /// Judges the next η; `plain` says that the iteration has a fixed θ, whose error falls steadily or
    /// not at all.
    pub(crate) fn judge(&mut self, eta: f64, plain: bool) -> Option<NnddStatus> {
        let best = self.best.unwrap_or(f64::INFINITY);
        if !eta.is_finite() {
            return Some(NnddStatus::Diverged { best, theta_limit: None });
        }
        self.largest = self.largest.max(eta);
        self.rises = if self.best.is_some() && eta > 1.05 * self.last { self.rises + 1 } else { 0 };
        self.last = eta;
        if eta < 0.9 * best {
            self.best = Some(eta);
            self.idle = 0;
        } else {
            self.idle += 1;
        }
        let round_off = best <= ROUND_OFF * self.largest;
        if !round_off && (eta > GROWTH * best || plain && self.rises >= RISES) {
            return Some(NnddStatus::Diverged { best, theta_limit: None });
        }
        let stalled = self.idle >= PATIENCE[usize::from(!round_off)];
        stalled.then_some(NnddStatus::Stalled { floor: best, at_round_off: round_off })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(etas: impl IntoIterator<Item = f64>) -> Option<NnddStatus> {
        let mut monitor = Monitor::default();
        etas.into_iter().find_map(|eta| monitor.judge(eta, true))
    }

    #[test]
    fn a_falling_error_is_left_alone() {
        assert_eq!(judge((0..40).map(|k| 0.6f64.powi(k))), None);
        // One bad step is not divergence.
        assert_eq!(judge([1.0, 0.1, 0.5, 0.05]), None);
    }

    #[test]
    fn growth_is_divergence_and_a_floor_is_a_floor() {
        assert!(matches!(judge((0..40).map(|k| 1.5f64.powi(k))), Some(NnddStatus::Diverged { .. })));
        assert!(matches!(judge([1.0, f64::NAN]), Some(NnddStatus::Diverged { .. })));
        let floor = (0..60).map(|k| 0.1f64.powi(k).max(1e-15 * (1.0 + f64::from(k % 3))));
        assert!(matches!(judge(floor), Some(NnddStatus::Stalled { at_round_off: true, .. })));
        let plateau = (0..90).map(|_| 1.0);
        assert!(matches!(judge(plateau), Some(NnddStatus::Stalled { at_round_off: false, .. })));
    }
}
