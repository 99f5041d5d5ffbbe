//! The status word, exit status and reason of a run.

use crate::failure::{FILES, INTERRUPTED, LIMIT, NOT_CERTIFIED};
use crate::motion::all_move;
use crate::solved::RunResult;
use crate::words::{components, counted, one_line, raised, short, with_digits};
use case_io::Case;
use case_io::case::{Acceleration, Criterion, Dimension, Imposed, QpChoice, Theta, Weights};
use case_io::diagnostic::significant;
use case_io::report::Status;
use certified_contact::{CertifiedSolution, ContactSpace, CoulombResult, IterationRecord, Reaction, Results};
use contact_qp::QpStatus;
use cre_estimator::{Estimate, EstimatorError};
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::ContactProblem;
use nndd::{CoulombSolution, CoulombStatus, NnddStatus};

/// The exit status of a run that did not converge.
pub const NOT_CONVERGED: u8 = 5;

/// Why a run was ended from outside the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    /// By a signal with this exit status.
    Signal(u8),
    /// By the time limit, in seconds, with the name of the longest step between two checks of the clock.
    TimeLimit(f64, &'static str),
    /// Because the output directory was removed.
    OutputGone,
}

/// Judges a finished run.
fn judge<S: ContactSpace + Dimension>(
    case: &Case<S>,
    solution: &CertifiedSolution<S>,
    ended: Option<Ended>,
) -> Status {
    if let Some(lack @ EstimatorError::OutOfMemory { .. }) = &solution.no_estimate {
        return word("limit", LIMIT, format!("{lack}; take fewer cells"));
    }
    let status = of_iteration(case, solution, ended);
    if status.code == 0 && !solution.is_certified() {
        return word("not_certified", NOT_CERTIFIED, uncertified(solution));
    }
    status
}

/// Judges a finished run with any law.
pub(crate) fn judge_answer<S: ContactSpace + Dimension>(
    case: &Case<S>,
    answer: &RunResult<S>,
    ended: Option<Ended>,
) -> Status {
    match answer {
        RunResult::Certified(solution) => judge(case, solution, ended),
        RunResult::Coulomb(result) => judge_coulomb(case, result, ended),
    }
}

fn judge_coulomb<S: ContactSpace + Dimension>(
    case: &Case<S>,
    result: &CoulombResult<S>,
    ended: Option<Ended>,
) -> Status {
    let CoulombSolution { status, steps, changes, .. } = &result.solution;
    let counted = counted(*steps, "step");
    let tolerance = short(case.solver.friction_tolerance);
    let change = changes.last().map_or_else(String::new, |change| format!(", its last change {change:.1e}"));
    match status {
        CoulombStatus::Converged if result.residual().is_none() => {
            let reason = failed_checks(
                (&result.problem, Some(&result.results)),
                result.estimate(),
                "the residual would mean nothing",
            );
            word("no_residual", NOT_CERTIFIED, reason)
        }
        CoulombStatus::Converged => word(
            "converged",
            0,
            match changes.last() {
                Some(change) => format!(
                    "one solution found: the friction limit changed by {change:.1e} <= {tolerance} of itself in step {steps}"
                ),
                None => "one solution found: the friction limit did not change".to_owned(),
            },
        ),
        CoulombStatus::MaxSteps => word(
            "max_iterations",
            NOT_CONVERGED,
            format!(
                "the friction limit did not converge to {tolerance} in {counted}{change}; raise solver.friction_steps, or \
                 lower mu"
            ),
        ),
        CoulombStatus::Interrupted => interrupted(ended, &counted),
        CoulombStatus::TooSmall => stalled(not_enough_friction(case, result, &counted)),
        _ => stalled(format!(
            "the problem of step {steps} with a given friction limit was not solved: {}; try another solver.qp",
            result.solution.exact.status
        )),
    }
}

/// Says which load friction does not hold with the pressures that were found.
fn not_enough_friction<S: ContactSpace + Dimension>(
    case: &Case<S>,
    result: &CoulombResult<S>,
    counted: &str,
) -> String {
    let moves = result.unresisted().map_or_else(String::new, |motion| {
        let (moves, load) = (all_move(case, &motion), significant(motion.load));
        format!(": {moves} (load {load} in that direction is left)")
    });
    format!(
        "friction is too small to hold the bodies with the pressures found in {counted}{moves}; whether other pressures hold them is not \
         known: raise mu, hold the bodies, or change the loads"
    )
}

