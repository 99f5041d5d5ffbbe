//! Every check of a case that needs no factorisation.

use crate::failure::Failure;
use crate::motion::{member, moves};
use crate::space::ReportSpace;
use crate::words::ROUNDING;
use case_io::Case;
use case_io::case::{BodyCase, Contact, Factors};
use certified_contact::contact_geometry::{FacingSides, facing_sides};
use certified_contact::{FreeMotion, SolveError};
use fem_core::assembly::{AssemblyError, external_forces};
use fem_core::body::{Body, RigidSide};
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactProblem;
use fem_core::prepared::PrepareError;
use fem_core::space::{Plane, Space};
use serde_json::{Value, json};
use std::collections::HashMap;

/// The parts of a body of a case.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckedBody<S: Space = Plane> {
    /// Its name.
    pub name: String,
    /// Its sides, each with the number of its facets.
    pub sides: Vec<(String, usize)>,
    /// Number of conditions that support it.
    pub supports: usize,
    /// Number of sides that stay rigid.
    pub rigid_sides: usize,
    /// Number of sides on springs.
    pub springs: usize,
    /// Number of cuts.
    pub cuts: usize,
    /// Number of nodes that are held in some direction, by supports or rigid sides that cannot move.
    pub held_nodes: usize,
    /// Number of conditions that load it: tractions, rigid sides with a force or a moment, and a body force.
    pub loads: usize,
    /// Resultant of its loads, N/m, of solids N.
    pub resultant: S::Vector,
    /// The smallest angle of its mesh, of solids between two faces, degrees.
    pub smallest_angle: f64,
}

