//! The paper's iteration with its operators: sets the steps up, and iterates.

use crate::balance::Balance;
use crate::correction::Correction;
use crate::error::NnddError;
use crate::exact_iterate;
use crate::iteration::{Start, explain, iterate, successor, switch};
use crate::settings::NnddSettings;
use crate::solution::NnddSolution;
use crate::spectrum;
use crate::steps::Steps;
use crate::stopping::StoppingCriterion;
use crate::subdomain::Subdomain;
use fem_core::contact_system::ContactSystem;
use fem_core::try_each_body;

/// θ without a spectrum, for weights by stiffness; half of it for the paper's weights, whose update is twice as long.
pub(crate) const FALLBACK: f64 = 0.9;

/// Iterates, and takes the exact solution if that fails.
pub(crate) fn iteration(
    (system, balance): (&ContactSystem<'_>, &Balance<'_>),
    start: Start,
    settings: &NnddSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let rows = &system.rows;
    let bodies = try_each_body(system.bodies.len(), |b| Subdomain::new(system, b))?;
    let correction = Correction::new(&bodies, rows.len(), settings.weights, settings.coarse);
    let estimate = || spectrum::of_product(rows.len(), |v| correction.operator(v), |j| correction.apply(j));
    let fallback = FALLBACK / correction.scale();
    let (theta, chosen) = spectrum::choose_theta(settings.theta, fallback, estimate);
    let mut steps = Steps::new(system, balance, (&bodies, &correction), &settings.qp);
    if let Some(active) = &start.active {
        steps.start_from(active);
    }
    let mut solution = iterate(start.lambda, &mut steps, (settings, theta), stop)?;
    if let Some(newton) = successor(&solution, settings, stop) {
        let found = exact_iterate::solve(system, newton, solution.history.len() + 1);
        solution = switch(solution, found, stop)?;
    }
    Ok(explain(solution, chosen, estimate, stop))
}
