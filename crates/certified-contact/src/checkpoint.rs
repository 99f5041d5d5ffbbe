//! The state of an adaptive run as plain data: enough to resume it in another process with identical results.

use crate::error::SolveError;
use crate::history::Step;
use crate::solution::RoleReason;
use crate::space::ContactSpace;
use contact_geometry::FinerProblem;
use fem_core::body::Body;
use fem_core::interface::{ContactProblem, Roles};
use nndd::Start;

/// An adaptive run that is about to solve a mesh finer than its first.
///
/// It does not contain meshes: they are rebuilt bit for bit from the first one and the cells that were refined.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// Who carries λ in each pair.
    pub roles: Vec<Roles>,
    /// Why the body was chosen that carries λ.
    pub role_reason: RoleReason,
    /// The second mesh and all later ones; the last one is still to be solved.
    pub meshes: Vec<FinerMesh>,
    /// One entry per mesh solved: as many as `meshes`.
    pub history: Vec<Step>,
}

/// How a mesh was made from the previous one, and the initial values of its iteration.
#[derive(Clone, Debug)]
pub struct FinerMesh {
    /// For each round, the cells of each body that were cut.
    pub rounds: Vec<Vec<Vec<u32>>>,
    /// λ and the active set.
    pub start: Start,
}

impl Checkpoint {
    /// Rebuilds the mesh of a step from the first one.
    ///
    /// * `first`: the problem in the order passed in, on its first mesh.
    /// * `step`: from 2.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] if this is not a checkpoint of that problem.
    pub(crate) fn replay<S: ContactSpace>(
        &self,
        first: &ContactProblem<S>,
        step: usize,
    ) -> Result<(ContactProblem<S>, S::Cuts), SolveError<S>> {
        if self.roles.len() != first.contacts.len() {
            return Err(SolveError::Checkpoint { what: "it has another number of contact pairs" });
        }
        let mut problem = first.clone();
        problem.contacts.iter_mut().zip(&self.roles).for_each(|(pair, roles)| pair.roles = *roles);
        let mut cuts = S::cuts(&problem)?;
        for round in self.meshes.iter().take(step - 1).flat_map(|mesh| &mesh.rounds) {
            if round.len() != problem.bodies.len() {
                return Err(SolveError::Checkpoint { what: "it has another number of bodies" });
            }
            let unknown = |(body, cells): (&Body<S>, &Vec<u32>)| {
                cells.iter().any(|&cell| cell as usize >= body.mesh().cells().len())
            };
            if problem.bodies.iter().zip(round).any(unknown) {
                return Err(SolveError::Checkpoint { what: "it refines a cell that the mesh does not have" });
            }
            let finer = S::finer(&problem, &cuts, round)?;
            FinerProblem { problem, cuts, .. } = finer;
        }
        let (rows, pairs) = (problem.rows(), problem.node_pairs());
        let start = self.start_of::<S>(step)?;
        if start.lambda.len() != rows || start.active.as_ref().is_some_and(|a| a.len() != pairs) {
            return Err(SolveError::Checkpoint { what: "its interface has another number of pairs" });
        }
        Ok((problem, cuts))
    }

    /// Returns the initial values of the iteration on the mesh of a step, from 2.
    pub(crate) fn start_of<S: ContactSpace>(&self, step: usize) -> Result<&Start, SolveError<S>> {
        let mesh = self.meshes.get(step.wrapping_sub(2));
        mesh.map(|m| &m.start).ok_or(SolveError::Checkpoint { what: "it lacks a mesh" })
    }

    /// Removes the mesh that is still to be solved: the previous one is then solved again.
    pub(crate) fn step_back(&mut self) {
        self.meshes.pop();
        self.history.pop();
    }
}
