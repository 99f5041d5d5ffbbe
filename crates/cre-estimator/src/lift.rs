//! Makes the opening of a bent contact line nowhere negative.
//!
//! Where the normal changes along an edge, the opening between two pairs that touch is a quadratic whose middle Bernstein
//! coefficient can be negative, by the square of the edge length where the bodies slide. The first body's contact nodes
//! are moved back along their normals until no coefficient is; one that is held, along the direction left free.

use fem_core::body::NodeConstraint;
use fem_core::geometry::{Vector, dot, perpendicular, scale, sub};
use fem_core::interface::{ContactInterface, ContactProblem, Pair};

/// A node whose motion opens the edge by less of itself is left where it is; what then penetrates is refused by the checks.
const SMALLEST_GAIN: f64 = 0.1;

/// Computes the middle Bernstein coefficient of the opening along every contact edge, m.
pub(crate) fn middle_openings(interface: &ContactInterface, displacement: [&[Vector]; 2]) -> Vec<f64> {
    let jump = |k: usize| {
        let [a, b] = interface.pairs()[k].nodes;
        sub(displacement[0][a as usize], displacement[1][b as usize])
    };
    interface.edges().iter().map(|edge| interface.middle_opening(edge, jump)).collect()
}

/// Returns the direction in which a pair's node of the first body moves, `d·n = 1`: along the normal, or as a support leaves it
/// free.
fn direction(problem: &ContactProblem, pair: &Pair) -> Vector {
    match problem.bodies[0].node_constraints()[pair.nodes[0] as usize] {
        NodeConstraint::Along { direction, .. } => {
            let free = perpendicular(direction);
            scale(1.0 / dot(free, pair.normal), free)
        }
        _ => pair.normal,
    }
}

/// Computes how far each pair's node of the first body must move, `ε ≥ 0`, m: by `−ε d`. Zero on straight edges.
pub(crate) fn lift(problem: &ContactProblem, middle: &[f64]) -> Vec<f64> {
    let interface = &problem.interface;
    let pairs = interface.pairs();
    let mut lift = vec![0.0f64; pairs.len()];
    for (edge, &middle) in interface.edges().iter().zip(middle) {
        if middle >= 0.0 || !interface.is_bent(edge) {
            continue;
        }
        let [i, j] = edge.pairs.map(|k| k as usize);
        // The coefficient grows by ½ (ε_i d_i·n_j + ε_j d_j·n_i).
        for (k, other) in [(i, j), (j, i)] {
            let gain = dot(direction(problem, &pairs[k]), pairs[other].normal);
            if gain > SMALLEST_GAIN {
                lift[k] = lift[k].max(-middle / gain);
            }
        }
    }
    lift
}

/// Moves the first body's contact nodes by `−factor ε d`.
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
            lifted[node] = sub(lifted[node], scale(factor * epsilon, direction(problem, pair)));
        }
    }
    lifted
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::body::Body;
    use fem_core::boundary::BoundaryConditions;
    use fem_core::interface::{ContactInterface, Gap};
    use fem_core::material::{Hypothesis, LinearElastic};
    use fem_core::mesh::generate::ring;

    #[test]
    fn the_lift_closes_what_penetrates_where_a_support_is_oblique_too() {
        // The contact line is an arc from 0 to 60 degrees; at its end, x is held: 30 degrees off the tangent.
        let body = |radii| {
            let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
            let mesh = ring([0.0; 2], radii, [0.0, 60.0], [4, 2]).unwrap();
            let held = BoundaryConditions::new().displace("start", None, Some(0.0.into()));
            Body::new(mesh, material, &held.displace("end", Some(0.0.into()), None)).unwrap()
        };
        let bodies = [body([1.0, 1.5]), body([1.5, 2.0])];
        let interface =
            ContactInterface::pair(&bodies[0], &bodies[1], ["outer", "inner"], &Gap::Geometric).unwrap();
        let problem = ContactProblem { bodies, interface };
        let nodes = [0, 1].map(|b| vec![[0.0; 2]; problem.bodies[b].mesh().points().len()]);
        let edges = problem.interface.edges().len();
        for penetrating in 0..edges {
            let middle: Vec<f64> = (0..edges).map(|k| if k == penetrating { -1e-3 } else { 0.0 }).collect();
            let first = moved(&problem, &nodes[0], &lift(&problem, &middle), 1.0);
            let opened = middle_openings(&problem.interface, [&first, &nodes[1]]);
            assert!((opened[penetrating] - 1e-3).abs() < 1e-12, "{penetrating}: {opened:?}");
            assert!(opened.iter().all(|o| *o >= -1e-15), "{penetrating}: {opened:?}");
            for (u, held) in first.iter().zip(problem.bodies[0].node_constraints()) {
                if let NodeConstraint::Along { direction, .. } = held {
                    assert!(dot(*u, *direction).abs() < 1e-15, "{penetrating}");
                }
            }
        }
    }
}
