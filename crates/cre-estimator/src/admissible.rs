//! Builds an admissible pair from a contact state: displacements that satisfy the contact condition, and
//! stresses in exact equilibrium with one common pressure.

use crate::equilibrated::EquilibratedStress;
use crate::error::EstimatorError;
use crate::lift::{self, Lift};
use crate::pressure;
use crate::star_relaxation::{Relaxation, RelaxationReport, StarRelaxation, relax_with_stars};
use fem_core::body::{Body, EdgeCondition, EdgeReaction};
use fem_core::condensation::CondensedBody;
use fem_core::each_body;
use fem_core::field;
use fem_core::geometry::{Vector, scale};
use fem_core::interface::{ContactInterface, ContactProblem, ContactState};
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};
use fem_core::tensor::SymTensor2;

/// An admissible pair: kinematic displacements, and stresses that share one pressure.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AdmissiblePair {
    /// The given displacements of the two bodies, Cartesian, m. With [`Self::lift`] they are kinematically admissible.
    pub displacement: [Vec<Vector>; 2],
    /// Stress of these displacements, one per triangle, Pa.
    pub stress: [Vec<SymTensor2>; 2],
    /// Opening at each pair with the lift, ≥ 0, m.
    pub opening: Vec<f64>,
    /// Middle Bernstein coefficient of the opening along each contact edge with the lift, ≥ 0, m.
    pub middle_opening: Vec<f64>,
    /// Required motion of the contact nodes of one body back along the normals; zero on a straight contact line.
    pub lift: Lift,
    /// Pressure at each pair, `r²_i/ℓ_i ≥ 0`, Pa.
    pub pressure: Vec<f64>,
    /// Common pressure at the two ends of each contact edge, ≥ 0, Pa, see [`crate::pressure::edge_pressure`].
    pub edge_pressure: Vec<[f64; 2]>,
    /// Nodal forces of this pressure at each pair, Cartesian, N/m: on the second body; those on the first are opposite.
    pub pressure_force: Vec<Vector>,
    /// Equilibrated stresses.
    pub equilibrated: [EquilibratedStress; 2],
    /// How they were relaxed.
    pub relaxation: [RelaxationReport; 2],
}

/// Builds the admissible pair of a contact state.
///
/// The pressure is `p_i = r²_i/ℓ_i`, linear along straight contact edges, its mean on edges along which the normal changes.
/// There a lift opens the bodies until they penetrate nowhere (theory: the contact line is a
/// polygon with a frozen normal field, linear along the edges). One Neumann problem per body with the consistent load
/// `∫ p n φ_i` gives an FE stress in FE equilibrium with exactly this pressure; EET and Johnson-Mercier make it equilibrated, and the
/// relaxation sharpens it.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite.
pub fn admissible_pair(
    prepared: &PreparedProblem,
    state: &ContactState<'_>,
    relaxation: Relaxation,
) -> Result<AdmissiblePair, EstimatorError> {
    check_state(prepared, state)?;
    Ok(pair_and_stars(prepared, state, relaxation, Accuracy::Double).0)
}

/// Accuracy of an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Accuracy {
    /// Neumann problems by the factor alone, residuals in double precision.
    Double,
    /// Neumann problems with iterative refinement, residuals in double-double numbers.
    Refined,
}

/// [`admissible_pair`] of a state that has been checked, with the stars of Ω₁ for another stress of that body; `None`
/// without relaxation.
pub(crate) fn pair_and_stars<'a>(
    prepared: &'a PreparedProblem,
    state: &ContactState<'_>,
    relaxation: Relaxation,
    accuracy: Accuracy,
) -> (AdmissiblePair, Option<StarRelaxation<'a>>) {
    let (problem, bodies) = (prepared.problem(), prepared.bodies());
    let interface = &problem.interface;
    let pressure = pressure::nodal_pressure(interface, state.contact_force);
    let edge_pressure = pressure::edge_pressure(interface, &pressure);
    let pressure_force = pressure::nodal_forces(interface, &pressure, &edge_pressure);
    let found = lift::middle_openings(interface, state.displacement);
    let lift = lift::find(problem, state.displacement, &found);
    let middle_opening = if lift.energy > 0.0 {
        lift::lifted_middle_openings(problem, state.displacement, &lift)
    } else {
        found
    };
    let recover = |b: usize| {
        let body = &problem.bodies[b];
        let conditions = with_pressure(body, interface, b, &edge_pressure);
        let stress = neumann_stress(problem, &bodies[b], b, (&pressure, &pressure_force), accuracy);
        let equilibrated = EquilibratedStress::recover(body, stress, conditions);
        (equilibrated, field::stresses(body, state.displacement[b]))
    };
    let [(e1, s1), (e2, s2)] = each_body(recover);
    let mut equilibrated = [e1, e2];
    // One body after the other, each in parallel: only the stars of one body are in memory at a time, those of Ω₁ last.
    let [imposed, unilateral] = prepared.roles().bodies();
    let mut relax =
        |b: usize, used| relax_with_stars(&problem.bodies[b], &mut equilibrated[b], relaxation, used);
    let (used, of_unilateral) = relax(unilateral, None);
    let (stars, of_imposed) = relax(imposed, used);
    let pair = AdmissiblePair {
        displacement: state.displacement.map(<[Vector]>::to_vec),
        stress: [s1, s2],
        opening: state.opening.iter().zip(&lift.by_pair).map(|(o, l)| o + l).collect(),
        middle_opening,
        lift,
        pressure,
        edge_pressure,
        pressure_force,
        equilibrated,
        relaxation: prepared.roles().by_body([of_imposed, of_unilateral]),
    };
    (pair, stars)
}

