//! Bounds of other quantities of the exact solution, from the bound of the energy error.

use crate::contact_force::{NoContactForce, contact_force};
use cre_estimator::{Estimate, Recovery, friction};
use fem_core::body::{Body, FacetSprings};
use fem_core::geometry::Coordinates;
use fem_core::mesh::id::FacetId;
use fem_core::prepared::PreparedProblem;
use nndd::Iterate;

/// Bounds `[lower, upper]` of quantities of the exact solution `u`. They follow from `e_CRE` without any constant and
/// hold under the same conditions as `e_CRE`: exactly represented data, that is, displacements and loads linear along
/// each edge, on the given polygons.
///
/// With `v` the computed pair of displacements, `τ`, `p` the equilibrated stress and its pressure, `o` the opening of `v`,
/// `a` the energy product, `ℓ` the work of the loads, `e² = e_CRE² = ‖τ − σ(v)‖² + 2∫ p o`:
///
/// * **Energy norm.** `‖u − v‖ ≤ e`, hence `‖v‖ − e ≤ ‖u‖ ≤ ‖v‖ + e`.
/// * **Potential energy** `J(v) = ½ a(v, v) − ℓ(v)`. `u` minimises it over the displacements that satisfy supports and
///   contact condition, including `v`: `J(u) ≤ J(v)`. From below: multiply `div τ + b = 0` by any such `v` and
///   integrate, with `τ n = F` on Γ_N, `∓p n` on Γ_C, `v = u_D` on Γ_D and `[v]·n = g − o` on Γ_C:
///   ```text
///   ∫ τ : ε(v) = ℓ(v) + ∫_{Γ_D} τ n · u_D − ∫ p g + ∫ p o
///   ½ e²       = ½ ‖τ‖² + ½ a(v, v) − ∫ τ : ε(v) + ∫ p o = J(v) + J*(τ, p)
///   J*(τ, p)   = ½ ‖τ‖² − ∫_{Γ_D} τ n · u_D + ∫ p g
///   ```
///   In the same identity with `u` in place of `v` the left side is not negative: `J(u) ≥ −J*(τ, p)`. So
///   `J(v) − ½ e² ≤ J(u) ≤ J(v)`. On a roller or under one imposed component only that component of `u_D` and the
///   reaction along it count; the rest of the traction is given and part of `ℓ`. On a curved contact line `v` is
///   admissible only with its lift `l`: then `J(u) ≤ J(v + l)`. With the friction of Tresca `J` gains `∫ s|w|`, `w` the slip, and the
///   identities hold with `½ e²` that contains `∫ (s|w| − q w)`. Springs add `½ ∫ k (v − u₀)²` to `J`, and `∫ k w²` to what `e²` bounds.
///   The energy norm is without them. The jump `δ e` of a cut is part of `v`: a given force `F` in it adds `−F δ` to `J`.
/// * **Contact force** `N = ∫ p_ex` of all pairs: by virtual work on a displacement of one body that moves a whole contact line by one length
///   along its normal, with the mean of `τ` and `σ(v)` as the stress: `|N − ½(∫ p + W)| ≤ ½ √(e² + 2∫ p o) ‖w‖`. A body that is free to move
///   rigidly along that normal knows its force by equilibrium. Derivation: `src/contact_force.rs`.
///
/// Source: Prager and Synge 1947 for the mean; the identities are derived here.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounds {
    /// `√a(u, u)` of all bodies together, square root of J/m.
    pub energy_norm: [f64; 2],
    /// `J(u) = ½ a(u, u) − ℓ(u)`, J/m.
    pub potential_energy: [f64; 2],
    /// `∫ p_ex ds` of all pairs, N/m; an error says why there are no bounds.
    pub contact_force: Result<[f64; 2], NoContactForce>,
}

impl Bounds {
    /// Computes the bounds of an iterate from its estimate.
    pub fn new<S: Recovery>(problem: &PreparedProblem<S>, iterate: &Iterate, estimate: &Estimate<S>) -> Self {
        let e = estimate.unchecked().e_cre;
        let energy: f64 = estimate.energy_norm_squared.iter().sum();
        let norm = energy.sqrt();
        let (mut work, mut size) = (0.0, 0.0);
        for (forces, fields) in problem.external_forces().iter().zip(&estimate.pair.bodies) {
            for (f, u) in forces.iter().zip(&fields.displacement) {
                work += f.times(u);
                size += f.times(u).abs();
            }
        }
        // ½ ∫ k (v − u₀)²
        let mut stretch = 0.0;
        for (body, fields) in problem.problem().bodies.iter().zip(&estimate.pair.bodies) {
            let of_facet = |(facet, springs): (FacetId, &FacetSprings<S>)| {
                let nodes = body.mesh().topology().facets()[facet];
                let moved = springs.stretched(&S::axes(|k| fields.displacement[nodes[k]]));
                springs.energy(&moved.stretch, body.mesh().facet_measure(facet))
            };
            stretch += 0.5 * body.facet_springs().map(of_facet).sum::<f64>();
        }
        for cut_work in problem.problem().bodies.iter().map(Body::cut_work) {
            work += cut_work;
            size += cut_work.abs();
        }
        for (amount, of) in iterate.amounts.iter().zip(problem.rigid_motions()) {
            // The load of an obstacle acts on its free motion.
            if of.partner.is_obstacle() {
                work += amount * of.load;
                size += (amount * of.load).abs();
            }
        }
        let mut potential = 0.5 * energy + stretch - work;
        size += stretch;
        for (pair, contact) in problem.problem().contacts.iter().zip(&estimate.pair.contacts) {
            let sliding = friction::sliding_work(pair, &contact.facet_friction);
            potential += sliding;
            size += sliding;
        }
        // The admissible displacement is v + l: J(v + l) = J(v) + (K v − f)·l + ½ ‖l‖².
        let mut lifted = 0.0;
        let blocks = problem.problem().blocks().zip(problem.problem().tangential_blocks());
        for ((of, contact), (block, tangents)) in
            problem.problem().contacts.iter().zip(&estimate.pair.contacts).zip(blocks)
        {
            for (side, added) in contact.added.iter().enumerate() {
                let role = of.roles.of_side(side);
                let (forces, sign) = (&iterate.reactions()[role][block.clone()], [-1.0, 1.0][role]);
                lifted += added.iter().zip(forces).map(|(l, r)| sign * l * r).sum::<f64>();
            }
            let by_role = [&iterate.tangential.reaction, &iterate.tangential.force];
            let by_side = [0, 1].map(|side| &by_role[of.roles.of_side(side)][tangents.clone()]);
            lifted += friction::work_of_lift(of, &contact.facet_friction, by_side);
        }
        let upper = potential + (lifted + 0.5 * estimate.pair.lift_energy).max(0.0);
        // Rounding of the displacements affects the energies as well as the bound.
        let round_off = estimate.round_off;
        let noise = 64.0 * f64::EPSILON * (energy + size) + (norm + e) * round_off;
        Self {
            energy_norm: [(norm - e - round_off).max(0.0), norm + e + round_off],
            potential_energy: [potential - 0.5 * e * e - noise, upper + noise],
            contact_force: contact_force(problem, estimate),
        }
    }
}
