//! Programmes with bounds on both sides and equality rows: an active set with a small system for the rows, and Clarabel
//! behind it.
//!
//! ```math
//! \min_x \; ½ x^T P x + q^T x \qquad \text{subject to} \quad l ≤ x ≤ u, \quad G x = e
//! ```
//! `P` may be singular as long as `P + c GᵀG` is positive definite on the unknowns that are not at a bound, and rows may
//! depend on each other. On a given set of unknowns at their bounds the rest `F` and the multipliers `a` solve
//! ```math
//! \begin{bmatrix} P_{FF} + c\,G_F^T G_F & -G_F^T \\ G_F & 0 \end{bmatrix} \begin{bmatrix} x_F \\ a \end{bmatrix}
//! = \begin{bmatrix} -q_F - P_{FB} x_B + c\,G_F^T (e - G_B x_B) \\ e - G_B x_B \end{bmatrix}
//! ```
//! by a Cholesky factor of the first block and the eigenvalues of the Schur complement, whose zeros are the dependent rows.
//! The multipliers are then the ones of least norm.

use crate::cholesky::Factor;
use crate::error::QpError;
use crate::interior_point::{self, Boxed};
use crate::place::Place;
use crate::problem::MatrixView;
use crate::settings::{QpMethod, QpSettings};
use crate::solution::{QpPath, QpStatus};
use faer::{Mat, Side};
use std::collections::HashSet;

/// A sign or a bound is wrong beyond this fraction of the scale of the data.
const WRONG: f64 = 1e-12;

/// Eigenvalues of the rows' Schur complement below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-10;

/// Dependent rows contradict each other beyond this fraction of the right-hand side.
const CONTRADICTION: f64 = 1e-9;

/// Corrections of a solution on one set.
const REFINEMENTS: usize = 2;

/// The borrowed data of `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`.
#[derive(Clone, Copy, Debug)]
pub struct BoxQp<'a> {
    /// `P`, symmetric, positive semi-definite, n² entries, both triangles.
    pub matrix: &'a [f64],
    /// `q`, n entries.
    pub linear: &'a [f64],
    /// `l`, n entries; −∞ for none.
    pub lower: &'a [f64],
    /// `u ≥ l`, n entries; ∞ for none.
    pub upper: &'a [f64],
    /// `G`, row after row, m·n entries.
    pub rows: &'a [f64],
    /// `e`, m entries.
    pub right_side: &'a [f64],
}

/// The solution of a [`BoxQp`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BoxSolution {
    /// `x`, within its bounds exactly.
    pub x: Vec<f64>,
    /// `y = P x + q − Gᵀ a`: ≥ 0 at lower bounds, ≤ 0 at upper bounds, exactly 0 between them.
    pub multipliers: Vec<f64>,
    /// `a`, of least norm where rows depend on each other.
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

/// Residuals of the KKT conditions, each over the scale of its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxResiduals {
    /// `max |P x + q − Gᵀ a − y|` over the largest of its terms.
    pub stationarity: f64,
    /// `max |G x − e|` of a row over the sum of its terms' sizes.
    pub rows: f64,
    /// The part of `x` outside its bounds, over the largest `|x|`.
    pub primal: f64,
    /// The part of `y` with the wrong sign, over the scale of the stationarity.
    pub dual: f64,
    /// `max |y (x − bound)|` over the product of both scales.
    pub complementarity: f64,
}

impl BoxResiduals {
    /// Returns the largest of them.
    #[must_use]
    pub fn max(&self) -> f64 {
        [self.stationarity, self.rows, self.primal, self.dual, self.complementarity]
            .into_iter()
            .fold(0.0, |most, r| if r > most || r.is_nan() { r } else { most })
    }
}

