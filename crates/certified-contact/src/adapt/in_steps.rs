//! All load steps on each mesh of an adaptive run: the mesh serves every step.

use super::AdaptiveEnd;
use super::solve_on_mesh::{SolveLoadStep, SolveOnMesh};
use crate::error::SolveError;
use crate::history::Step;
use crate::observer::Observer;
use crate::solution::RoleReason;
use crate::space::ContactSpace;
use crate::steps::LoadSteps;
use cre_estimator::Estimate;
use fem_core::body::ConditionPlace;
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};
use nndd::{Iterate, Start};

/// The factors at the end of a load step.
#[derive(Clone)]
pub struct StepFactors<'a> {
    /// Of each condition of each body, see [`LoadSteps::solve`].
    pub conditions: &'a dyn Fn(usize, ConditionPlace) -> f64,
    /// Of the gap of each pair, see [`LoadSteps::scale_gaps`].
    pub gaps: Vec<f64>,
}

/// The solutions of the load steps on one mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StepSolutions<A, S: Space = Plane> {
    /// The problem on this mesh, its conditions with the factor 1.
    pub problem: ContactProblem<S>,
    /// One per load step, in order; fewer if a step was not solved or not certified, or the run was interrupted.
    pub steps: Vec<A>,
    /// The number of load steps.
    pub of: usize,
    /// True if the observer ended the run between two steps.
    interrupted: bool,
}

impl<A, S: Space> StepSolutions<A, S> {
    /// Tells whether all load steps were solved.
    pub fn is_complete(&self) -> bool {
        self.steps.len() == self.of
    }
}

/// All load steps on each mesh, each solved by the same method.
pub(super) struct InSteps<'a, M> {
    pub(super) method: &'a M,
    pub(super) factors: &'a [StepFactors<'a>],
}

impl<S: ContactSpace, M: SolveLoadStep<S>> SolveOnMesh<S> for InSteps<'_, M> {
    type Solution = StepSolutions<M::Solution, S>;

    /// Solves one step after the other, from rest, until one is not solved.
    fn solve(
        &self,
        problem: ContactProblem<S>,
        previous: Option<(RoleReason, Start)>,
        observer: &mut dyn Observer<S>,
    ) -> Result<Self::Solution, SolveError<S>> {
        let mut load_steps = LoadSteps::new(problem.clone());
        if let Some((_, start)) = previous {
            load_steps.start_from(start);
        }
        let of = self.factors.len();
        let mut found = StepSolutions { problem, steps: Vec::with_capacity(of), of, interrupted: false };
        for (step, StepFactors { conditions, gaps }) in (1..).zip(self.factors) {
            load_steps.scale_gaps(gaps.clone());
            let next = self.method.solve_step(&mut load_steps, conditions, observer);
            let next = next.map_err(|error| match error {
                SolveError::Stopped => error,
                _ => SolveError::LoadStep { step, error: Box::new(error) },
            })?;
            let ends = M::cut_short(&next).or_else(|| self.method.unsolved(&next)).is_some()
                || !M::step(&next, step).is_sound();
            found.steps.push(next);
            if ends {
                break;
            }
            if step < of && observer.should_stop() {
                found.interrupted = true;
                break;
            }
        }
        Ok(found)
    }

    fn problem(solution: &Self::Solution) -> &ContactProblem<S> {
        &solution.problem
    }

    fn estimates(solution: &Self::Solution) -> Vec<&Estimate<S>> {
        solution.steps.iter().flat_map(M::estimates).collect()
    }

    /// The first step of the next mesh starts from that of this one.
    fn last(solution: &Self::Solution) -> Option<&Iterate> {
        solution.steps.first().and_then(M::last)
    }

    /// Sums up all steps: the bound or residual is that of the step with the largest relative one, the largest stress that of the last step.
    fn step(solution: &Self::Solution, number: usize) -> Step {
        let steps: Vec<Step> = solution.steps.iter().map(|of_step| M::step(of_step, number)).collect();
        let size = |step: &Step| step.measured().unwrap_or(f64::NEG_INFINITY);
        let largest = (1..).zip(&steps).max_by(|(_, a), (_, b)| size(a).total_cmp(&size(b)));
        let (load_step, largest) = largest.map_or((0, Step::default()), |(k, step)| (k, *step));
        let sound = solution.is_complete() && steps.iter().all(Step::is_sound);
        Step {
            load_step: Some(load_step),
            relative: largest.relative.filter(|_| sound),
            certified: sound && largest.certified,
            e_b: largest.e_b.filter(|_| sound),
            relative_residual: largest.relative_residual.filter(|_| sound),
            iterations: steps.iter().map(|step| step.iterations).sum(),
            peak_stress: steps.last().and_then(|step| step.peak_stress),
            ..largest
        }
    }

    fn tell(observer: &mut dyn Observer<S>, step: &Step, solution: &Self::Solution) {
        if let Some(last) = solution.steps.last() {
            M::tell(observer, step, last);
        }
    }

    fn cut_short(solution: &Self::Solution) -> Option<AdaptiveEnd<S>> {
        let between = solution.interrupted.then_some(AdaptiveEnd::Interrupted);
        between.or_else(|| solution.steps.last().and_then(M::cut_short))
    }

    /// Every step must meet the target. The bound of a step without strain energy is compared with the largest energy norm of all steps.
    fn meets(&self, step: &Step, solution: &Self::Solution, target: f64) -> bool {
        let largest = Self::estimates(solution).iter().map(|e| e.energy_norm()).fold(0.0, f64::max);
        let is_idle = |e: &&Estimate<S>| e.holds_no_energy() && e.unchecked().e_cre <= target * largest;
        let meets = |of_step: &M::Solution| {
            self.method.meets(&M::step(of_step, step.step), of_step, target)
                || self.method.unsolved(of_step).is_none() && M::estimates(of_step).iter().all(is_idle)
        };
        step.is_sound() && solution.steps.iter().all(meets)
    }

    fn unsolved(&self, solution: &Self::Solution) -> Option<AdaptiveEnd<S>> {
        solution.steps.last().and_then(|last| self.method.unsolved(last))
    }
}