/// Describes the bodies of a case, in the file's order, if supports and contacts hold them.
///
/// # Errors
/// Bodies that the loads move and nothing holds.
pub fn check<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
) -> Result<Vec<CheckedBody<S>>, Failure> {
    balancing(case, problem)?;
    let checked = |(k, (body, model)): (usize, (&BodyCase<S>, &Body<S>))| {
        let loaded =
            |side: &&RigidSide<S>| side.force != S::Vector::ZERO || side.moment != S::Spin::default();
        Ok(CheckedBody {
            name: body.name.clone(),
            sides: model.mesh().groups().iter().map(|(name, edges)| (name.clone(), edges.len())).collect(),
            supports: model.supports().len(),
            rigid_sides: model.rigid_sides().len(),
            springs: model.springs().len(),
            cuts: model.cuts().len(),
            held_nodes: model.node_constraints().iter().filter(|node| !node.supported().is_none()).count(),
            loads: body.tractions.len()
                + model.rigid_sides().iter().filter(loaded).count()
                + usize::from(model.has_force())
                + body.temperatures.len(),
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
fn resultant_of<V: Coordinates>(forces: &[V]) -> Option<V> {
    let size: f64 = forces.iter().map(V::largest).sum();
    let sum: V = forces.iter().copied().sum();
    let exact = V::of(|c| if sum[c].abs() <= ROUNDING * size { 0.0 } else { sum[c] });
    size.is_finite().then_some(exact)
}

/// Computes the resultant of all loads of a case, loads of obstacles included, N/m.
pub fn resultant<S: Space>(problem: &ContactProblem<S>, bodies: &[CheckedBody<S>]) -> S::Vector {
    let of_obstacles = problem.obstacles.iter().map(|obstacle| obstacle.force);
    bodies.iter().map(|body| body.resultant).chain(of_obstacles).sum()
}

/// Bodies of one motion, and motions, that are named.
pub(crate) const MOST_NAMED: usize = 3;

/// Refuses an assembly that the loads move and nothing holds, before anything is computed or written. The answer is kept with the problem.
///
/// # Errors
/// The bodies that move, with their motions and the load; a body that moves without strain where a load acts.
pub fn held<S: ReportSpace>(case: &Case<S>, problem: &mut ContactProblem<S>) -> Result<(), Failure> {
    problem.balancing = balancing(case, problem)?;
    Ok(())
}

/// Finds the forces that balance the loads, at the end of the last load step.
fn balancing<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Result<Vec<f64>, Failure> {
    // Loads are linear in the factors: what holds at the ends of the load steps holds between them.
    let mut forces = None;
    for factors in case.step_ends() {
        forces = Some(balancing_under(case, &with_factors(case, problem, &factors)?)?);
    }
    forces.map_or_else(|| balancing_under(case, problem), Ok)
}

fn balancing_under<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Result<Vec<f64>, Failure> {
    let support = certified_contact::support(problem).map_err(|error| Failure::solve(case, &error))?;
    match support.unresisted {
        Some(motion) => Err(Failure::solve(case, &SolveError::NotHeld { motion })),
        None => Ok(support.forces),
    }
}

/// Makes the problem with the loads at the end of a load step.
pub(crate) fn with_factors<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    factors: &Factors,
) -> Result<ContactProblem<S>, Failure> {
    let of_gap = |pair: usize| case.gap_factor(factors, pair);
    let scaled = problem.with_factors(&|body, place| case.factor(factors, body, place), &of_gap);
    scaled.map_err(|error| Failure::solve(case, &SolveError::Factors(error)))
}

/// A motion that nothing resists, in words, with its load and whether it is weak, see [`certified_contact::FreeMotion`].
pub(crate) type NamedMotion = (String, f64, bool);

/// Says what the motions are that nothing resists.
///
/// # Errors
/// Numbers that are not finite.
pub(crate) fn free_motions<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
) -> Result<Vec<NamedMotion>, Failure> {
    let loaded = case.step_ends().pop().map(|factors| with_factors(case, problem, &factors)).transpose()?;
    let found = certified_contact::free_motions(loaded.as_ref().unwrap_or(problem));
    let found = found.map_err(|error| Failure::solve(case, &error))?;
    let of_motion = |FreeMotion { bodies, load, weak, .. }: &FreeMotion<S>| {
        let moves = bodies.iter().map(|(b, motion)| format!("{} {}", member(case, *b), moves(motion)));
        let mut words: Vec<String> = moves.take(MOST_NAMED).collect();
        words.extend(
            bodies.len().checked_sub(MOST_NAMED + 1).map(|more| format!("{} more with it", more + 1)),
        );
        (words.join(" and "), *load, *weak)
    };
    Ok(found.iter().map(of_motion).collect())
}

/// Two sides that face each other, with the names of the bodies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckedSides {
    /// Body and side, in the file's order of the bodies.
    pub sides: [(String, String); 2],
    /// The name of the contact in which they are; `None` if they are in none.
    pub contact: Option<String>,
}

/// Lists the sides of different bodies that face each other, and the contact in which facets of both are.
pub fn facing<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Vec<CheckedSides> {
    let share = |body: usize, names: [&str; 2]| {
        let [own, given] = names.map(|name| problem.bodies[body].mesh().group(name).unwrap_or(&[]));
        // Both are sorted by number.
        own.iter().any(|facet| given.binary_search(facet).is_ok())
    };
    // By their bodies: there may be thousands of contacts.
    let mut contacts: HashMap<[usize; 2], Vec<&Contact<S>>> = HashMap::new();
    for contact in &case.contacts {
        if let [a, b] = contact.bodies[..] {
            contacts.entry([a.min(b), a.max(b)]).or_default().push(contact);
        }
    }
    let of = |FacingSides { bodies, sides, .. }: FacingSides| {
        let is_in = |contact: &&&Contact<S>| {
            (0..2).all(|k| {
                let mut given = contact.bodies.iter().zip(&contact.surfaces);
                given.any(|(b, name)| *b == bodies[k] && share(*b, [&sides[k], name]))
            })
        };
        let of_bodies = contacts.get(&bodies).into_iter().flatten();
        let contact = of_bodies.into_iter().find(is_in).map(|contact| contact.name.clone());
        let [first, second] = sides;
        let name = |k: usize| case.bodies[bodies[k]].name.clone();
        CheckedSides { sides: [(name(0), first), (name(1), second)], contact }
    };
    let meshes: Vec<_> = problem.bodies.iter().map(Body::mesh).collect();
    facing_sides(&meshes, 1.0).into_iter().map(of).collect()
}

/// Makes one object of what a check found.
///
/// * `notes`: about the case and the problem, see [`crate::run::build`] and [`crate::notes::of_problem`]; `memory`: see [`crate::memory::Plan::estimate`], bytes.
pub fn summary<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    bodies: &[CheckedBody<S>],
    notes: &[String],
    memory: f64,
) -> Value {
    let body = |(k, body): (usize, &CheckedBody<S>)| {
        let mesh = problem.bodies[k].mesh();
        let sides: serde_json::Map<String, Value> =
            body.sides.iter().map(|(name, edges)| (name.clone(), json!(edges))).collect();
        json!({
            "name": body.name,
            "nodes": mesh.points().len(),
            S::WORDS.cells: mesh.cells().len(),
            "sides": sides,
            "supports": body.supports,
            "held_nodes": body.held_nodes,
            "rigid_sides": body.rigid_sides,
            "springs": body.springs,
            "cuts": body.cuts,
            "loads": body.loads,
            "resultant": body.resultant.entries(),
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
            S::EXTENT: pair.interface.measure(),
        })
    });
    let facing = facing(case, problem).into_iter().map(|CheckedSides { sides, contact }| {
        let [bodies, surfaces] = [sides.each_ref().map(|of| &of.0), sides.each_ref().map(|of| &of.1)];
        json!({ "bodies": bodies, "surfaces": surfaces, "contact": contact })
    });
    json!({
        "event": "checked",
        "case": case.file_name(),
        "bodies": bodies.iter().enumerate().map(body).collect::<Vec<_>>(),
        "contact": contact.collect::<Vec<_>>(),
        "facing": facing.collect::<Vec<_>>(),
        "resultant": resultant(problem, bodies).entries(),
        "memory_bytes": memory.round() as u64,
        "notes": notes,
        "warnings": case.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