impl BoxQp<'_> {
    /// Checks lengths, finite numbers, and the order of the bounds.
    ///
    /// # Errors
    /// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`].
    pub fn check(&self) -> Result<(), QpError> {
        let (n, m) = (self.linear.len(), self.right_side.len());
        let lengths = [
            ("matrix", n.saturating_mul(n), self.matrix.len()),
            ("lower", n, self.lower.len()),
            ("upper", n, self.upper.len()),
            ("rows", n.saturating_mul(m), self.rows.len()),
        ];
        if let Some(&(what, expected, found)) = lengths.iter().find(|(_, expected, found)| expected != found)
        {
            return Err(QpError::Length { what, expected, found });
        }
        let finite = [
            ("matrix", self.matrix),
            ("linear", self.linear),
            ("rows", self.rows),
            ("right_side", self.right_side),
        ];
        for (what, values) in finite {
            if let Some(place) = values.iter().position(|v| !v.is_finite()) {
                return Err(QpError::NotFinite { what, place, found: values[place] });
            }
        }
        let bounds = self.lower.iter().zip(self.upper);
        let wrong = |(l, u): (&f64, &f64)| !(l <= u && *l < f64::INFINITY && *u > f64::NEG_INFINITY);
        match bounds.clone().position(wrong) {
            Some(place) => Err(QpError::Bounds { place, lower: self.lower[place], upper: self.upper[place] }),
            None => Ok(()),
        }
    }

    /// Computes `P x + q − Gᵀ a`.
    fn gradient(&self, x: &[f64], a: &[f64]) -> Vec<f64> {
        let n = x.len();
        let mut gradient = self.linear.to_vec();
        MatrixView::Dense { n, values: self.matrix }.add_product(x, &mut gradient);
        for (row, a) in self.rows.chunks_exact(n.max(1)).zip(a) {
            gradient.iter_mut().zip(row).for_each(|(g, entry)| *g -= entry * a);
        }
        gradient
    }

    /// Computes `e − G x`.
    fn defect(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.rows.chunks_exact(x.len().max(1)).zip(self.right_side);
        rows.map(|(row, e)| e - row.iter().zip(x).map(|(g, x)| g * x).sum::<f64>()).collect()
    }

    fn bound(&self, i: usize, place: Place) -> f64 {
        match place {
            Place::Lower => self.lower[i],
            Place::Upper => self.upper[i],
            Place::Free => 0.0,
        }
    }
}

/// Solves `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`, exactly on its active set.
///
/// * `start`: where the unknowns are at the start; `None`: all between their bounds.
///
/// An active set that comes back, or on which the rows cannot hold, calls Clarabel, whose solution is polished.
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
    let system = System::new(qp);
    if settings.method != QpMethod::Clarabel {
        let start = start.map_or_else(|| vec![Place::Free; n], <[Place]>::to_vec);
        let (found, steps) = system.active_set(start, settings.step_limit());
        if let Some(candidate) = found {
            let path = if steps == 1 { QpPath::WarmStart } else { QpPath::ActiveSet };
            let answer = candidate.into_solution(qp, path, steps);
            if answer.kkt.max() <= settings.kkt_tolerance {
                return Ok(answer);
            }
        }
    }
    let boxed = Boxed {
        matrix: MatrixView::Dense { n, values: qp.matrix },
        linear: qp.linear,
        lower: qp.lower,
        upper: qp.upper,
        rows: qp.rows,
        right_side: qp.right_side,
    };
    let guess = interior_point::solve_boxed(&boxed, settings)?;
    let clarabel = |mut answer: BoxSolution| {
        (answer.path, answer.iterations, answer.clarabel_calls) = (QpPath::Clarabel, guess.iterations, 1);
        answer
    };
    let (found, steps) = system.active_set(guess.places.clone(), settings.max_iterations);
    if let Some(candidate) = found {
        let answer = candidate.into_solution(qp, QpPath::Clarabel, steps);
        if answer.kkt.max() <= settings.kkt_tolerance {
            return Ok(clarabel(answer));
        }
    }
    let candidate = Candidate { x: guess.x, a: guess.row_multipliers, places: guess.places };
    let mut answer = clarabel(candidate.into_solution(qp, QpPath::Clarabel, guess.iterations));
    answer.status = match guess.status {
        QpStatus::Solved => QpStatus::PolishFailed,
        other => other,
    };
    Ok(answer)
}

/// A programme with what all active sets share.
struct System<'a> {
    qp: &'a BoxQp<'a>,
    /// `P + c GᵀG` with rows of length one.
    matrix: Vec<f64>,
    /// `G` with rows of length one, and the lengths.
    rows: Vec<f64>,
    lengths: Vec<f64>,
    weight: f64,
    /// The sizes of `x` and `y` that the data have.
    size: [f64; 2],
}

/// The minimiser on one set, whatever the signs.
struct Candidate {
    x: Vec<f64>,
    a: Vec<f64>,
    places: Vec<Place>,
}

