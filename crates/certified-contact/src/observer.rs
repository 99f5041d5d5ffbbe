//! How a run tells the outside where it is. The library itself neither prints nor reads the clock.

use crate::history::Row;

/// What is being worked on; exactly one phase is open at any time of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Pattern, stiffness and load of both bodies.
    Assembly,
    /// Order, symbolic and numeric factorisation, interface operator.
    Factorisation,
    /// The loop, its contact problems, and the recovery of displacements.
    Iterations,
    /// Everything for certificates.
    Estimate,
}

/// Follows a run.
pub trait Observer {
    /// A phase begins, and the one before it ends.
    fn phase(&mut self, _phase: Phase) {}

    /// An iteration has ended.
    fn iteration(&mut self, _row: &Row) {}

    /// Asked after every iteration: whether the run should end with what it has.
    fn should_stop(&mut self) -> bool {
        false
    }
}

/// An observer that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