/// Names the checks that fail, and what helps.
fn uncertified<S: ContactSpace + Dimension>(solution: &CertifiedSolution<S>) -> String {
    let Some(estimate) = &solution.estimate else {
        return "no certificate could be computed; check the units of the data, which are too large or too small".into();
    };
    failed_checks((&solution.problem, solution.results.as_ref()), estimate, "the bound would not be valid")
}

/// Names the checks of an estimate that fail, and what helps.
fn failed_checks<S: ContactSpace + Dimension>(
    found: (&ContactProblem<S>, Option<&Results<S>>),
    estimate: &Estimate<S>,
    so: &str,
) -> String {
    let failed: Vec<_> = estimate.admissibility.failed().collect();
    let pin = loaded_node(found);
    // A violated balance explains the other failed checks, so it is named first.
    let first = failed.iter().find(|(name, _)| *name == "rigid_balance").or(failed.first());
    let fix = match first {
        Some(("supports", ..)) => {
            "a roller on a curved side is violated between its nodes: impose ux and uy on it, or hold \
             it where it is straight"
        }
        Some(("rigid_balance", ..)) => {
            "no contact pressure on these nodes keeps a body in balance that only contact holds, or keeps the given force in a cut: its load \
             acts near the end of the contact; use a finer mesh there"
        }
        Some(("rotation", ..)) => {
            "a body that only contact or springs hold turns so far that small displacements are no longer a fair assumption: \
             hold it, or lower the loads"
        }
        _ if failed.iter().any(|(name, _)| *name == "boundary_traction") && pin.is_some() => {
            pin.as_deref().unwrap_or("")
        }
        Some(("equilibrium" | "traction_jump" | "boundary_traction", ..)) => {
            "round-off is too large for these materials and cells: make the moduli more alike, the cells less thin, or lower \
             Poisson's ratio to 0.49"
        }
        _ => "check the units of gap, displacements and loads: they are too far apart in size",
    };
    let names: Vec<String> = failed.iter().map(|(name, found)| format!("{name} ({found:.1e})")).collect();
    let (checks, verb) = if names.len() == 1 { ("check", "fails") } else { ("checks", "fail") };
    format!("the {checks} {} {verb} by more than round-off, so {so}; {fix}", names.join(", "))
}

/// Says which support on a single node carries the largest force; `None` if there is no such support.
fn loaded_node<S: ContactSpace + Dimension>(
    (problem, results): (&ContactProblem<S>, Option<&Results<S>>),
) -> Option<String> {
    let reactions = &results?.reactions;
    let on_node = |reaction: &&Reaction<S>| {
        let supports = problem.bodies[reaction.body].supports();
        supports.iter().any(|set| set.group == reaction.on && set.nodes.len() == 1)
    };
    let size = |reaction: &Reaction<S>| norm(reaction.force);
    let most = reactions.iter().filter(on_node).max_by(|a, b| size(a).total_cmp(&size(b)))?;
    (size(most) > 0.0).then(|| {
        format!(
            "the support \"{}\" on a single node carries the force {}, which a point of an elastic body cannot: hold a \
             side with {}, or let the loads balance",
            one_line(&most.on),
            components(most.force.entries(), |x| with_digits(x, 3)),
            S::WORDS.facets
        )
    })
}

/// Makes a status.
pub(crate) fn word(word: &str, code: u8, reason: impl Into<String>) -> Status {
    Status { word: word.into(), code, reason: reason.into() }
}

/// The status of an iteration that no longer makes progress.
pub(crate) fn stalled(reason: impl Into<String>) -> Status {
    word("stalled", NOT_CONVERGED, reason)
}