impl<'a> System<'a> {
    fn new(qp: &'a BoxQp<'a>) -> Self {
        let n = qp.linear.len();
        let length = |row: &[f64]| row.iter().map(|g| g * g).sum::<f64>().sqrt();
        // A row of zeros stays one.
        let lengths: Vec<f64> = qp
            .rows
            .chunks_exact(n.max(1))
            .map(|row| Some(length(row)).filter(|l| *l > 0.0).unwrap_or(1.0))
            .collect();
        let mut rows = qp.rows.to_vec();
        for (row, length) in rows.chunks_exact_mut(n.max(1)).zip(&lengths) {
            row.iter_mut().for_each(|g| *g /= length);
        }
        let trace: f64 = (0..n).map(|i| qp.matrix[i * n + i]).sum();
        let weight = if trace > 0.0 && !lengths.is_empty() { trace / lengths.len() as f64 } else { 1.0 };
        let mut matrix = qp.matrix.to_vec();
        for row in rows.chunks_exact(n.max(1)) {
            for (j, g) in row.iter().enumerate().filter(|(_, g)| **g != 0.0) {
                let column = &mut matrix[j * n..(j + 1) * n];
                column.iter_mut().zip(row).for_each(|(p, other)| *p += weight * g * other);
            }
        }
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, v| m.max(v.abs()));
        let finite = |v: &f64| if v.is_finite() { *v } else { 0.0 };
        let alone = |i: usize| qp.linear[i] / matrix[i * n + i].max(f64::MIN_POSITIVE);
        let x = largest(&mut (0..n).map(alone))
            .max(largest(&mut qp.right_side.iter().zip(&lengths).map(|(e, length)| e / length)))
            .max(largest(&mut qp.lower.iter().chain(qp.upper).map(finite)));
        let y = largest(&mut qp.linear.iter().copied());
        Self { qp, matrix, rows, lengths, weight, size: [x, y] }
    }

    /// Tries at most `limit` sets. Returns the solution, if it was found, and the number of sets tried.
    fn active_set(&self, mut places: Vec<Place>, limit: usize) -> (Option<Candidate>, usize) {
        let mut visited = HashSet::new();
        for step in 1..=limit {
            let Some(candidate) = self.candidate(&places) else { return (None, step) };
            let next = self.next(&candidate);
            if next == places {
                return (Some(candidate), step);
            }
            if !visited.insert(std::mem::replace(&mut places, next)) {
                return (None, step);
            }
        }
        (None, limit)
    }

    /// Solves on one set; `None` if the rows cannot hold on it, or if it leaves a direction without stiffness.
    fn candidate(&self, places: &[Place]) -> Option<Candidate> {
        let (qp, n, m) = (self.qp, places.len(), self.lengths.len());
        let mut x: Vec<f64> = (0..n).map(|i| qp.bound(i, places[i])).collect();
        if x.iter().any(|x| x.is_infinite()) {
            return None;
        }
        let mut a = vec![0.0; m];
        let free: Vec<usize> = (0..n).filter(|i| places[*i] == Place::Free).collect();
        let factor = match free.len() {
            0 => None,
            _ => Some(Factor::of_block(&MatrixView::Dense { n, values: &self.matrix }, &free).ok()?),
        };
        let row = |k: usize| -> Vec<f64> { free.iter().map(|i| self.rows[k * n + i]).collect() };
        let rows: Vec<Vec<f64>> = (0..m).map(row).collect();
        let solve = |rhs: &mut [f64]| {
            if let Some(factor) = &factor {
                factor.solve(rhs);
            }
        };
        // H⁻¹ G_Fᵀ and G_F H⁻¹ G_Fᵀ.
        let mut solved = rows.clone();
        solved.iter_mut().for_each(|row| solve(row));
        let complement = RowSystem::new(&rows, &solved)?;
        for _ in 0..=REFINEMENTS {
            let scaled: Vec<f64> = a.iter().zip(&self.lengths).map(|(a, length)| a / length).collect();
            let gradient = qp.gradient(&x, &scaled);
            let defect: Vec<f64> =
                qp.defect(&x).iter().zip(&self.lengths).map(|(d, length)| d / length).collect();
            let mut step: Vec<f64> = free.iter().map(|&i| -gradient[i]).collect();
            for (row, d) in rows.iter().zip(&defect) {
                step.iter_mut().zip(row).for_each(|(s, g)| *s += self.weight * g * d);
            }
            solve(&mut step);
            let rest: Vec<f64> = rows.iter().zip(&defect).map(|(row, d)| d - dot(row, &step)).collect();
            let scale = self.size[0].max(largest(&x)).max(largest(&step));
            let change = complement.solve(&rest, scale)?;
            for (solved, change) in solved.iter().zip(&change) {
                step.iter_mut().zip(solved).for_each(|(s, v)| *s += v * change);
            }
            a.iter_mut().zip(&change).for_each(|(a, change)| *a += change);
            free.iter().zip(&step).for_each(|(&i, s)| x[i] += s);
        }
        if !x.iter().chain(&a).all(|v| v.is_finite()) {
            return None;
        }
        a.iter_mut().zip(&self.lengths).for_each(|(a, length)| *a /= length);
        Some(Candidate { x, a, places: places.to_vec() })
    }

    /// Returns the set that the signs of a candidate ask for.
    fn next(&self, candidate: &Candidate) -> Vec<Place> {
        let Candidate { x, a, places } = candidate;
        let y = self.qp.gradient(x, a);
        let least = WRONG * largest(x).max(self.size[0]);
        let slack = WRONG * self.size[1].max(largest(&y));
        let place = |i: usize| match places[i] {
            Place::Free if x[i] < self.qp.lower[i] - least => Place::Lower,
            Place::Free if x[i] > self.qp.upper[i] + least => Place::Upper,
            Place::Lower if y[i] < -slack && self.qp.lower[i] < self.qp.upper[i] => Place::Free,
            Place::Upper if y[i] > slack && self.qp.lower[i] < self.qp.upper[i] => Place::Free,
            same => same,
        };
        (0..x.len()).map(place).collect()
    }
}

