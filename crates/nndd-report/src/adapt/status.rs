//! How an adaptive run ended: its status word, exit status and reason.

use super::Course;
use crate::failure::{Failure, LIMIT, NOT_CERTIFIED};
use crate::motion::all_move;
use crate::outcome::{self, Ended, NOT_CONVERGED, stalled, word};
use crate::solved::RunResult;
use crate::space::ReportSpace;
use crate::words::{self, short};
use case_io::Case;
use case_io::case::{Adapt, Criterion, Target};
use case_io::diagnostic::significant;
use case_io::report::Status;
use certified_contact::{AdaptiveEnd, SolveError};
use fem_core::interface::Partner;
use nndd::NnddStatus;

/// Judges a finished run.
///
/// * `memory`: why there is not enough memory for the next mesh.
pub(super) fn judge<S: ReportSpace>(
    case: &Case<S>,
    adapt: &Adapt,
    answer: &Course<S>,
    ended: Option<Ended>,
    memory: Option<&str>,
) -> Status {
    // The best certificate may belong to an earlier mesh.
    let last = answer.step == answer.history.len();
    let mut status = match &answer.end {
        AdaptiveEnd::Iteration(_) | AdaptiveEnd::FixedPoint(_) | AdaptiveEnd::NotCertified { .. } if last => {
            let mut status = outcome::judge_answer(case, &answer.answer, ended);
            if !case.steps.is_empty() {
                status.reason = format!("load step {}: {}", answer.earlier.len() + 1, status.reason);
            }
            status
        }
        AdaptiveEnd::Interrupted => outcome::interrupted(ended, &format!("mesh {}", answer.history.len())),
        AdaptiveEnd::OutOfMemory { nodes } => {
            let needed = memory.unwrap_or("too much memory");
            word("limit", LIMIT, format!("the next mesh of {nodes} nodes needs {needed}"))
        }
        AdaptiveEnd::Failed(error) => failed(case, adapt, answer, error),
        _ => of_end(case, adapt, answer),
    };
    status.reason += match status.word.as_str() {
        "interrupted" => "; continue with --resume",
        "limit" => "; raise the limit and continue with --resume",
        _ => "",
    };
    if !last {
        let what = if answer.answer.certified().is_some() { "certificate" } else { "residual" };
        status.reason += &format!("; the {what} is that of mesh {}", answer.step);
    }
    status
}

/// Says how small the certified error, or the residual, is.
fn reached<S: ReportSpace>(answer: &Course<S>) -> String {
    let [alone, named] = match answer.answer {
        RunResult::Certified(_) => ["the bound", "certified relative error"],
        RunResult::Coulomb(_) => ["the residual", "relative residual"],
    };
    let step = answer.largest_step();
    let of_step = step.map_or_else(String::new, |step| format!(" in load step {step}, the largest,"));
    answer
        .relative()
        .map_or_else(|| alone.into(), |relative| format!("{named} {}{of_step}", words::rounded_up(relative)))
}

/// The reason why a relative target cannot be met if the bodies hold no strain energy.
const NO_ENERGY: &str = "the bodies hold no strain energy, and a relative target has no meaning here";

fn missed<S: ReportSpace>(adapt: &Adapt, answer: &Course<S>, reason: &str) -> Status {
    let target = short(adapt.target.value());
    if answer.holds_no_energy() {
        return word("target_missed", NOT_CERTIFIED, format!("{NO_ENERGY}; {reason}"));
    }
    word("target_missed", NOT_CERTIFIED, format!("{} > {target}: {reason}", reached(answer)))
}

/// Says how the bound, or the residual, rose on the last three meshes.
fn rose<S: ReportSpace>(answer: &Course<S>) -> String {
    let last = answer.history.get(answer.history.len().saturating_sub(3)..).unwrap_or_default();
    let relative = last.iter().filter_map(|step| step.relative.or(step.relative_residual));
    let relative: Vec<String> = relative.map(words::rounded_up).collect();
    let what = if answer.answer.certified().is_some() { "bound" } else { "residual" };
    format!("the {what} rose on two meshes in a row, {}", relative.join(" < "))
}

/// Says that the next mesh is not held along a motion whose load the polygon of this one explained; `None` for other errors.
fn no_longer_explained<S: ReportSpace>(
    case: &Case<S>,
    answer: &Course<S>,
    error: &SolveError<S>,
) -> Option<String> {
    let error = if let SolveError::LoadStep { error, .. } = error { error } else { error };
    let SolveError::NotHeld { motion } = error else { return None };
    let left_out = &answer.answer.fields().problem.left_out;
    left_out.iter().find(|of| motion.bodies.iter().any(|(partner, _)| *partner == Partner::Body(of.body)))?;
    Some(format!(
        "the load that is left out on mesh {} is more than the error of the polygon of the next mesh, so it turns the body there: {} (load {} in \
         that direction, nothing resists); add a [[body.displacement]] that prevents this motion, or change the load",
        answer.step,
        all_move(case, motion),
        significant(motion.load)
    ))
}

