//! Builds an admissible pair from a contact state: displacements that satisfy the contact condition, and
//! stresses in exact equilibrium with one common pressure.

use crate::eet::{self, EdgeMoments};
use crate::error::EstimatorError;
use crate::johnson_mercier::{self, CellLoads, CellStress};
use crate::pressure;
use crate::star_relaxation::{Relaxation, RelaxationReport, StarRelaxation, relax_with_stars};
use fem_core::body::{Body, EdgeCondition, EdgeReaction};
use fem_core::condensation::CondensedBody;
use fem_core::field;
use fem_core::geometry::{Vector, scale, sub};
use fem_core::interface::{ContactInterface, ContactProblem, ContactState};
use fem_core::tensor::SymTensor2;

/// A stress in exact equilibrium with given edge tractions: Johnson-Mercier in every triangle.
#[derive(Clone, Debug)]
pub struct EquilibratedStress {
    /// Moments of the edge tractions.
    pub edge_moments: EdgeMoments,
    /// What is given on each boundary edge (order of the mesh's boundary edges).
    pub conditions: Vec<EdgeCondition>,
    /// The FE stress it was recovered from, one per triangle, Pa.
    pub finite_element: Vec<SymTensor2>,
}

impl EquilibratedStress {
    /// Recovers an equilibrated stress from an FE stress that is in FE equilibrium with the conditions.
    pub fn recover(body: &Body, finite_element: Vec<SymTensor2>, conditions: Vec<EdgeCondition>) -> Self {
        let edge_moments = eet::edge_moments(body, &finite_element, &conditions);
        Self { edge_moments, conditions, finite_element }
    }

    /// Computes the loads (traction times length) on the edges of a triangle, N/m.
    pub fn cell_loads(&self, body: &Body, triangle: usize) -> CellLoads {
        let topology = body.mesh().topology();
        let corners = body.mesh().triangles()[triangle];
        std::array::from_fn(|k| {
            let edge = topology.triangle_edges()[triangle][k] as usize;
            let [a, b] = self.edge_moments[edge];
            // |Γ| F_a = 4 b_a − 2 b_b
            let at = |near: Vector, far: Vector| sub(scale(4.0, near), scale(2.0, far));
            let sign = if topology.edge_triangles()[edge][0] as usize == triangle { 1.0 } else { -1.0 };
            let ends = [scale(sign, at(a, b)), scale(sign, at(b, a))];
            if topology.edges()[edge][0] == corners[k] { ends } else { [ends[1], ends[0]] }
        })
    }

    /// Computes the stress in a triangle.
    pub fn cell(&self, body: &Body, triangle: usize) -> CellStress {
        let loads = self.cell_loads(body, triangle);
        johnson_mercier::cell_stress(body.mesh().corners(triangle), &loads, body.body_force())
    }

    /// Computes the distance² to a constant stress in a triangle, in the complementary norm, J/m.
    pub fn cell_distance_squared(&self, body: &Body, triangle: usize, constant: SymTensor2) -> f64 {
        let stress = self.cell(body, triangle);
        johnson_mercier::distance_squared(
            &stress,
            constant,
            body.mesh().area(triangle),
            body.material(triangle),
        )
    }

    /// Returns the mean stress in a triangle, for pictures.
    pub fn cell_mean(&self, body: &Body, triangle: usize) -> SymTensor2 {
        let stress = self.cell(body, triangle);
        stress.iter().flatten().fold(SymTensor2::default(), |sum, s| sum.plus(*s)).scaled(1.0 / 9.0)
    }
}

/// An admissible pair: kinematic displacements, and stresses that share one pressure.
#[derive(Clone, Debug)]
pub struct AdmissiblePair {
    /// Displacements of the two bodies, Cartesian, m.
    pub displacement: [Vec<Vector>; 2],
    /// Stress of these displacements, one per triangle, Pa.
    pub stress: [Vec<SymTensor2>; 2],
    /// Opening at each pair, ≥ 0, m.
    pub opening: Vec<f64>,
    /// Common pressure at each pair, ≥ 0, Pa.
    pub pressure: Vec<f64>,
    /// Equilibrated stresses.
    pub equilibrated: [EquilibratedStress; 2],
    /// How they were relaxed.
    pub relaxation: [RelaxationReport; 2],
}

/// Builds the admissible pair of a contact state.
///
/// The pressure is `p_i = r²_i/ℓ_i`. One Neumann problem per body with the consistent load `M p` gives an FE
/// stress in FE equilibrium with exactly this pressure; EET and Johnson-Mercier make it equilibrated, and the
/// relaxation makes it the sharper.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite.
pub fn admissible_pair(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    state: &ContactState<'_>,
    relaxation: Relaxation,
) -> Result<AdmissiblePair, EstimatorError> {
    Ok(pair_and_stars(problem, bodies, state, relaxation)?.0)
}

