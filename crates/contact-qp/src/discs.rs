//! Programmes in which pairs of unknowns are in discs, such as friction along two tangents.
//!
//! ```math
//! min_x ½ xᵀ P x + qᵀ x   subject to   l ≤ x ≤ u,   G x = e,   x_i² + x_j² ≤ r²
//! ```
//! With `y = P x + q − Gᵀ a` and any `c > 0` the pair solves its part if `x` is the point of the disc that is nearest to `d = x − c y`. Each step of the
//! semi-smooth Newton method for these equations is a programme with bounds, in axes along and across `d`: `x_along ≤ r`, and the stiffness across grows by
//! ```math
//! κ = (|d| − r)/(c r) if |d| > r,   0 if not
//! ```
//! the curvature of the circle times the multiplier. The first `d` comes from a similar programme, from the same one without discs or with squares in their
//! place, or from Clarabel with second-order cones.

use crate::bound_state::BoundState;
use crate::box_qp::{ActiveSetPoint, solve_box, solve_by_sets};
use crate::disc::{Disc, Frame, check_discs, parts, places, rotated_rows, within};
use crate::error::QpError;
use crate::interior_point;
use crate::problem::{MatrixView, check_length};
use crate::programme::BoxQp;
use crate::settings::{QpMethod, QpSettings};
use crate::solution::{BoxSolution, QpCounts, QpPath, QpStatus};
use crate::sparse::SparseRows;
use crate::symmetric_matrix::SymmetricMatrix;

/// Steps of Newton's method, at most, from one start.
const MOST_STEPS: usize = 30;

/// A solution with residuals above this fraction of the tolerance gets one step more.
const EXACT: f64 = 1e-2;

/// Clarabel's tolerance: Newton's method needs a start near the solution.
const TOLERANCE: f64 = 1e-9;

/// Where a programme with discs starts: the solution of a similar one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiscStart {
    /// The place of each unknown; of those in discs it does not count.
    pub states: Vec<BoundState>,
    /// `x`.
    pub x: Vec<f64>,
    /// `y`.
    pub multipliers: Vec<f64>,
}

/// Solves `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`, with some pairs of unknowns in discs.
///
/// In the solution `x` is within its bounds and discs, and multipliers have the right signs and, on circles, the right directions: both exactly, but for
/// the rounding of a length. Both unknowns of a disc are [`BoundState::Upper`] on the circle, and [`BoundState::Free`] inside.
///
/// * `start`: of a similar programme. Without it [`QpMethod::ActiveSet`] begins with the programme without discs, and then with squares around them.
///   Clarabel is called otherwise, and if these lead nowhere.
///
/// # Errors
/// See [`solve_box`]; a disc whose unknowns do not exist, are equal or in another disc, or whose radius is negative or not finite. No convergence is a
/// [`QpStatus`].
pub fn solve_discs(
    qp: &BoxQp<'_>,
    discs: &[Disc],
    start: Option<&DiscStart>,
    settings: &QpSettings,
) -> Result<BoxSolution, QpError> {
    if discs.is_empty() {
        return solve_box(qp, start.map(|start| start.states.as_slice()), settings);
    }
    settings.check()?;
    qp.check()?;
    let n = qp.linear.len();
    check_discs(discs, n)?;
    let search = Search { qp, discs, settings, mean: mean_diagonal(qp, discs) };
    let mut counts = QpCounts::default();
    let mut first = Vec::new();
    match start {
        _ if settings.method == QpMethod::Clarabel => {}
        Some(DiscStart { states, x, multipliers }) => {
            for found in [states.len(), x.len(), multipliers.len()] {
                check_length("start", n, found)?;
            }
            first.push(First::Given(states, search.frames(x, multipliers)));
        }
        None if settings.method == QpMethod::ActiveSet => first.extend([First::Without, First::Squares]),
        None => {}
    }
    for first in first {
        let Some((states, frames)) = search.first(first, &mut counts)? else { continue };
        let found = search.newton(&states, &frames, true, &mut counts)?;
        if let Some(found) = found.filter(|found| found.status.is_solved()) {
            let (path, iterations) = counts.path();
            return Ok(BoxSolution { path, iterations, counts, ..found });
        }
    }
    let tolerance = settings.tolerance.min(TOLERANCE);
    let point = interior_point::solve_boxed(qp, discs, &settings.clone().with_tolerance(tolerance))?;
    counts.whole_calls += 1;
    counts.interior_points += point.iterations;
    let gradient = qp.gradient(&point.x, &point.row_multipliers);
    let frames = search.frames(&point.x, &gradient);
    let last = match point.status {
        QpStatus::Infeasible => None,
        _ => search.newton(&point.states, &frames, false, &mut counts)?,
    };
    let status = match (&last, point.status) {
        (Some(found), _) if found.status.is_solved() => QpStatus::Solved,
        (_, QpStatus::Solved) => QpStatus::PolishFailed,
        (_, other) => other,
    };
    let found = last.unwrap_or_else(|| {
        let rotated = Rotated::new(qp, &frames);
        search.answer((&frames, &rotated), &point.x, &point.row_multipliers, &point.states)
    });
    Ok(BoxSolution { status, path: QpPath::Clarabel, iterations: point.iterations, counts, ..found })
}

