//! The openings and slips that displacements have themselves.

use crate::recovery::Recovery;
use crate::size::{SIGN_TOLERANCE, larger, largest_displacement};
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem, ContactState, NodePair, PairState};

/// Computes the openings `g − (v¹ − v²)·n` of a state's displacements, m, for each pair on which they differ from the given ones by more
/// than round-off, or are negative by more than that; `None` for all others.
///
/// The exact solution of a discrete problem has openings of exactly zero where there is a force. If materials are many orders of magnitude apart in
/// stiffness and bodies float, its displacements have fewer digits than that. The bound is then computed with these openings, and with a
/// [`crate::lift`] if they are negative.
pub(crate) fn own<S: Recovery>(
    problem: &ContactProblem<S>,
    state: &ContactState<'_, S>,
) -> Vec<Option<Vec<f64>>> {
    let of_pair = |(pair, given): (&ContactPair<S>, &PairState<'_>)| {
        let displacement = problem.places_of(pair).map(|b| state.displacement[b]);
        let own: Vec<f64> = pair.interface.pairs().iter().map(|p| of_fields(p, displacement)).collect();
        let off = |(own, given): (&f64, &f64)| larger((own - given).abs(), larger(-own, -given));
        let worst = own.iter().zip(given.opening).map(off).fold(0.0, larger);
        (worst > SIGN_TOLERANCE * size(&pair.interface, displacement)).then_some(own)
    };
    problem.contacts.iter().zip(&state.contacts).map(of_pair).collect()
}

/// Computes the slips `(v¹ − v²)·t` of this load step, m, of a state's displacements like [`own`]: for each pair on which they differ from the given ones
/// by more than round-off.
pub(crate) fn own_slips<S: Recovery>(
    problem: &ContactProblem<S>,
    state: &ContactState<'_, S>,
) -> Vec<Option<Vec<f64>>> {
    let of_pair = |(pair, given): (&ContactPair<S>, &PairState<'_>)| {
        if given.slip.is_empty() {
            return None;
        }
        let displacement = problem.places_of(pair).map(|b| state.displacement[b]);
        let normals = pair.interface.pairs().len();
        let tangents = pair.rows().skip(normals);
        let mut own: Vec<f64> = tangents
            .map(|row| jump(&pair.interface.pairs()[row.pair], displacement).times(&row.direction))
            .collect();
        let mut size = larger(largest_displacement(displacement[0]), largest_displacement(displacement[1]));
        if let Some(before) = &pair.slip_before {
            own.iter_mut().zip(&before.rows).for_each(|(own, before)| *own -= before);
            size = before.rows.iter().fold(size, |size, w| larger(size, w.abs()));
        }
        let worst = own.iter().zip(given.slip).map(|(own, given)| (own - given).abs()).fold(0.0, larger);
        (worst > SIGN_TOLERANCE * size).then_some(own)
    };
    problem.contacts.iter().zip(&state.contacts).map(of_pair).collect()
}

/// Tells whether the given openings of a pair are negative by more than round-off.
///
/// * `displacement`: of the first and the second partner, m.
pub(crate) fn penetrate<S: Recovery>(
    pair: &ContactPair<S>,
    displacement: [&[S::Vector]; 2],
    given: &PairState<'_>,
) -> bool {
    let deepest = given.opening.iter().fold(0.0f64, |m, o| m.max(-o));
    deepest > 0.0 && deepest > SIGN_TOLERANCE * size(&pair.interface, displacement)
}

/// Computes the opening `g − (v¹ − v²)·n` of a pair of nodes, m.
///
/// * `displacement`: of the first and the second body.
pub(crate) fn of_fields<S: Recovery>(pair: &NodePair<S>, displacement: [&[S::Vector]; 2]) -> f64 {
    pair.gap - jump(pair, displacement).times(&pair.normal)
}

/// Computes `v¹ − v²` at a pair of nodes, m.
fn jump<S: Recovery>(pair: &NodePair<S>, displacement: [&[S::Vector]; 2]) -> S::Vector {
    let [first, second] = [0, 1].map(|side: usize| displacement[side][pair.nodes[side]]);
    first - second
}

/// Computes the size that openings are compared with, m: the largest displacement of the two bodies, since their fields are right to its
/// rounding, or the largest gap or interference.
///
/// * `displacement`: of the first and the second body.
pub(crate) fn size<S: Recovery>(interface: &ContactInterface<S>, displacement: [&[S::Vector]; 2]) -> f64 {
    let [first, second] = displacement.map(largest_displacement);
    interface.pairs().iter().map(|p| p.gap.abs()).fold(larger(first, second), larger)
}
