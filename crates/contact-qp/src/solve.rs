//! The choice of method: warm start, active-set steps, Clarabel.

use crate::active_set::ActiveSet;
use crate::cholesky::Factor;
use crate::error::QpError;
use crate::interior_point;
use crate::kkt::{CheckedMatrix, KktResiduals};
use crate::polish::{Admissible, Prepared};
use crate::primal_dual::{self, OnCycle, Outcome};
use crate::problem::BoundQp;
use crate::reduce;
use crate::settings::{QpMethod, QpSettings};
use crate::solution::{QpPath, QpSolution, QpStatus};

/// Solves `min ½ xᵀP x + qᵀx` subject to `x_i ≥ l_i`, exactly on its active set.
///
/// `warm_start` is a guess of the active set (one flag per bound), typically that of a similar problem. It
/// is always checked: if its KKT conditions hold it *is* the solution, found with one linear solve.
/// Otherwise [`QpMethod`] selects the method.
///
/// Only the block of `P` that belongs to the free unknowns is factorised. The solution is unique and global
/// provided `P` is positive definite, or at least positive semi-definite.
///
/// If a bound is only just reached (`x_i = l_i` and `r_i = 0` to round-off) the active set is not unique; such a
/// bound is usually reported active.
///
/// # Errors
/// - those of [`BoundQp::check`], before anything is solved;
/// - [`QpError::Length`] for a warm start of the wrong length, [`QpError::Setting`] for a setting out of range;
/// - [`QpError::NotPositiveDefinite`] when `P` is not positive definite on the free unknowns;
/// - [`QpError::Library`] when Clarabel rejects data that passed the checks.
///
/// No convergence is a [`QpStatus`], not an error.
pub fn solve(
    qp: &BoundQp<'_>,
    warm_start: Option<&ActiveSet>,
    settings: &QpSettings,
) -> Result<QpSolution, QpError> {
    let matrix = CheckedMatrix::new(qp.matrix)?;
    solve_with(&matrix, qp.linear, qp.bounded, qp.lower, warm_start, settings)
}

/// [`solve`] with a matrix that has been checked: for many programmes with different vectors.
///
/// * `linear`, `bounded`, `lower`: as in [`BoundQp`].
///
/// # Errors
/// Those of [`solve`] that do not concern the matrix's entries.
pub fn solve_with(
    matrix: &CheckedMatrix<'_>,
    linear: &[f64],
    bounded: &[usize],
    lower: &[f64],
    warm_start: Option<&ActiveSet>,
    settings: &QpSettings,
) -> Result<QpSolution, QpError> {
    settings.check()?;
    let problem = Prepared::new(matrix, linear, bounded, lower)?;
    if let Some(set) = warm_start.filter(|set| set.len() != problem.bounds()) {
        return Err(QpError::Length { what: "warm_start", expected: problem.bounds(), found: set.len() });
    }
    if linear.is_empty() {
        return Ok(nothing_to_solve());
    }
    if let Some(start) = starting_set(&problem, warm_start, settings.method) {
        let (outcome, steps) = primal_dual::run(&problem, start, settings.step_limit(), OnCycle::Stop);
        if let Outcome::Found(answer) = outcome {
            let kkt = answer.residuals(&problem);
            if kkt.max() <= settings.kkt_tolerance {
                let path =
                    if steps == 1 && warm_start.is_some() { QpPath::WarmStart } else { QpPath::ActiveSet };
                return Ok(solution(answer, kkt, QpStatus::Solved, path, steps));
            }
        }
    }
    solve_with_clarabel(&problem, settings)
}

