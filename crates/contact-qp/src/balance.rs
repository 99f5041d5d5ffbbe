//! Non-negative numbers in balance: least squares, and the nearest ones to given numbers.

use crate::dense::{SemiDefinite, dot, least_squares, norm};
use crate::error::QpError;
use crate::interior_point::{self, Boxed};
use crate::problem::{MatrixView, check_finite, check_length};
use crate::settings::QpSettings;
use crate::solution::QpStatus;

/// A gradient below this fraction of its terms is zero.
const ROUND_OFF: f64 = 1e-13;

/// Eigenvalues below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-12;

/// The rows are in balance if they hold to this fraction of their terms.
const BALANCED: f64 = 1e-13;

/// Maximum number of Newton steps of [`nearest_balanced`].
const MOST_STEPS: usize = 200;

/// Solves `min |G x − e|` subject to `x ≥ 0` by an active set (Lawson and Hanson 1974, chapter 23), and returns
/// `x` and `e − G x`.
///
/// The residual is the projection of `e` on the cone of all `a` with `Gᵀ a ≤ 0`: zero if and only if some `x ≥ 0` has
/// `G x = e`; otherwise `e·a > 0` (Farkas).
///
/// * `rows`: G, row after row, m·n entries; `right_side`: e, m entries, few.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`].
pub fn nonnegative_least_squares(rows: &[f64], right_side: &[f64]) -> Result<(Vec<f64>, Vec<f64>), QpError> {
    let m = right_side.len();
    let n = rows.len().checked_div(m).unwrap_or(0);
    check("rows", n * m, rows)?;
    check("right_side", m, right_side)?;
    // Columns of length one: their lengths are positive, so that signs do not change.
    let column = |j: usize| (0..m).map(|k| rows[k * n + j]).collect::<Vec<f64>>();
    let lengths: Vec<f64> = (0..n).map(|j| norm(&column(j))).collect();
    let columns: Vec<Vec<f64>> =
        (0..n).map(|j| column(j).iter().map(|g| g / lengths[j].max(f64::MIN_POSITIVE)).collect()).collect();
    let mut x = vec![0.0; n];
    let mut passive: Vec<usize> = Vec::new();
    let mut residual = right_side.to_vec();
    let size = norm(right_side);
    // Every step lowers the residual; the limit is only for round-off.
    for _ in 0..3 * n.max(m) + 10 {
        let gradient = |j: usize| dot(&columns[j], &residual);
        let open = (0..n).filter(|j| lengths[*j] > 0.0 && !passive.contains(j));
        let Some(best) = open.max_by(|i, j| gradient(*i).total_cmp(&gradient(*j))) else { break };
        // As many columns as rows leave nothing but round-off.
        if gradient(best) <= ROUND_OFF * size || passive.len() >= m {
            break;
        }
        passive.push(best);
        loop {
            let used: Vec<&[f64]> = passive.iter().map(|j| columns[*j].as_slice()).collect();
            let trial = least_squares(&used, right_side);
            if passive.last() == Some(&best) && trial.last().is_some_and(|t| *t <= 0.0) {
                // By round-off: the column depends on the others.
                passive.pop();
                return Ok(unscaled(x, &lengths, residual));
            }
            let blocking = passive.iter().zip(&trial).filter(|(_, t)| **t <= 0.0);
            let ratio = |(j, t): (&usize, &f64)| x[*j] / (x[*j] - t);
            let Some(step) = blocking.map(ratio).reduce(f64::min) else {
                x.fill(0.0);
                passive.iter().zip(&trial).for_each(|(j, t)| x[*j] = *t);
                break;
            };
            for (j, t) in passive.iter().zip(&trial) {
                x[*j] += step * (t - x[*j]);
            }
            let least = passive.iter().zip(&trial).filter(|(_, t)| **t <= 0.0).map(|(j, _)| x[*j]);
            let least = least.fold(f64::INFINITY, f64::min).max(0.0);
            let leaves = |j: &usize| x[*j] <= least;
            let gone: Vec<usize> = passive.iter().copied().filter(leaves).collect();
            gone.iter().for_each(|j| x[*j] = 0.0);
            passive.retain(|j| !gone.contains(j));
        }
        residual = right_side.to_vec();
        for &j in &passive {
            residual.iter_mut().zip(&columns[j]).for_each(|(r, g)| *r -= x[j] * g);
        }
    }
    Ok(unscaled(x, &lengths, residual))
}

fn unscaled(mut x: Vec<f64>, lengths: &[f64], residual: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    x.iter_mut().zip(lengths).filter(|(x, _)| **x > 0.0).for_each(|(x, length)| *x /= length);
    (x, residual)
}

