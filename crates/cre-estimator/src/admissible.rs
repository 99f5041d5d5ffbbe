//! Builds an admissible pair from a contact state: displacements that satisfy the contact condition, and
//! stresses in exact equilibrium with one common pressure.

use crate::balance::{self, Pressure};
use crate::equilibrated::EquilibratedStress;
use crate::error::EstimatorError;
use crate::friction::{FacetFriction, OnFacets};
use crate::lift::{self, Lift};
use crate::measures::Accuracy;
use crate::node_lines::NodeLines;
use crate::openings;
use crate::pressure;
use crate::recovery::Recovery;
use crate::relaxation::RelaxationReport;
use crate::side::side_sign;
use crate::springs::{SAME_DIRECTION, released, stretched};
use fem_core::body::{FacetCondition, FacetSprings};
use fem_core::directions::Directions;
use fem_core::each_body;
use fem_core::field;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem, ContactState, PairState, Partner};
use fem_core::mesh::id::NodeId;
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use fem_core::space::{Plane, Space};
use neumann_neumann::{BodySolver, BodySolvers};
use std::borrow::Cow;

/// An admissible pair `(û, τ)` for the error in the constitutive relation: displacements `û = u + l`, with which the bodies
/// satisfy their supports and penetrate nowhere, and stresses `τ` in equilibrium with the loads and with one pressure
/// `p ≥ 0` along each contact line.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AdmissiblePair<S: Space = Plane> {
    /// `u`, `σ(u)` and `τ` of each body.
    pub bodies: Vec<AdmissibleBody<S>>,
    /// The displacement of the points of each obstacle, Cartesian, m.
    pub obstacles: Vec<Vec<S::Vector>>,
    /// Opening `o`, lift `l` and pressure `p` of each contact line.
    pub contacts: Vec<AdmissibleContact<S>>,
    /// `‖l‖²` of the lifts of all contact lines together, J/m.
    pub lift_energy: f64,
    /// By how much the pressure differs from `r²_i/ℓ_i`, relative: the least change that balances the floating bodies, (31).
    pub pressure_shift: f64,
    /// The largest force or moment by which the pressure and the loads of a floating body are out of balance, relative. If it
    /// is not round-off, no admissible pressure was found.
    pub rigid_balance: f64,
}

/// The part of one body in an [`AdmissiblePair`]: what is compared cell by cell, `τ` with `σ(u)`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AdmissibleBody<S: Space = Plane> {
    /// `u`, the given displacement of every node, Cartesian, m. With the lifts it is kinematically admissible.
    pub displacement: Vec<S::Vector>,
    /// `σ(u)`, the stress of that displacement, one per triangle, Pa.
    pub stress: Vec<S::Tensor>,
    /// `τ`, in exact equilibrium with the loads and the pressures on the sides of the body, Pa.
    pub equilibrated: EquilibratedStress<S>,
    /// By how much the relaxation lowered the energy of `τ`.
    pub relaxation: RelaxationReport,
}

/// The part of one contact line in an [`AdmissiblePair`]: openings and a pressure that neither pull nor penetrate, whose
/// product `2∫ p o ds` (J/m) belongs to the bound.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AdmissibleContact<S: Space = Plane> {
    /// `o`, the opening at each pair of nodes with the lift, ≥ 0, m.
    pub opening: Vec<f64>,
    /// Openings that the lifts of the first and of the second body add, lifts of other contact lines included, ≥ 0, m; empty without a lift.
    pub added: [Vec<f64>; 2],
    /// Middle Bernstein coefficient of the opening along each contact edge with the lift, m: `≥ −√(o_i o_j)`.
    pub middle_opening: Vec<f64>,
    /// `l`, the required motion of the contact nodes of one body back along the normals; zero on a straight contact line.
    pub lift: Lift,
    /// Pressure at each pair, Pa: `r²_i/ℓ_i ≥ 0`, or the nearest one that balances the floating bodies, (31). If that is constant on bent facets,
    /// the mean of the facets around.
    pub pressure: Vec<f64>,
    /// `p`, the pressure common to both bodies at the corners of each contact facet, ≥ 0, Pa.
    pub edge_pressure: Vec<S::Axes<f64>>,
    /// Nodal forces `∫ (p n + q t) φ_i ds` of pressure and friction at each pair of nodes, Cartesian, N/m: on
    /// the second body; the forces on the first are opposite.
    pub pressure_force: Vec<S::Vector>,
    /// Friction in each row along a tangent, at most its limit, Pa; empty without friction.
    pub friction: Vec<f64>,
    /// The limit `s` of friction at each pair, Pa: the given one, or `μ p` of this pressure; empty without friction.
    pub friction_limit: Vec<f64>,
    /// The slip that was given with the state in each row along a tangent, m; empty without friction.
    pub slip: Vec<f64>,
    /// Friction, its limit and the slip of the displacements on the contact facets.
    pub facet_friction: FacetFriction<S>,
}

