//! Everything a certificate needs, in one call.

use crate::admissible::{AdmissiblePair, pair_and_stars};
use crate::check::{Admissibility, check_and_visit};
use crate::cre::{Cre, cell_distances};
use crate::error::EstimatorError;
use crate::indicators::eta_dis_squared_with;
use crate::round_off;
use crate::star_relaxation::{Relaxation, bytes_of_stars};
use fem_core::condensation::CondensedBody;
use fem_core::interface::{ContactProblem, ContactState};
use fem_core::norm::{from_squared, sum_over_triangles};
use fem_core::room::has_room_for;
use rayon::prelude::*;

/// Rounding is relative to squares above this, and a product of two of their roundings does not underflow.
const SMALLEST_SQUARE: f64 = 1e-250;

/// The estimate of a contact state.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Estimate {
    /// The admissible pair the bound rests on.
    pub pair: AdmissiblePair,
    /// The constitutive relation error and its split.
    pub cre: Cre,
    /// Residuals of admissibility.
    pub admissibility: Admissibility,
    /// The guaranteed bound `e_CRE` of the energy error, round-off allowance included, square root of J/m.
    pub e_cre: f64,
    /// The part of it that is an allowance for round-off: errors of this size and below cannot be told from zero.
    pub round_off: f64,
    /// The discretisation indicator `η_dis`.
    pub eta_dis: f64,
    /// `a(u, u)` of the state's displacements in each body, J/m.
    pub energy_norm_squared: [f64; 2],
}

impl Estimate {
    /// Computes the energy norm of the state's displacements, `√(a₁+a₂)`, square root of J/m.
    pub fn energy_norm(&self) -> f64 {
        self.energy_norm_squared.iter().sum::<f64>().sqrt()
    }
}

/// Estimates the error of a contact state, whoever computed it, by EET alone: [`estimate_with`] without
/// relaxation.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite.
pub fn estimate(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    state: &ContactState<'_>,
) -> Result<Estimate, EstimatorError> {
    estimate_with(problem, bodies, state, Relaxation::NONE)
}

/// Estimates the error of a contact state, whoever computed it.
///
/// * `relaxation`: how far the equilibrated stresses are relaxed. The bound is strict at every step; more
///   steps make it sharper.
///
/// # Errors
/// Arrays of the wrong length, values that are not finite, a lack of memory.
pub fn estimate_with(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    state: &ContactState<'_>,
    relaxation: Relaxation,
) -> Result<Estimate, EstimatorError> {
    if relaxation.max_steps() > 0 {
        let bytes = problem.bodies.iter().map(|body| bytes_of_stars(body.mesh())).sum();
        if !has_room_for(bytes) {
            return Err(EstimatorError::OutOfMemory { bytes });
        }
    }
    let (mut pair, stars) = pair_and_stars(problem, bodies, state, relaxation)?;
    // One walk over the cells for both.
    let (admissibility, distances) =
        check_and_visit(problem, &pair, |b, t, tau| cell_distances(problem, &pair, b, t, tau));
    let cre = Cre::from_cells(problem, &pair, distances);
    let energy_of = |b: usize| {
        let body = &problem.bodies[b];
        sum_over_triangles(pair.stress[b].len(), |t| {
            let s = pair.stress[b][t];
            body.mesh().area(t) * body.material(t).complementary(s, s)
        })
    };
    let energy_norm_squared = [energy_of(0), energy_of(1)];
    let first = std::mem::take(&mut pair.stress[0]);
    let (eta_dis_squared, first) = eta_dis_squared_with(problem, first, &cre, relaxation, stars);
    let eta_dis = from_squared(eta_dis_squared);
    pair.stress[0] = first;
    // Squares of smaller numbers are lost, and with them the checks.
    let largest = |b: usize| {
        let all = pair.stress[b].par_iter().with_min_len(4096);
        all.map(|s| s.xx.abs().max(s.yy.abs()).max(s.xy.abs())).reduce(|| 0.0, f64::max)
    };
    let stress = largest(0).max(largest(1));
    let energy: f64 = energy_norm_squared.iter().sum();
    if stress > 0.0 && (stress * stress).min(energy) < SMALLEST_SQUARE {
        return Err(EstimatorError::TooSmall { stress, energy });
    }
    let round_off = round_off::allowance(problem, &pair, energy_norm_squared);
    let e_cre = cre.e_cre() + round_off;
    if !(e_cre.is_finite() && eta_dis.is_finite()) {
        return Err(EstimatorError::NotFinite { what: "the estimate" });
    }
    Ok(Estimate { pair, cre, admissibility, e_cre, round_off, eta_dis, energy_norm_squared })
}