fn of_iteration<S: Dimension>(
    case: &Case<S>,
    solution: &CertifiedSolution<S>,
    ended: Option<Ended>,
) -> Status {
    let iterations = solution.rows.len();
    let counted = match case.solver.max_iterations {
        0 => "1 iteration (the minimum)".to_owned(),
        _ => counted(iterations, "iteration"),
    };
    match solution.nndd.status {
        NnddStatus::StoppedByCriterion => word("converged", 0, met(case, solution)),
        NnddStatus::MaxIterations if case.solver.stop.criterion == Criterion::Iterations => word(
            "completed",
            0,
            match case.solver.max_iterations {
                0 => counted,
                _ => format!("{counted}, as asked for"),
            },
        ),
        NnddStatus::Stalled { floor, at_round_off }
            if case.solver.stop.criterion == Criterion::Iterations =>
        {
            let end = if at_round_off { "at its round-off floor" } else { "no longer falling" };
            word("completed", 0, format!("{counted}, then eta_nndd was {end}, {floor:.3e} at best"))
        }
        NnddStatus::MaxIterations => {
            word("max_iterations", NOT_CONVERGED, too_many(case, solution, &counted))
        }
        NnddStatus::Diverged { best, .. } => word("diverged", NOT_CONVERGED, diverged(case, solution, best)),
        NnddStatus::Stalled { floor, at_round_off: true } => stalled(format!(
            "eta_nndd has reached its round-off floor {floor:.3e}, and {} is not met: {}",
            criterion(case, solution),
            attainable(case, solution, floor)
        )),
        NnddStatus::Stalled { floor, at_round_off: false } => stalled(format!(
            "eta_nndd fell by less than 10 % in 60 iterations, to {floor:.3e} at best{}",
            match theta_too_small(case, solution) {
                Some(advice) => format!("; {advice}"),
                None => format!("{}; {}", range_of_theta(case, solution), other_settings(case)),
            }
        )),
        NnddStatus::BalanceError { eta_nndd } => stalled(format!(
            "the discrete problem is solved, but pressures in balance on the meshed outline differ from its forces by eta_nndd = \
                 {eta_nndd:.3e}: refine the meshes, or {}",
            attainable(case, solution, eta_nndd)
        )),
        NnddStatus::ContactQpUnsolved(status) => stalled(unsolved(case, solution, status)),
        NnddStatus::Interrupted => interrupted(ended, &format!("iteration {iterations}")),
        _ => stalled("the iteration ended in an unknown way"),
    }
}

/// Says that all iterations were used, and what helps.
fn too_many<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>, counted: &str) -> String {
    let advice = theta_too_small(case, solution);
    let advice =
        advice.unwrap_or_else(|| format!("raise solver.max_iterations, or {}", other_settings(case)));
    format!("{} not met after {counted}; {advice}", criterion(case, solution))
}

/// A given θ this many times smaller than the best one is too small: it needs more than this many iterations.
const TOO_SMALL: f64 = 1e4;

/// Says that a given θ is too small, if that is known.
fn theta_too_small<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>) -> Option<String> {
    let Theta::Value(theta) = case.solver.theta else { return None };
    let best = solution.nndd.spectrum?.best_theta();
    (TOO_SMALL * theta < best).then(|| {
        format!(
            "theta = {} is too small: in full contact theta is best near {}; use it, or theta = \"auto\"",
            short(theta),
            significant(best)
        )
    })
}

/// Names the settings that the case does not have and with which the iteration converges more surely.
fn other_settings<S: Dimension>(case: &Case<S>) -> String {
    let solver = &case.solver;
    let others = [
        (solver.theta != Theta::Auto, "theta = \"auto\""),
        (solver.weights != Weights::Stiffness, "weights = \"stiffness\""),
        (solver.acceleration != Acceleration::Anderson, "acceleration = \"anderson\""),
        (solver.imposed != Imposed::Auto, "imposed = \"auto\""),
    ];
    let others: Vec<&str> =
        others.into_iter().filter_map(|(differs, setting)| differs.then_some(setting)).collect();
    match others.as_slice() {
        [] => "use method = \"newton\"".into(),
        _ => format!("use {}, or method = \"newton\"", others.join(", ")),
    }
}

/// By this factor the round-off of another run may be larger.
const OF_ANOTHER_RUN: f64 = 2.0;

/// Says which value the criterion can be set to, when the iteration has reached its round-off.
fn attainable<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>, floor: f64) -> String {
    let stop = &case.solver.stop;
    let smallest =
        |of: fn(&IterationRecord) -> f64| solution.rows.iter().map(of).fold(f64::INFINITY, f64::min);
    let first = solution.rows.first().map_or(f64::NAN, |row| row.iteration.eta_nndd);
    let mesh = solution.estimate.as_ref().map_or(f64::NAN, |e| e.unchecked().eta_dis);
    let (key, least) = match stop.criterion {
        // Rounding of the answer counts in this criterion.
        Criterion::Estimator => ("solver.stop.ratio", floor.max(solution.last().eta_nndd) / mesh),
        Criterion::Precision => ("solver.stop.tolerance", smallest(|row| row.iteration.precision)),
        Criterion::EtaNndd => ("solver.stop.tolerance", floor / first),
        Criterion::Iterations => return "lower solver.max_iterations".into(),
    };
    if !least.is_finite() {
        return "use criterion = \"iterations\"".into();
    }
    format!("set {key} to {} or more", short(raised(OF_ANOTHER_RUN * least, 2)))
}

