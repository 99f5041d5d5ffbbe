//! The discretisation indicator: the error of step 1's own problems for a frozen λ_p.

use crate::admissible::{AdmissiblePair, with_imposed_normal};
use crate::cre::Cre;
use crate::equilibrated::EquilibratedStress;
use crate::star_relaxation::{Relaxation, StarRelaxation, relax};
use fem_core::interface::ContactProblem;
use fem_core::norm::sum_over_triangles;
use fem_core::tensor::SymTensor2;

/// Computes `η_dis,p²`, J/m, (23) of `certified_contact::theory`: the constitutive relation error of the second reference
/// problem, λ_p frozen.
///
/// * Ω₁ has `v¹ = λ_p` imposed: recovery on `σ(u¹_p)` itself, the normal traction on Γ_C free and the
///   tangential one zero.
/// * Ω₂ stands against a rigid obstacle at `λ_p − g`: its equilibrated stress and its contact term are those
///   of the global bound, since the pressure is the same, `p_i = r²_i/ℓ_i`.
///
/// Where the normal changes along contact edges, the reactions of an imposed trace are not those of a traction that is
/// linear along the edges: there the pressure of Ω₁ is frozen instead of λ, and its part is `‖τ¹ − σ̂¹‖²`.
///
/// `relaxation` applies to Ω₁ and should be that of the pair.
pub fn eta_dis_squared(
    problem: &ContactProblem,
    pair: &AdmissiblePair,
    cre: &Cre,
    relaxation: Relaxation,
) -> f64 {
    eta_dis_squared_with(problem, pair.stress[0].clone(), cre, relaxation, None).0
}

/// [`eta_dis_squared`] with stars of Ω₁ that are ready already. Takes the stress of Ω₁ and gives it back.
pub(crate) fn eta_dis_squared_with<'a>(
    problem: &'a ContactProblem,
    stress: Vec<SymTensor2>,
    cre: &Cre,
    relaxation: Relaxation,
    stars: Option<StarRelaxation<'a>>,
) -> (f64, Vec<SymTensor2>) {
    let second = sum_over_triangles(cre.by_cell[1].len(), |t| cre.by_cell[1][t]);
    let contact = cre.by_contact_edge.iter().sum::<f64>();
    if problem.interface.has_bent_edges() {
        let cells = &cre.discretisation_by_cell[0];
        return (sum_over_triangles(cells.len(), |t| cells[t]) + second + contact, stress);
    }
    let body = &problem.bodies[0];
    let conditions = with_imposed_normal(body, &problem.interface, 0);
    let mut recovered = EquilibratedStress::recover(body, stress, conditions);
    let report = match stars {
        Some(mut stars) => {
            stars.restate(&recovered.conditions);
            stars.relax(&mut recovered, relaxation)
        }
        None => relax(body, &mut recovered, relaxation),
    };
    let first = report.energy_history.last().copied().unwrap_or(f64::NAN);
    (first + second + contact, recovered.finite_element)
}
