//! Any number of bodies and pairs, floating bodies among them.

mod exact;

use crate::error::NnddError;
use crate::settings::Method;
use crate::solution::NnddSolution;
use crate::stopping::StoppingCriterion;
use fem_core::prepared::PreparedProblem;

/// Solves the contact problem of an assembly.
pub(crate) fn solve(
    problem: &PreparedProblem,
    method: &Method,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    match method {
        Method::Newton(settings) => exact::solve(problem, settings, stop),
        Method::Nndd(_) => {
            let contact = problem.problem();
            Err(NnddError::Unsupported { bodies: contact.bodies.len(), pairs: contact.contacts.len() })
        }
    }
}
