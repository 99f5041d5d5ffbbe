//! The algorithm of the paper, for any number of bodies, and the method that takes over if it fails.

use crate::acceleration::Accelerator;
use crate::active_set::ActiveSet;
use crate::error::NnddError;
use crate::iterate::{Iterate, IterationRow};
use crate::monitor::Monitor;
use crate::settings::{Acceleration, NewtonSettings, NnddSettings};
use crate::solution::{NnddSolution, NnddStatus, Switch};
use crate::spectrum::Spectrum;
use crate::steps::Steps;
use crate::stopping::{Decision, StoppingCriterion};
use contact_qp::QpStatus;

/// The initial values of an iteration.
#[derive(Clone, Debug)]
pub struct Start {
    /// The normal trace λ of each Ω₁ at its pairs of nodes, pair after pair, m; with friction each pair's tangential traces follow its
    /// normal ones.
    pub lambda: Vec<f64>,
    /// The active set of the contact problem of each Ω₂, if one is known, in the same order: it is tried before Clarabel.
    pub active: Option<ActiveSet>,
}

/// Iterates until the criterion is met, no progress is possible, or all iterations are used.
///
/// * `theta`: θ of the first update.
pub(crate) fn iterate(
    mut lambda: Vec<f64>,
    steps: &mut Steps<'_>,
    (settings, theta): (&NnddSettings, f64),
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let mut update = Accelerator::new(settings.acceleration, theta);
    let mut monitor = Monitor::default();
    let (mut history, mut clarabel_calls) = (Vec::new(), 0);
    loop {
        // Step 1: λ imposed on each Ω₁ (8), unilateral contact of each Ω₂ (9).
        let answers = steps.step_1(lambda)?;
        // Step 2: the Neumann problems (10), (11) under the imbalance r¹ + r².
        let direction = steps.step_2(&answers);
        // The indicator η_NNDD (22).
        let eta_nndd = steps.eta_nndd(&answers)?;
        // The update: λ ← λ + θ (w¹ − w²)·n.
        let next = update.step(&answers.lambda, direction, eta_nndd);
        // The iterate with its precision ε_t (24).
        let number = history.len() + 1;
        let last = Iterate { iteration: number, theta: next.theta, ..steps.iterate_of(eta_nndd, answers) };
        clarabel_calls += last.contact.clarabel_calls;
        history.push(IterationRow::from(&last));
        // Stop, or give up?
        let plain = settings.acceleration == Acceleration::None;
        let mut status = verdict(&last, settings.max_iterations, stop, |eta| monitor.judge(eta, plain))?;
        lambda = if status.is_none() { next.lambda } else { Vec::new() };
        if lambda.iter().any(|x| !x.is_finite()) {
            status = Some(NnddStatus::Diverged { best: monitor.smallest(), theta_limit: None });
        }
        if let Some(status) = status {
            let (switch, spectrum) = (None, None);
            return Ok(NnddSolution { status, switch, history, last, theta, spectrum, clarabel_calls });
        }
    }
}

/// Tells whether and how the iteration ends with this iterate.
///
/// * `judge`: of its η_NNDD, if the criterion is not met.
pub(crate) fn verdict(
    iterate: &Iterate,
    max_iterations: usize,
    stop: &mut dyn StoppingCriterion,
    judge: impl FnOnce(f64) -> Option<NnddStatus>,
) -> Result<Option<NnddStatus>, NnddError> {
    if !iterate.contact.status.is_solved() {
        return Ok(Some(NnddStatus::ContactQpUnsolved(iterate.contact.status)));
    }
    Ok(match stop.check(iterate).map_err(NnddError::Criterion)? {
        Decision::Stop => Some(NnddStatus::StoppedByCriterion),
        Decision::Interrupt => Some(NnddStatus::Interrupted),
        Decision::Continue if iterate.iteration >= max_iterations => Some(NnddStatus::MaxIterations),
        Decision::Continue => judge(iterate.eta_nndd),
    })
}

