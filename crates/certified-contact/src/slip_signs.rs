//! The signs of slips in the plane.

use fem_core::interface::{ContactPair, ContactProblem};
use nndd::PairFriction;

/// Returns the common sign of all slips of each pair with Coulomb friction, open parts included, 0 for other pairs; `None` if a pair slips
/// in both directions.
pub(crate) fn slip_signs(problem: &ContactProblem, friction: &[PairFriction]) -> Option<Vec<f64>> {
    let of_pair = |(pair, friction): (&ContactPair, &PairFriction)| {
        if pair.friction.coulomb().is_none() {
            return Some(0.0);
        }
        let forwards = friction.slip.iter().any(|w| *w > 0.0);
        let backwards = friction.slip.iter().any(|w| *w < 0.0);
        (!forwards || !backwards).then_some(if backwards { -1.0 } else { 1.0 })
    };
    problem.contacts.iter().zip(friction).map(of_pair).collect()
}
