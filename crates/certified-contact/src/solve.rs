//! The way from a problem to a certified answer.

use crate::bounds::Bounds;
use crate::error::SolveError;
use crate::history::Row;
use crate::observer::{Observer, Phase};
use crate::results;
use crate::settings::{Imposed, Settings};
use crate::solution::{CertifiedSolution, RoleReason, Roles};
use crate::stopping::Follow;
use fem_core::assembly::System;
use fem_core::condensation::CondensedBody;
use fem_core::dof::DofMap;
use fem_core::interface::ContactProblem;
use nndd::Start;

/// Solves a contact problem and certifies the answer.
///
/// * `problem`: bodies in the user's order; the settings choose which of them carries λ.
///
/// # Errors
/// A body without unique solution, or settings that make no sense. Not converging is a status in
/// `nndd.status`, with the certificate of what was reached.
pub fn solve(
    problem: ContactProblem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<CertifiedSolution, SolveError> {
    let bodies = condense(&problem, observer)?;
    let (swapped, reason) = choose_roles(&problem, &bodies, settings.imposed);
    let (problem, bodies) = if swapped {
        let [first, second] = bodies;
        (problem.swapped(), [second.reversed(), first.reversed()])
    } else {
        (problem, bodies)
    };
    let points = problem.bodies[0].mesh().points();
    let pairs = problem.interface.pairs().iter();
    let lambda = pairs.map(|p| settings.lambda.at(points[p.nodes[0] as usize])).collect();
    let start = Start { lambda, active: None };
    iterate(problem, &bodies, Roles { swapped, reason }, start, settings, observer)
}

/// Solves a finer problem, in the roles that the coarser one had, from what was found there.
pub(crate) fn solve_again(
    problem: ContactProblem,
    roles: Roles,
    start: Start,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<CertifiedSolution, SolveError> {
    let given = |b: usize| if roles.swapped { 1 - b } else { b };
    let bodies = condense(&problem, observer).map_err(|error| match error {
        SolveError::Assembly { body, source } => SolveError::Assembly { body: given(body), source },
        SolveError::Factor { body, source } => SolveError::Factor { body: given(body), source },
        other => other,
    })?;
    iterate(problem, &bodies, roles, start, settings, observer)
}

/// Iterates, certifies the last iterate, and reads off the results; everything in the roles of the iteration.
fn iterate(
    problem: ContactProblem,
    bodies: &[CondensedBody; 2],
    roles: Roles,
    start: Start,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<CertifiedSolution, SolveError> {
    observer.phase(Phase::Iterations);
    let mut follow = Follow::new(&problem, bodies, settings, observer);
    let nndd = nndd::solve_from(&problem, bodies, start, &settings.nndd, &mut follow)?;
    let last = &nndd.last;
    if follow.rows.last().is_none_or(|row| row.iteration.iteration != last.iteration) {
        // An iteration whose contact problem was not solved has not passed the criterion.
        follow.rows.push(Row { iteration: last.into(), eta_dis: None, e_cre: None });
    }
    // A diverged iteration may have run out of finite numbers: then there is no certificate, but a report.
    // One that must end at once has the certificate that it has.
    let certified = follow.may_estimate(last) && follow.try_estimate(last).unwrap_or(false);
    let rows = std::mem::take(&mut follow.rows);
    let no_estimate = follow.no_estimate.take().filter(|_| !certified);
    let estimate = follow.latest.take().filter(|_| certified).map(|(_, estimate)| estimate);
    let swapped = roles.swapped;
    let results =
        estimate.as_ref().map(|e| results::results(&problem, swapped, last, &e.pair, e.energy_norm_squared));
    let bounds = estimate.as_ref().map(|e| Bounds::new(&problem, bodies, last, e));
    let given = |b: usize| if swapped { 1 - b } else { b };
    let unknowns = [0, 1].map(|b| bodies[given(b)].dofs().len());
    let role_reason = roles.reason;
    Ok(CertifiedSolution {
        swapped,
        role_reason,
        nndd,
        rows,
        estimate,
        no_estimate,
        bounds,
        results,
        unknowns,
        problem,
    })
}

/// Assembles and factorises both bodies, each at the same time as the other.
fn condense(problem: &ContactProblem, observer: &mut dyn Observer) -> Result<[CondensedBody; 2], SolveError> {
    let sides = problem.interface.sides();
    observer.phase(Phase::Factorisation);
    let order = |b: usize| DofMap::new(&problem.bodies[b], &sides[b]);
    let (first, second) = rayon::join(|| order(0), || order(1));
    go_on(observer)?;
    observer.phase(Phase::Assembly);
    let assemble = |b: usize, dofs: DofMap| {
        System::with_dofs(&problem.bodies[b], dofs).map_err(|source| SolveError::Assembly { body: b, source })
    };
    let (first, second) = rayon::join(|| assemble(0, first), || assemble(1, second));
    let (first, second) = (first?, second?);
    go_on(observer)?;
    observer.phase(Phase::Factorisation);
    let factorise = |b: usize, system: System| {
        CondensedBody::factorise(system, problem.bodies[b].mesh().points())
            .map_err(|source| SolveError::Factor { body: b, source })
    };
    let (first, second) = rayon::join(|| factorise(0, first), || factorise(1, second));
    let bodies = [first?, second?];
    go_on(observer)?;
    Ok(bodies)
}

/// Asks the observer whether the run may continue.
fn go_on(observer: &mut dyn Observer) -> Result<(), SolveError> {
    if observer.must_stop() { Err(SolveError::Stopped) } else { Ok(()) }
}

/// Decides whether the bodies exchange their roles.
fn choose_roles(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    imposed: Imposed,
) -> (bool, RoleReason) {
    match imposed {
        Imposed::First => (false, RoleReason::Given),
        Imposed::Second => (true, RoleReason::Given),
        Imposed::Auto => {
            let force: Vec<f64> = problem.interface.pairs().iter().map(|p| p.tributary_length).collect();
            let compliance = [0, 1].map(|b: usize| {
                let mut w = vec![0.0; force.len()];
                bodies[b].trace_from_force(&force, &mut w);
                w.iter().zip(&force).map(|(w, f)| w * f).sum::<f64>()
            });
            (compliance[1] < compliance[0], RoleReason::Stiffer { compliance })
        }
    }
}
