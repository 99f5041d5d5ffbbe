//! Where an adaptive run stands, as plain data: enough to go on in another process and come to the same numbers.

use crate::error::SolveError;
use crate::history::Step;
use crate::refine::edges_of_cells;
use crate::solution::{RoleReason, Roles};
use fem_core::interface::ContactProblem;
use fem_core::mesh::refine::RefinementEdges;
use nndd::Start;

/// An adaptive run that is about to solve a mesh finer than its first.
///
/// Meshes are not in it: they follow from the first one and from the cells that were refined, bit by bit.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// Whether the roles are exchanged against the order handed over.
    pub swapped: bool,
    /// Why.
    pub role_reason: RoleReason,
    /// The second mesh and every one after it; the last one is to be solved.
    pub meshes: Vec<FinerMesh>,
    /// One entry per mesh solved: as many as `meshes`.
    pub history: Vec<Step>,
}

/// How a mesh came from the one before it, and where its iteration starts.
#[derive(Clone, Debug)]
pub struct FinerMesh {
    /// Round by round the cells of each body whose three edges were halved, in the roles of the iteration.
    pub rounds: Vec<[Vec<u32>; 2]>,
    /// λ and the active set.
    pub start: Start,
}

impl Checkpoint {
    /// Makes the mesh of a step again, from the first one.
    ///
    /// * `first`: the problem in the order handed over, on its first mesh.
    /// * `step`: from 2.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] where this is no checkpoint of that problem.
    pub(crate) fn replay(
        &self,
        first: &ContactProblem,
        step: usize,
    ) -> Result<(ContactProblem, [RefinementEdges; 2]), SolveError> {
        let mut problem = if self.swapped { first.clone().swapped() } else { first.clone() };
        let mut edges = [0, 1].map(|b| RefinementEdges::longest(problem.bodies[b].mesh()));
        for round in self.meshes.iter().take(step - 1).flat_map(|mesh| &mesh.rounds) {
            let cells = |b: usize| problem.bodies[b].mesh().triangles().len();
            if (0..2).any(|b| round[b].iter().any(|&cell| cell as usize >= cells(b))) {
                return Err(SolveError::Checkpoint { what: "it refines a cell that the mesh does not have" });
            }
            let finer = problem.refined([&edges[0], &edges[1]], &edges_of_cells(&problem, round))?;
            edges = finer.refinements.map(|r| r.refinement_edges);
            problem = finer.problem;
        }
        let pairs = problem.interface.pairs().len();
        let start = self.start_of(step)?;
        if start.lambda.len() != pairs || start.active.as_ref().is_some_and(|a| a.len() != pairs) {
            return Err(SolveError::Checkpoint { what: "its interface has another number of pairs" });
        }
        Ok((problem, edges))
    }

    /// Returns where the iteration on the mesh of a step, from 2, starts.
    pub(crate) fn start_of(&self, step: usize) -> Result<&Start, SolveError> {
        let mesh = self.meshes.get(step.wrapping_sub(2));
        mesh.map(|m| &m.start).ok_or(SolveError::Checkpoint { what: "it lacks a mesh" })
    }

    /// Returns who carries λ.
    pub(crate) fn roles(&self) -> Roles {
        Roles { swapped: self.swapped, reason: self.role_reason }
    }

    /// Forgets the mesh that is to be solved: the one before it is then to be solved again.
    pub(crate) fn step_back(&mut self) {
        self.meshes.pop();
        self.history.pop();
    }
}