/// The mean of the positive diagonal entries of the unknowns in discs; 1 without any.
fn mean_diagonal(qp: &BoxQp<'_>, discs: &[Disc]) -> f64 {
    let entries = discs.iter().flat_map(|disc| disc.unknowns).map(|i| qp.matrix.diagonal(i));
    let (sum, count) =
        entries.filter(|d| *d > 0.0).fold((0.0, 0usize), |(sum, count), d| (sum + d, count + 1));
    if count > 0 { sum / count as f64 } else { 1.0 }
}

/// The data of a programme in the axes of the discs.
struct Rotated {
    matrix: SymmetricMatrix,
    linear: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    rows: SparseRows,
}

/// Takes a matrix to the axes of the discs.
fn rotated_matrix(matrix: &MatrixView<'_>, frames: &[Frame]) -> SymmetricMatrix {
    match *matrix {
        MatrixView::Dense { n, values } => {
            let mut values = values.to_vec();
            // Rows, column by column, and then columns.
            values.chunks_exact_mut(n).for_each(|column| frames.iter().for_each(|frame| frame.enter(column)));
            for Frame { unknowns: [i, j], along: [a, b], .. } in frames {
                for k in 0..n {
                    let (u, v) = (values[i * n + k], values[j * n + k]);
                    (values[i * n + k], values[j * n + k]) = (a * u + b * v, a * v - b * u);
                }
            }
            SymmetricMatrix::Full { n, values }
        }
        MatrixView::SparseUpper { n, .. } => {
            let (places, mut entries) = (places(n, frames), Vec::new());
            matrix.for_each_upper(|i, j, value| {
                for (row, column) in [(i, j), (j, i)].into_iter().take(if i == j { 1 } else { 2 }) {
                    for (p, of_row) in parts(&places, frames, row) {
                        let upper = parts(&places, frames, column).filter(|(q, _)| p <= *q);
                        entries.extend(upper.map(|(q, of_column)| (p, q, of_row * value * of_column)));
                    }
                }
            });
            SymmetricMatrix::sparse(n, entries)
        }
    }
}

impl Rotated {
    fn new(qp: &BoxQp<'_>, frames: &[Frame]) -> Self {
        let (mut lower, mut upper) = (qp.lower.to_vec(), qp.upper.to_vec());
        let mut linear = qp.linear.to_vec();
        for frame in frames {
            frame.enter(&mut linear);
            frame.bound(&mut lower, &mut upper);
        }
        let (matrix, rows) = (rotated_matrix(&qp.matrix, frames), rotated_rows(qp.rows, frames));
        Self { matrix, linear, lower, upper, rows }
    }

    fn programme<'a>(&'a self, qp: &BoxQp<'a>) -> BoxQp<'a> {
        BoxQp {
            matrix: self.matrix.view(),
            linear: &self.linear,
            lower: &self.lower,
            upper: &self.upper,
            rows: &self.rows,
            right_side: qp.right_side,
        }
    }
}

/// Where Newton's steps begin.
enum First<'a> {
    /// At a given point.
    Given(&'a [BoundState], Vec<Frame>),
    /// At the solution without discs.
    Without,
    /// At the solution with squares around the discs in their place.
    Squares,
}

/// A set, and the axes of the discs.
type Begun = (Vec<BoundState>, Vec<Frame>);

/// A programme with discs.
struct Search<'a> {
    qp: &'a BoxQp<'a>,
    discs: &'a [Disc],
    settings: &'a QpSettings,
    /// See [`mean_diagonal`].
    mean: f64,
}