/// [`admissible_pair`], with the stars of Ω₁ for another stress of that body; none without relaxation.
pub(crate) fn pair_and_stars<'a>(
    problem: &'a ContactProblem,
    bodies: &[CondensedBody; 2],
    state: &ContactState<'_>,
    relaxation: Relaxation,
) -> Result<(AdmissiblePair, Option<StarRelaxation<'a>>), EstimatorError> {
    check_state(problem, bodies, state)?;
    let interface = &problem.interface;
    let pressure = pressure::nodal_pressure(interface, state.contact_force);
    let force = interface.mass(&pressure);
    let recover = |b: usize| {
        let body = &problem.bodies[b];
        // Along the common normal, out of the first body: −p on Ω₁, +p on Ω₂.
        let sign = if b == 0 { -1.0 } else { 1.0 };
        let load: Vec<f64> = force.iter().map(|f| sign * f).collect();
        let neumann = bodies[b].displacement_from_force(&load);
        let conditions = with_pressure(body, interface, b, &pressure);
        let equilibrated = EquilibratedStress::recover(body, field::stresses(body, &neumann), conditions);
        (equilibrated, field::stresses(body, state.displacement[b]))
    };
    let ((mut e1, s1), (mut e2, s2)) = rayon::join(|| recover(0), || recover(1));
    // One body after the other, each in parallel: the stars of one at a time are in memory.
    let (_, r2) = relax_with_stars(&problem.bodies[1], &mut e2, relaxation);
    let (stars, r1) = relax_with_stars(&problem.bodies[0], &mut e1, relaxation);
    let pair = AdmissiblePair {
        displacement: state.displacement.map(<[Vector]>::to_vec),
        stress: [s1, s2],
        opening: state.opening.to_vec(),
        pressure,
        equilibrated: [e1, e2],
        relaxation: [r1, r2],
    };
    Ok((pair, stars))
}

/// Puts the contact pressure on a body's contact edges: traction `−p n` on Ω₁, `+p n` on Ω₂.
fn with_pressure(
    body: &Body,
    interface: &ContactInterface,
    b: usize,
    pressure: &[f64],
) -> Vec<EdgeCondition> {
    let mut conditions = body.edge_conditions().to_vec();
    let sign = if b == 0 { -1.0 } else { 1.0 };
    for_contact_edges(body, interface, b, |place, ends| {
        let traction = ends.map(|k| scale(sign * pressure[k], interface.pairs()[k].normal));
        conditions[place] = EdgeCondition { reaction: EdgeReaction::None, traction };
    });
    conditions
}

/// Makes the contact edges of a body those of an imposed normal displacement: the normal traction is a
/// reaction, the tangential one is zero.
pub(crate) fn with_imposed_normal(body: &Body, interface: &ContactInterface, b: usize) -> Vec<EdgeCondition> {
    let mut conditions = body.edge_conditions().to_vec();
    for_contact_edges(body, interface, b, |place, ends| {
        let normal = interface.pairs()[ends[0]].normal;
        conditions[place] = EdgeCondition { reaction: EdgeReaction::Along(normal), traction: [[0.0; 2]; 2] };
    });
    conditions
}

/// Calls `act` with the place of each contact edge among the boundary edges, and the pairs at its two nodes
/// in the edge's own order.
fn for_contact_edges(
    body: &Body,
    interface: &ContactInterface,
    b: usize,
    mut act: impl FnMut(usize, [usize; 2]),
) {
    let topology = body.mesh().topology();
    for contact in interface.edges() {
        let edge = contact.edges[b];
        let Ok(place) = topology.boundary_edges().binary_search(&edge) else { continue };
        let mut ends = contact.pairs.map(|k| k as usize);
        if interface.pairs()[ends[0]].nodes[b] != topology.edges()[edge as usize][0] {
            ends.reverse();
        }
        act(place, ends);
    }
}

fn check_state(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    state: &ContactState<'_>,
) -> Result<(), EstimatorError> {
    let pairs = problem.interface.pairs().len();
    let nodes = [0, 1].map(|b| problem.bodies[b].mesh().points().len());
    let lengths = [
        ("the displacement of the first body", state.displacement[0].len(), nodes[0]),
        ("the displacement of the second body", state.displacement[1].len(), nodes[1]),
        ("the contact force", state.contact_force.len(), pairs),
        ("the opening", state.opening.len(), pairs),
        ("the interface of the first condensed body", bodies[0].len(), pairs),
        ("the interface of the second condensed body", bodies[1].len(), pairs),
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
