//! The solution of a programme, by the first of a list of ways that leads to it.
//!
//! On a given set of unknowns `B` at their bounds the others `F` and the multipliers `a` of the rows solve
//! ```math
//! (P_FF + c G_Fᵀ G_F) x_F − G_Fᵀ a  = −q_F − P_FB x_B + c G_Fᵀ (e − G_B x_B)
//! G_F x_F                           = e − G_B x_B
//! ```
//! by a Cholesky factor of `P_FF + c G_Fᵀ G_F` and the eigenvalues of the Schur complement, whose zeros are the dependent rows.
//! If `P + c GᵀG` is singular on `F`, some unknowns keep their values, and the solution is one of many.
//! Large sets that differ in few unknowns from the last factorised one use its factor. A sparse `P`, as in a wall of bodies, stays sparse: the
//! matrix of `x_F` and `a` is factorised with `η` on the diagonal of `x` and `−δ` on that of `a`, and solutions are corrected until these have no part in them.

mod active_set;
mod augmented;
mod full;
mod kept;
mod weighted;

use crate::bound_state::BoundState;
use crate::error::QpError;
use crate::interior_point::{self, BoxedPoint};
use crate::programme::BoxQp;
use crate::reduce;
use crate::residuals::kkt_residuals;
use crate::settings::{QpMethod, QpSettings};
use crate::solution::{BoxSolution, QpCounts, QpPath, QpStatus};
use active_set::System;

pub(crate) use active_set::ActiveSetPoint;

/// A way to the solution. Each begins where the one before it ended, and the KKT residuals decide whether it has led there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Active sets from the given one, or from the set of the fixed unknowns: a solution of similar data is next to the right one.
    ActiveSets,
    /// Clarabel with few of the bounds, and active sets from its set: a full matrix that is large for Clarabel.
    Shrunk,
    /// Clarabel, and active sets from its set.
    Clarabel,
    /// Clarabel's set with multipliers that have the right signs. Those of least norm may have wrong ones if the set determines `x`
    /// alone, such as in a single feasible point.
    Multipliers,
    /// A descent from Clarabel's point, or from one where the rows hold, which lowers the objective with every step: active sets may come back, and
    /// the rows may not hold on Clarabel's set.
    Descent,
}

/// The ways in the order in which they are tried.
const WAYS: [Way; 5] = [Way::ActiveSets, Way::Shrunk, Way::Clarabel, Way::Multipliers, Way::Descent];

/// Steps of a descent, at most, besides four per unknown.
const MOST_DESCENTS: usize = 50;

/// Sparse programmes with more unknowns than this have no descent, each step of which takes a factor, and no multipliers fitted.
const MOST_DESCENDED: usize = 2000;

/// Solves `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`, exactly on its active set.
///
/// * `start`: the place of each unknown on the first set that is tried, n entries, such as those of a similar programme; [`QpMethod`] says
///   what happens without it.
///
/// Active sets that come back, or on which the rows cannot hold, call Clarabel, whose solution is made exact. If a bound is only just
/// reached, so that its multiplier is zero, it is usually reported as reached.
///
/// # Errors
/// Those of [`BoxQp::check`]; a `start` of the wrong length, settings out of range, a matrix with a negative direction, and data that
/// Clarabel rejects. No convergence is a [`QpStatus`], and so are rows that no `x` within the bounds satisfies:
/// [`QpStatus::Infeasible`].
pub fn solve_box(
    qp: &BoxQp<'_>,
    start: Option<&[BoundState]>,
    settings: &QpSettings,
) -> Result<BoxSolution, QpError> {
    solve_by(&WAYS, qp, start, settings)
}

fn solve_by(
    ways: &[Way],
    qp: &BoxQp<'_>,
    start: Option<&[BoundState]>,
    settings: &QpSettings,
) -> Result<BoxSolution, QpError> {
    settings.check()?;
    qp.check()?;
    let n = qp.linear.len();
    if let Some(found) = start.map(<[BoundState]>::len).filter(|found| *found != n) {
        return Err(QpError::Length { what: "start", expected: n, found });
    }
    if n == 0 {
        return Ok(without_unknowns(qp, settings));
    }
    let [lower, upper] = qp.near_bounds();
    let near = BoxQp { lower: &lower, upper: &upper, ..*qp };
    let start = first_set(&near, start, settings.method);
    let mut search = Search {
        near,
        system: System::new(qp, &near),
        settings,
        start,
        point: None,
        counts: QpCounts::default(),
    };
    for way in ways {
        if let Some(candidate) = search.follow(*way)? {
            let answer = search.answer(qp, candidate);
            if answer.kkt.max() <= settings.kkt_tolerance {
                return Ok(answer);
            }
        }
    }
    search.unsolved(qp)
}

