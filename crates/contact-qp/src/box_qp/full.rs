//! The equations of a set with a full matrix: a factor of `P_FF + c G_Fᵀ G_F` and the eigenvalues of the Schur complement of the rows.

use super::kept::{DEPENDENT_COLUMN, Kept};
use crate::cholesky::{Factor, PIVOT_FLOOR, eliminate};
use crate::dense::{SemiDefinite, dot, largest};
use crate::error::QpError;
use crate::programme::BoxQp;
use std::borrow::Cow;
use std::cell::RefCell;

/// Dependent rows contradict each other beyond this fraction of the right-hand side.
pub(super) const CONTRADICTION: f64 = 1e-9;

/// Eigenvalues of the rows' Schur complement below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-10;

/// Corrections of a solution on one set.
const REFINEMENTS: usize = 2;

/// A full matrix with what all sets share.
pub(super) struct Full<'a> {
    qp: &'a BoxQp<'a>,
    /// `P + c GᵀG` with rows of length one.
    pub(super) matrix: Cow<'a, [f64]>,
    /// The block that was factorised last.
    kept: RefCell<Option<Kept>>,
    /// `G` with rows of length one.
    rows: Vec<f64>,
    weight: f64,
}

impl<'a> Full<'a> {
    /// * `values`: `P`; `trace`: of it; `lengths`: of the rows.
    pub(super) fn new(qp: &'a BoxQp<'a>, values: &'a [f64], trace: f64, lengths: &[f64]) -> Self {
        let n = qp.linear.len();
        let mut rows = qp.rows.dense();
        for (row, length) in rows.chunks_exact_mut(n.max(1)).zip(lengths) {
            row.iter_mut().for_each(|g| *g /= length);
        }
        let added = !lengths.is_empty();
        let weight = match added {
            true if trace > 0.0 => trace / lengths.len() as f64,
            true => 1.0,
            false => 0.0,
        };
        let mut matrix = Cow::Borrowed(values);
        if added {
            let matrix = matrix.to_mut();
            for row in rows.chunks_exact(n.max(1)) {
                for (j, g) in row.iter().enumerate().filter(|(_, g)| **g != 0.0) {
                    let column = &mut matrix[j * n..(j + 1) * n];
                    column.iter_mut().zip(row).for_each(|(p, other)| *p += weight * g * other);
                }
            }
        }
        Self { qp, matrix, kept: RefCell::new(None), rows, weight }
    }