impl<S: Space> AdmissiblePair<S> {
    /// Returns the given displacement of each body, then of the points of each obstacle.
    pub fn displacements(&self) -> Vec<&[S::Vector]> {
        let bodies = self.bodies.iter().map(|body| body.displacement.as_slice());
        bodies.chain(self.obstacles.iter().map(Vec::as_slice)).collect()
    }
}

/// Builds the admissible pair of a state that has been checked; its stresses are not yet relaxed.
pub(crate) fn recovered_pair<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    state: &ContactState<'_, S>,
    accuracy: Accuracy,
) -> Result<AdmissiblePair<S>, EstimatorError> {
    let (prepared, problem) = (solvers.prepared(), solvers.problem());
    let Pressure { by_pair, by_facet, friction, limit, facet_friction, shift, imbalance } =
        balance::pressure(prepared, state)?;
    let lines = NodeLines::new(problem);
    let all = problem.contacts.iter().zip(&state.contacts);
    let found = all.map(|(pair, given)| lift_of((problem, &lines), pair, state, given));
    let (lifts, openings): (Vec<Lift>, Vec<Vec<f64>>) = found.unzip();
    let moved = lift::joined(problem, &lifts);
    let lift_energy = lift::total_energy(problem, &lifts, &moved);
    let contacts: Vec<AdmissibleContact<S>> = by_pair
        .into_iter()
        .zip(by_facet)
        .zip(friction.into_iter().zip(limit).zip(facet_friction))
        .zip(lifts.into_iter().zip(openings))
        .enumerate()
        .map(|(k, ((pressure, friction), (lift, opening)))| {
            AdmissibleContact::new((problem, k), state, pressure, friction, (lift, opening, &moved))
        })
        .collect();
    let recovered =
        each_body(problem.bodies.len(), |b| recover(solvers, b, state.displacement[b], &contacts, accuracy));
    let (pressure_shift, rigid_balance) = (shift, imbalance);
    let obstacles = state.displacement[problem.bodies.len()..].iter().map(|u| u.to_vec()).collect();
    Ok(AdmissiblePair { bodies: recovered, obstacles, contacts, lift_energy, pressure_shift, rigid_balance })
}

/// Finds the lift of a pair, and the middle openings without it.
fn lift_of<S: Recovery>(
    (problem, lines): (&ContactProblem<S>, &NodeLines<'_, S>),
    pair: &ContactPair<S>,
    state: &ContactState<'_, S>,
    given: &PairState<'_>,
) -> (Lift, Vec<f64>) {
    let displacement = problem.places_of(pair).map(|b| state.displacement[b]);
    let middle = S::middle_openings(&pair.interface, displacement);
    // The allowance for round-off covers what is smaller.
    let penetrates = openings::penetrate(pair, displacement, given);
    (lift::find(lines, pair, displacement, (given.opening, penetrates, &middle)), middle)
}

/// The lifts of all nodes of each body, see [`lift::joined`].
type Moved<S> = [Option<Vec<<S as Space>::Vector>>];

impl<S: Recovery> AdmissibleContact<S> {
    /// Computes the openings of pair `k` and what belongs to its pressure.
    ///
    /// * `pressure`: at the pairs, and at the corners of the facets, Pa; `friction`: friction and its limit at the pairs, and at the corners, Pa.
    /// * `lift`: of the pair, with the middle openings without it, and [`lift::joined`].
    fn new(
        (problem, k): (&ContactProblem<S>, usize),
        state: &ContactState<'_, S>,
        (pressure, edge_pressure): (Vec<f64>, Vec<S::Axes<f64>>),
        ((friction, friction_limit), on_facets): ((Vec<f64>, Vec<f64>), OnFacets<S>),
        (lift, found, moved): (Lift, Vec<f64>, &Moved<S>),
    ) -> Self {
        let (pair, given) = (&problem.contacts[k], &state.contacts[k]);
        let interface = &pair.interface;
        let displacement = problem.places_of(pair).map(|b| state.displacement[b]);
        let mut pressure_force = pressure::nodal_forces(interface, &pressure, &edge_pressure);
        // The lifts of other pairs move nodes of this one, too.
        let moved = problem.places_of(pair).map(|b| moved.get(b).and_then(Option::as_deref));
        let middle_opening = if moved == [None, None] {
            found
        } else {
            let lifted = [0, 1].map(|side: usize| match moved[side] {
                Some(l) => {
                    Cow::from(displacement[side].iter().zip(l).map(|(u, l)| *u + *l).collect::<Vec<_>>())
                }
                None => Cow::from(displacement[side]),
            });
            S::middle_openings(interface, [&lifted[0], &lifted[1]])
        };
        let facet_friction = FacetFriction::new(pair, on_facets, displacement, moved);
        if pair.friction.acts() {
            let forces = facet_friction.nodal_forces(interface);
            pressure_force.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        }
        // Fields that are recovered from forces have these openings to round-off, which the checks measure.
        let mut opening = given.opening.to_vec();
        let added = [0, 1].map(|side: usize| lift::added(interface, side, moved[side]));
        for added in &added {
            opening.iter_mut().zip(added).for_each(|(opening, added)| *opening += added);
        }
        Self {
            opening,
            added,
            middle_opening,
            lift,
            pressure,
            edge_pressure,
            pressure_force,
            friction,
            friction_limit,
            slip: given.slip.to_vec(),
            facet_friction,
        }
    }
}

/// Recovers the equilibrated stress of one body under its loads and the pressure on its sides, not yet relaxed.
fn recover<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    b: usize,
    displacement: &[S::Vector],
    contacts: &[AdmissibleContact<S>],
    accuracy: Accuracy,
) -> AdmissibleBody<S> {
    let problem = solvers.problem();
    let body = &problem.bodies[b];
    let neumann = neumann_field(problem, &solvers.bodies()[b], b, contacts, accuracy);
    let conditions = released(body, with_pressure(problem, b, contacts), &[&neumann.high, &neumann.low]);
    let stress = match accuracy {
        Accuracy::Double => field::stresses(body, &neumann.high),
        Accuracy::Refined => residual::stresses(body, &neumann),
    };
    AdmissibleBody {
        stress: field::stresses(body, displacement),
        equilibrated: EquilibratedStress::recover(body, stress, conditions),
        displacement: displacement.to_vec(),
        relaxation: RelaxationReport::default(),
    }
}

