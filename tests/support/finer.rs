//! The same problem on finer meshes, with displacements that are carried along.

use crate::model::{Body, ContactProblem, Made, Vector};
use contact_geometry::RefinedProblem;
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
        u = refined.refinements.iter().zip(&u).map(|(refinement, u)| refinement.prolong(u)).collect();
        problem = refined.problem;
    }
    Ok((problem, u))
}
