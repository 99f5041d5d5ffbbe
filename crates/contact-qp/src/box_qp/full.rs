//! The equations of a set with a full matrix: a factor of `P_FF + c G_Fᵀ G_F` and the eigenvalues of the Schur complement of the rows.

use super::kept::{DEPENDENT_COLUMN, Kept};
use super::weighted::Weighted;
use crate::cholesky::{Factor, PIVOT_FLOOR, products, subtract_square};
use crate::dense::{SemiDefinite, dot, largest};
use crate::error::QpError;
use crate::programme::BoxQp;
use crate::sparse::SparseRows;
use std::cell::RefCell;

/// Dependent rows contradict each other beyond this fraction of the right-hand side. A solution is judged as strictly.
pub(super) const CONTRADICTION: f64 = 1e-12;

/// Eigenvalues of the rows' Schur complement below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-10;

/// Corrections of a solution on one set.
const REFINEMENTS: usize = 2;
/// Columns that an elimination takes at once.
const COLUMNS: usize = 64;

/// A full matrix with what all sets share.
pub(super) struct Full<'a> {
    qp: &'a BoxQp<'a>,
    /// `P + c GᵀG` with rows of length one.
    pub(super) matrix: Weighted<'a>,
    /// The block that was factorised last.
    kept: RefCell<Option<Kept>>,
}

impl<'a> Full<'a> {
    /// * `values`: `P`; `trace`: of it; `lengths`: of the rows.
    pub(super) fn new(qp: &'a BoxQp<'a>, values: &'a [f64], trace: f64, lengths: &[f64]) -> Self {
        let n = qp.linear.len();
        let mut rows = SparseRows::new(n);
        qp.rows.rows().zip(lengths).for_each(|(row, length)| rows.push(row.map(|(i, g)| (i, g / length))));
        let weight = if trace > 0.0 { trace / lengths.len().max(1) as f64 } else { 1.0 };
        Self { qp, matrix: Weighted::new(n, values, rows, weight), kept: RefCell::new(None) }
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
        let m = a.len();
        let mut kept = self.kept.borrow_mut();
        let changes = kept.as_mut().and_then(|kept| kept.changes(&self.matrix, &free));
        if changes.is_none() {
            *kept = Kept::new(&self.matrix, &free);
        }
        if kept.is_none() {
            for i in self.dependent(&free)? {
                x[i] = from[i].max(self.qp.lower[i]).min(self.qp.upper[i]);
                free.retain(|j| *j != i);
            }
            *kept = Kept::new(&self.matrix, &free);
        }
        let (kept, changes) = (kept.as_ref()?, changes.unwrap_or_default());
        // With `H⁻¹ = R Q`: `Q G_Fᵀ` and `G_F R Q G_Fᵀ`.
        let rows = self.free_rows(&free);
        let mut solved = rows.dense();
        kept.forward(&free, &changes, &mut solved);
        let left = if changes.is_none() { Vec::new() } else { rows.dense() };
        let left = if changes.is_none() { &solved } else { &left };
        let product = products(left, &solved, m);
        let entry = |i: usize, j: usize| 0.5 * (product[j * m + i] + product[i * m + j]);
        let complement = SemiDefinite::new(m, entry, DEPENDENT)?;
        let height = free.len().max(1);
        for _ in 0..=REFINEMENTS {
            let gradient = self.qp.gradient(x, a);
            let defect: Vec<f64> =
                self.qp.defect(x).iter().zip(lengths).map(|(d, length)| d / length).collect();
            let mut step: Vec<f64> = free.iter().map(|&i| -gradient[i]).collect();
            for (row, d) in rows.rows().zip(&defect) {
                row.for_each(|(j, g)| step[j] += self.matrix.weight() * g * d);
            }
            kept.forward(&free, &changes, &mut step);
            let mut rest = defect;
            let columns = left.chunks_exact(height);
            rest.iter_mut().zip(columns).for_each(|(rest, column)| *rest -= dot(column, &step));
            let (change, contradiction) = complement.solve(&rest);
            for (solved, change) in solved.chunks_exact(height).zip(&change) {
                step.iter_mut().zip(solved).for_each(|(s, v)| *s += v * change);
            }
            kept.backward(&changes, &mut step);
            let scale = size.max(largest(x.iter().copied())).max(largest(step.iter().copied()));
            if contradiction > CONTRADICTION * scale {
                return None;
            }
            a.iter_mut().zip(change.iter().zip(lengths)).for_each(|(a, (c, length))| *a += c / length);
            free.iter().zip(&step).for_each(|(&i, s)| x[i] += s);
        }
        Some(())
    }

