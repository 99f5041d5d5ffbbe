//! Programmes with bounds on both sides and equality rows: an active set with a small system for the rows, and Clarabel
//! behind it.
//!
//! ```math
//! min_x ½ xᵀ P x + qᵀ x   subject to   l ≤ x ≤ u,   G x = e
//! ```
//! `P` may be singular, and rows may depend on each other. If `P + c GᵀG` is singular on the unknowns that are not at a bound, some of
//! them keep their values, and the solution is one of many. On a given set of unknowns at their bounds the rest `F` and the multipliers `a` solve
//! ```math
//! (P_FF + c G_Fᵀ G_F) x_F − G_Fᵀ a  = −q_F − P_FB x_B + c G_Fᵀ (e − G_B x_B)
//! G_F x_F                           = e − G_B x_B
//! ```
//! by a Cholesky factor of `P_FF + c G_Fᵀ G_F` and the eigenvalues of the Schur complement, whose zeros are the dependent rows.
//! Large sets that differ in few unknowns from the last factorised one use its factor. A sparse `P`, as in a wall of bodies, stays sparse: the
//! matrix of `x_F` and `a` is factorised with `η` on the diagonal of `x` and `−δ` on that of `a`, and solutions are corrected until these have no part in them.
//! The multipliers are then the ones of least norm. If the bounds leave `x` no room, such as in a single feasible point, these may
//! have wrong signs although others are right: then those are found by a least distance programme.

mod active_set;
mod augmented;
mod full;
mod kept;
mod residuals;

use crate::error::QpError;
use crate::interior_point;
use crate::place::Place;
use crate::programme::BoxQp;
use crate::settings::{QpMethod, QpSettings};
use crate::solution::{QpPath, QpStatus};
use active_set::{Candidate, System};

pub use residuals::{BoxResiduals, box_residuals};

/// The solution of a [`BoxQp`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BoxSolution {
    /// `x`, within its bounds exactly.
    pub x: Vec<f64>,
    /// `y = P x + q − Gᵀ a`: ≥ 0 at lower bounds, ≤ 0 at upper bounds, exactly 0 between them.
    pub multipliers: Vec<f64>,
    /// `a`, of least norm if rows depend on each other.
    pub row_multipliers: Vec<f64>,
    /// Where each unknown is.
    pub places: Vec<Place>,
    /// How the solve ended.
    pub status: QpStatus,
    /// Method that found this solution.
    pub path: QpPath,
    /// Sets tried, or iterations of Clarabel.
    pub iterations: usize,
    /// Number of calls of Clarabel.
    pub clarabel_calls: usize,
    /// How far it is from the KKT conditions.
    pub kkt: BoxResiduals,
}

/// Steps of a descent, at most, besides four per unknown.
const MOST_DESCENTS: usize = 50;

/// Sparse programmes with more unknowns than this are solved by active sets and Clarabel only.
const MOST_DESCENDED: usize = 2000;

/// Fractions of the largest unknown by which an unknown is clearly off its bounds; they are tried one after the other.
const CLEARLY: [f64; 4] = [1e-9, 1e-7, 1e-5, 1e-3];

/// Places the unknowns that are within a fraction of the largest one of a bound at that bound.
fn clearly_off(qp: &BoxQp<'_>, x: &[f64], places: &[Place], fraction: f64) -> Vec<Place> {
    let least = fraction * x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let place = |i: usize| match places[i] {
        _ if x[i] - qp.lower[i] <= least => Place::Lower,
        _ if qp.upper[i] - x[i] <= least => Place::Upper,
        _ => Place::Free,
    };
    (0..x.len()).map(place).collect()
}

/// Answers a programme without unknowns, which Clarabel does not take: its rows hold if their right sides are zero.
fn without_unknowns(qp: &BoxQp<'_>, settings: &QpSettings) -> BoxSolution {
    let empty = Candidate { x: Vec::new(), a: vec![0.0; qp.right_side.len()], places: Vec::new() };
    let mut answer = empty.into_solution(qp, QpPath::ActiveSet, 0);
    if answer.kkt.max() > settings.kkt_tolerance {
        answer.status = QpStatus::Infeasible;
    }
    answer
}

