//! Every check of a case that needs no factorisation.

use crate::failure::Failure;
use crate::memory;
use crate::motion::{member, moves};
use crate::words::ROUNDING;
use case_io::Case;
use case_io::case::{BodyCase, Factors};
use certified_contact::SolveError;
use fem_core::assembly::{AssemblyError, external_forces};
use fem_core::body::{Body, RigidMotion, RigidSide};
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Partner};
use fem_core::prepared::PrepareError;
use serde_json::{Value, json};

/// The parts of a body of a case.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckedBody {
    /// Its name.
    pub name: String,
    /// Its sides, each with the number of its edges.
    pub sides: Vec<(String, usize)>,
    /// Number of conditions that support it.
    pub supports: usize,
    /// Number of sides that stay rigid.
    pub rigid_sides: usize,
    /// Number of nodes that are held in some direction, by supports or rigid sides that cannot move.
    pub held_nodes: usize,
    /// Number of conditions that load it: tractions, rigid sides with a force or a moment, and a body force.
    pub loads: usize,
    /// Resultant of its loads, N/m.
    pub resultant: Vector,
    /// The smallest angle of its mesh, degrees.
    pub smallest_angle: f64,
}

/// Describes the bodies of a case, in the file's order, if supports and contacts hold them.
///
/// # Errors
/// Bodies that the loads move and nothing holds.
pub fn check(case: &Case, problem: &ContactProblem) -> Result<Vec<CheckedBody>, Failure> {
    balancing(case, problem)?;
    let checked = |(k, (body, model)): (usize, (&BodyCase, &Body))| {
        let loaded = |side: &&RigidSide| side.force != Vector::zeros() || side.moment != 0.0;
        Ok(CheckedBody {
            name: body.name.clone(),
            sides: model.mesh().groups().iter().map(|(name, edges)| (name.clone(), edges.len())).collect(),
            supports: model.supports().len(),
            rigid_sides: model.rigid_sides().len(),
            held_nodes: model.node_constraints().iter().filter(|node| !node.supported().is_none()).count(),
            loads: body.tractions.len()
                + model.rigid_sides().iter().filter(loaded).count()
                + usize::from(model.body_force() != Vector::zeros()),
            resultant: resultant_of(&external_forces(model)).ok_or_else(|| {
                let source = AssemblyError::NotFinite { what: "the load" };
                Failure::solve(case, &SolveError::Prepare(PrepareError::Assembly { body: k, source }))
            })?,
            smallest_angle: model.mesh().smallest_angle(),
        })
    };
    case.bodies.iter().zip(&problem.bodies).enumerate().map(checked).collect()
}

/// Adds forces, N/m; a component that is rounding is zero. `None` if they are too large.
fn resultant_of(forces: &[Vector]) -> Option<Vector> {
    let size: f64 = forces.iter().map(Vector::amax).sum();
    let sum: Vector = forces.iter().sum();
    let exact = sum.map(|c| if c.abs() <= ROUNDING * size { 0.0 } else { c });
    size.is_finite().then_some(exact)
}

/// Computes the resultant of all loads of a case, loads of obstacles included, N/m.
pub fn resultant(problem: &ContactProblem, bodies: &[CheckedBody]) -> Vector {
    let of_obstacles = problem.obstacles.iter().map(|obstacle| obstacle.force);
    bodies.iter().map(|body| body.resultant).chain(of_obstacles).sum()
}

/// Bodies of one motion, and motions, that are named.
pub(crate) const MOST_NAMED: usize = 3;

/// Refuses an assembly that the loads move and nothing holds, before anything is computed or written. The answer is kept with the problem.
///
/// # Errors
/// The bodies that move, with their motions and the load; a body that moves without strain where a load acts.
pub fn held(case: &Case, problem: &mut ContactProblem) -> Result<(), Failure> {
    problem.balancing = balancing(case, problem)?;
    Ok(())
}