/// Chooses the first set; `None` if the method begins with Clarabel.
fn first_set(qp: &BoxQp<'_>, start: Option<&[BoundState]>, method: QpMethod) -> Option<Vec<BoundState>> {
    let is_bounded = qp.lower.iter().chain(qp.upper).any(|bound| bound.is_finite());
    match (method, start) {
        (QpMethod::Clarabel, _) => None,
        (_, Some(start)) => Some(start.to_vec()),
        // A system of equations needs no interior-point method.
        (QpMethod::Auto, None) if is_bounded => None,
        (QpMethod::Auto | QpMethod::ActiveSet, None) => Some(qp.states_at_rest()),
    }
}

/// What the ways have in common, and what they leave for the next ones.
struct Search<'a> {
    /// The programme without far bounds.
    near: BoxQp<'a>,
    system: System<'a>,
    settings: &'a QpSettings,
    start: Option<Vec<BoundState>>,
    /// What Clarabel has found for the whole programme.
    point: Option<BoxedPoint>,
    counts: QpCounts,
}

impl Search<'_> {
    /// Follows one way; `None` if it does not apply or leads nowhere.
    fn follow(&mut self, way: Way) -> Result<Option<ActiveSetPoint>, QpError> {
        match way {
            Way::ActiveSets => Ok(self.active_sets()),
            Way::Shrunk => self.shrunk(),
            Way::Clarabel => self.clarabel(),
            Way::Multipliers => Ok(self.multipliers()),
            Way::Descent => Ok(self.descent()),
        }
    }

    fn active_sets(&mut self) -> Option<ActiveSetPoint> {
        let start = self.start.take()?;
        let origin = vec![0.0; start.len()];
        let (found, sets) = self.system.active_set(start, &origin, self.settings.step_limit());
        self.counts.active_sets = sets;
        found
    }

    fn shrunk(&mut self) -> Result<Option<ActiveSetPoint>, QpError> {
        let Some((states, iterations)) = reduce::guess(&self.near, self.settings)? else { return Ok(None) };
        self.counts.shrunk_calls = 1;
        self.counts.interior_points += iterations;
        let limit = self.settings.step_limit();
        Ok(self.polished(states, &vec![0.0; self.near.linear.len()], limit))
    }

    fn clarabel(&mut self) -> Result<Option<ActiveSetPoint>, QpError> {
        let point = interior_point::solve_boxed(&self.near, &[], self.settings)?;
        self.counts.whole_calls = 1;
        self.counts.interior_points += point.iterations;
        let found = self.polished(point.states.clone(), &point.x, self.settings.max_iterations);
        self.point = Some(point);
        Ok(found)
    }

    fn polished(&mut self, states: Vec<BoundState>, from: &[f64], limit: usize) -> Option<ActiveSetPoint> {
        let (found, sets) = self.system.active_set(states, from, limit);
        self.counts.polish_sets += sets;
        found
    }

    fn descent(&mut self) -> Option<ActiveSetPoint> {
        let point = self.point.as_ref().filter(|_| self.is_small())?;
        let all = self.near.states_at_rest();
        // The second one passes all bounds on its way. The third one begins where the rows hold, so that they hold on all its sets: Clarabel's
        // point may be far from there if gaps are much larger than what the loads move.
        let starts = [(Some(&point.x), &point.states), (Some(&point.x), &all), (None, &all)];
        for (from, states) in starts {
            let limit = MOST_DESCENTS + 4 * states.len();
            let feasible = if from.is_none() { self.system.feasible(&point.x) } else { None };
            let from = from.or(feasible.as_ref())?;
            let (found, steps) = self.system.descend(from, states.clone(), limit);
            self.counts.descent_steps += steps;
            if found.is_some() {
                return found;
            }
        }
        None
    }

    fn multipliers(&mut self) -> Option<ActiveSetPoint> {
        let point = self.point.as_ref().filter(|_| self.is_small())?;
        self.counts.fitted = 1;
        self.system.with_fitting_multipliers(&point.states, &point.x)
    }

    fn is_small(&self) -> bool {
        !self.system.is_sparse() || self.near.linear.len() <= MOST_DESCENDED
    }

    fn answer(&self, qp: &BoxQp<'_>, candidate: ActiveSetPoint) -> BoxSolution {
        let (path, iterations) = self.counts.path();
        BoxSolution { path, iterations, counts: self.counts, ..candidate.into_solution(qp) }
    }

    /// Returns what Clarabel has found, and how it ended.
    fn unsolved(&mut self, qp: &BoxQp<'_>) -> Result<BoxSolution, QpError> {
        self.system.check_semi_definite()?;
        let n = qp.linear.len();
        let point = self.point.take();
        let status = match point.as_ref().map(|point| point.status) {
            Some(QpStatus::Solved) | None => QpStatus::PolishFailed,
            Some(other) => other,
        };
        let candidate = match point {
            Some(point) => ActiveSetPoint { x: point.x, a: point.row_multipliers, states: point.states },
            None => ActiveSetPoint {
                x: vec![0.0; n],
                a: vec![0.0; qp.right_side.len()],
                states: qp.states_at_rest(),
            },
        };
        Ok(BoxSolution { status, ..self.answer(qp, candidate) })
    }
}