/// Solves `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`, exactly on its active set.
///
/// * `start`: the place of each unknown on the first set that is tried, n entries; `None`: all between their bounds, or at them if these
///   are equal.
///
/// An active set that comes back, or on which the rows cannot hold, calls Clarabel, whose solution is polished; if that fails, the
/// objective is lowered step by step from a vertex at which the rows hold.
///
/// # Errors
/// Those of [`BoxQp::check`]; a `start` of the wrong length, settings out of range, and data that Clarabel rejects. No
/// convergence is a [`QpStatus`], and so are rows that no `x` within the bounds satisfies: [`QpStatus::Infeasible`].
pub fn solve_box(
    qp: &BoxQp<'_>,
    start: Option<&[Place]>,
    settings: &QpSettings,
) -> Result<BoxSolution, QpError> {
    settings.check()?;
    qp.check()?;
    let n = qp.linear.len();
    if let Some(found) = start.map(<[Place]>::len).filter(|found| *found != n) {
        return Err(QpError::Length { what: "start", expected: n, found });
    }
    if n == 0 {
        return Ok(without_unknowns(qp, settings));
    }
    let system = System::new(qp);
    if settings.method != QpMethod::Clarabel {
        let fixed = |i: usize| if qp.lower[i] == qp.upper[i] { Place::Lower } else { Place::Free };
        let start = start.map_or_else(|| (0..n).map(fixed).collect(), <[Place]>::to_vec);
        let (found, steps) = system.active_set(start, &vec![0.0; n], settings.step_limit());
        if let Some(candidate) = found {
            let path = if steps == 1 { QpPath::WarmStart } else { QpPath::ActiveSet };
            let answer = candidate.into_solution(qp, path, steps);
            if answer.kkt.max() <= settings.kkt_tolerance {
                return Ok(answer);
            }
        }
    }
    let guess = interior_point::solve_boxed(qp, settings)?;
    let clarabel = |mut answer: BoxSolution| {
        (answer.path, answer.iterations, answer.clarabel_calls) = (QpPath::Clarabel, guess.iterations, 1);
        answer
    };
    let polished = |candidate: Candidate| {
        let answer = clarabel(candidate.into_solution(qp, QpPath::Clarabel, guess.iterations));
        Some(answer).filter(|answer| answer.kkt.max() <= settings.kkt_tolerance)
    };
    let (found, _) = system.active_set(guess.places.clone(), &guess.x, settings.max_iterations);
    let found = found.and_then(polished);
    let descended = || system.descend(&guess.x, &guess.places, MOST_DESCENTS + 4 * n).and_then(polished);
    let fitting = || system.with_fitting_multipliers(&guess.places, &guess.x).and_then(polished);
    // Where a set determines a vertex, sets about it follow each other without a step: the set of what is clearly off its bounds.
    let clear = || {
        CLEARLY.into_iter().find_map(|fraction| {
            let places = clearly_off(qp, &guess.x, &guess.places, fraction);
            let found =
                system.active_set(places.clone(), &guess.x, settings.max_iterations).0.and_then(polished);
            let small = n <= MOST_DESCENDED;
            let fitting = || system.with_fitting_multipliers(&places, &guess.x).and_then(polished);
            if small { found.or_else(fitting) } else { found }
        })
    };
    let from_vertex = || system.descend_from_vertex(MOST_DESCENTS + 4 * n).and_then(polished);
    // Large sparse programmes are not descended step by step: each step takes a factor.
    let answer = if system.is_sparse() && n > MOST_DESCENDED {
        found.or_else(clear)
    } else {
        found.or_else(descended).or_else(fitting).or_else(clear).or_else(from_vertex)
    };
    if let Some(answer) = answer {
        return Ok(answer);
    }
    let candidate = Candidate { x: guess.x, a: guess.row_multipliers, places: guess.places };
    let mut answer = clarabel(candidate.into_solution(qp, QpPath::Clarabel, guess.iterations));
    answer.status = match guess.status {
        QpStatus::Solved => QpStatus::PolishFailed,
        other => other,
    };
    Ok(answer)
}

/// Solves a programme by active sets alone; `None` if they come back.
///
/// * `start`: the first set.
///
/// # Errors
/// Those of [`BoxQp::check`].
pub(crate) fn solve_on_sets(qp: &BoxQp<'_>, start: Vec<Place>) -> Result<Option<Vec<f64>>, QpError> {
    qp.check()?;
    let (found, _) =
        System::new(qp).active_set(start, &vec![0.0; qp.linear.len()], QpSettings::default().max_iterations);
    Ok(found.map(|candidate| candidate.into_solution(qp, QpPath::ActiveSet, 0).x))
}

