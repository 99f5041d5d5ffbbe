//! Numbers within bounds and in balance that are nearest to given ones.

use crate::box_qp::{BoxQp, solve_box};
use crate::dense::{SemiDefinite, dot, norm};
use crate::error::QpError;
use crate::interior_point::{self, Boxed};
use crate::least_squares::bounded_least_squares;
use crate::problem::{MatrixView, check_length, check_values};
use crate::settings::QpSettings;
use crate::solution::QpStatus;

/// Eigenvalues below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-12;

/// The rows are in balance if they hold to this fraction of their terms.
const BALANCED: f64 = 1e-13;

/// A load of which more than this fraction is left is out of balance.
const FAR: f64 = 1e-9;

/// Maximum number of Newton steps of [`nearest_balanced`].
const MOST_STEPS: usize = 200;

/// The numbers in balance and within bounds that are nearest to given ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Balanced {
    /// `l ≤ p ≤ u`, with `C p = e`.
    pub values: Vec<f64>,
    /// The multipliers of the rows.
    pub row_multipliers: Vec<f64>,
    /// Newton steps, or active sets tried.
    pub steps: usize,
}

/// Finds `min Σ w_i (p_i − t_i)²` subject to `l ≤ p ≤ u`, `C p = e`; `None` if no `p` within the bounds is in balance.
///
/// The solution is `p = min(u, max(l, x))` with `x = t + W⁻¹ Cᵀ a`; `a` minimises the convex `½ Σ w p (2x − p) − a·e`, by a semi-smooth
/// Newton method with a line search, or from Clarabel's multipliers.
///
/// * `target`: t, n entries; `weights`: w > 0, n entries.
/// * `bounds`: l and u, n entries each; they may be infinite.
/// * `rows`: C, row after row, m·n entries; `right_side`: e, m entries, few.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`], and data that Clarabel rejects.
pub fn nearest_balanced(
    target: &[f64],
    weights: &[f64],
    bounds: [&[f64]; 2],
    rows: &[f64],
    right_side: &[f64],
) -> Result<Option<Balanced>, QpError> {
    let (n, m) = (target.len(), right_side.len());
    check_values("target", n, target)?;
    check_values("weights", n, weights)?;
    check_values("rows", n * m, rows)?;
    check_values("right_side", m, right_side)?;
    let [lower, upper] = bounds;
    check_length("lower", n, lower.len())?;
    check_length("upper", n, upper.len())?;
    if let Some(place) = (0..n).find(|i| !(lower[*i] <= upper[*i])) {
        return Err(QpError::Bounds { place, lower: lower[place], upper: upper[place] });
    }
    let problem = Projection { target, weights, lower, upper, rows, right_side };
    if let Some(found) = problem.newton(vec![0.0; m]) {
        return Ok(Some(found));
    }
    let multipliers = problem.clarabel()?;
    match multipliers.and_then(|a| problem.newton(a)) {
        Some(found) => Ok(Some(found)),
        None if problem.is_out_of_balance()? => Ok(None),
        None => problem.on_its_active_set(),
    }
}

struct Projection<'a> {
    target: &'a [f64],
    weights: &'a [f64],
    rows: &'a [f64],
    right_side: &'a [f64],
    lower: &'a [f64],
    upper: &'a [f64],
}

