//! Bounds of other quantities of the exact solution, from the bound of the energy error.

use cre_estimator::{Estimate, friction};
use fem_core::norm;
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
///   identities hold with `½ e²` that contains `∫ (s|w| − q w)`.
/// * **Contact force** `N = ∫ p_ex`. In each body take the displacement `w` of least energy with `w·n = ∓1` on Γ_C
///   that vanishes where displacements are imposed, `‖w‖² = s = 1ᵀ S 1`. Virtual work gives
///   `N = ∫ σ : ε(w) − ℓ(w)` in either body, the same with `τ` gives `∫ p`, and with `σ(v)` the computed reaction. Both
///   bodies with the weights `s₂/(s₁+s₂)`, `s₁/(s₁+s₂)` give the least energy `s₁ s₂/(s₁+s₂)`. The mean of the two
///   stresses is nearer to the exact one than either:
///   ```text
///   ‖σ − ½(τ + σ(v))‖² = ¼ (‖σ−τ‖² + ‖σ−σ(v)‖² − 2∫ p o_ex − 2∫ p_ex o + 2∫ p o)  ≤  ¼ (e² + 2∫ p o)
///   ```
///   so `|N − N_mean| ≤ ½ √(e² + 2∫ p o) √(s₁ s₂/(s₁+s₂))`. This needs one normal for the whole interface.
///
/// Source: Prager and Synge 1947 for the mean; the identities are derived here.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bounds {
    /// `√a(u, u)` of all bodies together, square root of J/m.
    pub energy_norm: [f64; 2],
    /// `J(u) = ½ a(u, u) − ℓ(u)`, J/m.
    pub potential_energy: [f64; 2],
    /// `∫ p_ex ds`, N/m; `None` if the interface is not straight, or not the only one.
    pub contact_force: Option<[f64; 2]>,
}

impl Bounds {
    /// * `iterate`, `estimate`: of one iteration.
    pub(crate) fn new(problem: &PreparedProblem, iterate: &Iterate, estimate: &Estimate) -> Self {
        let e = estimate.unchecked().e_cre;
        let energy: f64 = estimate.energy_norm_squared.iter().sum();
        let norm = energy.sqrt();
        let (mut work, mut size) = (0.0, 0.0);
        for (forces, fields) in problem.external_forces().iter().zip(&estimate.pair.bodies) {
            for (f, u) in forces.iter().zip(&fields.displacement) {
                work += f.dot(u);
                size += f.dot(u).abs();
            }
        }
        for ((body, motion, amount), of) in iterate.motions.iter().zip(problem.rigid_motions()) {
            // The load of an obstacle acts on its free motion.
            if *body >= problem.bodies().len() && *motion == of.motion {
                work += amount * of.load;
                size += (amount * of.load).abs();
            }
        }
        let mut potential = 0.5 * energy - work;
        for (pair, contact) in problem.problem().contacts.iter().zip(&estimate.pair.contacts) {
            let sliding = friction::sliding_work(pair, &contact.edge_friction);
            potential += sliding;
            size += sliding;
        }
        // The admissible displacement is v + l: J(v + l) = J(v) + (K v − f)·l + ½ ‖l‖².
        let mut lifted = 0.0;
        let blocks = iterate.blocks(problem.problem());
        let blocks = blocks.zip(iterate.tangential_blocks(problem.problem()));
        for ((of, contact), (block, tangents)) in
            problem.problem().contacts.iter().zip(&estimate.pair.contacts).zip(blocks)
        {
            let role = of.roles.of_side(contact.lift.side);
            let (forces, sign) = (&iterate.forces()[role][block], [-1.0, 1.0][role]);
            lifted += contact.lift.by_pair.iter().zip(forces).map(|(l, r)| sign * l * r).sum::<f64>();
            let by_role = [&iterate.tangential.reaction, &iterate.tangential.force];
            let by_side = [0, 1].map(|side| &by_role[of.roles.of_side(side)][tangents.clone()]);
            lifted += friction::work_of_lift(of, &contact.edge_friction, by_side);
        }
        let upper = potential + (lifted + 0.5 * estimate.pair.lift_energy).max(0.0);
        // Rounding of the displacements affects the energies as well as the bound.
        let round_off = estimate.round_off;
        let noise = 64.0 * f64::EPSILON * (energy + size) + (norm + e) * round_off;
        Self {
            energy_norm: [(norm - e - round_off).max(0.0), norm + e + round_off],
            potential_energy: [potential - 0.5 * e * e - noise, upper + noise],
            contact_force: contact_force(problem, iterate, estimate),
        }
    }
}

/// A sum below this fraction of its terms has lost digits.
const CANCELLED: f64 = 1e-3;

fn contact_force(problem: &PreparedProblem, iterate: &Iterate, estimate: &Estimate) -> Option<[f64; 2]> {
    let only = problem.problem().plain_pair()?;
    let pairs = only.interface.pairs();
    let straight = pairs.iter().all(|p| p.normal == pairs[0].normal);
    let stiffness = |b: usize| {
        let condensed = &problem.bodies()[b];
        let mut force = vec![0.0; pairs.len()];
        condensed.apply_schur(&vec![1.0; pairs.len()], &mut force);
        let (sum, size) = force.iter().fold((0.0, 0.0), |(sum, size), f| (sum + f, size + f.abs()));
        let largest = condensed.schur().iter().fold(0.0f64, |m, s| m.max(s.abs()));
        if sum > CANCELLED * size.max(largest) {
            return sum;
        }
        // If a soft part supports a stiff one, the rows of S add up to round-off. Any displacement with that trace is
        // valid: its energy comes from its strains.
        let w = condensed.correction_from_trace(&vec![1.0; pairs.len()]);
        norm::energy_norm_squared(&problem.problem().bodies[b], &w)
    };
    let s = [only.imposed(), only.unilateral()].map(stiffness);
    let sum = |r: &[f64]| r.iter().sum::<f64>();
    let [first, second] = iterate.forces();
    let (first, second) = (-sum(first), sum(second));
    let share = s[1] / (s[0] + s[1]);
    // The pressure adds up to the force of Ω₂, whichever body it is integrated on.
    let mean = 0.5 * (second + share * first + (1.0 - share) * second);
    let contact = estimate.cre.contact_squared();
    let radius = 0.5 * (estimate.unchecked().e_cre.powi(2) + contact.max(0.0)).sqrt() * (share * s[0]).sqrt();
    let noise = 64.0 * f64::EPSILON * (first.abs() + second.abs())
        + estimate.round_off * s[0].max(s[1]).max(0.0).sqrt();
    let bounds = [(mean - radius - noise).max(0.0), mean + radius + noise];
    (straight && bounds.iter().all(|x| x.is_finite())).then_some(bounds)
}
