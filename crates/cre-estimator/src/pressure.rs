//! The contact pressure of an admissible stress.

use fem_core::interface::ContactInterface;

/// Computes the P1 pressure of nodal contact forces, `p_i = r²_i/ℓ_i ≥ 0`, Pa.
///
/// Lumping keeps the sign; the inverse of the consistent mass matrix would not.
pub fn nodal_pressure(interface: &ContactInterface, contact_force: &[f64]) -> Vec<f64> {
    interface.pairs().iter().zip(contact_force).map(|(pair, r)| r / pair.tributary_length).collect()
}

/// Computes `2 ∫ p o ds` on every contact edge, J/m, with the consistent mass: for P1 factors
/// `∫ p o = ℓ/6 (2 p_i o_i + p_i o_j + p_j o_i + 2 p_j o_j)`.
pub fn contact_terms(interface: &ContactInterface, pressure: &[f64], opening: &[f64]) -> Vec<f64> {
    interface
        .edges()
        .iter()
        .map(|edge| {
            let [i, j] = edge.pairs.map(|k| k as usize);
            let (p, o) = (pressure, opening);
            edge.length / 3.0 * (p[i] * (2.0 * o[i] + o[j]) + p[j] * (o[i] + 2.0 * o[j]))
        })
        .collect()
}
