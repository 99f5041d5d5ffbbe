//! The same problem on finer meshes, with displacements that are carried along.

use crate::model::{Body, ContactProblem, Made, Vector};
use contact_geometry::RefinedProblem;
use fem_core::mesh::id::NodeId;
use fem_core::mesh::refine::RefinementEdges;

/// The same problem, every triangle cut in four.
///
/// # Errors
/// None, for sound problems.
pub fn halve(problem: &ContactProblem) -> Made<RefinedProblem> {
    let meshes = || problem.bodies.iter().map(Body::mesh);
    let edges: Vec<RefinementEdges> = meshes().map(RefinementEdges::longest).collect();
    let marked: Vec<Vec<bool>> = meshes().map(|mesh| vec![true; mesh.topology().facets().len()]).collect();
    Ok(contact_geometry::refined(problem, &edges, &marked)?)
}

/// The displacements of the nodes of each body on a finer mesh, m.
///
/// * `u`: of each body of the coarse problem, m.
pub fn carried(problem: &ContactProblem, refined: &RefinedProblem, u: &[Vec<Vector>]) -> Vec<Vec<Vector>> {
    let of_body = |(b, u): (usize, &Vec<Vector>)| {
        let (refinement, coarse, fine) =
            (&refined.refinements[b], &problem.bodies[b], &refined.problem.bodies[b]);
        let mut found = refinement.prolong(u);
        if coarse.cuts().is_empty() {
            return found;
        }
        // Beyond a cut the field is that of the nodes and the jump; the finer jump is in smaller cells.
        let new = u.len()..found.len();
        let on_cut = |node: NodeId| fine.cuts().iter().any(|cut| cut.has(node));
        for (cell, parent) in refinement.parent_cell.iter().enumerate() {
            let jump = coarse.cut_displacement(*parent as usize);
            let (corners, x) =
                (coarse.mesh().cells()[*parent as usize], coarse.mesh().corners(*parent as usize));
            for node in fine.mesh().cells()[cell] {
                if new.contains(&node.index()) && !on_cut(node) {
                    let at = fine.mesh().points()[node];
                    let share = |k: usize| {
                        let [a, b] = [1, 2].map(|j| x[(k + j) % 3]);
                        (b - a).perp(&(at - a)) / (b - a).perp(&(x[k] - a))
                    };
                    found[node.index()] = (0..3).map(|k| (u[corners[k].index()] + jump[k]) * share(k)).sum();
                }
            }
        }
        found
    };
    // Obstacles come after the bodies.
    u.iter().take(problem.bodies.len()).enumerate().map(of_body).collect()
}

/// A problem, and the displacements of the nodes of each body, m.
pub type Finer = (ContactProblem, Vec<Vec<Vector>>);

/// The same problem, every triangle cut in four `times` times, with the displacements of its nodes.
///
/// * `u`: of each body, m.
///
/// # Errors
/// None, for sound problems.
pub fn finer(mut problem: ContactProblem, mut u: Vec<Vec<Vector>>, times: usize) -> Made<Finer> {
    for _ in 0..times {
        let refined = halve(&problem)?;
        u = carried(&problem, &refined, &u);
        problem = refined.problem;
    }
    Ok((problem, u))
}
