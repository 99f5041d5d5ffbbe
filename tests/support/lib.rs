//! Reference problems with trusted answers, one file each, and the few steps every test shares.
//!
//! Each file says where its reference values come from and of which kind they are: exact, from an
//! independent code, or an earlier value of this code.

use fem_core::assembly::{AssemblyError, System};
use fem_core::body::Body;
use fem_core::condensation::CondensedBody;
use fem_core::interface::{ContactProblem, InterfaceSide};

pub mod paper;
pub mod patch;
pub mod signorini;

/// Assembles and factorises a body that is known to be sound.
///
/// # Panics
/// If it is not.
pub fn condense(body: &Body, side: &InterfaceSide) -> CondensedBody {
    let system: Result<System, AssemblyError> = System::assemble(body, side);
    match system.map(|s| CondensedBody::factorise(s, body.mesh().points())) {
        Ok(Ok(condensed)) => condensed,
        Ok(Err(e)) => unreachable!("the reference body cannot be factorised: {e}"),
        Err(e) => unreachable!("the reference body cannot be assembled: {e}"),
    }
}

/// Condenses both bodies of a reference problem.
pub fn condense_both(problem: &ContactProblem) -> [CondensedBody; 2] {
    let sides = problem.interface.sides();
    [condense(&problem.bodies[0], &sides[0]), condense(&problem.bodies[1], &sides[1])]
}
