//! Certificates of displacement fields that other codes computed.

use crate::admissible::{check_finite, check_length};
use crate::error::EstimatorError;
use crate::estimate::{Estimate, estimate_with};
use crate::node_lines::NodeLines;
use crate::recovery::Recovery;
use crate::relaxation::Relaxation;
use crate::round_off::Noise;
use crate::side::side_sign;
use fem_core::body::Body;
use fem_core::field::nodal_residual;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactPair, ContactProblem, ContactState, LeftOut, NodePair, PairState, Partner};
use fem_core::mesh::id::NodeId;
use fem_core::mesh_field::MeshField;
use fem_core::norm::energy_distance_squared;
use fem_core::prepared::{FactorisedBody, PreparedProblem};
use fem_core::space::{Plane, Space};

/// A supported node that misses its imposed displacement by at most this fraction of the largest displacement is put there.
const HELD: f64 = 1e-4;
/// Corners of several pairs are opened in this many rounds.
const ROUNDS: usize = 4;

/// The certificate of a field of another code, see [`certify`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FieldCertificate<S: Space = Plane> {
    /// The estimate of the changed field.
    pub estimate: Estimate<S>,
    /// Energy norm of the difference between the given field and the admissible one, square root of J/m: supports and penetrations that
    /// were mended, and nodes that were moved so that contact surfaces match.
    pub change: f64,
    /// The largest displacement of a supported node that was changed, m.
    pub support_change: f64,
    /// The largest penetration that was removed, m.
    pub penetration: f64,
    /// The supported node that misses its support by most, if it is too much to be mended: then there is no bound.
    pub missed_support: Option<MissedSupport<S>>,
    /// The number of unknowns of each body.
    pub unknowns: Vec<usize>,
    /// The loads without which the problem is posed.
    pub left_out: Vec<LeftOut<S>>,
}

/// A supported node whose displacement is not the imposed one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MissedSupport<S: Space = Plane> {
    /// The body, from 0.
    pub body: usize,
    /// The place of the node, m.
    pub point: S::Vector,
    /// The distance of its displacement from the imposed one, m.
    pub distance: f64,
}

impl<S: Space> FieldCertificate<S> {
    /// Returns the bound of the energy norm of the given field's error, `e_CRE` of the changed field plus the change; `None` if a check
    /// of admissibility fails: then there is no bound.
    pub fn bound(&self) -> Option<f64> {
        Some(self.estimate.certificate()?.e_cre + self.change)
    }

    /// Counts a further difference between the given field and the admissible one.
    ///
    /// * `by`: a bound of its energy norm, square root of J/m.
    pub fn widen(&mut self, by: f64) {
        self.change += by;
    }

    /// Returns [`Self::bound`] over the energy norm of the changed field; `None` if that is zero to rounding.
    pub fn relative(&self) -> Option<f64> {
        self.estimate.over_norm(self.bound()?)
    }
}