/// Solves a body's Neumann problem with the consistent loads of the pressures, `−p n` on the first body of a pair and `+p n`
/// on the second.
fn neumann_field<S: Recovery>(
    problem: &ContactProblem<S>,
    solver: &BodySolver<'_, S>,
    b: usize,
    contacts: &[AdmissibleContact<S>],
    accuracy: Accuracy,
) -> SplitField<S> {
    let body = &problem.bodies[b];
    let bent = |(k, _): (usize, usize)| problem.contacts[k].interface.has_bent_facets();
    let forces = pressure_forces(problem, b, contacts);
    let straight = solver.whole().filter(|_| !problem.sides_of(Partner::Body(b)).any(bent));
    let displacement = if let Some(condensed) = straight {
        let load = |(k, side): (usize, usize)| {
            let mass = consistent_forces(&problem.contacts[k].interface, &contacts[k]);
            mass.iter().map(|f| side_sign(side) * f).collect()
        };
        let loads: Vec<Vec<f64>> = problem.sides_of(Partner::Body(b)).map(load).collect();
        condensed.displacement_from_force(&condensed.dofs().interface_forces(&loads))
    } else {
        // On bent facets the loads have a small part along the surface as well.
        solver.displacement_from_nodal_forces(&forces)
    };
    let mut field = SplitField::new(displacement);
    if accuracy == Accuracy::Refined {
        solver.refine(body, &forces, false, &mut field);
    }
    field
}

/// Computes the consistent loads of pressure and friction on a straight contact line, by row, N/m.
pub(crate) fn consistent_forces<S: Recovery>(
    interface: &ContactInterface<S>,
    contact: &AdmissibleContact<S>,
) -> Vec<f64> {
    let mut forces = interface.mass(&contact.pressure);
    let tangents = contact.friction.chunks(interface.pairs().len().max(1));
    forces.extend(tangents.flat_map(|friction| interface.mass(friction)));
    forces
}

/// Lists the nodal forces of the pressures on a body, Cartesian, N/m.
pub(crate) fn pressure_forces<S: Recovery>(
    problem: &ContactProblem<S>,
    b: usize,
    contacts: &[AdmissibleContact<S>],
) -> Vec<(NodeId, S::Vector)> {
    on_body(problem, b, |k| &contacts[k].pressure_force)
}

/// Applies forces at the node pairs to the contact nodes of a body.
///
/// * `forces`: of a pair, on its second body, Cartesian, N/m.
pub(crate) fn on_body<'a, S: Recovery>(
    problem: &ContactProblem<S>,
    b: usize,
    forces: impl Fn(usize) -> &'a [S::Vector],
) -> Vec<(NodeId, S::Vector)> {
    let mut all = Vec::new();
    for (k, side) in problem.sides_of(Partner::Body(b)) {
        let nodes = problem.contacts[k].interface.pairs().iter().map(|pair| pair.nodes[side]);
        all.extend(nodes.zip(forces(k)).map(|(node, force)| (node, *force * side_sign(side))));
    }
    all
}

