//! Every check of a case that needs no factorisation.

use crate::failure::Failure;
use case_io::Case;
use certified_contact::SolveError;
use fem_core::assembly::AssemblyError;
use fem_core::body::NodeConstraint;
use fem_core::interface::ContactProblem;
use fem_core::prepared::PrepareError;

/// What a body of a case consists of.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckedBody {
    /// Its name.
    pub name: String,
    /// Its sides, each with the number of its edges.
    pub sides: Vec<(String, usize)>,
    /// Number of conditions that support it.
    pub supports: usize,
    /// Number of nodes that are held in some direction.
    pub held_nodes: usize,
    /// Number of conditions that load it.
    pub loads: usize,
    /// The smallest angle of its mesh, degrees.
    pub smallest_angle: f64,
}

/// Describes the bodies of a case, in the file's order, whose supports hold them.
///
/// # Errors
/// A body that can move freely.
pub fn check(case: &Case, problem: &ContactProblem) -> Result<Vec<CheckedBody>, Failure> {
    supports(case, problem)?;
    let bodies = case.bodies.iter().zip(&problem.bodies);
    Ok(bodies
        .map(|(body, model)| CheckedBody {
            name: body.name.clone(),
            sides: model.mesh().groups().iter().map(|(name, edges)| (name.clone(), edges.len())).collect(),
            supports: model.supports().len(),
            held_nodes: model.node_constraints().iter().filter(|c| **c != NodeConstraint::Free).count(),
            loads: body.tractions.len(),
            smallest_angle: model.mesh().smallest_angle(),
        })
        .collect())
}

/// Refuses bodies that can move freely, before anything is computed or written.
///
/// # Errors
/// The first such body, with its motion.
pub fn supports(case: &Case, problem: &ContactProblem) -> Result<(), Failure> {
    for (body, model) in problem.bodies.iter().enumerate() {
        if let Some(motion) = model.free_motion() {
            let source = AssemblyError::Floating { motion };
            return Err(Failure::solve(case, &SolveError::Prepare(PrepareError::Assembly { body, source })));
        }
    }
    Ok(())
}
