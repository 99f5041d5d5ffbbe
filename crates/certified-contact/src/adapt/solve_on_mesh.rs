//! The interface between the adaptive loop and the solve on one mesh.

use super::AdaptiveEnd;
use crate::coulomb::CoulombResult;
use crate::error::SolveError;
use crate::history::Step;
use crate::observer::Observer;
use crate::settings::{Criterion, Settings};
use crate::solution::{CertifiedSolution, RoleReason};
use crate::solve::{solve, solve_again};
use crate::solve_coulomb::solve_coulomb;
use crate::space::ContactSpace;
use crate::steps::LoadSteps;
use cre_estimator::{Estimate, EstimatorError, Relaxation};
use fem_core::body::ConditionPlace;
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};
use nndd::{CoulombSettings, CoulombStatus, Iterate, NnddStatus, Start};

/// How the problem of one mesh is solved, and what the loop needs of the solution: certified, or with Coulomb friction a residual.
pub(super) trait SolveOnMesh<S: Space = Plane> {
    type Solution;

    /// Solves the problem of one mesh.
    ///
    /// * `previous`: on a finer mesh, why the roles were chosen on the first one, and where to start.
    fn solve(
        &self,
        problem: ContactProblem<S>,
        previous: Option<(RoleReason, Start)>,
        observer: &mut dyn Observer<S>,
    ) -> Result<Self::Solution, SolveError<S>>;

    /// Returns the problem of this mesh, which a finer mesh poses again.
    fn problem(solution: &Self::Solution) -> &ContactProblem<S>;

    /// Lists the estimates, in load steps one for each step.
    fn estimates(solution: &Self::Solution) -> Vec<&Estimate<S>>;

    /// Returns the iterate from which a finer mesh starts.
    fn last(solution: &Self::Solution) -> Option<&Iterate>;

    fn role_reason(_: &Self::Solution) -> RoleReason {
        RoleReason::Given
    }

    /// Sums up the solution as a step.
    fn step(solution: &Self::Solution, number: usize) -> Step;

    fn tell(observer: &mut dyn Observer<S>, step: &Step, solution: &Self::Solution);

    /// Returns the end of a run whose solve had no time or memory to end on its own.
    fn cut_short(solution: &Self::Solution) -> Option<AdaptiveEnd<S>>;

    /// Tells whether the relative bound or residual of a mesh is at most the target, see [`meets`].
    fn meets(&self, step: &Step, solution: &Self::Solution, target: f64) -> bool {
        meets(step, &Self::estimates(solution), target)
    }

    /// Returns the end of a run whose discrete problem was not solved.
    fn unsolved(&self, solution: &Self::Solution) -> Option<AdaptiveEnd<S>>;
}

/// Tells whether the relative bound or residual is at most the target; if the bodies have no strain energy, whether it is zero to
/// round-off, at most twice its allowance.
fn meets<S: Space>(step: &Step, estimates: &[&Estimate<S>], target: f64) -> bool {
    let is_zero = |e: &&Estimate<S>| e.unchecked().e_cre <= 2.0 * e.round_off;
    let zero = || !estimates.is_empty() && estimates.iter().all(is_zero);
    step.measured().map_or_else(zero, |found| found <= target)
}

/// A solve that can also be that of a load step.
pub(super) trait SolveLoadStep<S: ContactSpace = Plane>: SolveOnMesh<S> {
    /// Solves the next load step.
    fn solve_step(
        &self,
        steps: &mut LoadSteps<S>,
        factor: &dyn Fn(usize, ConditionPlace) -> f64,
        observer: &mut dyn Observer<S>,
    ) -> Result<Self::Solution, SolveError<S>>;
}

impl<S: ContactSpace> SolveLoadStep<S> for Settings<S> {
    fn solve_step(
        &self,
        steps: &mut LoadSteps<S>,
        factor: &dyn Fn(usize, ConditionPlace) -> f64,
        observer: &mut dyn Observer<S>,
    ) -> Result<CertifiedSolution<S>, SolveError<S>> {
        steps.solve(factor, self, observer)
    }
}

impl<S: ContactSpace> SolveLoadStep<S> for (CoulombSettings, Relaxation) {
    fn solve_step(
        &self,
        steps: &mut LoadSteps<S>,
        factor: &dyn Fn(usize, ConditionPlace) -> f64,
        observer: &mut dyn Observer<S>,
    ) -> Result<CoulombResult<S>, SolveError<S>> {
        steps.solve_coulomb(factor, &self.0, self.1, observer)
    }
}