/// Applies pressures and friction to a body's contact edges: traction `−p n − q t` on the first body of a pair, `+p n + q t` on the
/// second.
fn with_pressure<S: Recovery>(
    problem: &ContactProblem<S>,
    b: usize,
    contacts: &[AdmissibleContact<S>],
) -> Vec<FacetCondition<S>> {
    pressure::conditions(problem, b, |[k, edge, end], scale| {
        let interface = &problem.contacts[k].interface;
        let normal = interface.corner_pair(&interface.facets()[edge], end).normal;
        let pressure = normal * (contacts[k].edge_pressure[edge][end] * scale);
        match contacts[k].facet_friction.traction.get(edge) {
            None => pressure,
            Some(friction) => pressure + friction[end] * scale,
        }
    })
}

/// Sets the conditions of an imposed λ on all contact edges of a body: the normal traction is a reaction, the tangential one is zero, or a
/// reaction as well if there is friction or a support along the edge. Springs there keep their traction.
///
/// * `displacement`: of the body, m.
pub(crate) fn with_imposed_normal<S: Recovery>(
    problem: &ContactProblem<S>,
    b: usize,
    displacement: &[S::Vector],
) -> Vec<FacetCondition<S>> {
    let body = &problem.bodies[b];
    let mut conditions = body.facet_conditions().to_vec();
    for (k, side) in problem.sides_of(Partner::Body(b)) {
        let interface = &problem.contacts[k].interface;
        for edge in interface.facets() {
            let normal = interface.pairs()[edge.pairs[0] as usize].normal;
            let friction = problem.contacts[k].friction.acts();
            let reaction = if friction { Directions::ALL } else { Directions::along(normal) };
            let own = edge.facets[side];
            let place = body.mesh().topology().boundary_place(own);
            let condition = &body.facet_conditions()[place];
            let reaction = reaction.joined(&condition.reaction, SAME_DIRECTION);
            let of_springs = stretched(body, own, &condition.springs, displacement).traction();
            let traction = S::axes(|k| of_springs[k] - reaction.project(of_springs[k]));
            conditions[place] = FacetCondition { reaction, traction, springs: FacetSprings::NONE };
        }
    }
    conditions
}

/// Checks the sizes of a state and that its numbers are finite.
pub(crate) fn check_state<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
) -> Result<(), EstimatorError> {
    let problem = prepared.problem();
    let counts = [
        ("the fields", state.displacement.len(), problem.bodies.len() + problem.obstacles.len()),
        ("the contact lines", state.contacts.len(), problem.contacts.len()),
    ];
    for (what, found, expected) in counts {
        check_length(|| what.into(), found, expected)?;
    }
    let nodes = problem.bodies.iter().map(|body| body.mesh().points().len());
    let points = problem.obstacles.iter().map(|obstacle| obstacle.points().len());
    for (b, (u, expected)) in state.displacement.iter().zip(nodes.chain(points)).enumerate() {
        let what = || format!("the displacement of body {}", b + 1);
        check_length(what, u.len(), expected)?;
        check_finite(what, u.iter().flat_map(Coordinates::entries))?;
    }
    let several = problem.contacts.len() > 1;
    for (k, (given, pair)) in state.contacts.iter().zip(&problem.contacts).enumerate() {
        let pairs = pair.interface.pairs().len();
        let tangents = pair.row_count() - pairs;
        let arrays = [
            ("the contact force", given.contact_force, pairs),
            ("the opening", given.opening, pairs),
            ("the friction force", given.friction_force, tangents),
            ("the slip", given.slip, tangents),
        ];
        for (what, numbers, expected) in arrays {
            let what = || if several { format!("{what} of pair {}", k + 1) } else { what.into() };
            check_length(what, numbers.len(), expected)?;
            check_finite(what, numbers)?;
        }
    }
    Ok(())
}

pub(crate) fn check_length(
    what: impl Fn() -> String,
    found: usize,
    expected: usize,
) -> Result<(), EstimatorError> {
    if found == expected { Ok(()) } else { Err(EstimatorError::Length { what: what(), found, expected }) }
}

pub(crate) fn check_finite<'a>(
    what: impl Fn() -> String,
    numbers: impl IntoIterator<Item = &'a f64>,
) -> Result<(), EstimatorError> {
    let finite = numbers.into_iter().all(|x| x.is_finite());
    if finite { Ok(()) } else { Err(EstimatorError::NotFinite { what: what() }) }
}
