//! The indicators: of the mesh, for a frozen λ_p, and of the iteration.

use crate::admissible::{AdmissibleBody, AdmissiblePair, on_body};
use crate::balance;
use crate::check::{Admissibility, check_stress_and_measure};
use crate::cre::{Cre, of_cells};
use crate::equilibrated::EquilibratedStress;
use crate::measures::Accuracy;
use crate::recovery::Recovery;
use crate::relaxation::Relaxation;
use crate::relaxed::{FrozenStresses, freezes_lambda, frozen_stress};
use crate::round_off::{Noise, less, less_rough, stress_residual};
use fem_core::each_body;
use fem_core::field;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactPair, ContactState, PairState};
use fem_core::prepared::PreparedProblem;
use fem_core::residual;
use neumann_neumann::BodySolvers;
use rayon::prelude::*;

/// The discretisation indicator, with the residuals of its stress.
#[derive(Clone, Debug)]
pub(crate) struct EtaDis {
    /// `η_dis²`, J/m.
    pub(crate) squared: f64,
    /// Residuals of its own stress; zero if that is the stress of the bound.
    pub(crate) admissibility: Admissibility,
    /// The residual of its stress in each body, [`stress_residual`]; `None` if that is the stress of the bound.
    pub(crate) residuals: Vec<Option<Vec<f64>>>,
}

/// Computes `η_dis,p²`, J/m: the constitutive relation error of the second reference problem, λ_p frozen,
/// ```math
/// η_dis² = ‖τ^1_λ − σ(u^1_p)‖² + ‖τ^2 − σ(u^2_p)‖² + 2 ∫ p o     (23)
/// ```
///
/// * Ω₁ has `v¹ = λ_p` imposed: recovery on `σ(u¹_p)` itself, the normal traction on Γ_C free and the
///   tangential one zero.
/// * Ω₂ lies against a rigid obstacle at `λ_p − g`: its equilibrated stress and its contact term are the same as
///   in the global bound, since the pressure is the same, `p_i = r²_i/ℓ_i`.
///
/// If the normal changes along contact edges, the reactions of an imposed trace do not come from a traction that is
/// linear along the edges. In this case the pressure of Ω₁ is frozen instead of λ, and its part is `‖τ¹ − σ̂¹‖²`. The
/// same holds for a body that carries λ in one pair and is unilateral in another, and for one in subdomains.
///
/// The squares are summed up from the stress, cell by cell, and body by body.
///
/// * `noise`: of each body.
/// * `frozen`: the stresses for a frozen λ that are known already. If one of them is not admissible, it is recovered again with refinement.
pub(crate) fn eta_dis<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    pair: &AdmissiblePair<S>,
    cre: &Cre,
    (relaxation, accuracy): (Relaxation, Accuracy),
    frozen: FrozenStresses<S>,
    noise: &[Noise],
) -> EtaDis {
    let problem = solvers.problem();
    let of_body = |(b, known): (usize, Option<EquilibratedStress<S>>)| {
        if !problem.carries_lambda(b) {
            (of_cells(&cre.by_cell[b]), None)
        } else if freezes_lambda(solvers, b) {
            let of_body = (solvers, b, &pair.bodies[b]);
            let of_accuracy = |accuracy| frozen_stress(of_body, (relaxation, accuracy), None);
            let stress = known.unwrap_or_else(|| of_accuracy(accuracy));
            let mut found = measure(of_body, &stress, accuracy, noise[b]);
            drop(stress);
            // A displacement from another source may be in equilibrium to only a few digits.
            if accuracy == Accuracy::Double && !found.admissibility.is_valid() {
                found = measure(of_body, &of_accuracy(Accuracy::Refined), Accuracy::Refined, noise[b]);
            }
            (found.squared, Some(found))
        } else {
            (of_cells(&cre.discretisation_by_cell[b]), None)
        }
    };
    let mut found: Vec<(f64, Option<Frozen>)> = frozen.into_par_iter().enumerate().map(of_body).collect();
    let mut all = EtaDis {
        squared: 0.0,
        admissibility: Admissibility::default(),
        residuals: vec![None; problem.bodies.len()],
    };
    for b in problem.by_role() {
        let (squared, frozen) = &mut found[b];
        all.squared += *squared;
        if let Some(Frozen { admissibility, residual, .. }) = frozen.take() {
            all.admissibility = all.admissibility.worst(admissibility);
            all.residuals[b] = Some(residual);
        }
    }
    all.squared += cre.contact_squared();
    all
}

/// The stress of one body for a frozen λ.
struct Frozen {
    /// `‖τ − σ(u)‖²` of this body, J/m.
    squared: f64,
    admissibility: Admissibility,
    /// [`stress_residual`].
    residual: Vec<f64>,
}