/// Judges a run whose next mesh cannot be solved.
fn failed<S: ReportSpace>(
    case: &Case<S>,
    adapt: &Adapt,
    answer: &Course<S>,
    error: &SolveError<S>,
) -> Status {
    let failure = Failure::solve(case, error);
    let reason = failure.message.unwrap_or_else(|| error.to_string());
    match failure.code {
        LIMIT => word("limit", LIMIT, format!("the next mesh: {reason}")),
        _ if let Some(reason) = no_longer_explained(case, answer, error) => missed(adapt, answer, &reason),
        _ => missed(adapt, answer, &format!("the next mesh cannot be solved: {reason}")),
    }
}

/// Bounds up to this many times the allowance for round-off are round-off of the iteration too.
const NEAR_ROUND_OFF: f64 = 100.0;

/// A target this many times the allowance for round-off can be met.
const ABOVE_FLOOR: f64 = 10.0;

/// Names the target that a run at its round-off can be given.
///
/// * `floor`: the allowance for round-off over the energy norm.
fn attainable<S: ReportSpace>(adapt: &Adapt, answer: &Course<S>, floor: f64) -> String {
    let near = answer.relative().filter(|relative| *relative <= NEAR_ROUND_OFF * floor);
    let least = words::raised(near.unwrap_or(ABOVE_FLOOR * floor), 2);
    if least >= 1.0 {
        return "no target can be met; leave out [adapt], and check the units".into();
    }
    format!("set adapt.{} to {} or more", adapt.target.key(), short(least))
}

/// Judges a run that was not interrupted.
fn of_end<S: ReportSpace>(case: &Case<S>, adapt: &Adapt, answer: &Course<S>) -> Status {
    let meshes = answer.history.len();
    let target = short(adapt.target.value());
    match &answer.end {
        AdaptiveEnd::TargetMet => {
            let met = match adapt.target {
                Target::RelativeError(_) => "converged",
                Target::CoulombResidual(_) => "residual_reached",
            };
            let found = match answer.relative() {
                Some(_) => format!("{} <= {target}", reached(answer)),
                None => format!("{NO_ENERGY}: {} is zero to round-off", reached(answer)),
            };
            word(met, 0, format!("{found} on mesh {meshes}"))
        }
        AdaptiveEnd::MaxSteps => missed(
            adapt,
            answer,
            &format!("all adapt.max_steps = {} meshes are used; raise it", adapt.max_steps),
        ),
        AdaptiveEnd::Rose => missed(adapt, answer, &rose(answer)),
        AdaptiveEnd::MaxNodes => missed(
            adapt,
            answer,
            &format!("adapt.max_nodes = {} is too small for another useful mesh; raise it", adapt.max_nodes),
        ),
        AdaptiveEnd::RoundOff { .. } if answer.holds_no_energy() => {
            stalled(format!("{NO_ENERGY}; leave out [adapt]"))
        }
        AdaptiveEnd::RoundOff { floor } => stalled(format!(
            "the target {target} lies below the attainable floor {floor:.1e}, the round-off of this problem; {}",
            attainable(adapt, answer, *floor)
        )),
        AdaptiveEnd::Iteration(status) => {
            let failed = match status {
                NnddStatus::MaxIterations => "max_iterations",
                NnddStatus::Diverged { .. } => "diverged",
                _ => "stalled",
            };
            word(failed, NOT_CONVERGED, format!("the iteration on mesh {meshes} did not meet its criterion"))
        }
        AdaptiveEnd::FixedPoint(_) => {
            stalled(format!("the fixed point of Coulomb friction on mesh {meshes} did not converge"))
        }
        AdaptiveEnd::IterationError if answer.answer.certified().is_none() => stalled(format!(
            "{} > {target}, and nearly all of it is not the mesh's, so that no finer mesh lowers it; {}",
            reached(answer),
            attainable(adapt, answer, answer.round_off())
        )),
        AdaptiveEnd::IterationError => stalled(format!(
            "{} > {target}, and nearly all of it is the iteration's error, which no finer mesh lowers; {}",
            reached(answer),
            match case.solver.stop.criterion {
                Criterion::Estimator => attainable(adapt, answer, answer.round_off()),
                _ => "use solver.stop.criterion = \"estimator\", or more iterations".into(),
            }
        )),
        AdaptiveEnd::NotCertified { failed } => {
            let names: Vec<String> =
                failed.iter().map(|(name, found)| format!("{name} {found:.1e}")).collect();
            let which = if names.is_empty() { "does not exist".into() } else { names.join(", ") };
            let [name, what] = match answer.answer {
                RunResult::Certified(_) => ["not_certified", "bound"],
                RunResult::Coulomb(_) => ["no_residual", "residual"],
            };
            word(
                name,
                NOT_CERTIFIED,
                format!("the {what} of mesh {meshes} does not pass its checks: {which}"),
            )
        }
        _ => missed(adapt, answer, "the run ended in an unknown way"),
    }
}
