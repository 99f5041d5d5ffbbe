//! The contact pressure of an admissible stress.

use crate::lift::with_middles;
use crate::recovery::Recovery;
use crate::side::side_sign;
use fem_core::body::FacetCondition;
use fem_core::interface::{ContactFacet, ContactInterface, ContactProblem, Partner};
use fem_core::mesh::id::NodeId;
use fem_core::space::Space;

/// Computes the P1 pressure of nodal contact forces, `p_i = r²_i/ℓ_i ≥ 0`, Pa (18).
///
/// Lumping keeps the sign; the inverse of the consistent mass matrix would not.
pub fn nodal_pressure<S: Space>(interface: &ContactInterface<S>, contact_force: &[f64]) -> Vec<f64> {
    interface.pairs().iter().zip(contact_force).map(|(pair, r)| r / pair.weight).collect()
}

/// Computes the pressure at the corners of every contact facet, Pa, see [`ContactInterface::pressure`].
pub fn facet_pressure<S: Space>(interface: &ContactInterface<S>, pressure: &[f64]) -> Vec<S::Axes<f64>> {
    interface.facets().iter().map(|facet| interface.pressure(facet, pressure)).collect()
}

/// Computes the nodal forces `∫ p n φ_i ds` at the pairs, Cartesian, N/m: consistent with the pressure at the corners of the facets.
pub(crate) fn nodal_forces<S: Space>(
    interface: &ContactInterface<S>,
    pressure: &[f64],
    facet_pressure: &[S::Axes<f64>],
) -> Vec<S::Vector> {
    if interface.has_bent_facets() {
        return interface.pressure_forces(facet_pressure);
    }
    let forces = interface.mass(pressure);
    interface.pairs().iter().zip(forces).map(|(pair, force)| pair.normal * force).collect()
}

/// Applies tractions to the contact facets of a body, and returns the condition on each of its boundary facets.
///
/// * `body`: its number; `traction`: at a corner of a contact facet, by the numbers of pair, facet and corner, Pa: on the second body of a pair, times the
///   factor given. The factor has the sign of the side, and turns a traction on the interface into one on the body's own facet.
pub fn conditions<S: Space>(
    problem: &ContactProblem<S>,
    body: usize,
    traction: impl Fn([usize; 3], f64) -> S::Vector,
) -> Vec<FacetCondition<S>> {
    let of = &problem.bodies[body];
    let (mesh, topology) = (of.mesh(), of.mesh().topology());
    let mut conditions = of.facet_conditions().to_vec();
    for (k, side) in problem.sides_of(Partner::Body(body)) {
        let interface = &problem.contacts[k].interface;
        for (number, facet) in interface.facets().iter().enumerate() {
            let own = facet.facets[side];
            let factor = side_sign(side) * (facet.measure / mesh.facet_measure(own));
            let places = places(interface, facet, side, &topology.facets()[own]);
            // An edge may be in two pairs.
            let sums = &mut conditions[topology.boundary_place(own)].traction;
            for corner in 0..S::DIM {
                sums[places[corner]] += traction([k, number, corner], factor);
            }
        }
    }
    conditions
}

/// Finds the corners of a contact facet among the nodes of a body's own facet.
fn places<S: Space>(
    interface: &ContactInterface<S>,
    facet: &ContactFacet<S>,
    side: usize,
    nodes: &S::Axes<NodeId>,
) -> S::Axes<usize> {
    S::axes(|corner| {
        let node = interface.corner_pair(facet, corner).nodes[side];
        nodes.as_ref().iter().position(|own| *own == node).unwrap_or(corner)
    })
}

/// Computes `2 ∫ p o ds` on every contact facet, J/m, see [`ContactFacet::work`]: the last term of (15).
///
/// * `facet_pressure`: see [`facet_pressure`].
/// * `opening`: at the pairs; `middle`: on the edges of the facets, see [`fem_core::interface::ContactInterface::middle_opening`].
pub fn contact_terms<S: Recovery>(
    interface: &ContactInterface<S>,
    facet_pressure: &[S::Axes<f64>],
    opening: &[f64],
    middle: &[f64],
) -> Vec<f64> {
    let facets = with_middles(interface, middle).zip(facet_pressure);
    let terms =
        facets.map(|((facet, middle), p)| 2.0 * S::contact_work(facet, p, &facet.openings(opening), middle));
    terms.collect()
}
