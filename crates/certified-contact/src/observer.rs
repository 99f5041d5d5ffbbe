//! How a run reports its progress. The library itself neither prints nor reads the clock.

use crate::checkpoint::Checkpoint;
use crate::coulomb::CoulombResult;
use crate::history::{IterationRecord, Step};
use crate::solution::CertifiedSolution;
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};

/// The current phase of the work; exactly one phase is active at any time of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Pattern, stiffness and load of both bodies.
    Assembly,
    /// Order, symbolic and numeric factorisation, interface operator.
    Factorisation,
    /// The loop, its contact problems, and the recovery of displacements.
    Iterations,
    /// All computations for certificates, and the results: forces, reactions, recovered stress.
    Estimate,
    /// Marking and refining the meshes of an adaptive run.
    Refinement,
}

/// Follows a run in a space, the plane unless it is named.
pub trait Observer<S: Space = Plane> {
    /// A phase begins, and the one before it ends.
    fn phase(&mut self, _phase: Phase) {}

    /// An iteration has ended.
    fn iteration(&mut self, _row: &IterationRecord) {}

    /// A mesh of an adaptive run has been solved.
    fn step(&mut self, _step: &Step, _solution: &CertifiedSolution<S>) {}

    /// A mesh of an adaptive run with Coulomb friction has been solved.
    fn coulomb_step(&mut self, _step: &Step, _result: &CoulombResult<S>) {}

    /// Called before a finer mesh of an adaptive run is solved: returns whether there is enough memory for it. The
    /// bodies are in the order of the iteration.
    fn fits_in_memory(&mut self, _problem: &ContactProblem<S>) -> bool {
        true
    }

    /// A finer mesh of an adaptive run is about to be solved: [`crate::resume_adaptively`] can resume from here.
    fn checkpoint(&mut self, _checkpoint: &Checkpoint) {}

    /// Called after every iteration, and between the meshes of an adaptive run: returns whether the run should end with
    /// its current result.
    fn should_stop(&mut self) -> bool {
        false
    }

    /// Called between the steps of a solve that cannot be interrupted: returns whether the run must end now, without a
    /// certificate if it has none yet.
    fn must_stop(&mut self) -> bool {
        false
    }
}

/// An observer that does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl<S: Space> Observer<S> for Silent {}