/// Says which contact problem was not solved, and what may help.
fn unsolved<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>, status: QpStatus) -> String {
    let solver = &case.solver;
    let newton = matches!(solution.method, nndd::Method::Newton(_));
    let what = if newton {
        "the programme of all contact forces".into()
    } else {
        format!("the contact problem of iteration {}", solution.rows.len())
    };
    let advice = match (newton, status, solver.qp) {
        (true, QpStatus::MaxIterations, _) => "raise solver.max_iterations",
        // It tries both, whatever solver.qp is.
        _ if newton => {
            "active sets and Clarabel have been tried: use other mesh sizes, end one of two contact sides that share nodes an edge earlier, or \
             move a load that lies next to the edge of what the contact sides can balance"
        }
        (.., QpChoice::ActiveSet) => "try solver.qp = \"clarabel\"",
        _ => "try solver.qp = \"active-set\"",
    };
    format!("{what} was not solved: {status}; {advice}")
}

/// Says what ended a run from outside, and after what.
pub(crate) fn interrupted(ended: Option<Ended>, after: &str) -> Status {
    match ended {
        Some(Ended::Signal(code)) => word("interrupted", code, format!("by a signal after {after}")),
        Some(Ended::TimeLimit(seconds, step)) => word(
            "limit",
            LIMIT,
            format!(
                "limits.time = {seconds} s reached after {after}; the longest step between two checks of the clock was {step}"
            ),
        ),
        Some(Ended::OutputGone) => {
            word("interrupted", FILES, format!("the output directory was removed after {after}"))
        }
        None => word("interrupted", INTERRUPTED, format!("after {after}")),
    }
}

/// Tells whether a run was ended from outside, so that it can be resumed.
pub(crate) fn may_go_on(status: &Status) -> bool {
    ["interrupted", "limit"].contains(&status.word.as_str())
}

/// Says what ended a converged iteration.
fn met<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>) -> String {
    let by_estimate = case.solver.stop.criterion == Criterion::Estimator;
    match &solution.estimate {
        Some(e)
            if by_estimate && solution.last().eta_nndd > case.solver.stop.ratio * e.unchecked().eta_dis =>
        {
            "eta_dis and eta_nndd are round-off".into()
        }
        _ => criterion(case, solution),
    }
}

fn criterion<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>) -> String {
    if matches!(solution.method, nndd::Method::Newton(_)) {
        return "exact solution of the discrete problem".into();
    }
    let stop = &case.solver.stop;
    match stop.criterion {
        Criterion::Estimator => {
            let forces = stop
                .force_balance
                .map(|part| format!(" and contact forces equal to {} %", short(100.0 * part)));
            format!("eta_nndd <= {} eta_dis{}", short(stop.ratio), forces.unwrap_or_default())
        }
        Criterion::Precision => format!("precision <= {:e}", stop.tolerance),
        Criterion::EtaNndd => format!("eta_nndd <= {:e} eta_nndd(1)", stop.tolerance),
        Criterion::Iterations => "the number of iterations".into(),
    }
}

/// Says which θ converges, if that is known.
fn range_of_theta<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>) -> String {
    solution.nndd.spectrum.map_or_else(String::new, |spectrum| {
        format!(
            " with theta = {}; in full contact theta converges between 0 and {} and is best near {}",
            match case.solver.theta {
                Theta::Value(theta) => short(theta),
                Theta::Auto => significant(solution.nndd.theta),
            },
            significant(spectrum.theta_limit()),
            significant(spectrum.best_theta())
        )
    })
}

/// Numbers that differ by less than this part differ by rounding.
const ROUNDING: f64 = 1e-9;

fn diverged<S: Dimension>(case: &Case<S>, solution: &CertifiedSolution<S>, best: f64) -> String {
    if !best.is_finite() {
        return "eta_nndd overflowed in the first iteration: the loads or displacements are too large for \
                these moduli; check the units"
            .into();
    }
    let eta = solution.last().eta_nndd;
    let range = range_of_theta(case, solution);
    let advice = other_settings(case);
    // The last one contains the allowance for its rounding.
    if eta <= (1.0 + ROUNDING) * best {
        let iterations = solution.rows.len();
        return format!(
            "lambda overflowed after iteration {iterations}, eta_nndd {eta:.3e}{range}; {advice}"
        );
    }
    let eta = if eta.is_finite() { format!("to {eta:.3e}") } else { "until it overflowed".into() };
    format!("eta_nndd grew from {best:.3e} {eta}{range}; {advice}")
}

#[cfg(test)]
mod tests;
