//! The few operations the solver needs from a borrowed symmetric matrix.

use crate::problem::MatrixView;

impl MatrixView<'_> {
    /// Returns n, the number of rows and columns.
    #[must_use]
    pub fn size(&self) -> usize {
        match *self {
            Self::Dense { n, .. } | Self::SparseUpper { n, .. } => n,
        }
    }

    /// Returns `P_ii`; in a sparse column the diagonal, if stored, is the last entry.
    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        match *self {
            Self::Dense { n, values } => values[i * n + i],
            Self::SparseUpper { column_starts, row_indices, values, .. } => {
                let range = column_starts[i]..column_starts[i + 1];
                match row_indices[range.clone()].last() {
                    Some(&row) if row == i => values[range.end - 1],
                    _ => 0.0,
                }
            }
        }
    }

    /// Passes every stored entry `(i, j, P_ij)` with `i ≤ j` to a function.
    pub(crate) fn for_each_upper(&self, mut visit: impl FnMut(usize, usize, f64)) {
        match *self {
            Self::Dense { n, values } => {
                for j in 0..n {
                    (0..=j).for_each(|i| visit(i, j, values[j * n + i]));
                }
            }
            Self::SparseUpper { n, column_starts, row_indices, values } => {
                for j in 0..n {
                    (column_starts[j]..column_starts[j + 1])
                        .for_each(|k| visit(row_indices[k], j, values[k]));
                }
            }
        }
    }

    /// Adds `P x` to `y` (n entries each).
    pub(crate) fn add_product(&self, x: &[f64], y: &mut [f64]) {
        match *self {
            Self::Dense { n, values } => add_dense_product(n, values, x, y),
            Self::SparseUpper { n, column_starts, row_indices, values } => {
                for j in 0..n {
                    let mut mirrored = 0.0;
                    for k in column_starts[j]..column_starts[j + 1] {
                        let i = row_indices[k];
                        y[i] += values[k] * x[j];
                        if i != j {
                            mirrored += values[k] * x[i];
                        }
                    }
                    y[j] += mirrored;
                }
            }
        }
    }

    /// Adds `|P| |x|` to `y` (n entries each).
    pub(crate) fn add_magnitudes(&self, x: &[f64], y: &mut [f64]) {
        match *self {
            Self::Dense { n, values } => {
                for (column, x) in values.chunks_exact(n.max(1)).zip(x).filter(|(_, x)| **x != 0.0) {
                    y.iter_mut().zip(column).for_each(|(y, p)| *y += (p * x).abs());
                }
            }
            Self::SparseUpper { .. } => self.for_each_upper(|i, j, value| {
                y[i] += (value * x[j]).abs();
                if i != j {
                    y[j] += (value * x[i]).abs();
                }
            }),
        }
    }
}

/// Adds `P x` to `y` four columns at a time, so that `y` is read and written a quarter as often; columns whose
/// `x_j` is 0 (free unknowns before the solution) cost nothing.
fn add_dense_product(n: usize, values: &[f64], x: &[f64], y: &mut [f64]) {
    let columns: Vec<usize> = (0..n).filter(|&j| x[j] != 0.0).collect();
    let column = |j: usize| &values[j * n..(j + 1) * n];
    let mut groups = columns.chunks_exact(4);
    for group in &mut groups {
        let [a, b, c, d] = [column(group[0]), column(group[1]), column(group[2]), column(group[3])];
        let [xa, xb, xc, xd] = [x[group[0]], x[group[1]], x[group[2]], x[group[3]]];
        for ((((y, a), b), c), d) in y.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *y += (a * xa + b * xb) + (c * xc + d * xd);
        }
    }
    for &j in groups.remainder() {
        for (y, a) in y.iter_mut().zip(column(j)) {
            *y += a * x[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_and_sparse_agree_with_the_hand_calculation() {
        // P = tridiag(-1, 4, -1) with P_04 = 2, n = 5.
        let n = 5;
        let mut values = vec![0.0; n * n];
        for i in 0..n {
            values[i * n + i] = 4.0;
            if i > 0 {
                values[i * n + i - 1] = -1.0;
                values[(i - 1) * n + i] = -1.0;
            }
        }
        values[4 * n] = 2.0;
        values[4] = 2.0;
        let dense = MatrixView::Dense { n, values: &values };
        let sparse = MatrixView::SparseUpper {
            n,
            column_starts: &[0, 1, 3, 5, 7, 10],
            row_indices: &[0, 0, 1, 1, 2, 2, 3, 0, 3, 4],
            values: &[4.0, -1.0, 4.0, -1.0, 4.0, -1.0, 4.0, 2.0, -1.0, 4.0],
        };
        for matrix in [dense, sparse] {
            let mut y = vec![1.0; n];
            matrix.add_product(&[1.0, 2.0, 3.0, 4.0, 5.0], &mut y);
            assert_eq!(y, [13.0, 5.0, 7.0, 9.0, 19.0]);
            let mut sizes = vec![0.0; n];
            matrix.add_magnitudes(&[1.0, -2.0, 3.0, 4.0, 5.0], &mut sizes);
            assert_eq!(sizes, [16.0, 12.0, 18.0, 24.0, 26.0]);
            assert_eq!(matrix.diagonal(3), 4.0);
        }
        let mut y = vec![0.0; n];
        dense.add_product(&[0.0, 2.0, 0.0, 0.0, 0.0], &mut y);
        assert_eq!(y, [-2.0, 8.0, -2.0, 0.0, 0.0]);
    }

    #[test]
    fn a_missing_diagonal_entry_is_zero() {
        let matrix = MatrixView::SparseUpper {
            n: 2,
            column_starts: &[0, 1, 2],
            row_indices: &[0, 0],
            values: &[1.0, 5.0],
        };
        assert_eq!(matrix.diagonal(1), 0.0);
    }
}
