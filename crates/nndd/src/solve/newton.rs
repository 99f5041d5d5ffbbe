//! The interface Newton method: alone, or after an iteration that did not converge.

use super::Run;
use crate::error::NnddError;
use crate::iterate::Programme;
use crate::iteration::Exact;
use crate::monolithic;
use crate::settings::NewtonSettings;
use crate::vector::add;
use contact_qp::{ActiveSet, QpMethod};

impl Run<'_> {
    /// The reference: λ by interface Newton, then one pass of both steps, which certifies it. Returns it as the iterate with
    /// the given number.
    ///
    /// * `closed`: the pairs that are closed at the start; `None`: all of them.
    pub(super) fn exact(
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
        let mut iterate = self.iterate_of(eta, answer.lambda, reaction, contact);
        iterate.iteration = number;
        let status =
            if answer.solution.status.is_solved() { iterate.contact.status } else { answer.solution.status };
        iterate.programme = Programme { path: answer.solution.path, iterations: answer.solution.iterations };
        Ok(Exact { iterate, status, clarabel_calls })
    }
}
