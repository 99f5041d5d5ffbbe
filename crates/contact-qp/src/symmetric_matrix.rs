//! A symmetric matrix with its entries.

use crate::problem::MatrixView;

/// A symmetric n × n matrix.
#[derive(Clone, Debug, PartialEq)]
pub enum SymmetricMatrix {
    /// Both triangles.
    Full {
        /// Number of rows and columns.
        n: usize,
        /// n² entries, column by column.
        values: Vec<f64>,
    },
    /// The upper triangle in compressed columns, see [`MatrixView::SparseUpper`].
    Sparse {
        /// Start of each column; n + 1 entries.
        starts: Vec<usize>,
        /// Row of each entry.
        rows: Vec<usize>,
        /// Value of each entry.
        values: Vec<f64>,
    },
}

impl SymmetricMatrix {
    /// Sums up the entries of a sparse matrix, those of one place in their order.
    ///
    /// * `upper`: row, column and value, with the row at most the column.
    #[must_use]
    pub fn sparse(n: usize, mut upper: Vec<(usize, usize, f64)>) -> Self {
        // Stable, so that sums have one order.
        upper.sort_by_key(|(row, column, _)| (*column, *row));
        let (mut starts, mut rows, mut values) = (vec![0; n + 1], Vec::new(), Vec::new());
        for entries in upper.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (row, column, _) = entries[0];
            rows.push(row);
            values.push(entries.iter().map(|(.., value)| value).sum());
            starts[column + 1] = rows.len();
        }
        (0..n).for_each(|j| starts[j + 1] = starts[j + 1].max(starts[j]));
        Self::Sparse { starts, rows, values }
    }

    /// Returns an entry.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Full { n, values } => values[j * n + i],
            Self::Sparse { values, .. } => self.place(i, j).map_or(0.0, |k| values[k]),
        }
    }

    /// Adds to an entry of the diagonal; a sparse matrix without this entry stays as it is.
    pub(crate) fn add_to_diagonal(&mut self, i: usize, value: f64) {
        let place = self.place(i, i);
        match self {
            Self::Full { n, values } => values[i * (*n + 1)] += value,
            Self::Sparse { values, .. } => place.into_iter().for_each(|k| values[k] += value),
        }
    }

    /// The place of an entry among those of a sparse matrix.
    fn place(&self, i: usize, j: usize) -> Option<usize> {
        let Self::Sparse { starts, rows, .. } = self else { return None };
        let (row, column) = (i.min(j), i.max(j));
        let start = starts[column];
        rows[start..starts[column + 1]].binary_search(&row).ok().map(|k| start + k)
    }

    /// Borrows it.
    #[must_use]
    pub fn view(&self) -> MatrixView<'_> {
        match self {
            Self::Full { n, values } => MatrixView::Dense { n: *n, values },
            Self::Sparse { starts, rows, values } => MatrixView::SparseUpper {
                n: starts.len() - 1,
                column_starts: starts,
                row_indices: rows,
                values,
            },
        }
    }
}
