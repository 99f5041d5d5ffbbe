//! The question whether an assembly is held, in words of its bodies.

use crate::error::{NO_MOTION, SolveError};
use crate::space::ContactSpace;
use fem_core::body::RigidMotion;
use fem_core::interface::{ContactProblem, Partner};
use fem_core::prepared::{AssemblyMotion, BodyMotion};
use fem_core::space::{Plane, Space};

/// A body that moves by less than this fraction of the one that moves most does not count as part of a free motion.
const WEAK: f64 = 1e-3;

/// A motion of the assembly: each body or obstacle that moves, with its own motion.
pub type PartnerMotions<S = Plane> = Vec<(Partner, RigidMotion<S>)>;

/// How an assembly is held.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Support<S: Space = Plane> {
    /// The motion that the loads cause and nothing resists; `None` if the assembly is held.
    pub unresisted: Option<AssemblyMotion<S>>,
    /// The motions that no pair resists and no load drives: each with the bodies and obstacles that move, the one that moves most (by 1 m) first.
    /// They stay at zero.
    pub free_motions: Vec<PartnerMotions<S>>,
    /// Forces that balance the loads, for [`ContactProblem::balancing`]; empty if none are needed, or none do.
    pub forces: Vec<f64>,
}

/// Tells how an assembly is held, without solving anything.
///
/// # Errors
/// Numbers that are not finite; [`SolveError::OutsideCones`] if no forces within the cones of Coulomb friction balance the loads.
pub fn support<S: ContactSpace>(problem: &ContactProblem<S>) -> Result<Support<S>, SolveError<S>> {
    let problem = &S::without_spin(problem.clone())?;
    let found =
        nndd::support(&problem.contact_rows()).map_err(|error| SolveError::of_nndd(problem, error))?;
    let motions = problem.rigid_motions();
    let motion =
        |of: nndd::UnresistedMotion| problem.assembly_motion(&motions, &of.amounts, of.work, NO_MOTION);
    Ok(Support {
        free_motions: in_bodies(problem, &motions, &found.free_motions),
        unresisted: found.unresisted.map(motion),
        forces: found.forces,
    })
}

/// Lists the motions that no pair resists and no load drives, see [`Support::free_motions`], without asking whether the assembly is held.
///
/// # Errors
/// Numbers that are not finite.
pub fn free_motions<S: ContactSpace>(
    problem: &ContactProblem<S>,
) -> Result<Vec<PartnerMotions<S>>, SolveError<S>> {
    let problem = &S::without_spin(problem.clone())?;
    let found = nndd::free_motions(&problem.contact_rows()).map_err(SolveError::Nndd)?;
    Ok(in_bodies(problem, &problem.rigid_motions(), &found))
}

fn in_bodies<S: Space>(
    problem: &ContactProblem<S>,
    motions: &[BodyMotion<S>],
    found: &[Vec<(usize, f64)>],
) -> Vec<PartnerMotions<S>> {
    let of = |amounts: &Vec<(usize, f64)>| {
        let motion = problem.assembly_motion(motions, amounts, 0.0, WEAK);
        let mut bodies: Vec<_> = motion.bodies.into_iter().zip(motion.largest).collect();
        bodies.sort_by(|a, b| b.1.total_cmp(&a.1));
        bodies.into_iter().map(|(of, _)| of).collect()
    };
    let mut free: Vec<PartnerMotions<S>> = found.iter().map(of).collect();
    free.sort_by_key(|bodies| bodies.first().map(|(body, _)| *body));
    free
}
