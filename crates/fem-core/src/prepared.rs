//! A contact problem that is ready to be solved.

use crate::assembly::{AssemblyError, System, external_forces};
use crate::condensation::{CondensedBody, FactorError, OrientedBody};
use crate::dof::DofMap;
use crate::each_body::each_body;
use crate::geometry::Vector;
use crate::interface::{ContactProblem, Roles};
use thiserror::Error;

/// A contact problem with its factorised bodies and their loads: all that an iteration and an estimator need.
#[derive(Clone, Debug)]
pub struct PreparedProblem {
    problem: ContactProblem,
    bodies: [CondensedBody; 2],
    external_forces: [Vec<Vector>; 2],
}

/// What is made next of both bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The order of the unknowns, and the tree of fronts.
    Ordering,
    /// Stiffness and load.
    Assembly,
    /// The factor and the interface operator.
    Factorisation,
    /// Nothing: all is ready.
    Ready,
}

/// Why a problem could not be prepared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// A system that cannot be assembled.
    #[error("body {}: {source}", body + 1)]
    Assembly {
        /// The body, from 0.
        body: usize,
        /// Why.
        source: AssemblyError,
    },
    /// A stiffness that cannot be factorised.
    #[error("body {}: {source}", body + 1)]
    Factor {
        /// The body, from 0.
        body: usize,
        /// Why.
        source: FactorError,
    },
    /// The caller ended it.
    #[error("ended before all bodies were factorised")]
    Stopped,
}

impl PreparedProblem {
    /// Assembles and factorises both bodies, in parallel.
    ///
    /// # Errors
    /// A body without unique solution.
    pub fn new(problem: ContactProblem) -> Result<Self, PrepareError> {
        Self::prepare(problem, |_| true)
    }

    /// [`Self::new`], asking before each stage whether to continue.
    ///
    /// # Errors
    /// A body without unique solution; [`PrepareError::Stopped`] if the answer is `false`.
    pub fn prepare(
        problem: ContactProblem,
        mut proceed: impl FnMut(Stage) -> bool,
    ) -> Result<Self, PrepareError> {
        let mut before = |stage| if proceed(stage) { Ok(()) } else { Err(PrepareError::Stopped) };
        let sides = problem.interface.sides();
        before(Stage::Ordering)?;
        let [first, second] = each_body(|b| DofMap::new(&problem.bodies[b], &sides[b]));
        before(Stage::Assembly)?;
        let assemble = |b: usize, dofs: DofMap| {
            System::with_dofs(&problem.bodies[b], dofs)
                .map_err(|source| PrepareError::Assembly { body: b, source })
        };
        let (first, second) = rayon::join(|| assemble(0, first), || assemble(1, second));
        let (first, second) = (first?, second?);
        before(Stage::Factorisation)?;
        let factorise = |b: usize, system: System| {
            CondensedBody::factorise(system, problem.bodies[b].mesh().points())
                .map_err(|source| PrepareError::Factor { body: b, source })
        };
        let (first, second) = rayon::join(|| factorise(0, first), || factorise(1, second));
        let bodies = [first?, second?];
        before(Stage::Ready)?;
        let external_forces = each_body(|b| external_forces(&problem.bodies[b]));
        Ok(Self { problem, bodies, external_forces })
    }

    /// Returns the problem.
    pub fn problem(&self) -> &ContactProblem {
        &self.problem
    }

    /// Returns the problem alone.
    pub fn into_problem(self) -> ContactProblem {
        self.problem
    }

    /// Returns the factorised bodies.
    pub fn bodies(&self) -> &[CondensedBody; 2] {
        &self.bodies
    }

    /// Returns the factorised bodies, to replace their condensed loads.
    pub fn bodies_mut(&mut self) -> &mut [CondensedBody; 2] {
        &mut self.bodies
    }

    /// Returns the nodal forces of tractions and body force of each body, Cartesian, N/m.
    pub fn external_forces(&self) -> &[Vec<Vector>; 2] {
        &self.external_forces
    }

    /// Returns the number of pairs.
    pub fn pairs(&self) -> usize {
        self.problem.interface.pairs().len()
    }

    /// Returns the roles of the bodies in an iteration.
    pub fn roles(&self) -> Roles {
        self.problem.interface.roles()
    }

    /// Gives the bodies other roles. No body changes, and no factor.
    pub fn set_roles(&mut self, roles: Roles) {
        self.problem.interface.set_roles(roles);
    }

    /// Replaces the gaps of the pairs, m, and returns the old ones: the problem for increments about a state.
    ///
    /// # Panics
    /// If there is not one gap per pair.
    pub fn replace_gaps(&mut self, gaps: &[f64]) -> Vec<f64> {
        self.problem.interface.replace_gaps(gaps)
    }

    /// Returns Ω₁ and Ω₂ as the iteration sees them: along the outward normal of Ω₁.
    pub fn sides(&self) -> [OrientedBody<'_>; 2] {
        let roles = self.roles();
        roles.bodies().map(|b| self.bodies[b].oriented(roles.sign()))
    }

    /// Recovers the displacements of the bodies (Cartesian, m) from the normal traces of Ω₁ and Ω₂.
    ///
    /// # Panics
    /// If a trace has not one entry per pair.
    pub fn displacements(&self, traces: [&[f64]; 2]) -> [Vec<Vector>; 2] {
        let sides = self.sides();
        self.roles().by_body(each_body(|role| sides[role].displacement_from_trace(traces[role])))
    }
}