impl Projection<'_> {
    fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.target.len()..(k + 1) * self.target.len()]
    }

    /// `x = t + W⁻¹ Cᵀ a`.
    fn unbounded(&self, a: &[f64]) -> Vec<f64> {
        let mut shift = vec![0.0; self.target.len()];
        for (k, a) in a.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            shift.iter_mut().zip(self.row(k)).for_each(|(s, c)| *s += c * a);
        }
        (0..self.target.len()).map(|i| self.target[i] + shift[i] / self.weights[i]).collect()
    }

    /// `min(u, max(l, x))`.
    fn values(&self, a: &[f64]) -> Vec<f64> {
        let within = |(i, x): (usize, f64)| x.max(self.lower[i]).min(self.upper[i]);
        self.unbounded(a).into_iter().enumerate().map(within).collect()
    }

    /// `C p − e`, and the sizes of its terms.
    fn defect(&self, p: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let of_row = |k: usize| {
            let terms = || self.row(k).iter().zip(p).map(|(c, p)| c * p);
            let e = self.right_side[k];
            (terms().sum::<f64>() - e, terms().map(f64::abs).sum::<f64>() + e.abs())
        };
        (0..self.right_side.len()).map(of_row).unzip()
    }

    /// Tells whether no `p` within the bounds is in balance, by far. If a lower bound is infinite it is not asked.
    fn is_out_of_balance(&self) -> Result<bool, QpError> {
        if self.lower.iter().any(|l| l.is_infinite()) {
            return Ok(false);
        }
        let (_, left) = bounded_least_squares(self.rows, self.right_side, [self.lower, self.upper])?;
        Ok(norm(&left) > FAR * norm(self.right_side))
    }

    /// `½ Σ w p (2x − p) − a·e`.
    fn dual(&self, p: &[f64], a: &[f64]) -> f64 {
        let terms = self.weights.iter().zip(p).zip(self.unbounded(a));
        0.5 * terms.map(|((w, p), x)| w * p * (2.0 * x - p)).sum::<f64>() - dot(a, self.right_side)
    }

    fn newton(&self, mut a: Vec<f64>) -> Option<Balanced> {
        let mut p = self.values(&a);
        for steps in 0..MOST_STEPS {
            let (defect, sizes) = self.defect(&p);
            let within = |(d, size): (&f64, &f64)| d.abs() <= BALANCED * size;
            let balanced = defect.iter().zip(&sizes).all(within);
            let step = self.step(&p, &defect)?;
            if balanced {
                // One more step leaves the rounding of the sums alone.
                let better: Vec<f64> = a.iter().zip(&step).map(|(a, s)| a - s).collect();
                let values = self.values(&better);
                let (a, p) =
                    if norm(&self.defect(&values).0) < norm(&defect) { (better, values) } else { (a, p) };
                return Some(Balanced { values: p, row_multipliers: a, steps });
            }
            let slope = -dot(&defect, &step);
            let before = self.dual(&p, &a);
            let mut length = 1.0;
            let (next, values) = loop {
                let trial: Vec<f64> = a.iter().zip(&step).map(|(a, s)| a - length * s).collect();
                let values = self.values(&trial);
                let change = self.dual(&values, &trial) - before;
                // Near the solution the change is round-off.
                if change <= 1e-4 * length * slope || change.abs() <= 1e-14 * before.abs() {
                    break (trial, values);
                }
                length *= 0.5;
                if length < 1e-12 {
                    return None;
                }
            };
            if values == p && next == a {
                return None;
            }
            (a, p) = (next, values);
        }
        None
    }

    /// The Newton step of the multipliers, on the values between their bounds.
    fn step(&self, p: &[f64], defect: &[f64]) -> Option<Vec<f64>> {
        let between = |i: &usize| p[*i] > self.lower[*i] && p[*i] < self.upper[*i];
        let free: Vec<usize> = (0..p.len()).filter(between).collect();
        let m = defect.len();
        // C_F W_F^{-1/2}, column by column, and its product with its transpose.
        let column = |&k: &usize| {
            let root = self.weights[k].sqrt();
            (0..m).map(move |i| self.row(i)[k] / root)
        };
        let columns: Vec<f64> = free.iter().flat_map(column).collect();
        let mut square = vec![0.0; m * m];
        dense_cholesky::add_square(1.0, (&columns, m), [m, free.len()], 0.0, (&mut square, m), m);
        let entry = |i: usize, j: usize| square[j * m + i];
        Some(SemiDefinite::new(defect.len(), entry, DEPENDENT)?.solve(defect).0)
    }

    /// Solves it as a programme with bounds: if the solution is nearly a vertex, the multipliers grow, and the steps of Newton's method
    /// are lost in rounding.
    fn on_its_active_set(&self) -> Result<Option<Balanced>, QpError> {
        let n = self.target.len();
        let mut matrix = vec![0.0; n * n];
        (0..n).for_each(|i| matrix[i * n + i] = self.weights[i]);
        let linear: Vec<f64> = self.target.iter().zip(self.weights).map(|(t, w)| -w * t).collect();
        let &Self { lower, upper, rows, right_side, .. } = self;
        let qp = BoxQp { matrix: &matrix, linear: &linear, lower, upper, rows, right_side };
        let found = solve_box(&qp, None, &QpSettings::default())?;
        let balanced =
            Balanced { values: found.x, row_multipliers: found.row_multipliers, steps: found.iterations };
        Ok(found.status.is_solved().then_some(balanced))
    }

    /// The multipliers of the rows by Clarabel; `None` if it finds that nothing is in balance.
    fn clarabel(&self) -> Result<Option<Vec<f64>>, QpError> {
        let n = self.target.len();
        let (starts, places): (Vec<usize>, Vec<usize>) = ((0..=n).collect(), (0..n).collect());
        let matrix =
            MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: self.weights };
        let linear: Vec<f64> = self.target.iter().zip(self.weights).map(|(t, w)| -w * t).collect();
        let boxed = Boxed {
            matrix,
            linear: &linear,
            lower: self.lower,
            upper: self.upper,
            rows: self.rows,
            right_side: self.right_side,
        };
        let found = interior_point::solve_boxed(&boxed, &QpSettings::default().with_tolerance(1e-9))?;
        Ok((found.status != QpStatus::Infeasible).then_some(found.row_multipliers))
    }
}
