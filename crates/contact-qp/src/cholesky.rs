//! Cholesky factors of the block `P_II` of the free unknowns `I`.

use crate::error::QpError;
use crate::problem::MatrixView;
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};
use dense_cholesky::NotPositiveDefinite;
use nalgebra::DMatrixView;

/// A pivot below this fraction of its diagonal entry may be round-off.
pub(crate) const PIVOT_FLOOR: f64 = 1e-9;

/// `L` with `P_II = L Lᵀ`.
pub(crate) enum Factor {
    /// Lower triangle of a full matrix, column by column, and its rows.
    Dense { lower: Vec<f64>, n: usize },
    /// `P_II = L D Lᵀ` in an approximate minimum degree order.
    Sparse(Box<QDLDLFactorisation>),
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

    /// Lists the diagonal of `L`; nothing of a sparse factor.
    pub(crate) fn pivots(&self) -> impl Iterator<Item = f64> {
        let (lower, n): (&[f64], usize) = match self {
            Self::Dense { lower, n } => (lower, *n),
            Self::Sparse(_) => (&[], 0),
        };
        (0..n).map(move |j| lower[j * (n + 1)])
    }

    /// Overwrites the columns of `rhs`, each as long as `I`, with `P_II⁻¹ rhs`.
    pub(crate) fn solve(&self, rhs: &mut [f64]) {
        match self {
            Self::Dense { lower, n } => {
                dense_cholesky::forward(lower, *n, rhs);
                dense_cholesky::backward(lower, *n, rhs);
            }
            Self::Sparse(factor) => {
                rhs.chunks_exact_mut(factor.D.len().max(1)).for_each(|rhs| solve_sparse(factor, rhs));
            }
        }
    }
}

/// Returns `P⁻¹ C` and `Cᵀ P⁻¹ C`, column by column.
///
/// * `solve`: overwrites columns with `P⁻¹` of them.
/// * `coupling`: C, column by column.
/// * `columns`: of C, at least 1.
pub(crate) fn eliminate(
    solve: impl Fn(&mut [f64]),
    coupling: &[f64],
    columns: usize,
) -> (Vec<f64>, Vec<f64>) {
    let size = coupling.len() / columns;
    let mut solved = coupling.to_vec();
    solve(&mut solved);
    let [c, product] = [coupling, &solved].map(|values| DMatrixView::from_slice(values, size, columns));
    let product = c.transpose() * product;
    (solved, product.data.into())
}

fn factorise_dense(n: usize, values: &[f64], free: &[usize]) -> Result<Factor, QpError> {
    let size = free.len();
    let mut lower = vec![0.0; size * size];
    for (j, &column) in free.iter().enumerate() {
        let source = &values[column * n..(column + 1) * n];
        // Only the lower triangle is read by the factorisation.
        for (i, &row) in free.iter().enumerate().skip(j) {
            lower[j * size + i] = source[row];
        }
    }
    dense_cholesky::factorise(&mut lower, size)
        .map_err(|NotPositiveDefinite { column }| QpError::NotPositiveDefinite { index: free[column] })?;
    Ok(Factor::Dense { lower, n: size })
}

/// Solves with `L D Lᵀ` and its order. Clarabel's own function needs the factor for itself.
pub(crate) fn solve_sparse(factor: &QDLDLFactorisation, rhs: &mut [f64]) {
    let (l, order) = (&factor.L, &factor.perm);
    let mut x: Vec<f64> = order.iter().map(|&unknown| rhs[unknown]).collect();
    let column = |j: usize| {
        let entries = l.colptr[j]..l.colptr[j + 1];
        l.rowval[entries.clone()].iter().zip(&l.nzval[entries])
    };
    for j in 0..x.len() {
        let value = x[j];
        column(j).for_each(|(&i, l)| x[i] -= l * value);
    }
    for j in (0..x.len()).rev() {
        let known: f64 = column(j).map(|(&i, l)| l * x[i]).sum();
        x[j] = x[j] * factor.Dinv[j] - known;
    }
    order.iter().zip(x).for_each(|(&unknown, x)| rhs[unknown] = x);
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
            // The factorisation expects all diagonal entries.
            let first = block.column_starts[place[column]];
            if block.row_indices[first..].last() != Some(&place[column]) {
                block.row_indices.push(place[column]);
                block.values.push(0.0);
            }
            block.column_starts.push(block.values.len());
        }
        block
    }

    fn factorise(self, free: &[usize]) -> Result<Factor, QpError> {
        let n = free.len();
        let matrix = CscMatrix::new(n, n, self.column_starts, self.row_indices, self.values);
        // A pivot that is not positive becomes infinite, which marks it and removes its unknown from the others.
        let settings = QDLDLSettings {
            regularize_eps: 0.0,
            regularize_delta: f64::INFINITY,
            ..QDLDLSettings::default()
        };
        let factor = QDLDLFactorisation::new(&matrix, Some(settings))
            .map_err(|error| QpError::Library { library: "clarabel", message: error.to_string() })?;
        match factor.D.iter().position(|pivot| !pivot.is_finite()) {
            Some(k) => Err(QpError::NotPositiveDefinite { index: free[factor.perm[k]] }),
            None => Ok(Factor::Sparse(Box::new(factor))),
        }
    }
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
        for n in [3, 40, 130, 583] {
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
        solves_the_block(583);
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