/// Finds the forces that balance the loads, at the end of the last load step.
fn balancing(case: &Case, problem: &ContactProblem) -> Result<Vec<f64>, Failure> {
    // Loads are linear in the factors: what holds at the ends of the load steps holds between them.
    let mut forces = None;
    for factors in case.step_ends() {
        forces = Some(balancing_under(case, &with_factors(case, problem, &factors)?)?);
    }
    forces.map_or_else(|| balancing_under(case, problem), Ok)
}

fn balancing_under(case: &Case, problem: &ContactProblem) -> Result<Vec<f64>, Failure> {
    let support = certified_contact::support(problem).map_err(|error| Failure::solve(case, &error))?;
    match support.unresisted {
        Some(motion) => Err(Failure::solve(case, &SolveError::NotHeld { motion })),
        None => Ok(support.forces),
    }
}

/// Makes the problem with the loads at the end of a load step.
pub(crate) fn with_factors(
    case: &Case,
    problem: &ContactProblem,
    factors: &Factors,
) -> Result<ContactProblem, Failure> {
    let scaled = problem.with_factors(&|body, place| case.factor(factors, body, place));
    scaled.map_err(|error| Failure::solve(case, &SolveError::Factors(error)))
}

/// Says what the motions are that nothing resists and no load drives.
///
/// # Errors
/// Numbers that are not finite.
pub(crate) fn free_motions(case: &Case, problem: &ContactProblem) -> Result<Vec<String>, Failure> {
    let loaded = case.step_ends().pop().map(|factors| with_factors(case, problem, &factors)).transpose()?;
    let found = certified_contact::free_motions(loaded.as_ref().unwrap_or(problem));
    let found = found.map_err(|error| Failure::solve(case, &error))?;
    let of_motion = |bodies: &Vec<(Partner, RigidMotion)>| {
        let moves = bodies.iter().map(|(b, motion)| format!("{} {}", member(case, *b), moves(motion)));
        let mut words: Vec<String> = moves.take(MOST_NAMED).collect();
        words.extend(
            bodies.len().checked_sub(MOST_NAMED + 1).map(|more| format!("{} more with it", more + 1)),
        );
        words.join(" and ")
    };
    Ok(found.iter().map(of_motion).collect())
}

/// Makes one object of what a check found.
///
/// * `notes`: about the case and the problem, see [`crate::run::build`] and [`crate::notes::of_problem`].
pub fn summary(case: &Case, problem: &ContactProblem, bodies: &[CheckedBody], notes: &[String]) -> Value {
    let body = |(k, body): (usize, &CheckedBody)| {
        let mesh = problem.bodies[k].mesh();
        let sides: serde_json::Map<String, Value> =
            body.sides.iter().map(|(name, edges)| (name.clone(), json!(edges))).collect();
        json!({
            "name": body.name,
            "nodes": mesh.points().len(),
            "triangles": mesh.cells().len(),
            "sides": sides,
            "supports": body.supports,
            "held_nodes": body.held_nodes,
            "rigid_sides": body.rigid_sides,
            "loads": body.loads,
            "resultant": <[f64; 2]>::from(body.resultant),
            "smallest_angle": body.smallest_angle,
            "floating": problem.bodies[k].free_motion().is_some(),
        })
    };
    let contact = case.contacts.iter().zip(&problem.contacts).map(|(given, pair)| {
        json!({
            "name": given.name,
            "bodies": given.bodies.iter().map(|b| &case.bodies[*b].name).collect::<Vec<_>>(),
            "surfaces": given.surfaces,
            "obstacle": given.obstacle.is_some(),
            "free_motions": problem.obstacle_of(pair).map_or(0, |obstacle| obstacle.free_motions().len()),
            "pairs": pair.interface.pairs().len(),
            "length": pair.interface.measure(),
        })
    });
    json!({
        "event": "checked",
        "case": case.file_name(),
        "bodies": bodies.iter().enumerate().map(body).collect::<Vec<_>>(),
        "contact": contact.collect::<Vec<_>>(),
        "resultant": <[f64; 2]>::from(resultant(problem, bodies)),
        "memory_bytes": memory::estimate(problem).round() as u64,
        "notes": notes,
        "warnings": case.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
