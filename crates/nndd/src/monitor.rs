//! Watches η_NNDD for divergence and stagnation.

use crate::solution::NnddStatus;

/// Growth factor over the last reference value that counts as divergence.
const GROWTH: f64 = 1e3;
/// This many consecutive increases also count as divergence if no acceleration is used.
const RISES: usize = 6;
/// Reduction of η below which it is round-off.
const ROUND_OFF: f64 = 1e-11;
/// Iterations without progress at round-off, and above it.
const PATIENCE: [usize; 2] = [6, 60];

/// A decrease to this fraction of the last reference value is progress and sets a new reference.
const PROGRESS: f64 = 0.9;

/// A decrease to this fraction of it, with η smaller in every iteration since, is slow but steady.
const STEADY: f64 = 0.999;

/// The history of η_NNDD so far.
#[derive(Clone, Debug)]
pub(crate) struct Monitor {
    largest: f64,
    smallest: f64,
    /// The last reference value, and the largest value until then.
    mark: f64,
    scale: f64,
    last: f64,
    rises: usize,
    /// Iterations since the reference value, and whether η fell in every one of them.
    idle: usize,
    falling: bool,
}

impl Default for Monitor {
    fn default() -> Self {
        let none = f64::INFINITY;
        Self {
            largest: 0.0,
            smallest: none,
            mark: none,
            scale: 0.0,
            last: none,
            rises: 0,
            idle: 0,
            falling: true,
        }
    }
}

impl Monitor {
    /// Returns the smallest η so far; infinite before the first.
    pub(crate) fn smallest(&self) -> f64 {
        self.smallest
    }

    /// Judges the next η; `plain` says that the iteration has a fixed θ, whose error falls steadily or
    /// not at all. A slow iteration that still falls continues to the iteration limit.
    pub(crate) fn judge(&mut self, eta: f64, plain: bool) -> Option<NnddStatus> {
        let (mark, scale) = (self.mark, self.scale);
        if !eta.is_finite() {
            return Some(self.diverged());
        }
        self.largest = self.largest.max(eta);
        self.smallest = self.smallest.min(eta);
        self.rises = if eta > 1.05 * self.last { self.rises + 1 } else { 0 };
        self.falling &= eta < self.last;
        self.last = eta;
        if eta < PROGRESS * mark {
            (self.mark, self.scale, self.idle, self.falling) = (eta, self.largest, 0, true);
        } else {
            self.idle += 1;
        }
        // The larger values since then are not a scale.
        let at_round_off = mark <= ROUND_OFF * scale;
        if !at_round_off && (eta > GROWTH * mark || plain && self.rises >= RISES) {
            return Some(self.diverged());
        }
        let slow = !at_round_off && self.falling && eta < STEADY * mark;
        let stalled = self.idle >= PATIENCE[usize::from(!at_round_off)] && !slow;
        stalled.then_some(NnddStatus::Stalled { floor: self.smallest, at_round_off })
    }

    fn diverged(&self) -> NnddStatus {
        NnddStatus::Diverged { best: self.smallest, theta_limit: None }
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
    fn a_slow_fall_is_left_to_the_limit_of_iterations() {
        // 5 % in 60 iterations, for a thousand.
        assert_eq!(judge((0..1000).map(|k| 0.99915f64.powi(k))), None);
        // 6e-8 in 60 iterations is not progress.
        assert!(matches!(
            judge((0..100).map(|k| 1.0 - 1e-9 * f64::from(k))),
            Some(NnddStatus::Stalled { .. })
        ));
        // With increases in between it has stalled, and the smallest value is reported.
        let rough = (0..1000).map(|k| 0.99915f64.powi(k) * if k % 7 == 3 { 1.01 } else { 1.0 });
        let Some(NnddStatus::Stalled { floor, at_round_off: false }) = judge(rough) else { panic!() };
        assert!((floor - 0.99915f64.powi(60)).abs() < 1e-13, "{floor}");
    }

    #[test]
    fn growth_is_divergence_and_a_floor_is_a_floor() {
        assert!(matches!(judge((0..40).map(|k| 1.5f64.powi(k))), Some(NnddStatus::Diverged { .. })));
        assert!(matches!(judge([1.0, f64::NAN]), Some(NnddStatus::Diverged { .. })));
        assert!(matches!(judge([1.0, 1e12, 1e24, 1e36]), Some(NnddStatus::Diverged { .. })));
        let floor = (0..60).map(|k| 0.1f64.powi(k).max(1e-15 * (1.0 + f64::from(k % 3))));
        assert!(matches!(judge(floor), Some(NnddStatus::Stalled { at_round_off: true, .. })));
        let plateau = (0..90).map(|_| 1.0);
        assert!(matches!(judge(plateau), Some(NnddStatus::Stalled { at_round_off: false, .. })));
    }
}
