//! Cholesky factors of blocks of full matrices.

use crate::error::QpError;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::solve::solve_in_place;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, MatMut, MatRef, Par};

/// A pivot below this fraction of its diagonal entry may be round-off.
pub(crate) const PIVOT_FLOOR: f64 = 1e-9;

/// `L` with `P_II = L Lᵀ`: its lower triangle, column by column.
pub(crate) struct Factor {
    lower: Vec<f64>,
    n: usize,
}

impl Factor {
    /// Factorises a matrix of `n` rows, column by column; only the lower triangle is read.
    ///
    /// # Errors
    /// The first pivot that is not positive and finite, from 0.
    pub(crate) fn new(n: usize, mut lower: Vec<f64>) -> Result<Self, usize> {
        let matrix = MatMut::from_column_major_slice_mut(&mut lower, n, n);
        let mut scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
        let stack = MemStack::new(&mut scratch);
        cholesky_in_place(matrix, Default::default(), Par::Seq, stack, Default::default())
            .map_err(|LltError::NonPositivePivot { index }| index)?;
        Ok(Self { lower, n })
    }

    /// Factorises the rows and columns `block` (sorted, unique) of a matrix.
    ///
    /// * `n`: its rows; `values`: column by column; only the lower triangle is read.
    ///
    /// # Errors
    /// [`QpError::NotPositiveDefinite`] with the unknown, numbered in the whole matrix.
    pub(crate) fn of_block(n: usize, values: &[f64], block: &[usize]) -> Result<Self, QpError> {
        let size = block.len();
        let mut lower = vec![0.0; size * size];
        for (j, &column) in block.iter().enumerate() {
            let source = &values[column * n..(column + 1) * n];
            for (i, &row) in block.iter().enumerate().skip(j) {
                lower[j * size + i] = source[row];
            }
        }
        Self::new(size, lower).map_err(|pivot| QpError::NotPositiveDefinite { index: block[pivot] })
    }

    /// Lists the diagonal of `L`.
    pub(crate) fn pivots(&self) -> impl Iterator<Item = f64> {
        (0..self.n).map(|j| self.lower[j * (self.n + 1)])
    }

    /// Overwrites the columns of `rhs`, each as long as `I`, with `P_II⁻¹ rhs`.
    pub(crate) fn solve(&self, rhs: &mut [f64]) {
        let (lower, rhs) = self.with(rhs);
        solve_in_place(lower, rhs, Par::Seq, MemStack::new(&mut []));
    }

    /// Overwrites the columns of `rhs` with `L⁻¹ rhs`.
    pub(crate) fn forward(&self, rhs: &mut [f64]) {
        let (lower, rhs) = self.with(rhs);
        solve_lower_triangular_in_place(lower, rhs, Par::Seq);
    }

    /// Overwrites the columns of `rhs` with `L⁻ᵀ rhs`.
    pub(crate) fn backward(&self, rhs: &mut [f64]) {
        let (lower, rhs) = self.with(rhs);
        solve_upper_triangular_in_place(lower.transpose(), rhs, Par::Seq);
    }

    fn with<'a>(&'a self, rhs: &'a mut [f64]) -> (MatRef<'a, f64>, MatMut<'a, f64>) {
        let columns = rhs.len().checked_div(self.n).unwrap_or(0);
        let lower = MatRef::from_column_major_slice(&self.lower, self.n, self.n);
        (lower, MatMut::from_column_major_slice_mut(rhs, self.n, columns))
    }
}

/// Subtracts `L L_1ᵀ` from a matrix, with the first rows `L_1` of `L`, as many as it has columns.
///
/// * `matrix`: as many rows as `L` has from `first` on, column by column; `lower`: `height` rows, column by column.
pub(crate) fn subtract_square(matrix: &mut [f64], lower: &[f64], (height, first): (usize, usize)) {
    let rows = height - first;
    let lower = MatRef::from_column_major_slice(lower, height, lower.len() / height).subrows(first, rows);
    let columns = matrix.len() / rows;
    let top = lower.subrows(0, columns).transpose();
    let matrix = MatMut::from_column_major_slice_mut(matrix, rows, columns);
    matmul(matrix, Accum::Add, lower, top, -1.0, Par::Seq);
}

/// Computes `AᵀB`, column by column.
///
/// * `a`, `b`: column by column; `columns`: of each.
pub(crate) fn products(a: &[f64], b: &[f64], columns: usize) -> Vec<f64> {
    let size = a.len().checked_div(columns).unwrap_or(0);
    let mut product = vec![0.0; columns * columns];
    let [a, b] = [a, b].map(|values| MatRef::from_column_major_slice(values, size, columns));
    let to = MatMut::from_column_major_slice_mut(&mut product, columns, columns);
    matmul(to, Accum::Replace, a.transpose(), b, 1.0, Par::Seq);
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `I + 0.25 tridiagonal`, whose entry `(bad, bad)` is −1, so that only this pivot is not positive: the
    /// matrix without that unknown is diagonally dominant, and a factorisation fails when it reaches it.
    fn with_bad_pivot(n: usize, bad: usize) -> Vec<f64> {
        let mut full = vec![0.0; n * n];
        for i in 0..n {
            full[i * n + i] = if i == bad { -1.0 } else { 1.0 };
            if i > 0 {
                full[i * n + i - 1] = 0.25;
                full[(i - 1) * n + i] = 0.25;
            }
        }
        full
    }

    #[test]
    fn the_failing_pivot_is_named_in_the_callers_numbering() {
        for n in [3, 40, 130, 583] {
            for bad in [1, n / 2, n - 1] {
                let full = with_bad_pivot(n, bad);
                let free: Vec<usize> = (1..n).collect();
                let error = Factor::of_block(n, &full, &free).err();
                assert_eq!(error, Some(QpError::NotPositiveDefinite { index: bad }), "n = {n}");
            }
        }
    }

    #[test]
    fn solves_the_block_of_some_unknowns() {
        // The larger one in several blocks of columns.
        for n in [60, 583] {
            let full = with_bad_pivot(n, 7);
            let free: Vec<usize> = (0..n).filter(|&i| i != 7).collect();
            let wanted: Vec<f64> = (0..n).map(|i| if i == 7 { 0.0 } else { 1.0 + i as f64 }).collect();
            let image = |i: usize| (0..n).map(|j| full[j * n + i] * wanted[j]).sum::<f64>();
            let mut found: Vec<f64> = free.iter().map(|&i| image(i)).collect();
            Factor::of_block(n, &full, &free).unwrap().solve(&mut found);
            for (found, &i) in found.iter().zip(&free) {
                assert!((found - wanted[i]).abs() < 1e-12 * wanted[i]);
            }
        }
    }
}
