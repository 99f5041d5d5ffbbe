//! Displacements from traces, or from contact forces and rigid motions.

use fem_core::body::RigidMotion;
use fem_core::each_body;
use fem_core::geometry::Vector;
use fem_core::prepared::{BodyMotion, PreparedProblem};

/// Computes the displacement of each body, `u = K⁺ (f − Bᵀ P) + R a`, and then of the points of each obstacle, Cartesian, m.
///
/// * `traces`: the interface unknowns of a body, if they are imposed, m.
/// * `force`: the contact forces on the body of a pair and side, along the normal of the pair, N/m.
/// * `motions`: body, rigid motion, and by how much.
pub(crate) fn displacements(
    problem: &PreparedProblem,
    traces: impl Fn(usize) -> Option<Vec<f64>> + Sync + Send,
    force: impl Fn(usize, usize) -> Vec<f64> + Sync + Send,
    motions: &[(usize, RigidMotion, f64)],
) -> Vec<Vec<Vector>> {
    let moved = |b: usize, u: &mut [Vector]| {
        for (body, motion, amount) in motions.iter().filter(|(of, ..)| *of == b) {
            let moved = problem.moved_by(&BodyMotion::new(*body, *motion));
            u.iter_mut().zip(moved).for_each(|(u, moved)| *u += *amount * moved);
        }
    };
    let mut all = each_body(problem.bodies().len(), |b| {
        let condensed = &problem.bodies()[b];
        if let Some(unknowns) = traces(b) {
            return condensed.displacement_from_trace(&unknowns);
        }
        let forces: Vec<Vec<f64>> = problem.problem().sides_of(b).map(|(k, side)| force(k, side)).collect();
        let mut u = condensed.displacement_from_force(&condensed.dofs().interface_forces(&forces));
        moved(b, &mut u);
        u
    });
    for obstacle in &problem.problem().obstacles {
        let mut u = obstacle.imposed();
        moved(all.len(), &mut u);
        all.push(u);
    }
    all
}