/// Answers a programme without unknowns, which Clarabel does not take: its rows hold if their right sides are zero.
fn without_unknowns(qp: &BoxQp<'_>, settings: &QpSettings) -> BoxSolution {
    let empty = ActiveSetPoint { x: Vec::new(), a: vec![0.0; qp.right_side.len()], states: Vec::new() };
    let answer = empty.into_solution(qp);
    let holds = answer.kkt.max() <= settings.kkt_tolerance;
    BoxSolution { status: if holds { QpStatus::Solved } else { QpStatus::Infeasible }, ..answer }
}

/// Solves a programme by active sets from a given one; without the ways that take long if there are many unknowns.
///
/// * `shrunk`: Clarabel with few of the bounds may find another set.
///
/// # Errors
/// Those of [`solve_box`].
pub(crate) fn solve_by_sets(
    qp: &BoxQp<'_>,
    start: &[BoundState],
    shrunk: bool,
    settings: &QpSettings,
) -> Result<BoxSolution, QpError> {
    let ways = [Way::ActiveSets, Way::Shrunk];
    solve_by(if shrunk { &ways } else { &ways[..1] }, qp, Some(start), settings)
}

/// Solves a programme by active sets alone; `None` if they come back.
///
/// * `start`: the first set.
///
/// # Errors
/// Those of [`BoxQp::check`].
pub(crate) fn solve_on_sets(qp: &BoxQp<'_>, start: Vec<BoundState>) -> Result<Option<Vec<f64>>, QpError> {
    qp.check()?;
    let origin = vec![0.0; qp.linear.len()];
    let (found, _) = System::new(qp, qp).active_set(start, &origin, QpSettings::default().max_iterations);
    Ok(found.map(|candidate| candidate.into_solution(qp).x))
}

impl ActiveSetPoint {
    /// Makes bounds and signs exact, provided that the errors are round-off.
    pub(crate) fn into_solution(self, qp: &BoxQp<'_>) -> BoxSolution {
        let Self { mut x, a, mut states } = self;
        for i in 0..x.len() {
            if states[i] == BoundState::Free && x[i] <= qp.lower[i] {
                states[i] = BoundState::Lower;
            } else if states[i] == BoundState::Free && x[i] >= qp.upper[i] {
                states[i] = BoundState::Upper;
            }
            if states[i] != BoundState::Free {
                x[i] = qp.bound(i, states[i]);
            }
        }
        debug_assert!(x.iter().zip(qp.lower.iter().zip(qp.upper)).all(|(x, (l, u))| (l..=u).contains(&x)));
        let mut multipliers = qp.gradient(&x, &a);
        for (i, (y, place)) in multipliers.iter_mut().zip(&mut states).enumerate() {
            if qp.lower[i] == qp.upper[i] {
                *place = if *y < 0.0 { BoundState::Upper } else { BoundState::Lower };
            }
            *y = match place {
                BoundState::Lower if *y > 0.0 => *y,
                BoundState::Upper if *y < 0.0 => *y,
                _ => 0.0,
            };
        }
        let kkt = kkt_residuals(qp, &x, &multipliers, &a);
        BoxSolution {
            x,
            multipliers,
            row_multipliers: a,
            states,
            status: QpStatus::Solved,
            path: QpPath::ActiveSet,
            iterations: 0,
            counts: QpCounts::default(),
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
        let mut random = crate::random::random(7);
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