/// The non-negative numbers in balance that are nearest to given ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Balanced {
    /// `p ≥ 0`, with `C p = e`.
    pub values: Vec<f64>,
    /// The multipliers of the rows.
    pub row_multipliers: Vec<f64>,
    /// Newton steps.
    pub steps: usize,
}

/// Finds `min Σ w_i (p_i − t_i)²` subject to `p ≥ 0`, `C p = e`; `None` if no `p ≥ 0` is in balance.
///
/// The solution is `p = max(0, t + W⁻¹ Cᵀ a)`; `a` minimises the convex `½ Σ w p² − a·e`, by a semi-smooth Newton method with
/// a line search, or from Clarabel's multipliers.
///
/// * `target`: t, n entries; `weights`: w > 0, n entries.
/// * `rows`: C, row after row, m·n entries; `right_side`: e, m entries, few.
/// * `allowed`: which numbers may be positive; `None`: all.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`], and data that Clarabel rejects.
pub fn nearest_balanced(
    target: &[f64],
    weights: &[f64],
    rows: &[f64],
    right_side: &[f64],
    allowed: Option<&[bool]>,
) -> Result<Option<Balanced>, QpError> {
    let (n, m) = (target.len(), right_side.len());
    check("target", n, target)?;
    check("weights", n, weights)?;
    check("rows", n * m, rows)?;
    check("right_side", m, right_side)?;
    if let Some(found) = allowed.map(<[bool]>::len).filter(|found| *found != n) {
        return Err(QpError::Length { what: "allowed", expected: n, found });
    }
    let problem = Projection { target, weights, rows, right_side, allowed };
    if let Some(found) = problem.newton(vec![0.0; m]) {
        return Ok(Some(found));
    }
    let multipliers = problem.clarabel()?;
    Ok(multipliers.and_then(|a| problem.newton(a)))
}

struct Projection<'a> {
    target: &'a [f64],
    weights: &'a [f64],
    rows: &'a [f64],
    right_side: &'a [f64],
    allowed: Option<&'a [bool]>,
}

impl Projection<'_> {
    fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.target.len()..(k + 1) * self.target.len()]
    }

    fn may_be_positive(&self, i: usize) -> bool {
        self.allowed.is_none_or(|allowed| allowed[i])
    }

    /// `max(0, t + W⁻¹ Cᵀ a)`.
    fn values(&self, a: &[f64]) -> Vec<f64> {
        let mut shift = vec![0.0; self.target.len()];
        for (k, a) in a.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            shift.iter_mut().zip(self.row(k)).for_each(|(s, c)| *s += c * a);
        }
        let value = |i: usize| (self.target[i] + shift[i] / self.weights[i]).max(0.0);
        (0..self.target.len()).map(|i| if self.may_be_positive(i) { value(i) } else { 0.0 }).collect()
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

    /// `½ Σ w p² − a·e`.
    fn dual(&self, p: &[f64], a: &[f64]) -> f64 {
        0.5 * self.weights.iter().zip(p).map(|(w, p)| w * p * p).sum::<f64>() - dot(a, self.right_side)
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

    /// The Newton step of the multipliers, on the positive values.
    fn step(&self, p: &[f64], defect: &[f64]) -> Option<Vec<f64>> {
        let positive: Vec<usize> = (0..p.len()).filter(|i| p[*i] > 0.0).collect();
        let entry = |i: usize, j: usize| {
            let (first, second) = (self.row(i), self.row(j));
            positive.iter().map(|&k| first[k] * second[k] / self.weights[k]).sum::<f64>()
        };
        Some(SemiDefinite::new(defect.len(), entry, DEPENDENT)?.solve(defect).0)
    }

    /// The multipliers of the rows by Clarabel; `None` if it finds that nothing is in balance.
    fn clarabel(&self) -> Result<Option<Vec<f64>>, QpError> {
        let n = self.target.len();
        let (starts, places): (Vec<usize>, Vec<usize>) = ((0..=n).collect(), (0..n).collect());
        let matrix =
            MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: self.weights };
        let linear: Vec<f64> = self.target.iter().zip(self.weights).map(|(t, w)| -w * t).collect();
        let upper: Vec<f64> =
            (0..n).map(|i| if self.may_be_positive(i) { f64::INFINITY } else { 0.0 }).collect();
        let boxed = Boxed {
            matrix,
            linear: &linear,
            lower: &vec![0.0; n],
            upper: &upper,
            rows: self.rows,
            right_side: self.right_side,
        };
        let found = interior_point::solve_boxed(&boxed, &QpSettings::default().with_tolerance(1e-9))?;
        Ok((found.status != QpStatus::Infeasible).then_some(found.row_multipliers))
    }
}

fn check(what: &'static str, expected: usize, values: &[f64]) -> Result<(), QpError> {
    check_length(what, expected, values.len())?;
    check_finite(what, values)
}