/// Measures the stress of a body for a frozen λ.
fn measure<S: Recovery>(
    (solvers, b, fields): (&BodySolvers<'_, S>, usize, &AdmissibleBody<S>),
    stress: &EquilibratedStress<S>,
    accuracy: Accuracy,
    noise: Noise,
) -> Frozen {
    let (body, solver) = (&solvers.problem().bodies[b], &solvers.bodies()[b]);
    let against = [Some(fields.stress.as_slice()), None];
    let displaced = (fields.displacement.as_slice(), noise);
    let (admissibility, cells) = check_stress_and_measure(body, displaced, stress, Some((against, accuracy)));
    let squared = of_cells(&cells.distances[0]);
    let residual = stress_residual(body, solver, (stress, &cells, accuracy), Vec::new());
    Frozen { squared, admissibility, residual }
}

/// Computes the residuals from which `η_NNDD` is computed, `R^α = K_α u^α_p − f^α ± r n` along the unknowns of each body, N/m.
///
/// * `balanced`: the forces `r` by row, in balance with the loads of floating bodies, N/m.
pub(crate) fn state_residuals<S: Recovery>(
    solvers: &BodySolvers<'_, S>,
    state: &ContactState<'_, S>,
    balanced: &[Vec<f64>],
    accuracy: Accuracy,
) -> Vec<Vec<f64>> {
    let (problem, bodies) = (solvers.problem(), solvers.bodies());
    let nodal_forces = |(pair, forces): (&ContactPair<S>, &Vec<f64>)| -> Vec<S::Vector> {
        let mut sums = vec![S::Vector::ZERO; pair.interface.pairs().len()];
        pair.rows().zip(forces).for_each(|(row, r)| sums[row.pair] += row.direction * *r);
        sums
    };
    let forces: Vec<_> = problem.contacts.iter().zip(balanced).map(nodal_forces).collect();
    let of_body = |b: usize| {
        let (body, u) = (&problem.bodies[b], state.displacement[b]);
        let forces = on_body(problem, b, |k| &forces[k]);
        match accuracy {
            Accuracy::Double => {
                bodies[b].rough_along_unknowns(&less_rough::<S>(field::nodal_residual(body, u), &forces))
            }
            Accuracy::Refined => {
                bodies[b].along_unknowns(&less::<S>(residual::of_displacement(body, u), &forces))
            }
        }
    };
    each_body(problem.bodies.len(), of_body)
}

/// Computes the distance of a state from the solution of the discrete problem, split into iteration and rounding.
/// ```math
/// η_NNDD² = ∑_α R^α·K_α⁻¹ R^α + 2 ∑_i r_i o_i ≥ ‖u_h − u_p‖²
/// ```
/// It is the constitutive relation error of the discrete problem: `u^α_p − K⁻¹R^α` is in FE equilibrium with the forces `r`. In
/// exact arithmetic `R` vanishes except for the imbalance at the interface of Ω₁, and this is (22). It includes the
/// rounding of the displacements.
///
/// Friction adds `2 Σ (S|w| − Q·w)`, with `|Q| ≤ S` and the given slip `w`.
///
/// * `interior`, `interface`: the parts of `R·K⁻¹ R` of all bodies' [`state_residuals`] `R^α`, J/m.
///
/// Returns the squares, J/m: the part on the interface, and the remainder, which is rounding.
pub(crate) fn eta_nndd_squared<S: Recovery>(
    prepared: &PreparedProblem<S>,
    state: &ContactState<'_, S>,
    balanced: &[Vec<f64>],
    [interior, interface]: [f64; 2],
) -> [f64; 2] {
    let pairs =
        state.contacts.iter().zip(balanced).flat_map(|(pair, forces)| forces.iter().zip(pair.opening));
    let work: f64 = pairs.map(|(r, o)| (r * o).max(0.0)).sum();
    let sliding = |((pair, forces), limits): ((&PairState<'_>, &Vec<f64>), &Vec<f64>)| -> f64 {
        let (nodes, friction) = (limits.len().max(1), &forces[pair.opening.len()..]);
        let of_node = |(k, s): (usize, &f64)| {
            let both = friction[k..].iter().zip(&pair.slip[k..]).step_by(nodes);
            let (work, squared) = both.fold((0.0, 0.0), |(work, sum), (q, w)| (work + q * w, sum + w * w));
            (s * squared.sqrt() - work).max(0.0)
        };
        limits.iter().enumerate().map(of_node).sum()
    };
    let limits = balance::force_limits(prepared, state);
    let work = work + state.contacts.iter().zip(balanced).zip(&limits).map(sliding).sum::<f64>();
    [interface + 2.0 * work, interior]
}