impl Search<'_> {
    /// Returns the axes at a point.
    fn frames(&self, x: &[f64], y: &[f64]) -> Vec<Frame> {
        let of_disc = |disc: &Disc| {
            let own = 0.5 * disc.unknowns.iter().map(|i| self.qp.matrix.diagonal(*i)).sum::<f64>();
            let c = 1.0 / if own > f64::EPSILON * self.mean { own } else { self.mean };
            Frame::new(disc, disc.unknowns.map(|i| x[i] - c * y[i]), c)
        };
        self.discs.iter().map(of_disc).collect()
    }

    /// Returns the set and the axes with which Newton's steps begin; `None` if active sets do not find them.
    fn first(&self, first: First<'_>, counts: &mut QpCounts) -> Result<Option<Begun>, QpError> {
        let squares = match first {
            First::Given(states, frames) => return Ok(Some((states.to_vec(), frames))),
            First::Without => false,
            First::Squares => true,
        };
        let (mut lower, mut upper) = (self.qp.lower.to_vec(), self.qp.upper.to_vec());
        for Disc { unknowns, radius } in self.discs {
            let most = if squares || *radius == 0.0 { *radius } else { f64::INFINITY };
            unknowns.iter().for_each(|i| (lower[*i], upper[*i]) = (0.0 - most, most));
        }
        let qp = BoxQp { lower: &lower, upper: &upper, ..*self.qp };
        let found = solve_by_sets(&qp, &qp.states_at_rest(), squares, self.settings)?;
        counts.add(found.counts);
        let gradient = self.qp.gradient(&found.x, &found.row_multipliers);
        let frames = self.frames(&found.x, &gradient);
        Ok(found.status.is_solved().then_some((found.states, frames)))
    }

    /// Follows Newton's steps; the last answer, solved or not. `None` if a step has none.
    ///
    /// * `by_sets`: no step may call Clarabel.
    fn newton(
        &self,
        states: &[BoundState],
        frames: &[Frame],
        by_sets: bool,
        counts: &mut QpCounts,
    ) -> Result<Option<BoxSolution>, QpError> {
        let (mut states, mut frames) = (states.to_vec(), frames.to_vec());
        let settings = self.settings.clone().active_sets_first();
        let mut rotated = Rotated::new(self.qp, &frames);
        let mut last: Option<BoxSolution> = None;
        for _ in 0..MOST_STEPS {
            for frame in &frames {
                frame.place(&mut states);
                rotated.matrix.add_to_diagonal(frame.across(), frame.curvature);
            }
            let programme = rotated.programme(self.qp);
            let step = match by_sets {
                true => solve_by_sets(&programme, &states, false, &settings)?,
                false => solve_box(&programme, Some(&states), &settings)?,
            };
            counts.add(step.counts);
            if !step.status.is_solved() {
                return Ok(last);
            }
            let mut x = step.x;
            frames.iter().for_each(|frame| frame.leave(&mut x));
            let gradient = self.qp.gradient(&x, &step.row_multipliers);
            states = step.states;
            frames = self.frames(&x, &gradient);
            rotated = Rotated::new(self.qp, &frames);
            let answer = self.answer((&frames, &rotated), &x, &step.row_multipliers, &states);
            match last.take_if(|before| before.status.is_solved()) {
                // A step more than the tolerance asks for.
                Some(before) if before.kkt.max() <= answer.kkt.max() => return Ok(Some(before)),
                Some(_) => return Ok(Some(answer)),
                None if answer.kkt.max() <= EXACT * self.settings.kkt_tolerance => return Ok(Some(answer)),
                None => last = Some(answer),
            }
        }
        Ok(last)
    }

    /// Moves a point into its discs, and measures it in the axes there.
    fn answer(
        &self,
        (frames, rotated): (&[Frame], &Rotated),
        x: &[f64],
        a: &[f64],
        states: &[BoundState],
    ) -> BoxSolution {
        let (mut x, mut states) = (x.to_vec(), states.to_vec());
        for frame in frames {
            frame.enter(&mut x);
            frame.place(&mut states);
            let [i, j] = frame.unknowns;
            let inside = if frame.is_on_circle() { [frame.radius, 0.0] } else { [x[i], x[j]] };
            [x[i], x[j]] = within(inside, frame.radius);
        }
        let point = ActiveSetPoint { x, a: a.to_vec(), states };
        let mut answer = point.into_solution(&rotated.programme(self.qp));
        if !(answer.kkt.max() <= self.settings.kkt_tolerance) {
            answer.status = QpStatus::PolishFailed;
        }
        for frame in frames {
            frame.leave(&mut answer.x);
            frame.leave(&mut answer.multipliers);
            let [i, j] = frame.unknowns;
            answer.states[j] = answer.states[i];
        }
        answer
    }
}