impl Candidate {
    /// Makes bounds and signs exact, provided that the errors are round-off.
    fn into_solution(self, qp: &BoxQp<'_>, path: QpPath, iterations: usize) -> BoxSolution {
        let Self { mut x, a, mut places } = self;
        for i in 0..x.len() {
            if places[i] == Place::Free && x[i] <= qp.lower[i] {
                places[i] = Place::Lower;
            } else if places[i] == Place::Free && x[i] >= qp.upper[i] {
                places[i] = Place::Upper;
            }
            if places[i] != Place::Free {
                x[i] = qp.bound(i, places[i]);
            }
        }
        debug_assert!(x.iter().zip(qp.lower.iter().zip(qp.upper)).all(|(x, (l, u))| (l..=u).contains(&x)));
        let mut multipliers = qp.gradient(&x, &a);
        for (i, (y, place)) in multipliers.iter_mut().zip(&mut places).enumerate() {
            if qp.lower[i] == qp.upper[i] {
                *place = if *y < 0.0 { Place::Upper } else { Place::Lower };
            }
            *y = match place {
                Place::Lower => y.max(0.0),
                Place::Upper => y.min(0.0),
                Place::Free => 0.0,
            };
        }
        let kkt = box_residuals(qp, &x, &multipliers, &a);
        let status = QpStatus::Solved;
        let row_multipliers = a;
        BoxSolution {
            x,
            multipliers,
            row_multipliers,
            places,
            status,
            path,
            iterations,
            clarabel_calls: 0,
            kkt,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::MatrixView;
    use crate::sparse::SparseRows;

    /// Solves 200 random programmes of 6 unknowns, of which unknown 2 acts like unknown 0 with the opposite sign, unknown 5 like 1 and 4
    /// together, and more unknowns that are fixed at zero.
    ///
    /// * `fixed`: their stiffness and load.
    fn solve_dependent(fixed: &[[f64; 2]]) {
        let (n, rank, all) = (6, 4, 6 + fixed.len());
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for _ in 0..200 {
            let mut columns: Vec<Vec<f64>> = (0..n).map(|_| (0..rank).map(|_| random()).collect()).collect();
            columns[2] = columns[0].iter().map(|c| -c).collect();
            columns[5] = columns[1].iter().zip(&columns[4]).map(|(a, b)| a + b).collect();
            let load: Vec<f64> = (0..rank).map(|_| random()).collect();
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let entry = |i: usize, j: usize| match i.max(j) {
                last if last < n => product(&columns[i], &columns[j]),
                last if i == j => fixed[last - n][0],
                _ => 0.0,
            };
            let matrix: Vec<f64> = (0..all * all).map(|k| entry(k % all, k / all)).collect();
            let loads = columns.iter().map(|c| product(c, &load)).chain(fixed.iter().map(|of| of[1]));
            let linear: Vec<f64> = loads.collect();
            let (limit, none) = (random().abs(), vec![0.0; fixed.len()]);
            let bounds = |bounds: [f64; 6]| [&bounds[..], &none].concat();
            let qp = BoxQp {
                matrix: MatrixView::Dense { n: all, values: &matrix },
                linear: &linear,
                lower: &bounds([0.0, 0.0, -limit, -limit, 0.0, -limit]),
                upper: &bounds([f64::INFINITY, f64::INFINITY, limit, limit, f64::INFINITY, limit]),
                rows: &SparseRows::new(all),
                right_side: &[],
            };
            for method in [QpMethod::Auto, QpMethod::Clarabel] {
                let found = solve_box(&qp, None, &QpSettings::default().with_method(method)).unwrap();
                assert!(found.status.is_solved() && found.kkt.max() <= 1e-12, "{found:?}");
            }
        }
    }

    #[test]
    fn unknowns_that_depend_on_each_other_do_not_stall_the_active_set() {
        solve_dependent(&[]);
    }

    #[test]
    fn a_fixed_unknown_with_a_stiffness_of_rounding_does_not_stall_the_others() {
        solve_dependent(&[[1e-24, 1.0], [0.0, -0.3]]);
    }
}