/// Solves a body's Neumann problem with the consistent load of the pressure, `−p n` on Ω₁, `+p n` on Ω₂, and returns its stress.
fn neumann_stress(
    problem: &ContactProblem,
    condensed: &CondensedBody,
    b: usize,
    (pressure, forces): (&[f64], &[Vector]),
    accuracy: Accuracy,
) -> Vec<SymTensor2> {
    let (body, interface) = (&problem.bodies[b], &problem.interface);
    let displacement = if interface.has_bent_edges() {
        // The loads have a small part along the surface as well.
        condensed.displacement_from_nodal_forces(&on_body(interface, b, forces))
    } else {
        let sign = side_sign(b);
        let load: Vec<f64> = interface.mass(pressure).iter().map(|f| sign * f).collect();
        condensed.displacement_from_force(&load)
    };
    match accuracy {
        Accuracy::Double => field::stresses(body, &displacement),
        Accuracy::Refined => {
            let mut field = SplitField::new(displacement);
            condensed.refine(body, &on_body(interface, b, forces), false, &mut field);
            residual::stresses(body, &field)
        }
    }
}

/// The sign of the pressure's forces on a body: −1 on the first, from which the normal points.
fn side_sign(b: usize) -> f64 {
    if b == 0 { -1.0 } else { 1.0 }
}

/// Applies forces of the pairs to the contact nodes of a body.
pub(crate) fn on_body(interface: &ContactInterface, b: usize, forces: &[Vector]) -> Vec<(u32, Vector)> {
    let nodes = interface.pairs().iter().map(|pair| pair.nodes[b]);
    nodes.zip(forces).map(|(node, force)| (node, scale(side_sign(b), *force))).collect()
}

/// Applies the contact pressure to a body's contact edges: traction `−p n` on Ω₁, `+p n` on Ω₂ per length of the
/// contact line, scaled to the length of the body's own edge.
fn with_pressure(
    body: &Body,
    interface: &ContactInterface,
    b: usize,
    edge_pressure: &[[f64; 2]],
) -> Vec<EdgeCondition> {
    let mut conditions = body.edge_conditions().to_vec();
    let sign = side_sign(b);
    for_contact_edges(body, interface, b, |place, contact, reversed| {
        let edge = &interface.edges()[contact];
        let stretch = edge.length / body.mesh().edge_length(edge.edges[b]);
        let end = |k: usize| {
            let normal = interface.pairs()[edge.pairs[k] as usize].normal;
            scale(sign * edge_pressure[contact][k] * stretch, normal)
        };
        let traction = if reversed { [end(1), end(0)] } else { [end(0), end(1)] };
        conditions[place] = EdgeCondition { reaction: EdgeReaction::None, traction };
    });
    conditions
}

/// Sets the conditions of an imposed normal displacement on the contact edges of a body: the normal traction is a
/// reaction, the tangential one is zero.
pub(crate) fn with_imposed_normal(body: &Body, interface: &ContactInterface, b: usize) -> Vec<EdgeCondition> {
    let mut conditions = body.edge_conditions().to_vec();
    for_contact_edges(body, interface, b, |place, contact, _| {
        let normal = interface.pairs()[interface.edges()[contact].pairs[0] as usize].normal;
        conditions[place] = EdgeCondition { reaction: EdgeReaction::Along(normal), traction: [[0.0; 2]; 2] };
    });
    conditions
}

/// Calls `act` with the place of each contact edge among the boundary edges, its number among the contact edges, and
/// whether the mesh's edge runs against it.
fn for_contact_edges(
    body: &Body,
    interface: &ContactInterface,
    b: usize,
    mut act: impl FnMut(usize, usize, bool),
) {
    let topology = body.mesh().topology();
    for (number, contact) in interface.edges().iter().enumerate() {
        let edge = contact.edges[b];
        let place = topology.boundary_place(edge);
        let first = interface.pairs()[contact.pairs[0] as usize].nodes[b];
        act(place, number, first != topology.edges()[edge as usize][0]);
    }
}

pub(crate) fn check_state(
    prepared: &PreparedProblem,
    state: &ContactState<'_>,
) -> Result<(), EstimatorError> {
    let problem = prepared.problem();
    let pairs = problem.interface.pairs().len();
    let nodes = [0, 1].map(|b| problem.bodies[b].mesh().points().len());
    let lengths = [
        ("the displacement of the first body", state.displacement[0].len(), nodes[0]),
        ("the displacement of the second body", state.displacement[1].len(), nodes[1]),
        ("the contact force", state.contact_force.len(), pairs),
        ("the opening", state.opening.len(), pairs),
    ];
    for (what, found, expected) in lengths {
        if found != expected {
            return Err(EstimatorError::Length { what, found, expected });
        }
    }
    let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
    let checks = [
        ("the displacement of the first body", finite(state.displacement[0].as_flattened())),
        ("the displacement of the second body", finite(state.displacement[1].as_flattened())),
        ("the contact force", finite(state.contact_force)),
        ("the opening", finite(state.opening)),
    ];
    match checks.into_iter().find(|(_, ok)| !ok) {
        Some((what, _)) => Err(EstimatorError::NotFinite { what }),
        None => Ok(()),
    }
}
