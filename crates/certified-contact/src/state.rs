//! The bound of an iterate, in the plane and in space.

use cre_estimator::{Estimate, EstimatorError, Recovery, Relaxation, estimate_with};
use fem_core::interface::{ContactState, PairState};
use fem_core::prepared::PreparedProblem;
use fem_core::space::Space;
use nndd::Iterate;

/// Bounds the error of an iterate of bodies in the plane or in space: with its displacements, openings and forces.
///
/// * `relaxation`: how far the equilibrated stresses are relaxed.
///
/// # Errors
/// Values that are not finite, a lack of memory.
pub fn estimate<S: Recovery>(
    problem: &PreparedProblem<S>,
    iterate: &Iterate,
    relaxation: Relaxation,
) -> Result<Estimate<S>, EstimatorError> {
    let displacement = problem.displacements(&iterate.fields(&problem.system()));
    let fields = displacement.iter().map(Vec::as_slice).collect();
    estimate_with(problem, &state_of(problem, iterate, fields), relaxation)
}

/// Puts an iterate together with its displacements.
pub(crate) fn state_of<'a, S: Space>(
    problem: &PreparedProblem<S>,
    iterate: &'a Iterate,
    displacement: Vec<&'a [S::Vector]>,
) -> ContactState<'a, S> {
    let blocks = problem.problem().blocks().zip(problem.problem().tangential_blocks());
    let (force, opening) = (&iterate.contact.normal_reaction, &iterate.opening);
    let (friction, slip) = (&iterate.tangential.force, &iterate.tangential.slip);
    let contacts = blocks.map(|(pairs, tangents)| PairState {
        contact_force: &force[pairs.clone()],
        opening: &opening[pairs],
        friction_force: &friction[tangents.clone()],
        slip: &slip[tangents],
    });
    ContactState { displacement, contacts: contacts.collect() }
}
