//! How a run tells the outside where it is. The library itself neither prints nor reads the clock.

use crate::checkpoint::Checkpoint;
use crate::history::{Row, Step};
use crate::solution::CertifiedSolution;
use fem_core::interface::ContactProblem;

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
    /// Marking and refining the meshes of an adaptive run.
    Refinement,
}

/// Follows a run.
pub trait Observer {
    /// A phase begins, and the one before it ends.
    fn phase(&mut self, _phase: Phase) {}

    /// An iteration has ended.
    fn iteration(&mut self, _row: &Row) {}

    /// A mesh of an adaptive run has been solved.
    fn step(&mut self, _step: &Step, _solution: &CertifiedSolution) {}

    /// Asked before a finer mesh of an adaptive run is solved: whether there is room for it. Bodies are in the roles of
    /// the iteration.
    fn has_room_for(&mut self, _problem: &ContactProblem) -> bool {
        true
    }

    /// A finer mesh of an adaptive run is about to be solved: from here [`crate::resume_adaptively`] can go on.
    fn checkpoint(&mut self, _checkpoint: &Checkpoint) {}

    /// Asked after every iteration, and between the meshes of an adaptive run: whether the run should end with what it has.
    fn should_stop(&mut self) -> bool {
        false
    }

    /// Asked between the steps of a solve that cannot be interrupted: whether the run must end now, without a certificate
    /// if there is none yet.
    fn must_stop(&mut self) -> bool {
        false
    }
}

/// An observer that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
