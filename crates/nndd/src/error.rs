//! Errors of invalid calls. How an iteration ended is a [`crate::NnddStatus`], never an error.

use crate::unresisted::UnresistedMotion;
use contact_qp::QpError;
use neumann_neumann::BalancingError;
use thiserror::Error;

/// Why an iteration could not be run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NnddError {
    /// The sizes of problem, condensed bodies and λ do not match.
    #[error("{what} has {found} interface unknowns; {expected} are needed")]
    Length {
        /// What has the wrong size.
        what: &'static str,
        /// Its size.
        found: usize,
        /// Number of rows: of pairs, and with friction of their tangents.
        expected: usize,
    },
    /// Contact normals of a body depend on each other or on its supports: a node is in two pairs with parallel normals, or a
    /// support imposes its displacement along a normal. The exact solution allows that, see [`crate::solve_exactly`].
    #[error("contact normals of body {} depend on each other or on its supports; the iteration does not allow that, the exact solution does", body + 1)]
    DependentRows {
        /// The body, from 0.
        body: usize,
    },
    /// The loads move bodies that nothing holds.
    #[error("the assembly is not held: the loads do work along a motion that nothing resists")]
    NotHeld {
        /// The motion.
        motion: UnresistedMotion,
    },
    /// The iteration is asked for with friction of solids.
    #[error("pair {} is one of solids with friction, which the iteration does not solve; use the exact method", pair + 1)]
    FrictionInSpace {
        /// The pair, from 0.
        pair: usize,
    },
    /// The iteration is asked for with a pair both sides of which belong to one body.
    #[error("both sides of pair {} belong to one bonded body, which the iteration does not solve; use the exact method", pair + 1)]
    WithinABody {
        /// The pair, from 0.
        pair: usize,
    },
    /// No forces within the cones of Coulomb friction balance the loads.
    #[error(
        "the load is not balanced within the friction cones; hold the bodies, or raise the coefficients of friction"
    )]
    OutsideCones {
        /// The motion along the load that is left.
        motion: UnresistedMotion,
    },
    /// The law of Coulomb is not a programme.
    #[error("pair {} has Coulomb friction; solve it with `solve_coulomb`", pair + 1)]
    Coulomb {
        /// The pair, from 0.
        pair: usize,
    },
    /// θ is not a positive number.
    #[error("theta is {found}; it must be a positive, finite number")]
    Theta {
        /// The value found.
        found: f64,
    },
    /// The initial λ is infinite or NaN.
    #[error("the initial lambda of pair {pair} is {found}; finite numbers are needed")]
    Lambda {
        /// Number of the pair.
        pair: usize,
        /// The value found.
        found: f64,
    },
    /// The contact problem was rejected.
    #[error("a contact problem cannot be solved: {0}")]
    Qp(#[from] QpError),
    /// The stopping criterion failed.
    #[error("the stopping criterion failed: {0}")]
    Criterion(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl From<BalancingError> for NnddError {
    fn from(error: BalancingError) -> Self {
        match error {
            BalancingError::DependentRows { body } => Self::DependentRows { body },
            BalancingError::Coarse(error) => Self::Qp(error),
        }
    }
}