/// Returns the initial set of the active-set steps; `None` if the method begins with Clarabel.
fn starting_set(
    problem: &Prepared<'_>,
    warm_start: Option<&ActiveSet>,
    method: QpMethod,
) -> Option<ActiveSet> {
    match (method, warm_start) {
        (QpMethod::Clarabel, _) => None,
        (_, Some(set)) => Some(set.clone()),
        // Without bounds there is only one set, and a linear system needs no interior-point method.
        (QpMethod::Auto, None) => (problem.bounds() == 0).then(ActiveSet::default),
        // The first step gives the unconstrained minimiser, the second set is that of the bounds it violates.
        (QpMethod::ActiveSet, None) => Some(ActiveSet::none(problem.bounds())),
    }
}

/// Calls Clarabel and polishes its last iterate, however the call ended: the KKT residuals decide, not Clarabel's
/// status. A large programme is shrunk first, and solved whole if that does not lead to the solution.
fn solve_with_clarabel(problem: &Prepared<'_>, settings: &QpSettings) -> Result<QpSolution, QpError> {
    let (mut calls, mut iterations) = (0, 0);
    if let Some(guess) = reduce::guess(problem, settings)? {
        (calls, iterations) = (1, guess.iterations);
        let (outcome, steps) = primal_dual::run(problem, guess.active, settings.step_limit(), OnCycle::Stop);
        if let Outcome::Found(answer) = outcome {
            let kkt = answer.residuals(problem);
            if kkt.max() <= settings.kkt_tolerance {
                let mut solution = solution(answer, kkt, QpStatus::Solved, QpPath::Clarabel, iterations);
                (solution.polish_steps, solution.clarabel_calls) = (steps, calls);
                return Ok(solution);
            }
        }
    }
    let found = interior_point::solve(problem, settings)?;
    (calls, iterations) = (calls + 1, iterations + found.iterations);
    let report = |answer: Admissible, status: QpStatus, steps: usize| {
        let kkt = answer.residuals(problem);
        let mut solution = solution(answer, kkt, status, QpPath::Clarabel, iterations);
        (solution.polish_steps, solution.clarabel_calls) = (steps, calls);
        solution
    };
    // x is unconstrained: there is no active set to find.
    if found.status == QpStatus::Unbounded {
        return Ok(report(found.iterate, found.status, 0));
    }
    diagnose(problem, found.status)?;
    let on_cycle = OnCycle::SinglePivots { slack: settings.kkt_tolerance };
    let (outcome, steps) =
        primal_dual::run(problem, found.iterate.active.clone(), settings.max_iterations, on_cycle);
    match outcome {
        Outcome::Found(answer) if answer.residuals(problem).max() <= settings.kkt_tolerance => {
            return Ok(report(answer, QpStatus::Solved, steps));
        }
        Outcome::Singular(error) if found.status.is_solved() => return Err(error),
        _ => {}
    }
    let status = if found.status.is_solved() { QpStatus::PolishFailed } else { found.status };
    Ok(report(found.iterate, status, steps))
}

/// Distinguishes an indefinite matrix, on which Clarabel stalls at an arbitrary point, from a hard problem.
fn diagnose(problem: &Prepared<'_>, status: QpStatus) -> Result<(), QpError> {
    let stalled =
        matches!(status, QpStatus::AlmostSolved | QpStatus::InsufficientProgress | QpStatus::NumericalError);
    if stalled {
        let all: Vec<usize> = (0..problem.qp.linear.len()).collect();
        Factor::of_block(&problem.qp.matrix, &all)?;
    }
    Ok(())
}

fn solution(
    answer: Admissible,
    kkt: KktResiduals,
    status: QpStatus,
    path: QpPath,
    iterations: usize,
) -> QpSolution {
    QpSolution {
        x: answer.x,
        multipliers: answer.multipliers,
        active: answer.active,
        status,
        path,
        iterations,
        polish_steps: 0,
        clarabel_calls: 0,
        kkt,
    }
}

fn nothing_to_solve() -> QpSolution {
    let answer = Admissible { x: Vec::new(), multipliers: Vec::new(), active: ActiveSet::default() };
    solution(answer, KktResiduals::default(), QpStatus::Solved, QpPath::ActiveSet, 0)
}
