//! Cholesky factors of the block `P_II` of the free unknowns `I`.

use crate::error::QpError;
use crate::problem::MatrixView;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::ReborrowMut;
use faer::sparse::linalg::cholesky as sparse_cholesky;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par, Side};

/// `L` with `P_II = L Lᵀ`.
pub(crate) enum Factor {
    /// Lower triangle of a full matrix.
    Dense(Mat<f64>),
    /// Pattern in an approximate minimum degree order, and values.
    Sparse { symbolic: Box<SymbolicCholesky<usize>>, values: Vec<f64> },
}

impl Factor {
    /// Factorises the rows and columns `free` (sorted, unique) of `matrix`.
    ///
    /// # Errors
    /// [`QpError::NotPositiveDefinite`] with the unknown, numbered in the whole matrix.
    pub(crate) fn of_block(matrix: &MatrixView<'_>, free: &[usize]) -> Result<Self, QpError> {
        match *matrix {
            MatrixView::Dense { n, values } => factorise_dense(n, values, free),
            MatrixView::SparseUpper { n, column_starts, row_indices, values } => {
                Block::gather(n, column_starts, row_indices, values, free).factorise(free)
            }
        }
    }

    /// Overwrites `rhs` with `P_II⁻¹ rhs`.
    pub(crate) fn solve(&self, rhs: &mut [f64]) {
        let size = rhs.len();
        self.solve_columns(MatMut::from_column_major_slice_mut(rhs, size, 1));
    }

    /// Returns `P_II⁻¹ C` and `Cᵀ P_II⁻¹ C`, column by column.
    ///
    /// * `coupling`: C, column by column.
    /// * `columns`: of C, at least 1.
    pub(crate) fn eliminate(&self, coupling: Vec<f64>, columns: usize) -> (Vec<f64>, Vec<f64>) {
        let size = coupling.len() / columns;
        let mut solved = coupling.clone();
        self.solve_columns(MatMut::from_column_major_slice_mut(&mut solved, size, columns));
        let mut product = vec![0.0; columns * columns];
        matmul(
            MatMut::from_column_major_slice_mut(&mut product, columns, columns),
            Accum::Replace,
            MatRef::from_column_major_slice(&coupling, size, columns).transpose(),
            MatRef::from_column_major_slice(&solved, size, columns),
            1.0,
            Par::Seq,
        );
        (solved, product)
    }

    fn solve_columns(&self, rhs: MatMut<'_, f64>) {
        let (size, columns) = (rhs.nrows(), rhs.ncols());
        match self {
            Self::Dense(lower) => {
                let scratch = llt::solve::solve_in_place_scratch::<f64>(size, columns, Par::Seq);
                let mut memory = MemBuffer::new(scratch);
                llt::solve::solve_in_place(lower.as_ref(), rhs, Par::Seq, MemStack::new(&mut memory));
            }
            Self::Sparse { symbolic, values } => {
                let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq));
                sparse_cholesky::LltRef::new(symbolic, values).solve_in_place_with_conj(
                    Conj::No,
                    rhs,
                    Par::Seq,
                    MemStack::new(&mut memory),
                );
            }
        }
    }
}

fn factorise_dense(n: usize, values: &[f64], free: &[usize]) -> Result<Factor, QpError> {
    let size = free.len();
    let mut lower = Mat::<f64>::zeros(size, size);
    for (j, &column) in free.iter().enumerate() {
        let source = &values[column * n..(column + 1) * n];
        // Only the lower triangle is read by the factorisation.
        for (i, &row) in free.iter().enumerate().skip(j) {
            lower[(i, j)] = source[row];
        }
    }
    factorise_blocks(lower.as_mut()).map_err(|index| QpError::NotPositiveDefinite { index: free[index] })?;
    Ok(Factor::Dense(lower))
}

/// Columns that are factorised at once; the rows below them, and the columns after them, are shared out in pieces of this size.
const BLOCK: usize = 192;

/// Overwrites the lower triangle of a matrix with its Cholesky factor: block of columns after block of columns,
/// `L₂₁ = A₂₁ L₁₁⁻ᵀ` and `A₂₂ − L₂₁ L₂₁ᵀ` by all threads. The result does not depend on their number. An error is the pivot that is
/// not positive.
fn factorise_blocks(matrix: MatMut<'_, f64>) -> Result<(), usize> {
    let mut first = 0;
    let mut rest = matrix;
    while rest.nrows() > 0 {
        let width = if rest.nrows() > 2 * BLOCK { BLOCK } else { rest.nrows() };
        let (mut diagonal, _, mut below, mut trailing) = rest.split_at_mut(width, width);
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
        llt::factor::cholesky_in_place(
            diagonal.rb_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .map_err(|llt::factor::LltError::NonPositivePivot { index }| first + index)?;
        each_rows(below.rb_mut(), &|rows| {
            solve_lower_triangular_in_place(diagonal.as_ref(), rows.transpose_mut(), Par::Seq);
        });
        subtract_products(trailing.rb_mut(), 0, below.as_ref());
        first += width;
        rest = trailing;
    }
    Ok(())
}

/// Does something with pieces of the rows of a matrix, in parallel.
fn each_rows(matrix: MatMut<'_, f64>, act: &(dyn Fn(MatMut<'_, f64>) + Sync)) {
    let pieces = matrix.nrows().div_ceil(BLOCK);
    if pieces < 2 {
        return act(matrix);
    }
    let (upper, lower) = matrix.split_at_row_mut(pieces / 2 * BLOCK);
    rayon::join(|| each_rows(upper, act), || each_rows(lower, act));
}

