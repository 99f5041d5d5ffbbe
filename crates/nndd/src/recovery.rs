//! Displacements from contact forces and rigid motions.

use fem_core::body::RigidMotion;
use fem_core::each_body;
use fem_core::geometry::Vector;
use fem_core::prepared::PreparedProblem;

/// Computes the displacement of each body, `u = K⁺ (f − Bᵀ P) + R a`, Cartesian, m.
///
/// * `force`: the contact forces on the body of a pair and side, along the normal of the pair, N/m.
/// * `motions`: body, rigid motion, and by how much.
pub(crate) fn displacements(
    problem: &PreparedProblem,
    force: impl Fn(usize, usize) -> Vec<f64> + Sync + Send,
    motions: &[(usize, RigidMotion, f64)],
) -> Vec<Vec<Vector>> {
    each_body(problem.bodies().len(), |b| {
        let condensed = &problem.bodies()[b];
        let forces: Vec<Vec<f64>> = problem.problem().sides_of(b).map(|(k, side)| force(k, side)).collect();
        let mut u = condensed.displacement_from_force(&condensed.dofs().interface_forces(&forces));
        let body = &problem.problem().bodies[b];
        let (piece_of, _) = body.mesh().topology().pieces();
        for (_, motion, amount) in motions.iter().filter(|(of, ..)| *of == b) {
            let points = body.mesh().points().iter().zip(&piece_of);
            for (u, (point, _)) in u.iter_mut().zip(points).filter(|(_, (_, piece))| **piece == motion.piece)
            {
                *u += *amount * motion.at(*point);
            }
        }
        u
    })
}