impl<S: ContactSpace> SolveOnMesh<S> for Settings<S> {
    type Solution = CertifiedSolution<S>;

    fn solve(
        &self,
        problem: ContactProblem<S>,
        previous: Option<(RoleReason, Start)>,
        observer: &mut dyn Observer<S>,
    ) -> Result<CertifiedSolution<S>, SolveError<S>> {
        match previous {
            None => solve(problem, self, observer),
            Some((reason, start)) => solve_again(problem, reason, start, self, observer),
        }
    }

    fn problem(solution: &CertifiedSolution<S>) -> &ContactProblem<S> {
        &solution.problem
    }

    fn estimates(solution: &CertifiedSolution<S>) -> Vec<&Estimate<S>> {
        solution.estimate.iter().collect()
    }

    fn last(solution: &CertifiedSolution<S>) -> Option<&Iterate> {
        Some(solution.last())
    }

    fn role_reason(solution: &CertifiedSolution<S>) -> RoleReason {
        solution.role_reason
    }

    fn step(solution: &CertifiedSolution<S>, number: usize) -> Step {
        solution.step(number)
    }

    fn tell(observer: &mut dyn Observer<S>, step: &Step, solution: &CertifiedSolution<S>) {
        observer.step(step, solution);
    }

    fn cut_short(solution: &CertifiedSolution<S>) -> Option<AdaptiveEnd<S>> {
        if let Some(error @ EstimatorError::OutOfMemory { .. }) = &solution.no_estimate {
            return Some(AdaptiveEnd::Failed(error.clone().into()));
        }
        // The result of an interrupted run must not depend on the moment of the interruption.
        (solution.nndd.status == NnddStatus::Interrupted).then_some(AdaptiveEnd::Interrupted)
    }

    fn unsolved(&self, solution: &CertifiedSolution<S>) -> Option<AdaptiveEnd<S>> {
        match solution.nndd.status {
            // A finer mesh lowers it as it lowers the mesh error.
            NnddStatus::StoppedByCriterion | NnddStatus::BalanceError { .. } => None,
            NnddStatus::MaxIterations | NnddStatus::Stalled { .. }
                if self.criterion == Criterion::Iterations =>
            {
                None
            }
            status => Some(AdaptiveEnd::Iteration(status)),
        }
    }
}

impl<S: ContactSpace> SolveOnMesh<S> for (CoulombSettings, Relaxation) {
    type Solution = CoulombResult<S>;

    /// The fixed point starts from full stick on every mesh.
    fn solve(
        &self,
        problem: ContactProblem<S>,
        _: Option<(RoleReason, Start)>,
        observer: &mut dyn Observer<S>,
    ) -> Result<CoulombResult<S>, SolveError<S>> {
        solve_coulomb(problem, &self.0, self.1, observer)
    }

    fn problem(solution: &CoulombResult<S>) -> &ContactProblem<S> {
        &solution.problem
    }

    fn estimates(solution: &CoulombResult<S>) -> Vec<&Estimate<S>> {
        vec![solution.estimate()]
    }

    fn last(solution: &CoulombResult<S>) -> Option<&Iterate> {
        Some(&solution.last)
    }

    fn step(solution: &CoulombResult<S>, number: usize) -> Step {
        solution.step(number)
    }

    fn tell(observer: &mut dyn Observer<S>, step: &Step, solution: &CoulombResult<S>) {
        observer.coulomb_step(step, solution);
    }

    fn cut_short(solution: &CoulombResult<S>) -> Option<AdaptiveEnd<S>> {
        (solution.solution.status == CoulombStatus::Interrupted).then_some(AdaptiveEnd::Interrupted)
    }

    /// The residual of a pair that is no solution says nothing of the target.
    fn meets(&self, step: &Step, solution: &CoulombResult<S>, target: f64) -> bool {
        SolveOnMesh::<S>::unsolved(self, solution).is_none() && meets(step, &[solution.estimate()], target)
    }

    fn unsolved(&self, solution: &CoulombResult<S>) -> Option<AdaptiveEnd<S>> {
        let status = solution.solution.status;
        (status != CoulombStatus::Converged).then_some(AdaptiveEnd::FixedPoint(status))
    }
}