/// The Schur complement of the rows, by its eigenvalues.
struct RowSystem {
    vectors: Vec<Vec<f64>>,
    values: Vec<f64>,
}

impl RowSystem {
    fn new(rows: &[Vec<f64>], solved: &[Vec<f64>]) -> Option<Self> {
        let m = rows.len();
        if m == 0 {
            return Some(Self { vectors: Vec::new(), values: Vec::new() });
        }
        let entry = |i: usize, j: usize| 0.5 * (dot(&rows[i], &solved[j]) + dot(&rows[j], &solved[i]));
        let matrix = Mat::from_fn(m, m, entry);
        let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
        let vectors = (0..m).map(|k| (0..m).map(|i| eigen.U()[(i, k)]).collect()).collect();
        let values = (0..m).map(|k| eigen.S().column_vector()[k]).collect();
        Some(Self { vectors, values })
    }

    /// Returns the solution of least norm; `None` if dependent rows contradict each other.
    ///
    /// * `scale`: the size of the unknowns, with which a contradiction is compared.
    fn solve(&self, rhs: &[f64], scale: f64) -> Option<Vec<f64>> {
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let mut solution = vec![0.0; rhs.len()];
        for (vector, value) in self.vectors.iter().zip(&self.values) {
            let part = dot(vector, rhs);
            if *value <= DEPENDENT * largest {
                if part.abs() > CONTRADICTION * scale {
                    return None;
                }
                continue;
            }
            solution.iter_mut().zip(vector).for_each(|(s, v)| *s += v * part / value);
        }
        Some(solution)
    }
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
        let sign = |(y, place): (&f64, &Place)| match place {
            Place::Lower => y.max(0.0),
            Place::Upper => y.min(0.0),
            Place::Free => 0.0,
        };
        let multipliers: Vec<f64> = qp.gradient(&x, &a).iter().zip(&places).map(sign).collect();
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

/// Measures the KKT residuals of any `x`, multipliers `y` of the bounds and `a` of the rows.
///
/// # Panics
/// If a length does not fit the programme.
pub fn box_residuals(
    qp: &BoxQp<'_>,
    x: &[f64],
    multipliers: &[f64],
    row_multipliers: &[f64],
) -> BoxResiduals {
    let n = x.len();
    let gradient = qp.gradient(x, row_multipliers);
    let mut product = vec![0.0; n];
    MatrixView::Dense { n, values: qp.matrix }.add_product(x, &mut product);
    let rows = || qp.rows.chunks_exact(n.max(1));
    let terms = rows().zip(row_multipliers).map(|(row, a)| largest(row) * a.abs());
    let force = largest(qp.linear).max(largest(&product)).max(terms.fold(0.0, f64::max));
    let length = largest(x);
    let over = |value: f64, scale: f64| if value == 0.0 { 0.0 } else { value / scale };
    let mut found = BoxResiduals::default();
    for i in 0..n {
        let y = multipliers[i];
        let below = (qp.lower[i] - x[i]).max(x[i] - qp.upper[i]).max(0.0);
        found.primal = found.primal.max(over(below, length));
        found.stationarity = found.stationarity.max(over((gradient[i] - y).abs(), force));
        let bound = if y > 0.0 { qp.lower[i] } else { qp.upper[i] };
        let distance = if y == 0.0 { 0.0 } else { (x[i] - bound).abs() };
        if distance.is_infinite() {
            found.dual = found.dual.max(over(y.abs(), force));
        } else {
            found.complementarity = found.complementarity.max(over(y.abs() * distance, force * length));
        }
    }
    for ((row, e), defect) in rows().zip(qp.right_side).zip(qp.defect(x)) {
        let size = row.iter().zip(x).map(|(g, x)| (g * x).abs()).sum::<f64>() + e.abs();
        found.rows = found.rows.max(over(defect.abs(), size));
    }
    found
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| if v.abs() > m || v.is_nan() { v.abs() } else { m })
}
