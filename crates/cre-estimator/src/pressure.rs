//! The contact pressure of an admissible stress.

use fem_core::geometry::Vector;
use fem_core::interface::{ContactEdge, ContactInterface};

/// Computes the P1 pressure of nodal contact forces, `p_i = r²_i/ℓ_i ≥ 0`, Pa (18).
///
/// Lumping keeps the sign; the inverse of the consistent mass matrix would not.
pub fn nodal_pressure(interface: &ContactInterface, contact_force: &[f64]) -> Vec<f64> {
    interface.pairs().iter().zip(contact_force).map(|(pair, r)| r / pair.tributary_length).collect()
}

/// Computes the pressure at the two ends of every contact edge, Pa, in the order of its pairs: the nodal values if
/// the normal is constant along the edge; their mean at both ends if it changes, so that `p n` is linear on the edge.
pub fn edge_pressure(interface: &ContactInterface, pressure: &[f64]) -> Vec<[f64; 2]> {
    let on_edge = |edge: &ContactEdge| {
        let ends = edge.pairs.map(|k| pressure[k as usize]);
        if interface.is_bent(edge) { [0.5 * (ends[0] + ends[1]); 2] } else { ends }
    };
    interface.edges().iter().map(on_edge).collect()
}

/// Computes the nodal forces `∫ p n φ_i ds` at the pairs, Cartesian, N/m: consistent with the pressure at the ends of the edges.
pub fn nodal_forces(
    interface: &ContactInterface,
    pressure: &[f64],
    edge_pressure: &[[f64; 2]],
) -> Vec<Vector> {
    if interface.has_bent_edges() {
        return interface.pressure_forces(edge_pressure);
    }
    let forces = interface.mass(pressure);
    interface.pairs().iter().zip(forces).map(|(pair, force)| force * pair.normal).collect()
}

/// Computes `2 ∫ p o ds` on every contact edge, J/m, with the consistent mass: the last term of (15).
///
/// * `edge_pressure`: see [`edge_pressure`].
/// * `opening`: at the pairs; `middle`: see [`fem_core::interface::ContactInterface::middle_opening`].
///
/// For P1 factors `∫ p o = ℓ/6 (2 p_i o_i + p_i o_j + p_j o_i + 2 p_j o_j)`. If the normal changes, the opening is the
/// quadratic with the Bernstein coefficients `o_i, o_m, o_j` and the pressure constant: `∫ p o = ℓ p (o_i + o_m + o_j)/3`.
pub fn contact_terms(
    interface: &ContactInterface,
    edge_pressure: &[[f64; 2]],
    opening: &[f64],
    middle: &[f64],
) -> Vec<f64> {
    let term = |((edge, p), m): ((&ContactEdge, &[f64; 2]), &f64)| {
        let o = edge.pairs.map(|k| opening[k as usize]);
        if interface.is_bent(edge) {
            return edge.length * (2.0 / 3.0) * p[0] * (o[0] + m + o[1]);
        }
        edge.length / 3.0 * (p[0] * (2.0 * o[0] + o[1]) + p[1] * (o[0] + 2.0 * o[1]))
    };
    interface.edges().iter().zip(edge_pressure).zip(middle).map(term).collect()
}
