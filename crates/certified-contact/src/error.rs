//! Errors on the way from a problem to its certified solution.

use contact_geometry::RefineError;
use cre_estimator::EstimatorError;
use fem_core::interface::{BondError, ContactProblem, InterfaceError, LoadFactorError};
use fem_core::prepared::{AssemblyMotion, PrepareError};
use fem_core::space::{Plane, Space};
use nndd::{NnddError, UnresistedMotion};
use thiserror::Error;

/// Why a problem could not be solved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SolveError<S: Space = Plane> {
    /// The bodies cannot be assembled or factorised, for example floating ones.
    #[error(transparent)]
    Prepare(PrepareError),
    /// The loads move bodies that nothing holds.
    #[error("the assembly is not held: a load of {:e} moves {} and nothing resists", motion.load, motion.bodies.iter().map(|of| of.0.to_string()).collect::<Vec<_>>().join(", "))]
    NotHeld {
        /// The motion.
        motion: AssemblyMotion<S>,
    },
    /// A load step of an adaptive run cannot be solved.
    #[error("load step {step}: {error}")]
    LoadStep {
        /// Its number, from 1.
        step: usize,
        /// The reason.
        error: Box<Self>,
    },
    /// No forces within the cones of Coulomb friction balance the loads.
    #[error(
        "the load is not balanced within the friction cones: a load of {:e} is left; hold the bodies, or raise the coefficients of friction",
        motion.load
    )]
    OutsideCones {
        /// A motion that no forces within the cones resist, with the load along it. The bodies may move otherwise.
        motion: AssemblyMotion<S>,
    },
    /// No shortening of a cut gives the force in it.
    #[error(
        "no shortening of the cut \"{name}\" up to the size of its body gives the force {force}: at {shortening:e} it is off by {:e}; something \
         must hold both ends of the bolt against it, for example a contact that the force closes", found - force
    )]
    CutForce {
        /// The cut.
        name: String,
        /// The given force, N/m.
        force: f64,
        /// The force that was found, N/m.
        found: f64,
        /// The shortening there, m.
        shortening: f64,
    },
    /// A force in a cut needs the exact solution.
    #[error(
        "the force in the cut \"{name}\" is given, which needs the exact solution without the friction of Coulomb; leave the method to the program, or give a shortening"
    )]
    CutMethod {
        /// The cut.
        name: String,
    },
    /// Bodies in subdomains are solved by one method, for contact without friction.
    #[error("subdomains do not go with {with}: leave the number of subdomains to the program, or write 1")]
    Subdomains {
        /// What was asked for beside them.
        with: &'static str,
    },
    /// Bonded bodies cannot become one.
    #[error(transparent)]
    Bonds(#[from] BondError),
    /// The iteration cannot be run.
    #[error(transparent)]
    Nndd(NnddError),
    /// The first iterate cannot be certified.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The problem cannot be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// The conditions cannot be imposed with the factors of a load step.
    #[error(transparent)]
    Factors(#[from] LoadFactorError),
    /// The slip of a load step is not finite.
    #[error(transparent)]
    Slip(#[from] InterfaceError),
    /// A problem without Coulomb friction.
    #[error("no pair has Coulomb friction; solve the problem with `solve`, which certifies the solution")]
    NoCoulomb,
    /// The observer ended the run before its first iteration: see [`crate::Observer::must_stop`].
    #[error("the run was ended before its first iteration")]
    Stopped,
    /// A checkpoint belongs to another problem.
    #[error("the checkpoint does not belong to this problem: {what}")]
    Checkpoint {
        /// The difference, in words.
        what: &'static str,
    },
}

/// Bodies that move by at most this fraction of the one that moves most do not move.
const NO_MOTION: f64 = 1e-10;

impl<S: Space> SolveError<S> {
    /// Says what an error of the algebra means for the bodies.
    pub(crate) fn of_nndd(problem: &ContactProblem<S>, error: NnddError) -> Self {
        match error {
            NnddError::NotHeld { motion } => Self::NotHeld { motion: in_bodies(problem, &motion) },
            NnddError::OutsideCones { motion } => Self::OutsideCones { motion: in_bodies(problem, &motion) },
            other => Self::Nndd(other),
        }
    }
}

/// Returns a motion of the rows as one of the bodies.
pub(crate) fn in_bodies<S: Space>(problem: &ContactProblem<S>, of: &UnresistedMotion) -> AssemblyMotion<S> {
    problem.assembly_motion(&problem.rigid_motions(), &of.amounts, of.work, NO_MOTION)
}