/// The solution of the discrete problem by another method than the iteration.
pub(crate) struct Exact {
    pub(crate) iterate: Iterate,
    /// Status of the method, or of the contact problem after it.
    pub(crate) status: QpStatus,
    pub(crate) clarabel_calls: usize,
}

impl Exact {
    /// Returns it as the only iterate of a solution.
    pub(crate) fn alone(self, stop: &mut dyn StoppingCriterion) -> Result<NnddSolution, NnddError> {
        let Self { iterate: last, status, clarabel_calls } = self;
        let status = if !status.is_solved() {
            NnddStatus::ContactQpUnsolved(status)
        } else {
            match stop.check(&last).map_err(NnddError::Criterion)? {
                Decision::Interrupt => NnddStatus::Interrupted,
                // The discrete problem is solved; no iteration follows.
                Decision::Stop | Decision::Continue => NnddStatus::StoppedByCriterion,
            }
        };
        let history = vec![IterationRow::from(&last)];
        let (switch, spectrum, theta) = (None, None, 0.0);
        Ok(NnddSolution { status, switch, history, last, theta, spectrum, clarabel_calls })
    }
}

/// Returns the settings of the method that takes over, if the iteration failed and one is wanted.
pub(crate) fn successor<'a>(
    solution: &NnddSolution,
    settings: &'a NnddSettings,
    stop: &dyn StoppingCriterion,
) -> Option<&'a NewtonSettings> {
    let open = match solution.status {
        NnddStatus::StoppedByCriterion | NnddStatus::Interrupted => false,
        // Energies that overflow in the first iteration do so with any method.
        NnddStatus::Diverged { best, .. } => best.is_finite(),
        _ => true,
    };
    settings.newton.as_ref().filter(|_| open && settings.theta.is_none() && stop.can_stop())
}

/// Appends what the other method found. If it failed too, the answer of the iteration is kept.
pub(crate) fn switch(
    mut solution: NnddSolution,
    found: Result<Exact, NnddError>,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let after = solution.status;
    let found = match found {
        // Rounding can make the flexibility indefinite.
        Err(NnddError::Qp(_)) => None,
        found => Some(found?).filter(|exact| exact.iterate.eta_nndd.is_finite()),
    };
    let newton = found.as_ref().map_or(QpStatus::NumericalError, |exact| exact.status);
    solution.switch = Some(Switch { after, newton });
    let Some(Exact { iterate, clarabel_calls, .. }) = found.filter(|exact| exact.status.is_solved()) else {
        return Ok(solution);
    };
    solution.clarabel_calls += clarabel_calls;
    solution.history.push(IterationRow::from(&iterate));
    solution.status = match stop.check(&iterate).map_err(NnddError::Criterion)? {
        Decision::Stop => NnddStatus::StoppedByCriterion,
        Decision::Interrupt => NnddStatus::Interrupted,
        // The discrete problem is solved, so the criterion asks for less than round-off.
        Decision::Continue => {
            let floor = solution.history.iter().map(|row| row.eta_nndd).fold(f64::INFINITY, f64::min);
            NnddStatus::Stalled { floor, at_round_off: true }
        }
    };
    solution.last = iterate;
    Ok(solution)
}

/// Reports the spectrum: the one that θ was chosen from, or, if a given θ failed, the one that shows which θ would
/// converge.
pub(crate) fn explain(
    mut solution: NnddSolution,
    chosen: Option<Spectrum>,
    estimate: impl FnOnce() -> Option<Spectrum>,
    stop: &dyn StoppingCriterion,
) -> NnddSolution {
    let failed = match solution.status {
        NnddStatus::Diverged { .. } | NnddStatus::Stalled { at_round_off: false, .. } => true,
        NnddStatus::MaxIterations => stop.can_stop(),
        _ => false,
    };
    solution.spectrum = if failed { chosen.or_else(estimate) } else { chosen };
    if let NnddStatus::Diverged { theta_limit, .. } = &mut solution.status {
        *theta_limit = solution.spectrum.map(|s| s.theta_limit());
    }
    solution
}
