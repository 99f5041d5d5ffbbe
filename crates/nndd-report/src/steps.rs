//! Load steps of a case: one solve after another, each from the slip that the last one left.

use crate::convert;
use crate::failure::Failure;
use crate::host::{Event, Host};
use crate::memory::Plan;
use crate::outcome::{self, Ended};
use crate::paraview;
use crate::report::{contact_rows, step_summary};
use crate::resume::RunDirectory;
use crate::run_observer::RunObserver;
use crate::solved::{RunResult, Solved, SolvedStep};
use crate::space::ReportSpace;
use crate::stopwatch::{Activity, Stopwatch};
use case_io::Case;
use case_io::case::Factors;
use case_io::output::OutputDirectory;
use case_io::report::{Status, StepSummary};
use case_io::table::ContactRow;
use certified_contact::{LoadSteps, Observer};
use fem_core::body::ConditionPlace;
use fem_core::interface::ContactProblem;

/// Solves all increments, until one fails; earlier ones remain.
pub(crate) fn solve<S: ReportSpace>(
    (case, plan): (&Case<S>, &Plan),
    problem: ContactProblem<S>,
    place: &mut RunDirectory,
    watch: &mut Stopwatch,
    host: &mut dyn Host,
) -> Result<Solved<S>, Failure> {
    let presence = place.presence();
    let mut follower = RunObserver::new(case, watch, host, presence);
    let settings = plan.settings(case);
    let mut load_steps = LoadSteps::new(problem);
    let increments = case.increments();
    let of = |k: usize| format!("load step {k} of {}", increments.len());
    let mut steps: Vec<SolvedStep> = Vec::new();
    let mut found: Option<Solved<S>> = None;
    for (k, factors) in (1..).zip(&increments) {
        let factor = |body: usize, place: ConditionPlace| case.factor(factors, body, place);
        load_steps.scale_gaps((0..case.contacts.len()).map(|pair| case.gap_factor(factors, pair)).collect());
        let next = match case.coulomb_pair() {
            Some(_) => {
                let (coulomb, relaxation) = (convert::coulomb(case), convert::relaxation(case));
                let found = load_steps.solve_coulomb(factor, &coulomb, relaxation, &mut follower);
                found.map(|result| RunResult::Coulomb(Box::new(result)))
            }
            None => {
                let found = load_steps.solve(factor, &settings, &mut follower);
                found.map(|solution| RunResult::Certified(Box::new(solution)))
            }
        };
        let judged = next.map_err(|error| follower.failure(case, &error));
        let judged =
            judged.and_then(|answer| judge(case, answer, (k, increments.len()), factors, follower.ended));
        let (mut solved, summary) = match judged {
            Ok(judged) => judged,
            Err(failure) => {
                let Some(mut solved) = found else { return Err(failure) };
                solved.status = failed(failure, &of(k));
                found = Some(solved);
                break;
            }
        };
        follower.tell(Event::LoadStep { step: &summary, of: increments.len() });
        follower.switch(Activity::Write);
        steps.push(keep(case, &solved, summary, increments.len(), &mut place.directory)?);
        solved.longest_step = follower.longest;
        if solved.status.code == 0 && k < increments.len() && Observer::<S>::should_stop(&mut follower) {
            solved.status = outcome::interrupted(follower.ended, &of(k));
        }
        let ended = solved.status.code != 0;
        found = Some(solved);
        if ended {
            break;
        }
    }
    let mut solved = found.ok_or_else(|| Failure::defect("a case without load steps has none to solve"))?;
    solved.notes.extend(note(&solved));
    solved.steps = steps;
    Ok(solved)
}

/// Judges a load step, from 1, and sums it up.
///
/// * `ended`: why the run was ended.
///
/// # Errors
/// A number that cannot be written.
pub(crate) fn judge<S: ReportSpace>(
    case: &Case<S>,
    answer: RunResult<S>,
    (step, of): (usize, usize),
    factors: &Factors,
    ended: Option<Ended>,
) -> Result<(Solved<S>, StepSummary), Failure> {
    let mut status = outcome::judge_answer(case, &answer, ended);
    status.reason = format!("load step {step} of {of}: {}", status.reason);
    let solved = Solved::of(answer, status);
    let summary = step_summary(case, &solved, step, factors);
    // A number that cannot be written must not cost the steps before.
    summary.check()?;
    Ok((solved, summary))
}

/// Writes the fields of a load step, and returns what else the results keep of it.
///
/// * `of`: the number of load steps.
///
/// # Errors
/// Files that cannot be written.
pub(crate) fn keep<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    summary: StepSummary,
    of: usize,
    directory: &mut OutputDirectory,
) -> Result<SolvedStep, Failure> {
    let (fields, step) = (solved.answer.fields(), summary.step);
    if case.output.vtu {
        paraview::write_step(case, &fields, step, directory)?;
    }
    let has_fields = fields.estimate.is_some();
    let rows = (0..case.contacts.len()).filter(|_| has_fields).map(|pair| {
        let mut rows = contact_rows(&fields, pair);
        rows.iter_mut().for_each(|row| row.step = Some(step));
        rows
    });
    let rows: Vec<Vec<ContactRow>> = rows.collect();
    let view = S::view_of_step(case, &fields, &rows, (step, of));
    Ok(SolvedStep { summary, rows, has_fields, view })
}

/// Says for which problem the certificate of a load step holds.
pub(crate) fn note<S: ReportSpace>(solved: &Solved<S>) -> Option<String> {
    solved.answer.certified().map(|_| {
        "the certificate of a load step is that of its increment, from the computed slip before it: the error that the steps accumulate has \
         no bound"
            .to_owned()
    })
}

/// Makes the status of a run whose next step could not be solved.
fn failed(failure: Failure, step: &str) -> Status {
    let said = failure.diagnostics.first().map(|diagnostic| diagnostic.message.clone());
    let reason = failure.message.or(said).unwrap_or_default();
    let first = reason.lines().next().unwrap_or_default();
    outcome::word(
        "step_failed",
        failure.code,
        format!("{step}: {first}; the results are those of the step before"),
    )
}
