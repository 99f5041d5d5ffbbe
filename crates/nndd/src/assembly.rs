//! Any number of bodies and pairs, floating bodies among them: the two steps in the rows of all pairs.
//!
//! Each pair has its λ, the trace of the body, or the obstacle, that carries it. A body may carry λ in some pairs and
//! be unilateral in others, so no order or colouring of the bodies is needed. All bodies answer to λ at the same time
//! (step 1) and correct it at the same time (step 2): preconditioned descent on a convex function of λ whose gradient
//! is the imbalance.

mod correction;
mod exact;
mod motions;
mod pass;
mod response;
mod roles;
mod sprung;
mod subdomain;

use crate::balance::Balance;
use crate::error::NnddError;
use crate::exact::refuse_coulomb;
use crate::iteration::{Start, explain, iterate, successor, switch};
use crate::rows::Rows;
use crate::settings::{Method, NnddSettings, Path};
use crate::solution::NnddSolution;
use crate::spectrum;
use crate::stopping::StoppingCriterion;
use correction::Correction;
use fem_core::prepared::PreparedProblem;
use fem_core::try_each_body;
use pass::Assembly;
use subdomain::Subdomain;

pub use roles::stiffer_roles;

/// θ without a spectrum, for weights by stiffness; half of it for the paper's weights, whose update is twice as long.
const FALLBACK: f64 = 0.9;

/// Solves the contact problem of an assembly.
pub(crate) fn solve(
    problem: &PreparedProblem,
    start: Start,
    method: &Method,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    match method {
        Method::Newton(settings) => exact::solve(problem, settings, 1)?.alone(stop),
        Method::Nndd(settings) => iteration(problem, start, settings, stop),
    }
}

/// Iterates, and takes the exact solution if that fails.
fn iteration(
    problem: &PreparedProblem,
    start: Start,
    settings: &NnddSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let contact = problem.problem();
    refuse_coulomb(problem)?;
    if settings.path == Path::Literal && contact.has_friction() {
        return Err(NnddError::LiteralFriction);
    }
    if settings.path == Path::Literal {
        return Err(NnddError::Unsupported { bodies: contact.bodies.len(), pairs: contact.contacts.len() });
    }
    let rows = Rows::new(contact);
    let balance = Balance::new(contact, problem.rigid_motions())?;
    balance.check_held(contact, rows.limits())?;
    let bodies = try_each_body(contact.bodies.len(), |b| Subdomain::new(problem, &rows, b))?;
    let correction = Correction::new(&bodies, rows.len(), settings.weights, settings.coarse);
    let estimate = || spectrum::of_product(rows.len(), |v| correction.operator(v), |j| correction.apply(j));
    let fallback = FALLBACK / correction.scale();
    let (theta, chosen) = spectrum::choose_theta(settings.theta, fallback, estimate);
    let mut assembly = Assembly::new(problem, &rows, &balance, &bodies, &correction, &settings.qp);
    if let Some(active) = &start.active {
        assembly.start_from(active);
    }
    let mut solution = iterate(start.lambda, (settings, theta), stop, |lambda| assembly.pass(lambda))?;
    if let Some(newton) = successor(&solution, settings, stop) {
        let found = exact::solve(problem, newton, solution.history.len() + 1);
        solution = switch(solution, found, stop)?;
    }
    Ok(explain(solution, chosen, estimate, stop))
}
