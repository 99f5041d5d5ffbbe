//! One solve of a case on its own mesh.

use crate::convert;
use crate::failure::Failure;
use crate::host::{Event, Host};
use crate::memory::Plan;
use crate::outcome;
use crate::run_observer::RunObserver;
use crate::solved::{RunResult, Solved};
use crate::space::ReportSpace;
use crate::stopwatch::Stopwatch;
use case_io::Case;
use case_io::output::Presence;
use certified_contact::SolveError;
use fem_core::interface::ContactProblem;

/// Solves a case on its own mesh, with or without Coulomb friction, and judges the answer.
///
/// * `output`: the directory that must stay until the end.
pub(crate) fn solve<S: ReportSpace>(
    (case, plan): (&Case<S>, &Plan),
    problem: ContactProblem<S>,
    output: Presence,
    (watch, host): (&mut Stopwatch, &mut dyn Host),
) -> Result<Solved<S>, Failure> {
    let mut follower = RunObserver::new(case, watch, host, output);
    let answer =
        answer((case, plan), problem, &mut follower).map_err(|error| follower.failure(case, &error))?;
    let status = outcome::judge_answer(case, &answer, follower.ended);
    Ok(Solved { longest_step: follower.longest, ..Solved::of(answer, status) })
}

fn answer<S: ReportSpace>(
    (case, plan): (&Case<S>, &Plan),
    problem: ContactProblem<S>,
    follower: &mut RunObserver<'_>,
) -> Result<RunResult<S>, SolveError<S>> {
    if case.coulomb_pair().is_none() {
        let solution = certified_contact::solve(problem, &plan.settings(case), follower)?;
        return Ok(RunResult::Certified(Box::new(solution)));
    }
    let (settings, relaxation) = (convert::coulomb(case), convert::relaxation(case));
    let result = certified_contact::solve_coulomb(problem, &settings, relaxation, follower)?;
    follower.tell(Event::Iteration(&result.row()));
    Ok(RunResult::Coulomb(Box::new(result)))
}
