//! The contact pressure of an admissible stress.

use fem_core::interface::{ContactFacet, ContactInterface};
use fem_core::space::Space;

/// Computes the P1 pressure of nodal contact forces, `p_i = r²_i/ℓ_i ≥ 0`, Pa (18).
///
/// Lumping keeps the sign; the inverse of the consistent mass matrix would not.
pub fn nodal_pressure<S: Space>(interface: &ContactInterface<S>, contact_force: &[f64]) -> Vec<f64> {
    interface.pairs().iter().zip(contact_force).map(|(pair, r)| r / pair.weight).collect()
}

/// Computes the pressure at the corners of every contact facet, Pa, see [`ContactFacet::pressure`].
pub fn facet_pressure<S: Space>(interface: &ContactInterface<S>, pressure: &[f64]) -> Vec<S::Axes<f64>> {
    interface.facets().iter().map(|facet| facet.pressure(pressure)).collect()
}

/// Computes the nodal forces `∫ p n φ_i ds` at the pairs, Cartesian, N/m: consistent with the pressure at the corners of the facets.
pub fn nodal_forces<S: Space>(
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

/// Computes `2 ∫ p o ds` on every contact edge, J/m, see [`ContactFacet::work`]: the last term of (15).
///
/// * `edge_pressure`: see [`facet_pressure`].
/// * `opening`: at the pairs; `middle`: see [`fem_core::interface::ContactInterface::middle_opening`].
pub fn contact_terms(
    interface: &ContactInterface,
    edge_pressure: &[[f64; 2]],
    opening: &[f64],
    middle: &[f64],
) -> Vec<f64> {
    let term =
        |((edge, p), m): ((&ContactFacet, &[f64; 2]), &f64)| 2.0 * edge.work(*p, edge.openings(opening), *m);
    interface.facets().iter().zip(edge_pressure).zip(middle).map(term).collect()
}
