//! The exact solution of an assembly as one iteration.

use crate::error::NnddError;
use crate::exact::{ExactSolution, solve_exactly};
use crate::iterate::{ContactAnswer, Iterate, IterationRow, Programme, Recovery};
use crate::settings::NewtonSettings;
use crate::solution::{NnddSolution, NnddStatus};
use crate::stopping::{Decision, StoppingCriterion};
use contact_qp::{ActiveSet, BoxResiduals, KktResiduals, QpSettings};
use fem_core::geometry::Vector;
use fem_core::norm::from_squared;
use fem_core::prepared::PreparedProblem;

/// Solves the discrete problem exactly.
pub(super) fn solve(
    problem: &PreparedProblem,
    settings: &NewtonSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let found = solve_exactly(problem, &programme_settings(settings))?;
    let last = iterate(found, problem, 1);
    let status = if !last.contact.status.is_solved() {
        NnddStatus::ContactQpUnsolved(last.contact.status)
    } else {
        match stop.check(&last).map_err(NnddError::Criterion)? {
            Decision::Interrupt => NnddStatus::Interrupted,
            // The discrete problem is solved; no iteration follows.
            Decision::Stop | Decision::Continue => NnddStatus::StoppedByCriterion,
        }
    };
    let history = vec![IterationRow::from(&last)];
    let (switch, spectrum, theta, clarabel_calls) = (None, None, 0.0, last.contact.clarabel_calls);
    Ok(NnddSolution { status, switch, history, last, theta, spectrum, clarabel_calls })
}

/// Returns the settings of the programme for those of the Newton method.
pub(super) fn programme_settings(settings: &NewtonSettings) -> QpSettings {
    let NewtonSettings { max_iterations, qp } = settings;
    qp.clone().with_max_iterations((*max_iterations).max(1).min(qp.max_iterations))
}

/// Converts the exact solution into the iterate with the given number. Its `η_NNDD` is the energy of the rounding errors
/// `δ` of the openings, `√(Σ S_ii δ_i²)`.
pub(super) fn iterate(solution: ExactSolution, problem: &PreparedProblem, number: usize) -> Iterate {
    let pairs = problem.problem().contacts.iter().enumerate();
    let (mut lambda, mut normal_trace, mut squared) = (Vec::new(), Vec::new(), 0.0);
    for (k, pair) in pairs {
        let sides = pair.roles.sides();
        // An obstacle has no stiffness of its own.
        let elastic = problem.problem().bodies_of(pair).map(|(side, _)| side);
        let stiffness = row_stiffness(
            problem,
            k,
            elastic.min_by_key(|side| pair.roles.of_side(*side)).unwrap_or_default(),
        );
        for (i, nodes) in pair.interface.pairs().iter().enumerate() {
            let trace = |side: usize| {
                let u: Vector = solution.displacement[pair.bodies[side]][nodes.nodes[side].index()];
                pair.roles.sign() * u.dot(&nodes.normal)
            };
            let [first, second] = sides.map(trace);
            let defect = nodes.gap - (first - second) - solution.opening[k][i];
            squared += stiffness[i] * defect * defect;
            lambda.push(first);
            normal_trace.push(second);
        }
    }
    let force = solution.contact_force.concat();
    let opening = solution.opening.concat();
    Iterate {
        iteration: number,
        lambda,
        reaction: force.iter().map(|p| 0.0 - p).collect(),
        programme: Programme { path: solution.path, iterations: solution.iterations },
        theta: 0.0,
        precision: 0.0,
        eta_nndd: from_squared(squared),
        recovery: Recovery::Forces,
        motions: solution.motions,
        contact: ContactAnswer {
            normal_trace,
            normal_reaction: force,
            active: ActiveSet::new(opening.iter().map(|o| *o == 0.0).collect()),
            status: solution.status,
            path: solution.path,
            iterations: solution.iterations,
            clarabel_calls: solution.clarabel_calls,
            kkt: residuals(&solution.kkt),
        },
        opening,
    }
}

/// Computes `S_ii` of a side of a pair, N/m².
fn row_stiffness(problem: &PreparedProblem, pair: usize, side: usize) -> Vec<f64> {
    let body = problem.problem().contacts[pair].bodies[side];
    let condensed = &problem.bodies()[body];
    let Some(block) = problem.problem().sides_of(body).position(|of| of == (pair, side)) else {
        unreachable!("side {side} of pair {pair} is not one of body {body}")
    };
    let diagonal = |k: u32| condensed.schur()[k as usize * (condensed.len() + 1)];
    let rows = condensed.dofs().rows(block).iter();
    rows.map(|row| row.terms.iter().filter(|t| t.1 != 0.0).map(|(k, a)| a * a * diagonal(*k)).sum()).collect()
}

/// Names the residuals of the programme in the forces by what they are in the contact problem: its bounds are signs of forces
/// there, and its multipliers the openings.
fn residuals(dual: &BoxResiduals) -> KktResiduals {
    KktResiduals {
        stationarity: dual.stationarity.max(dual.rows),
        primal: dual.dual,
        dual: dual.primal,
        complementarity: dual.complementarity,
    }
}