/// Subtracts the lower triangle of `L Lᵀ` from that of a matrix, piece of columns by piece of columns, in parallel.
///
/// * `first`: the number of its first column in the whole matrix.
fn subtract_products(matrix: MatMut<'_, f64>, first: usize, factor: MatRef<'_, f64>) {
    let pieces = matrix.ncols().div_ceil(BLOCK);
    if pieces < 2 {
        let columns = factor.subrows(first, matrix.ncols());
        // What is above the diagonal is not needed.
        let (_, matrix) = matrix.split_at_row_mut(first);
        let (_, rows) = factor.split_at_row(first);
        return matmul(matrix, Accum::Add, rows, columns.transpose(), -1.0, Par::Seq);
    }
    let half = pieces / 2 * BLOCK;
    let (left, right) = matrix.split_at_col_mut(half);
    rayon::join(|| subtract_products(left, first, factor), || subtract_products(right, first + half, factor));
}

/// Upper triangle of `P_II` in compressed columns.
struct Block {
    column_starts: Vec<usize>,
    row_indices: Vec<usize>,
    values: Vec<f64>,
}

impl Block {
    fn gather(n: usize, starts: &[usize], rows: &[usize], values: &[f64], free: &[usize]) -> Self {
        const FIXED: usize = usize::MAX;
        let mut place = vec![FIXED; n];
        for (local, &unknown) in free.iter().enumerate() {
            place[unknown] = local;
        }
        let mut block = Self { column_starts: vec![0], row_indices: Vec::new(), values: Vec::new() };
        for &column in free {
            for k in starts[column]..starts[column + 1] {
                if place[rows[k]] != FIXED {
                    block.row_indices.push(place[rows[k]]);
                    block.values.push(values[k]);
                }
            }
            block.column_starts.push(block.values.len());
        }
        block
    }

    fn factorise(&self, free: &[usize]) -> Result<Factor, QpError> {
        let size = free.len();
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &self.column_starts, None, &self.row_indices);
        let symbolic = sparse_cholesky::factorize_symbolic_cholesky(
            pattern,
            Side::Upper,
            SymmetricOrdering::Amd,
            Default::default(),
        )
        .map_err(library_error)?;
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        symbolic
            .factorize_numeric_llt(
                &mut values,
                SparseColMatRef::new(pattern, &self.values),
                Side::Upper,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|error| pivot_error(error, &symbolic, free))?;
        Ok(Factor::Sparse { symbolic: Box::new(symbolic), values })
    }
}

fn pivot_error(error: llt::factor::LltError, symbolic: &SymbolicCholesky<usize>, free: &[usize]) -> QpError {
    let llt::factor::LltError::NonPositivePivot { index } = error;
    // faer counts from 1 in its simplicial form, from 0 in its supernodal form, and in the permuted order.
    let permuted = match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(_) => index.saturating_sub(1),
        SymbolicCholeskyRaw::Supernodal(_) => index,
    };
    let local = symbolic.perm().map_or(permuted, |order| order.arrays().0[permuted]);
    QpError::NotPositiveDefinite { index: free[local] }
}

fn library_error(error: impl std::fmt::Debug) -> QpError {
    QpError::Library { library: "faer", message: format!("{error:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Upper triangle of a full column-major matrix, with or without its zeros.
    fn upper(n: usize, full: &[f64], keep_zeros: bool) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut starts, mut rows, mut values) = (vec![0], vec![], vec![]);
        for j in 0..n {
            for i in (0..=j).filter(|&i| keep_zeros || full[j * n + i] != 0.0) {
                rows.push(i);
                values.push(full[j * n + i]);
            }
            starts.push(values.len());
        }
        (starts, rows, values)
    }

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
        for n in [3, 40, 130, 3 * BLOCK + 7] {
            for bad in [1, n / 2, n - 1] {
                let full = with_bad_pivot(n, bad);
                let free: Vec<usize> = (1..n).collect();
                let dense = MatrixView::Dense { n, values: &full };
                for keep_zeros in [false, true] {
                    let (starts, rows, values) = upper(n, &full, keep_zeros);
                    let sparse = MatrixView::SparseUpper {
                        n,
                        column_starts: &starts,
                        row_indices: &rows,
                        values: &values,
                    };
                    for matrix in [dense, sparse] {
                        let error = Factor::of_block(&matrix, &free).err();
                        assert_eq!(error, Some(QpError::NotPositiveDefinite { index: bad }), "n = {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn solves_the_block_of_the_free_unknowns() {
        solves_the_block(60);
        // In several blocks of columns.
        solves_the_block(3 * BLOCK + 7);
    }

    fn solves_the_block(n: usize) {
        let full = with_bad_pivot(n, 7);
        let (starts, rows, values) = upper(n, &full, false);
        let sparse =
            MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &rows, values: &values };
        let free: Vec<usize> = (0..n).filter(|&i| i != 7).collect();
        for matrix in [MatrixView::Dense { n, values: &full }, sparse] {
            let wanted: Vec<f64> = (0..n).map(|i| if i == 7 { 0.0 } else { 1.0 + i as f64 }).collect();
            let mut image = vec![0.0; n];
            matrix.add_product(&wanted, &mut image);
            let mut found: Vec<f64> = free.iter().map(|&i| image[i]).collect();
            Factor::of_block(&matrix, &free).unwrap().solve(&mut found);
            for (found, &i) in found.iter().zip(&free) {
                assert!((found - wanted[i]).abs() < 1e-12 * wanted[i]);
            }
        }
    }
}
