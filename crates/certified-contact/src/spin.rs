//! Loads along rotations that only the error of a polygon resists.

use crate::error::SolveError;
use fem_core::interface::ContactProblem;

/// A body whose motion is below this fraction of the largest one does not move.
const NO_TRACE: f64 = 1e-9;

/// Leaves loads out along rotations that a contact line on a declared arc does not resist, if the error of the polygon explains them, see
/// [`ContactProblem::without_spins`]: the moment of the loads of a polygon about the centre of the arc is not exactly the curve's. A problem with
/// larger loads is returned as it is, and is not held.
///
/// # Errors
/// Numbers that are not finite.
pub(crate) fn without_spin(problem: ContactProblem) -> Result<ContactProblem, SolveError> {
    if problem.contacts.iter().all(|pair| pair.interface.centre().is_none()) {
        return Ok(problem);
    }
    let unbalanced = |of: &ContactProblem| nndd::unbalanced(&of.contact_rows()).map_err(SolveError::Nndd);
    let Some(found) = unbalanced(&problem)? else { return Ok(problem) };
    let nndd::UnresistedMotion { amounts, work, .. } = found.motion;
    let motion = problem.assembly_motion(&problem.rigid_motions(), &amounts, work, NO_TRACE);
    let Some(without) = problem.without_spins(&motion, &found.forces) else { return Ok(problem) };
    let left = unbalanced(&without)?;
    Ok(if left.is_none() { without } else { problem })
}