    /// Returns `G_F`, with columns for the free unknowns only.
    fn free_rows(&self, free: &[usize]) -> SparseRows {
        let mut places = vec![None; self.matrix.size()];
        free.iter().enumerate().for_each(|(place, i)| places[*i] = Some(place));
        let mut rows = SparseRows::new(free.len());
        let inside = |(i, g): (usize, f64)| Some((places[i]?, g));
        self.matrix.rows().rows().for_each(|row| rows.push(row.filter_map(inside)));
        rows
    }

    /// Checks that the matrix has no negative direction beyond round-off.
    pub(super) fn check_semi_definite(&self) -> Result<(), QpError> {
        let n = self.matrix.size();
        let mut shifted = self.matrix.lower(&(0..n).collect::<Vec<_>>());
        let added = PIVOT_FLOOR * largest((0..n).map(|i| shifted[i * (n + 1)]));
        (0..n).for_each(|i| shifted[i * (n + 1)] += added);
        Factor::new(n, shifted).map(|_| ()).map_err(|index| QpError::NotPositiveDefinite { index })
    }

    /// Finds unknowns whose columns depend on those of others among some, by an elimination that skips them. In contact: at a corner
    /// friction on one side acts along the normal of the other. Unknowns with two bounds come last, so that a pressure is determined
    /// before a friction. `None` if the matrix has a negative direction.
    fn dependent(&self, free: &[usize]) -> Option<Vec<usize>> {
        let (first, last): (Vec<usize>, Vec<usize>) =
            free.iter().partition(|i| self.qp.upper[**i].is_infinite() || self.qp.lower[**i].is_infinite());
        let order = [first, last].concat();
        let height = order.len();
        // The columns of L that are kept, zero above their pivots.
        let (mut lower, mut skipped): (Vec<f64>, Vec<usize>) = (Vec::new(), Vec::new());
        for start in (0..height).step_by(COLUMNS) {
            let rows = height - start;
            let columns = &order[start..height.min(start + COLUMNS)];
            let mut panel = Vec::with_capacity(columns.len() * rows);
            for column in columns.iter().map(|i| self.matrix.column(*i)) {
                panel.extend(order[start..].iter().map(|j| column[*j]));
            }
            subtract_square(&mut panel, &lower, (height, start));
            let earlier = lower.len();
            for (k, (&i, column)) in columns.iter().zip(panel.chunks_exact_mut(rows)).enumerate() {
                for beside in lower[earlier..].chunks_exact(height).map(|beside| &beside[start + k..]) {
                    let factor = beside[0];
                    column[k..].iter_mut().zip(beside).for_each(|(c, l)| *c -= factor * l);
                }
                let (pivot, diagonal) = (column[k], self.matrix.diagonal(i));
                if pivot < -PIVOT_FLOOR * diagonal {
                    return None;
                }
                if pivot <= DEPENDENT_COLUMN * diagonal {
                    skipped.push(i);
                    continue;
                }
                let pivot = pivot.sqrt();
                lower.extend(std::iter::repeat_n(0.0, start + k));
                lower.extend(column[k..].iter().map(|c| c / pivot));
            }
        }
        Some(skipped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::MatrixView;
    use crate::sparse::SparseRows;

    #[test]
    fn columns_beyond_the_rank_depend_on_others_and_unknowns_with_two_bounds_come_last() {
        let mut random = crate::random::random(1);
        for (n, rank) in [(40, 25), (150, 64), (300, 130)] {
            let factor: Vec<Vec<f64>> = (0..n).map(|_| (0..rank).map(|_| random()).collect()).collect();
            let entry = |k: usize| dot(&factor[k / n], &factor[k % n]);
            let values: Vec<f64> = (0..n * n).map(entry).collect();
            let (linear, lower) = (vec![0.0; n], vec![0.0; n]);
            // Every third unknown has two bounds.
            let two = |i: &usize| i.is_multiple_of(3);
            let upper: Vec<f64> = (0..n).map(|i| if two(&i) { 1.0 } else { f64::INFINITY }).collect();
            let rows = SparseRows::new(n);
            let qp = BoxQp {
                matrix: MatrixView::Dense { n, values: &values },
                linear: &linear,
                lower: &lower,
                upper: &upper,
                rows: &rows,
                right_side: &[],
            };
            let full = Full::new(&qp, &values, 1.0, &[]);
            let free: Vec<usize> = (0..n).collect();
            let (last, first): (Vec<usize>, Vec<usize>) = free.iter().copied().partition(two);
            let order = [first, last].concat();
            assert_eq!(full.dependent(&free).unwrap(), order[rank..], "n = {n}");
            // Without them none is left.
            assert_eq!(full.dependent(&order[..rank]), Some(Vec::new()));
            // A negative direction.
            let mut negative = values.clone();
            negative[n + 1] = -1.0;
            let qp = BoxQp { matrix: MatrixView::Dense { n, values: &negative }, ..qp };
            assert_eq!(Full::new(&qp, &negative, 1.0, &[]).dependent(&free), None);
        }
    }
}
