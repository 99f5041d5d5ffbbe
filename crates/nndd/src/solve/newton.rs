//! The interface Newton method: alone, or after an iteration that did not converge.

use super::Run;
use crate::error::NnddError;
use crate::iterate::{Iterate, IterationRow, Programme};
use crate::monolithic;
use crate::settings::NewtonSettings;
use crate::solution::{NnddSolution, NnddStatus, Switch};
use crate::stopping::{Decision, StoppingCriterion};
use crate::vector::add;
use contact_qp::{ActiveSet, QpMethod, QpStatus};

impl Run<'_> {
    /// The reference: λ by interface Newton, then one pass of both steps, which certifies it.
    pub(super) fn newton(
        &mut self,
        settings: &NewtonSettings,
        stop: &mut dyn StoppingCriterion,
    ) -> Result<NnddSolution, NnddError> {
        let Exact { iterate, status, clarabel_calls } = self.exact(None, settings, 1)?;
        let status = if !status.is_solved() {
            NnddStatus::ContactQpUnsolved(status)
        } else {
            match stop.check(&iterate).map_err(NnddError::Criterion)? {
                Decision::Interrupt => NnddStatus::Interrupted,
                // The discrete problem is solved; no iteration follows.
                Decision::Stop | Decision::Continue => NnddStatus::StoppedByCriterion,
            }
        };
        let history = vec![IterationRow::from(&iterate)];
        let (switch, spectrum, theta) = (None, None, 0.0);
        Ok(NnddSolution { status, switch, history, last: iterate, theta, spectrum, clarabel_calls })
    }

    /// Solves by interface Newton after the iteration failed. If Newton fails too, the iteration's answer is kept.
    pub(super) fn switch(
        &mut self,
        mut solution: NnddSolution,
        settings: &NewtonSettings,
        stop: &mut dyn StoppingCriterion,
    ) -> Result<NnddSolution, NnddError> {
        let after = solution.status;
        // The contact nodes of a diverged iteration are useless.
        let closed = match after {
            NnddStatus::Diverged { .. } => None,
            _ => Some(solution.last.contact.active.clone()),
        };
        let found = match self.exact(closed, settings, solution.history.len() + 1) {
            // Rounding can make the flexibility indefinite.
            Err(NnddError::Qp(_)) => None,
            found => Some(found?).filter(|exact| exact.iterate.eta_nndd.is_finite()),
        };
        let newton = found.as_ref().map_or(QpStatus::NumericalError, |exact| exact.status);
        solution.switch = Some(Switch { after, newton });
        let Some(Exact { iterate, clarabel_calls, .. }) = found.filter(|exact| exact.status.is_solved())
        else {
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

    /// Solves the discrete problem by interface Newton, and returns it as the iterate with the given number.
    ///
    /// * `closed`: the pairs that are closed at the start; `None`: all of them.
    fn exact(
        &mut self,
        closed: Option<ActiveSet>,
        settings: &NewtonSettings,
        number: usize,
    ) -> Result<Exact, NnddError> {
        let NewtonSettings { max_iterations, qp } = settings;
        let limit = (*max_iterations).max(1).min(qp.max_iterations);
        // The Newton method is the active-set method; interior points are used only on request or if that fails.
        let method = if qp.method == QpMethod::Auto { QpMethod::ActiveSet } else { qp.method };
        let qp = qp.clone().with_max_iterations(limit).with_method(method);
        let open = closed.map(|set| ActiveSet::new((0..set.len()).map(|k| !set.is_active(k)).collect()));
        let answer = monolithic::solve(self.interface, self.bodies, open.as_ref(), &qp)?;
        let flags: Vec<bool> = answer.solution.multipliers.iter().map(|o| *o == 0.0).collect();
        self.warm_start = Some(ActiveSet::new(flags));
        let (reaction, contact) = self.step_1(&answer.lambda)?;
        let clarabel_calls = answer.solution.clarabel_calls + contact.clarabel_calls;
        let imbalance = add(&reaction, &contact.normal_reaction);
        let [w1, _] = self.step_2(&imbalance);
        let eta = self.eta_nndd(&imbalance, &w1);
        let mut iterate = self.iterate_of(number, 0.0, eta, answer.lambda, reaction, contact);
        let status =
            if answer.solution.status.is_solved() { iterate.contact.status } else { answer.solution.status };
        iterate.programme = Programme { path: answer.solution.path, iterations: answer.solution.iterations };
        Ok(Exact { iterate, status, clarabel_calls })
    }
}

/// The result of interface Newton.
struct Exact {
    iterate: Iterate,
    /// Status of the Newton method, or of Ω₂'s contact problem after it.
    status: QpStatus,
    clarabel_calls: usize,
}
