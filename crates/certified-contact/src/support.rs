//! The question whether an assembly is held, in words of its bodies.

use crate::bonded;
use crate::error::{SolveError, in_bodies};
use crate::space::ContactSpace;
use fem_core::body::RigidMotion;
use fem_core::interface::{Bonds, ContactProblem, Partner};
use fem_core::prepared::AssemblyMotion;
use fem_core::space::{Plane, Space};
use nndd::UnresistedMotion;

/// A body that moves by less than this fraction of the one that moves most does not count as part of a free motion.
const WEAK: f64 = 1e-3;

/// A motion of the assembly: each body or obstacle that moves, with its own motion.
pub type PartnerMotions<S = Plane> = Vec<(Partner, RigidMotion<S>)>;

/// A motion that no pair resists. It stays at zero.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FreeMotion<S: Space = Plane> {
    /// The bodies and obstacles that move, the one that moves most (by 1 m) first.
    pub bodies: PartnerMotions<S>,
    /// The size of the load along it, N/m; 0 if no load drives it. A load is left out as far as the error of a polygon explains it, see
    /// [`ContactProblem::without_spins`], and is not held otherwise.
    pub load: f64,
    /// Whether the pairs resist it, by less than the error of their normals. The forces of the solution balance its load only up to that error then;
    /// the pressures of the certificate balance it.
    pub weak: bool,
}

/// How an assembly is held.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Support<S: Space = Plane> {
    /// The motion that the loads cause and nothing resists; `None` if the assembly is held.
    pub unresisted: Option<AssemblyMotion<S>>,
    /// See [`free_motions`].
    pub free_motions: Vec<FreeMotion<S>>,
    /// Forces that balance the loads, for [`ContactProblem::balancing`]; empty if none are needed, or none do.
    pub forces: Vec<f64>,
}

/// Tells how an assembly is held, without solving anything.
///
/// # Errors
/// Numbers that are not finite; [`SolveError::OutsideCones`] if no forces within the cones of Coulomb friction balance the loads.
pub fn support<S: ContactSpace>(problem: &ContactProblem<S>) -> Result<Support<S>, SolveError<S>> {
    if let Some(mut bonds) = Bonds::new(problem)? {
        let found = support(&bonds.take_joined()).map_err(|error| error.of_members(&bonds))?;
        return Ok(Support {
            free_motions: of_members(&bonds, found.free_motions),
            unresisted: found.unresisted.map(|of| bonded::of_members(&bonds, of)),
            forces: Vec::new(),
        });
    }
    let problem = &S::without_spin(problem.clone())?;
    let found =
        nndd::support(&problem.contact_rows()).map_err(|error| SolveError::of_nndd(problem, error))?;
    Ok(Support {
        free_motions: free_in_bodies(problem, &found.free_motions),
        unresisted: found.unresisted.map(|of| in_bodies(problem, &of)),
        forces: found.forces,
    })
}

/// Lists the motions that no pair resists and no load drives, and those of bodies whose contact lines are all on declared arcs with their loads, without
/// asking whether the assembly is held.
///
/// # Errors
/// Numbers that are not finite.
pub fn free_motions<S: ContactSpace>(
    problem: &ContactProblem<S>,
) -> Result<Vec<FreeMotion<S>>, SolveError<S>> {
    if let Some(mut bonds) = Bonds::new(problem)? {
        let found = free_motions(&bonds.take_joined())?;
        return Ok(of_members(&bonds, found));
    }
    let found = nndd::free_motions(&problem.contact_rows()).map_err(SolveError::Nndd)?;
    Ok(free_in_bodies(problem, &found))
}

/// Says which of the given bodies move.
fn of_members<S: Space>(bonds: &Bonds<S>, found: Vec<FreeMotion<S>>) -> Vec<FreeMotion<S>> {
    let members = |(partner, motion): (Partner, RigidMotion<S>)| -> PartnerMotions<S> {
        match partner.body() {
            Some(body) => bonds.members(body).map(|member| (Partner::Body(member), motion)).collect(),
            None => vec![(partner, motion)],
        }
    };
    let of =
        |of: FreeMotion<S>| FreeMotion { bodies: of.bodies.into_iter().flat_map(members).collect(), ..of };
    found.into_iter().map(of).collect()
}

fn free_in_bodies<S: ContactSpace>(
    problem: &ContactProblem<S>,
    found: &[UnresistedMotion],
) -> Vec<FreeMotion<S>> {
    let motions = problem.rigid_motions();
    let of = |of: &UnresistedMotion| {
        let motion = problem.assembly_motion(&motions, &of.amounts, of.work, WEAK);
        let left_out = problem.left_out.iter().find(|left_out| {
            motion.bodies.iter().any(|(partner, _)| *partner == Partner::Body(left_out.body))
        });
        let load = left_out.map_or(motion.load, |left_out| left_out.load).abs();
        let mut bodies: Vec<_> = motion.bodies.into_iter().zip(motion.largest).collect();
        bodies.sort_by(|a, b| b.1.total_cmp(&a.1));
        FreeMotion { bodies: bodies.into_iter().map(|(of, _)| of).collect(), load, weak: of.weak }
    };
    let may_be_left_out =
        |motion: &FreeMotion<S>| motion.bodies.iter().all(|(partner, _)| is_on_arcs(problem, *partner));
    let found =
        found.iter().map(of).filter(|motion| motion.load == 0.0 || motion.weak || may_be_left_out(motion));
    let mut free: Vec<FreeMotion<S>> = found.collect();
    free.sort_by_key(|motion| motion.bodies.first().map(|(body, _)| *body));
    free
}

/// Tells whether all contact lines of a body are on declared arcs.
fn is_on_arcs<S: ContactSpace>(problem: &ContactProblem<S>, partner: Partner) -> bool {
    let mut pairs = problem.contacts.iter().filter(|pair| pair.side_of(partner).is_some());
    pairs.all(|pair| S::is_on_arc(&pair.interface))
}
