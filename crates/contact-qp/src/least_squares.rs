//! Least squares with numbers that are not negative.

use crate::dense::{dot, least_squares, norm};
use crate::error::QpError;
use crate::problem::check_values;

/// A gradient below this fraction of its terms is zero.
const ROUND_OFF: f64 = 1e-13;

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
    check_values("rows", n * m, rows)?;
    check_values("right_side", m, right_side)?;
    let mut problem = LeastSquares::new(rows, right_side, n);
    problem.solve();
    let LeastSquares { x, lengths, residual, .. } = problem;
    let unscaled = |(x, length): (f64, f64)| if x > 0.0 { x / length } else { 0.0 };
    Ok((x.into_iter().zip(lengths).map(unscaled).collect(), residual))
}

struct LeastSquares<'a> {
    /// Columns of length one: their lengths are positive, so that signs do not change.
    columns: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    target: &'a [f64],
    x: Vec<f64>,
    residual: Vec<f64>,
}

impl<'a> LeastSquares<'a> {
    fn new(rows: &[f64], target: &'a [f64], n: usize) -> Self {
        let column = |j: usize| (0..target.len()).map(|k| rows[k * n + j]).collect::<Vec<f64>>();
        let mut columns: Vec<Vec<f64>> = (0..n).map(column).collect();
        let lengths: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
        for (column, length) in columns.iter_mut().zip(&lengths) {
            column.iter_mut().for_each(|g| *g /= length.max(f64::MIN_POSITIVE));
        }
        Self { columns, lengths, target, x: vec![0.0; n], residual: target.to_vec() }
    }

    fn solve(&mut self) {
        let (n, m, size) = (self.x.len(), self.target.len(), norm(self.target));
        let mut passive: Vec<usize> = Vec::new();
        // Columns that depend on the passive ones, to rounding.
        let mut dependent: Vec<usize> = Vec::new();
        // Every step lowers the residual; the limit is only for round-off.
        for _ in 0..3 * n.max(m) + 10 {
            let gradient = |j: usize| dot(&self.columns[j], &self.residual);
            let taken = |j: &usize| passive.contains(j) || dependent.contains(j);
            let open = (0..n).filter(|j| self.lengths[*j] > 0.0 && !taken(j));
            let Some(best) = open.max_by(|i, j| gradient(*i).total_cmp(&gradient(*j))) else { break };
            // As many columns as rows leave nothing but round-off.
            if gradient(best) <= ROUND_OFF * size || passive.len() >= m {
                break;
            }
            passive.push(best);
            let settled = self.settle(&mut passive, best);
            self.residual.copy_from_slice(self.target);
            for &j in &passive {
                let x = self.x[j];
                self.residual.iter_mut().zip(&self.columns[j]).for_each(|(r, g)| *r -= x * g);
            }
            if settled {
                dependent.clear();
            } else {
                dependent.push(best);
            }
        }
    }

    /// Moves the passive unknowns to the least squares on them; those that become zero on the way stay there. Returns false if the
    /// newest depends on the others.
    fn settle(&mut self, passive: &mut Vec<usize>, newest: usize) -> bool {
        loop {
            let used: Vec<&[f64]> = passive.iter().map(|j| self.columns[*j].as_slice()).collect();
            let trial = least_squares(&used, self.target);
            let no_better = passive.last() == Some(&newest) && trial.last().is_some_and(|t| *t <= 0.0);
            if no_better && self.x[newest] == 0.0 {
                // By round-off: the column depends on the others.
                passive.pop();
                return false;
            }
            let falling =
                passive.iter().zip(&trial).filter(|(_, t)| **t <= 0.0).map(|(j, t)| (self.x[*j], *t));
            // 0/0 if it is zero already: then the step has no length, and takes it out.
            let Some(step) = falling.map(|(x, t)| (x / (x - t)).max(0.0)).reduce(f64::min) else {
                self.x.fill(0.0);
                passive.iter().zip(&trial).for_each(|(j, t)| self.x[*j] = *t);
                return true;
            };
            for (j, t) in passive.iter().zip(&trial) {
                self.x[*j] += step * (t - self.x[*j]);
            }
            let least = passive.iter().zip(&trial).filter(|(_, t)| **t <= 0.0).map(|(j, _)| self.x[*j]);
            let least = least.fold(f64::INFINITY, f64::min).max(0.0);
            let gone: Vec<usize> = passive.iter().copied().filter(|j| self.x[*j] <= least).collect();
            gone.iter().for_each(|j| self.x[*j] = 0.0);
            passive.retain(|j| !gone.contains(j));
        }
    }
}
