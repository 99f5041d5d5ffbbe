//! Friction in the bound: slips along the contact line, and the work that friction at its limit would do beyond the actual one.
//!
//! ```math
//! 2 ∫_{Γ_C} (s|w| - q\,w), \qquad |q| ≤ s                                                                     \qquad (32)
//! ```
//! with the slip `w = (u^a − u^b)·t`, the friction `q` and its limit `s`, all linear along the edges of a straight contact line.

use crate::error::EstimatorError;
use fem_core::body::Body;
use fem_core::geometry::{Vector, perpendicular};
use fem_core::interface::{ContactEdge, ContactPair, ContactProblem};

/// Refuses friction that has no bound yet.
///
/// # Errors
/// [`EstimatorError::BentFriction`].
pub fn check_friction(problem: &ContactProblem) -> Result<(), EstimatorError> {
    let bent = |pair: &ContactPair| pair.friction.acts() && pair.interface.has_bent_edges();
    match problem.contacts.iter().position(bent) {
        Some(pair) => Err(EstimatorError::BentFriction { pair }),
        None => Ok(()),
    }
}

/// Computes the slip of displacement fields at the two ends of every contact edge, m; nothing without friction.
///
/// * `displacement`: of the bodies of the pair, or of the points of an obstacle, m.
pub(crate) fn edge_slips(
    problem: &ContactProblem,
    pair: &ContactPair,
    displacement: [&[Vector]; 2],
) -> Vec<[f64; 2]> {
    if !pair.friction.acts() {
        return Vec::new();
    }
    let pairs = pair.interface.pairs();
    let slip = |edge: &ContactEdge, end: usize| {
        let of = &pairs[edge.pairs[end] as usize];
        let node = |side: usize| match edge.clamped {
            // Obstacles have no clamped nodes.
            Some(clamped) if clamped.end == end => {
                other_node(&problem.bodies[pair.bodies[side]], edge, side, of.nodes[side].index())
            }
            _ => of.nodes[side].index(),
        };
        let [first, second] = [0, 1].map(|side: usize| displacement[side][node(side)]);
        (first - second).dot(&perpendicular(of.normal))
    };
    pair.interface.edges().iter().map(|edge| [0, 1].map(|end| slip(edge, end))).collect()
}

/// Returns the node of a contact edge that is not the given one.
fn other_node(body: &Body, edge: &ContactEdge, side: usize, node: usize) -> usize {
    let [a, b] = body.mesh().topology().edges()[edge.edges[side]].map(|n| n.index());
    if a == node { b } else { a }
}

/// Computes `2 ∫ (s|w| − q w) ds` on every contact edge, J/m, (32).
///
/// * `friction`: q, `limit`: s, at the pairs, Pa. `slips`: w at the ends of every edge, m; nothing without friction.
pub(crate) fn friction_terms(
    pair: &ContactPair,
    friction: &[f64],
    limit: &[f64],
    slips: &[[f64; 2]],
) -> Vec<f64> {
    let term = |(edge, w): (&ContactEdge, &[f64; 2])| {
        2.0 * edge.length * mean(edge.ends(limit), edge.ends(friction), *w)
    };
    pair.interface.edges().iter().zip(slips).map(term).collect()
}

/// Computes the mean of `s|w| − q w` along an edge of linear data by their values at its ends: exact, by Simpson's rule on the two sides of
/// the root of `w`.
fn mean(s: [f64; 2], q: [f64; 2], w: [f64; 2]) -> f64 {
    let at = |ends: [f64; 2], x: f64| ends[0] + x * (ends[1] - ends[0]);
    let simpson = |from: f64, to: f64| {
        let sign = if at(w, 0.5 * (from + to)) < 0.0 { -1.0 } else { 1.0 };
        let f = |x: f64| (at(s, x) - sign * at(q, x)) * (sign * at(w, x)).max(0.0);
        (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to))
    };
    if w[0] * w[1] < 0.0 {
        let root = w[0] / (w[0] - w[1]);
        return simpson(0.0, root) + simpson(root, 1.0);
    }
    simpson(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_that_of_a_fine_sum_and_never_negative() {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..200 {
            let s = [random(), random()];
            let q = s.map(|s| s * (2.0 * random() - 1.0));
            let w = [2.0 * random() - 1.0, 2.0 * random() - 1.0];
            let n = 4000;
            let sum: f64 = (0..n)
                .map(|k| {
                    let x = (f64::from(k) + 0.5) / f64::from(n);
                    let [s, q, w] = [s, q, w].map(|e| e[0] + x * (e[1] - e[0]));
                    (s * w.abs() - q * w) / f64::from(n)
                })
                .sum();
            let found = mean(s, q, w);
            assert!(found >= 0.0 && (found - sum).abs() < 1e-6, "{found} {sum}");
        }
        // Friction at its limit against the slip.
        assert_eq!(mean([2.0, 3.0], [2.0, 3.0], [0.0, 1.0]), 0.0);
        assert_eq!(mean([2.0, 2.0], [0.0, 0.0], [-1.0, 1.0]), 1.0);
    }
}
