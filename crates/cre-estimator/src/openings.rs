//! The openings that displacements have themselves.

use crate::size::{SIGN_TOLERANCE, larger, largest_displacement};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactPair, ContactProblem, ContactState, NodePair, PairState};

/// Computes the openings `g − (v¹ − v²)·n` of a state's displacements, m, for each pair on which they differ from the given ones by more
/// than round-off, or are negative by more than that; `None` for all others.
///
/// The exact solution of a discrete problem has openings of exactly zero where there is a force. If materials are many orders of magnitude apart in
/// stiffness and bodies float, its displacements have fewer digits than that. The bound is then that of these openings, with a [`crate::lift`]
/// where they are negative.
pub(crate) fn own(problem: &ContactProblem, state: &ContactState<'_>) -> Vec<Option<Vec<f64>>> {
    let of_pair = |(pair, given): (&ContactPair, &PairState<'_>)| {
        let [first, second] = pair.bodies.map(|b| state.displacement[b]);
        let pairs = pair.interface.pairs();
        let opening = |p: &NodePair| p.gap - (first[p.nodes[0]] - second[p.nodes[1]]).dot(&p.normal);
        let own: Vec<f64> = pairs.iter().map(opening).collect();
        let off = |(own, given): (&f64, &f64)| larger((own - given).abs(), larger(-own, -given));
        let worst = own.iter().zip(given.opening).map(off).fold(0.0, larger);
        (worst > round_off(pair, [first, second])).then_some(own)
    };
    problem.contacts.iter().zip(&state.contacts).map(of_pair).collect()
}

/// Tells whether the given openings of a pair are negative by more than round-off.
pub(crate) fn penetrate(pair: &ContactPair, state: &ContactState<'_>, given: &PairState<'_>) -> bool {
    let least = -round_off(pair, pair.bodies.map(|b| state.displacement[b]));
    given.opening.iter().any(|o| *o < least)
}

/// What counts as rounding of the openings of a pair, m, as for the check `penetration`.
///
/// * `displacement`: of the first and the second body.
fn round_off(pair: &ContactPair, displacement: [&[Vector]; 2]) -> f64 {
    let gaps = pair.interface.pairs().iter().map(|p| p.gap);
    let [first, second] = displacement.map(largest_displacement);
    SIGN_TOLERANCE * gaps.fold(larger(first, second), larger)
}