    /// Solves for the free unknowns and the multipliers of the rows; `None` if the rows cannot hold. Of free unknowns that depend on each other some
    /// keep given values.
    ///
    /// * `lengths`: of the rows; `size`: of `x` that the data have; `from`: these values; `x`: at their bounds but for the free ones, 0; `a`: 0.
    pub(super) fn solve(
        &self,
        (lengths, size): (&[f64], f64),
        (mut free, from): (Vec<usize>, &[f64]),
        (x, a): (&mut [f64], &mut [f64]),
    ) -> Option<()> {
        let (n, m) = (x.len(), a.len());
        let mut kept = self.kept.borrow_mut();
        let changes = kept.as_mut().and_then(|kept| kept.changes(&self.matrix, &free));
        if changes.is_none() {
            *kept = Kept::new(n, &self.matrix, &free);
        }
        if kept.is_none() {
            for i in self.dependent(&free)? {
                x[i] = from[i].max(self.qp.lower[i]).min(self.qp.upper[i]);
                free.retain(|j| *j != i);
            }
            *kept = Kept::new(n, &self.matrix, &free);
        }
        let (kept, changes) = (kept.as_ref()?, changes.unwrap_or_default());
        let solve = |rhs: &mut [f64]| kept.solve(&free, &changes, rhs);
        let row = |k: usize| -> Vec<f64> { free.iter().map(|i| self.rows[k * n + i]).collect() };
        let rows: Vec<Vec<f64>> = (0..m).map(row).collect();
        // H⁻¹ G_Fᵀ and G_F H⁻¹ G_Fᵀ.
        let (solved, product) = if m > 0 && !free.is_empty() {
            eliminate(solve, &rows.concat(), m)
        } else {
            (Vec::new(), vec![0.0; m * m])
        };
        let entry = |i: usize, j: usize| 0.5 * (product[j * m + i] + product[i * m + j]);
        let complement = SemiDefinite::new(m, entry, DEPENDENT)?;
        for _ in 0..=REFINEMENTS {
            let gradient = self.qp.gradient(x, a);
            let defect: Vec<f64> =
                self.qp.defect(x).iter().zip(lengths).map(|(d, length)| d / length).collect();
            let mut step: Vec<f64> = free.iter().map(|&i| -gradient[i]).collect();
            for (row, d) in rows.iter().zip(&defect) {
                step.iter_mut().zip(row).for_each(|(s, g)| *s += self.weight * g * d);
            }
            solve(&mut step);
            let rest: Vec<f64> = rows.iter().zip(&defect).map(|(row, d)| d - dot(row, &step)).collect();
            let scale = size.max(largest(x.iter().copied())).max(largest(step.iter().copied()));
            let (change, contradiction) = complement.solve(&rest);
            if contradiction > CONTRADICTION * scale {
                return None;
            }
            for (solved, change) in solved.chunks_exact(free.len().max(1)).zip(&change) {
                step.iter_mut().zip(solved).for_each(|(s, v)| *s += v * change);
            }
            a.iter_mut().zip(change.iter().zip(lengths)).for_each(|(a, (c, length))| *a += c / length);
            free.iter().zip(&step).for_each(|(&i, s)| x[i] += s);
        }
        Some(())
    }

    /// Checks that the matrix has no negative direction beyond round-off.
    pub(super) fn check_semi_definite(&self) -> Result<(), QpError> {
        let n = self.qp.linear.len();
        let mut shifted = self.matrix.to_vec();
        let added = PIVOT_FLOOR * largest((0..n).map(|i| shifted[i * (n + 1)]));
        (0..n).for_each(|i| shifted[i * (n + 1)] += added);
        Factor::of_block(n, &shifted, &(0..n).collect::<Vec<_>>()).map(|_| ())
    }

    /// Finds unknowns whose columns depend on those of others among some, by an elimination that skips them. In contact: at a corner
    /// friction on one side acts along the normal of the other. Unknowns with two bounds come last, so that a pressure is determined
    /// before a friction. `None` if the matrix has a negative direction.
    fn dependent(&self, free: &[usize]) -> Option<Vec<usize>> {
        let n = self.qp.linear.len();
        let (first, last): (Vec<usize>, Vec<usize>) =
            free.iter().partition(|i| self.qp.upper[**i].is_infinite() || self.qp.lower[**i].is_infinite());
        let order = [first, last].concat();
        let (mut kept, mut skipped): (Vec<(usize, Vec<f64>)>, Vec<usize>) = (Vec::new(), Vec::new());
        for (k, &i) in order.iter().enumerate() {
            // The column of L below its pivot, in the order.
            let mut column: Vec<f64> = order[k..].iter().map(|j| self.matrix[i * n + j]).collect();
            for (start, earlier) in &kept {
                let part = &earlier[k - start..];
                let factor = part[0];
                column.iter_mut().zip(part).for_each(|(c, l)| *c -= factor * l);
            }
            if column[0] < -PIVOT_FLOOR * self.matrix[i * (n + 1)] {
                return None;
            }
            if column[0] <= DEPENDENT_COLUMN * self.matrix[i * (n + 1)] {
                skipped.push(i);
                continue;
            }
            let pivot = column[0].sqrt();
            column.iter_mut().for_each(|c| *c /= pivot);
            kept.push((k, column));
        }
        Some(skipped)
    }
}
