//! Friction at nodes whose slip supports impose.
//!
//! If both bodies are held along the tangent at a pair of nodes, such as at the end of a side along a plane that a support presses down, friction there
//! moves nothing: the discrete problem has it at its limit, however large that is. As a traction it also loads the edge beside the node, and a limit far above the
//! stresses costs more than it saves. Of all admissible values the bound takes the one that continues friction at the neighbours `j` on the line,
//! ```math
//! q_i = w_i/|w_i| min(s_i, max_j (0, w_i·q_j/|w_i|))
//! ```
//! the limit where the line slides.

use crate::recovery::Recovery;
use crate::size::length;
use fem_core::directions::Directions;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactState, NodePair, Partner};
use fem_core::prepared::PreparedProblem;

/// A support along a direction holds the tangent if the sine of their angle is at most this.
const PARALLEL: f64 = 1e-10;

/// Replaces friction at pairs of nodes whose slip supports impose.
///
/// * `friction`: in the rows along tangents of each pair, Pa, within `limits` at its pairs of nodes, Pa; both empty without friction.
pub(crate) fn continued<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    friction: &mut [Vec<f64>],
    limits: &[Vec<f64>],
) {
    let problem = prepared.problem();
    let moves = |partner: Partner| prepared.rigid_motions().iter().any(|of| of.partner == partner);
    let holds = |partner: Partner, side: usize, pair: &NodePair<S>| match partner {
        Partner::Obstacle(_) => !moves(partner),
        Partner::Body(body) => {
            let held = problem.bodies[body].node_constraints()[pair.nodes[side]].supported();
            let tangents = Directions::<S>::along(pair.normal / length(pair.normal)).complement();
            tangents.basis().iter().all(|tangent| held.contains(*tangent, PARALLEL))
        }
    };
    for (k, (of, friction)) in problem.contacts.iter().zip(friction).enumerate() {
        let (pairs, slip) = (of.interface.pairs(), state.contacts[k].slip);
        let imposed = |i: &usize| [0, 1].iter().all(|side| holds(of.partners()[*side], *side, &pairs[*i]));
        let found: Vec<usize> = (0..limits[k].len()).filter(imposed).collect();
        if found.is_empty() {
            continue;
        }
        // The direction of the slip; zero without.
        let direction = |i: usize| {
            let slip = of.along_tangents(i, slip);
            let size = length(slip);
            if size > 0.0 { slip / size } else { S::Vector::ZERO }
        };
        let mut most = vec![0.0f64; pairs.len()];
        for edge in of.interface.facets() {
            let corners = || edge.pairs.as_ref().iter().map(|k| *k as usize);
            // A clamped end is no pair.
            for (i, j) in corners().flat_map(|i| corners().map(move |j| (i, j))).filter(|(i, j)| i != j) {
                most[i] = most[i].max(direction(i).times(&of.along_tangents(j, friction)));
            }
        }
        for i in found {
            let normal = pairs[i].normal_length();
            // Values in the rows are forces over the length of the normal.
            let size = (most[i] / normal).min(limits[k][i]) / normal;
            let parts = of.tangential_parts(i, direction(i));
            friction[i..].iter_mut().step_by(pairs.len()).zip(parts).for_each(|(q, w)| *q = w * size);
        }
    }
}