/// Certifies displacements that another code computed: with few digits, by a penalty, or wrong ones.
///
/// The field is given on meshes of its own; in the meshes of the problem nodes may have been added or moved so that the contact
/// surfaces match. It is evaluated at the nodes of the problem, and made admissible there: supported nodes get their imposed displacements if they miss them by at most 1e-4 of the
/// largest one, and if the bodies penetrate each other, the nodes of one of them move back. If no pressures are given, contact forces are the
/// forces that the equilibrium of the field lacks. The bound is
/// ```math
/// ‖u − v‖ ≤ e_CRE(v') + ‖v' − v‖
/// ```
/// with the given field `v` and the changed one `v'`; the norm of their difference is exact, over the common parts of the cells of both
/// meshes. A poor field gets a large bound, never a false one.
///
/// * `displacements`: the field of each body, Cartesian, m.
/// * `pressures`: at the pairs of each contact line, Pa; `None`: from the equilibrium of the field.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite, an obstacle that is free to move, friction, a lack of memory.
pub fn certify<S: Recovery>(
    prepared: &PreparedProblem<S>,
    displacements: &[MeshField<'_, S>],
    pressures: Option<&[Vec<f64>]>,
    relaxation: Relaxation,
) -> Result<FieldCertificate<S>, EstimatorError> {
    let problem = prepared.problem();
    if let Some(pair) = problem.contacts.iter().position(|pair| pair.friction.acts()) {
        return Err(EstimatorError::FrictionOfField { pair });
    }
    let touches = |b: usize| {
        let facets = problem.sides_of(Partner::Body(b));
        let mut facets = facets
            .flat_map(|(k, side)| problem.contacts[k].interface.facets().iter().map(move |f| f.facets[side]));
        facets.any(|facet| {
            problem.bodies[b].facet_condition(facet).is_some_and(|of| !of.springs.directions.is_none())
        })
    };
    let cut =
        |(b, field): &(usize, &MeshField<'_, S>)| !field.has_mesh(problem.bodies[*b].mesh()) && touches(*b);
    if let Some((body, _)) = displacements.iter().enumerate().take(problem.bodies.len()).find(cut) {
        return Err(EstimatorError::SpringsOfField { body });
    }
    let mut fields = fields(problem, displacements)?;
    if let Some(pressures) = pressures {
        check_length(|| "the pressure".into(), pressures.len(), problem.contacts.len())?;
        for (k, (given, pair)) in pressures.iter().zip(&problem.contacts).enumerate() {
            let what = || format!("the pressure of pair {}", k + 1);
            check_length(what, given.len(), pair.interface.pairs().len())?;
            check_finite(what, given)?;
        }
    }
    let held: Vec<Held> =
        problem.bodies.iter().zip(&mut fields).map(|(body, field)| hold(body, field)).collect();
    let support_change = held.iter().map(|held| held.changed).fold(0.0, f64::max);
    let missed = held.iter().enumerate().filter_map(|(body, held)| {
        let (node, distance) = held.missed?;
        Some(MissedSupport { body, point: problem.bodies[body].mesh().points()[node], distance })
    });
    let missed_support = missed.max_by(|a, b| a.distance.total_cmp(&b.distance));
    fields.extend(problem.obstacles.iter().map(|obstacle| obstacle.imposed()));
    let penetration = part(problem, &mut fields);
    let openings: Vec<Vec<f64>> =
        problem.contacts.iter().map(|pair| openings(problem, pair, &fields)).collect();
    let forces = match pressures {
        Some(pressures) => {
            let of_pair = |(pair, given): (&ContactPair<S>, &Vec<f64>)| {
                let pairs = pair.interface.pairs().iter().zip(given);
                pairs.map(|(p, pressure)| p.weight * pressure.max(0.0)).collect()
            };
            problem.contacts.iter().zip(pressures).map(of_pair).collect()
        }
        None => contact_forces(problem, &fields),
    };
    let contacts = forces.iter().zip(&openings);
    let state = ContactState {
        displacement: fields.iter().map(Vec::as_slice).collect(),
        contacts: contacts.map(|(force, opening)| PairState::frictionless(force, opening)).collect(),
    };
    let estimate = estimate_with(prepared, &state, relaxation)?;
    let squared = problem.bodies.iter().zip(displacements).zip(&fields);
    let squared = squared.map(|((body, given), changed)| given.energy_distance_squared(body, changed));
    let change = squared.sum::<f64>().sqrt();
    check_finite(|| "the change of the field".into(), &[change])?;
    let unknowns = prepared.bodies().iter().map(FactorisedBody::unknowns).collect();
    let left_out = problem.left_out.clone();
    Ok(FieldCertificate { estimate, change, support_change, penetration, missed_support, unknowns, left_out })
}

/// Evaluates the fields at the nodes of the problem.
fn fields<S: Recovery>(
    problem: &ContactProblem<S>,
    given: &[MeshField<'_, S>],
) -> Result<Vec<Vec<S::Vector>>, EstimatorError> {
    check_length(|| "the fields".into(), given.len(), problem.bodies.len())?;
    for (b, field) in given.iter().enumerate() {
        check_finite(
            || format!("the displacement of body {}", b + 1),
            field.values().iter().flat_map(Coordinates::entries),
        )?;
    }
    match problem.obstacles.iter().position(|obstacle| !obstacle.free_motions().is_empty()) {
        Some(obstacle) => Err(EstimatorError::FreeObstacle { obstacle }),
        None => Ok(given.iter().zip(&problem.bodies).map(|(field, body)| field.on(body.mesh())).collect()),
    }
}

/// The changes at the supported nodes of a body.
struct Held {
    /// The largest change, m.
    changed: f64,
    /// The node that misses its support by most, and by how much, m: too much to be changed.
    missed: Option<(NodeId, f64)>,
}

/// Puts supported nodes where their supports hold them, if they nearly are there.
fn hold<S: Recovery>(body: &Body<S>, field: &mut [S::Vector]) -> Held {
    let size = field.iter().map(|u| norm(*u)).fold(0.0, f64::max);
    let held = || body.node_constraints().iter().enumerate().filter(|(_, node)| !node.supported().is_none());
    let imposed = held().map(|(_, constraint)| norm(constraint.imposed));
    let allowed = HELD * imposed.fold(size, f64::max);
    let mut changes = Held { changed: 0.0, missed: None };
    let mut put = |field: &mut [S::Vector], node: NodeId, to: S::Vector| {
        let change = norm(to - field[node]);
        if change <= allowed {
            field[node] = to;
            changes.changed = changes.changed.max(change);
        } else if changes.missed.is_none_or(|(_, most)| change > most) {
            changes.missed = Some((node, change));
        }
    };
    for (node, constraint) in held() {
        put(field, NodeId::new(node), constraint.nearest(field[node]));
    }
    let points = body.mesh().points();
    for side in body.rigid_sides().iter().filter(|side| !side.motions.is_empty()) {
        let motion = side.allowed_near(points, field);
        for &node in &side.nodes {
            put(field, node, motion.at(points[node]));
        }
    }
    changes
}

/// Computes the openings at the pairs of a contact line, ≥ 0, m.
fn openings<S: Recovery>(
    problem: &ContactProblem<S>,
    pair: &ContactPair<S>,
    fields: &[Vec<S::Vector>],
) -> Vec<f64> {
    let fields = problem.places_of(pair).map(|place| &fields[place]);
    pair.interface.pairs().iter().map(|p| opening(fields, p).max(0.0)).collect()
}

fn opening<S: Recovery>(fields: [&Vec<S::Vector>; 2], p: &NodePair<S>) -> f64 {
    let [first, second] = [0, 1].map(|side: usize| fields[side][p.nodes[side]]);
    p.gap - (first - second).times(&p.normal)
}

/// Moves the nodes of one body of each pair back until none penetrates; returns the largest penetration, m.
fn part<S: Recovery>(problem: &ContactProblem<S>, fields: &mut [Vec<S::Vector>]) -> f64 {
    let (mut largest, lines) = (0.0f64, NodeLines::new(problem));
    for round in 0..ROUNDS {
        let mut deepest: f64 = 0.0;
        for pair in &problem.contacts {
            let both = problem.places_of(pair).map(|place| &fields[place]);
            let depths: Vec<f64> =
                pair.interface.pairs().iter().map(|p| (-opening(both, p)).max(0.0)).collect();
            deepest = depths.iter().copied().fold(deepest, f64::max);
            if depths.iter().any(|depth| *depth > 0.0) {
                part_pair((problem, &lines), pair, fields, &depths);
            }
        }
        if round == 0 {
            largest = deepest;
        }
        if deepest == 0.0 {
            break;
        }
    }
    largest
}

/// Moves the nodes of the body of a pair in which that takes less energy; a node that one body holds is moved in the other.
fn part_pair<S: Recovery>(
    (problem, lines): (&ContactProblem<S>, &NodeLines<'_, S>),
    pair: &ContactPair<S>,
    fields: &mut [Vec<S::Vector>],
    depths: &[f64],
) {
    let sides: Vec<(usize, usize)> = pair.elastic_sides().collect();
    let moved = |side: usize, b: usize| -> Vec<S::Vector> {
        let mut field = vec![S::Vector::default(); fields[b].len()];
        for (p, depth) in pair.interface.pairs().iter().zip(depths) {
            if let Some(direction) = lines.direction(b, side, p) {
                field[p.nodes[side]] = direction * (side_sign(side) * depth);
            }
        }
        field
    };
    let energy = |(side, b): &(usize, usize)| {
        let field = moved(*side, *b);
        let rest = vec![S::Vector::default(); field.len()];
        energy_distance_squared(&problem.bodies[*b], &field, &rest)
    };
    let mut order: Vec<(f64, (usize, usize))> = sides.iter().map(|of| (energy(of), *of)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (p, depth) in pair.interface.pairs().iter().zip(depths).filter(|(_, depth)| **depth > 0.0) {
        let movable =
            order.iter().find_map(|(_, (side, b))| Some((*side, *b, lines.direction(*b, *side, p)?)));
        if let Some((side, b, direction)) = movable {
            // A little more than needed, for the rounding of the sum.
            fields[b][p.nodes[side]] += direction * (side_sign(side) * (1.0 + 4.0 * f64::EPSILON) * *depth);
        }
    }
}

/// Computes the contact forces at the pairs, ≥ 0, N/m: what the equilibrium of the bodies lacks at the nodes that belong to one pair only
/// and are not clamped; the mean if that is so in both bodies, zero if it is in neither.
fn contact_forces<S: Recovery>(problem: &ContactProblem<S>, fields: &[Vec<S::Vector>]) -> Vec<Vec<f64>> {
    let residuals: Vec<Vec<S::Vector>> =
        problem.bodies.iter().zip(fields).map(|(body, field)| nodal_residual(body, field)).collect();
    let mut uses: Vec<Vec<u32>> = residuals.iter().map(|all| vec![0; all.len()]).collect();
    for pair in &problem.contacts {
        for (side, b) in pair.elastic_sides() {
            for p in pair.interface.pairs() {
                uses[b][p.nodes[side]] += 1;
            }
        }
    }
    let forces = problem.bodies.iter().zip(fields).map(|(body, field)| Noise::of(body).force(field));
    let forces: Vec<f64> = forces.collect();
    let lines = NodeLines::new(problem);
    let noise = |pair: &ContactPair<S>| pair.elastic_sides().map(|(_, b)| forces[b]).fold(0.0, f64::max);
    let force = |pair: &ContactPair<S>, p: &NodePair<S>| {
        let of_side = |(side, b): (usize, usize)| {
            let node = p.nodes[side];
            // A support takes what is not along its free direction.
            let along = lines.direction(b, side, p)?;
            (uses[b][node] == 1).then(|| side_sign(side) * residuals[b][node].times(&along))
        };
        let found: Vec<f64> = pair.elastic_sides().filter_map(of_side).collect();
        let mean = found.iter().sum::<f64>() / found.len().max(1) as f64;
        // Pressure is looked for among the pairs that carry a force, not where there is only rounding.
        if mean > noise(pair) { mean } else { 0.0 }
    };
    let of_pair = |pair: &ContactPair<S>| pair.interface.pairs().iter().map(|p| force(pair, p)).collect();
    problem.contacts.iter().map(of_pair).collect()
}
