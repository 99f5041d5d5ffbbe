//! Makes the opening of a bent contact line nowhere negative.
//!
//! Where the normal changes along an edge, the opening between two pairs that touch is a quadratic whose middle Bernstein
//! coefficient can be negative, by the square of the edge length where the bodies slide. The first body's contact nodes
//! are moved back along their normals until no coefficient is; one that is held, along the direction left free.

use fem_core::body::NodeConstraint;
use fem_core::geometry::{Vector, dot, perpendicular, scale, sub};
use fem_core::interface::{ContactInterface, ContactProblem};

/// Computes the middle Bernstein coefficient of the opening along every contact edge, m.
pub(crate) fn middle_openings(interface: &ContactInterface, displacement: [&[Vector]; 2]) -> Vec<f64> {
    let jump = |k: usize| {
        let [a, b] = interface.pairs()[k].nodes;
        sub(displacement[0][a as usize], displacement[1][b as usize])
    };
    interface.edges().iter().map(|edge| interface.middle_opening(edge, jump)).collect()
}

/// Computes how far each pair's node of the first body must move, `ε ≥ 0`, m: by `−ε n`. Zero on straight edges.
pub(crate) fn lift(interface: &ContactInterface, middle: &[f64]) -> Vec<f64> {
    let mut lift = vec![0.0f64; interface.pairs().len()];
    for (edge, &middle) in interface.edges().iter().zip(middle) {
        if middle >= 0.0 || !interface.is_bent(edge) {
            continue;
        }
        let [i, j] = edge.pairs.map(|k| k as usize);
        // The coefficient grows by ½ (ε_i + ε_j) n_i·n_j.
        let cosine = dot(interface.pairs()[i].normal, interface.pairs()[j].normal);
        for k in [i, j] {
            lift[k] = lift[k].max(-middle / cosine);
        }
    }
    lift
}

/// Moves the first body's contact nodes by `−factor ε` along the normal, or as far along the direction that a support
/// leaves free.
pub(crate) fn moved(
    problem: &ContactProblem,
    displacement: &[Vector],
    lift: &[f64],
    factor: f64,
) -> Vec<Vector> {
    let mut lifted = displacement.to_vec();
    for (pair, &epsilon) in problem.interface.pairs().iter().zip(lift) {
        if epsilon > 0.0 {
            let node = pair.nodes[0] as usize;
            let direction = match problem.bodies[0].node_constraints()[node] {
                NodeConstraint::Along { direction, .. } => {
                    let free = perpendicular(direction);
                    scale(1.0 / dot(free, pair.normal), free)
                }
                _ => pair.normal,
            };
            lifted[node] = sub(lifted[node], scale(factor * epsilon, direction));
        }
    }
    lifted
}
