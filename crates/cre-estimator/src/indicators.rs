//! The indicators: of the mesh, for a frozen λ_p, and of the iteration.

use crate::admissible::{Accuracy, AdmissiblePair, on_body, with_imposed_normal};
use crate::check::{Admissibility, check_stress_and_visit};
use crate::cre::{CellMeasure, Cre};
use crate::equilibrated::EquilibratedStress;
use crate::johnson_mercier;
use crate::round_off::{less, less_rough, stress_energy};
use crate::star_relaxation::{Relaxation, StarRelaxation, relax};
use fem_core::each_body;
use fem_core::field;
use fem_core::geometry::{Vector, scale};
use fem_core::interface::ContactState;
use fem_core::norm::sum_over_triangles;
use fem_core::prepared::PreparedProblem;
use fem_core::residual::{self, SplitField};

/// The discretisation indicator, with the residuals of its stress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EtaDis {
    /// `η_dis²`, J/m.
    pub(crate) squared: f64,
    /// Residuals of its own stress; zero if that is the stress of the bound.
    pub(crate) admissibility: Admissibility,
    /// `√(Rᵀ K⁻¹ R)` of its stress in Ω₁; `None` if that is the stress of the bound.
    pub(crate) residual: Option<f64>,
}

/// Computes `η_dis,p²`, J/m: the constitutive relation error of the second reference problem, λ_p frozen,
/// ```math
/// η_{dis}^2 = ‖τ^1_λ - σ(u^1_p)‖^2 + ‖τ^2 - σ(u^2_p)‖^2 + 2 ∫ p\,o                                             \qquad (23)
/// ```
///
/// * Ω₁ has `v¹ = λ_p` imposed: recovery on `σ(u¹_p)` itself, the normal traction on Γ_C free and the
///   tangential one zero.
/// * Ω₂ lies against a rigid obstacle at `λ_p − g`: its equilibrated stress and its contact term are those
///   of the global bound, since the pressure is the same, `p_i = r²_i/ℓ_i`.
///
/// If the normal changes along contact edges, the reactions of an imposed trace are not those of a traction that is
/// linear along the edges. In this case the pressure of Ω₁ is frozen instead of λ, and its part is `‖τ¹ − σ̂¹‖²`.
///
/// The squares are summed up from the stress, cell by cell. `relaxation` applies to Ω₁ and should be that of the pair.
pub(crate) fn eta_dis(
    prepared: &PreparedProblem,
    pair: &AdmissiblePair,
    cre: &Cre,
    (relaxation, accuracy): (Relaxation, Accuracy),
    stars: Option<StarRelaxation<'_>>,
) -> EtaDis {
    let [imposed, unilateral] = prepared.roles().bodies();
    let second = sum_over_triangles(cre.by_cell[unilateral].len(), |t| cre.by_cell[unilateral][t]);
    let contact = cre.by_contact_edge.iter().sum::<f64>();
    if prepared.problem().interface.has_bent_edges() {
        let cells = &cre.discretisation_by_cell[imposed];
        let squared = sum_over_triangles(cells.len(), |t| cells[t]) + second + contact;
        return EtaDis { squared, admissibility: Admissibility::default(), residual: None };
    }
    let mut stars = stars;
    let found = frozen(prepared, pair, (relaxation, accuracy), &mut stars);
    // A displacement from another source may be in equilibrium to only a few digits.
    let found = if accuracy == Accuracy::Double && !found.admissibility.is_valid() {
        frozen(prepared, pair, (relaxation, Accuracy::Refined), &mut stars)
    } else {
        found
    };
    EtaDis { squared: found.squared + second + contact, ..found }
}

/// Recovers the stress of Ω₁ for a frozen λ; the square is that of Ω₁ alone, `‖τ¹ − σ(u¹)‖²`.
fn frozen(
    prepared: &PreparedProblem,
    pair: &AdmissiblePair,
    (relaxation, accuracy): (Relaxation, Accuracy),
    stars: &mut Option<StarRelaxation<'_>>,
) -> EtaDis {
    let b = prepared.roles().imposed();
    let (body, condensed) = (&prepared.problem().bodies[b], &prepared.bodies()[b]);
    let stress = match accuracy {
        Accuracy::Double => pair.stress[b].clone(),
        Accuracy::Refined => {
            let mut field = SplitField::new(pair.displacement[b].clone());
            condensed.refine(body, &[], true, &mut field);
            residual::stresses(body, &field)
        }
    };
    let conditions = with_imposed_normal(body, &prepared.problem().interface, b);
    let mut recovered = EquilibratedStress::recover(body, stress, conditions);
    match stars {
        Some(stars) => {
            stars.restate(&recovered.conditions);
            stars.relax(&mut recovered, relaxation);
        }
        None => {
            relax(body, &mut recovered, relaxation);
        }
    }
    let visit = |t: usize, tau: &johnson_mercier::CellStress| {
        let (area, material) = (body.mesh().area(t), body.material(t));
        let distance = johnson_mercier::distance_squared(tau, pair.stress[b][t], area, material);
        CellMeasure::new([distance, 0.0], tau)
    };
    let (admissibility, cells) = check_stress_and_visit(body, &pair.displacement[b], &recovered, visit);
    let first = sum_over_triangles(cells.len(), |t| cells[t].distances[0]);
    let [interior, _] = stress_energy(body, condensed, &cells, &[], accuracy);
    EtaDis { squared: first, admissibility, residual: Some(interior.sqrt()) }
}

/// Computes the distance of a state from the solution of the discrete problem, split into iteration and rounding.
/// ```math
/// η_{NNDD}^2 = \sum_α R^α · K_α^{-1} R^α + 2 \sum_i r_i\,o_i ≥ ‖u_h - u_p‖^2, \qquad R^α = K_α u^α_p - f^α ± r\,n
/// ```
/// It is the constitutive relation error of the discrete problem: `u^α_p − K⁻¹R^α` is in FE equilibrium with the forces `r`. In
/// exact arithmetic `R` vanishes except for the imbalance at the interface of Ω₁, and this is (22). It includes the
/// rounding of the displacements.
///
/// Returns the squares, J/m: the part on the interface, and the remainder, which is rounding.
pub(crate) fn eta_nndd_squared(
    prepared: &PreparedProblem,
    state: &ContactState<'_>,
    accuracy: Accuracy,
) -> [f64; 2] {
    let (problem, bodies) = (prepared.problem(), prepared.bodies());
    let pairs = problem.interface.pairs();
    let forces: Vec<Vector> =
        pairs.iter().zip(state.contact_force).map(|(p, r)| scale(*r, p.normal)).collect();
    let of_body = |b: usize| {
        let (body, u) = (&problem.bodies[b], state.displacement[b]);
        let forces = on_body(&problem.interface, b, &forces);
        match accuracy {
            Accuracy::Double => {
                bodies[b].rough_residual_energy(&less_rough(field::nodal_residual(body, u), &forces))
            }
            Accuracy::Refined => {
                bodies[b].residual_energy(&less(residual::of_displacement(body, u), &forces))
            }
        }
    };
    let [[i1, c1], [i2, c2]] = each_body(of_body);
    let work: f64 = state.contact_force.iter().zip(state.opening).map(|(r, o)| (r * o).max(0.0)).sum();
    [c1 + c2 + 2.0 * work, i1 + i2]
}
