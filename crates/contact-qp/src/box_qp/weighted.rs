//! A full matrix with weighted rows added, `P + c GᵀG`: by its entries, since few of them differ from those of `P`.

use crate::sparse::SparseRows;

/// No row of the block.
const OUTSIDE: usize = usize::MAX;

/// `P + c GᵀG`.
pub(super) struct Weighted<'a> {
    n: usize,
    /// `P`, column by column.
    values: &'a [f64],
    /// `G`, and its columns.
    rows: SparseRows,
    columns: SparseRows,
    /// `c`.
    weight: f64,
}

impl<'a> Weighted<'a> {
    pub(super) fn new(n: usize, values: &'a [f64], rows: SparseRows, weight: f64) -> Self {
        Self { n, values, columns: rows.transposed(), rows, weight }
    }

    /// Returns the number of rows and columns of the matrix.
    pub(super) fn size(&self) -> usize {
        self.n
    }

    /// Returns `G`.
    pub(super) fn rows(&self) -> &SparseRows {
        &self.rows
    }

    /// Returns `c`.
    pub(super) fn weight(&self) -> f64 {
        self.weight
    }

    /// Returns an entry of the diagonal.
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        self.columns.row(i).fold(self.values[i * (self.n + 1)], |sum, (_, g)| sum + self.weight * g * g)
    }

    /// Passes what the rows add to a column to a function.
    fn added(&self, j: usize, mut add: impl FnMut(usize, f64)) {
        for (k, g) in self.columns.row(j) {
            self.rows.row(k).for_each(|(i, other)| add(i, self.weight * g * other));
        }
    }

    /// Returns a column.
    pub(super) fn column(&self, j: usize) -> Vec<f64> {
        let mut column = self.values[j * self.n..(j + 1) * self.n].to_vec();
        self.added(j, |i, value| column[i] += value);
        column
    }

    /// Returns the rows and columns `block` (sorted, unique), column by column; only the lower triangle is filled.
    pub(super) fn lower(&self, block: &[usize]) -> Vec<f64> {
        let size = block.len();
        let mut lower = vec![0.0; size * size];
        let mut place = vec![OUTSIDE; self.n];
        block.iter().enumerate().for_each(|(k, i)| place[*i] = k);
        for ((k, j), column) in block.iter().enumerate().zip(lower.chunks_exact_mut(size.max(1))) {
            let source = &self.values[j * self.n..(j + 1) * self.n];
            column[k..].iter_mut().zip(&block[k..]).for_each(|(to, i)| *to = source[*i]);
            self.added(*j, |i, value| {
                if place[i] != OUTSIDE && place[i] >= k {
                    column[place[i]] += value;
                }
            });
        }
        lower
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_those_of_the_full_matrix() {
        let (n, weight) = (7, 2.5);
        let values: Vec<f64> = (0..n * n).map(|k| ((k % n) as f64 - (k / n) as f64).cos()).collect();
        // The rows meet in column 3; columns 2 and 6 have none.
        let full = [[1.0, -2.0, 0.0, 0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 3.0, -1.0, 0.25, 0.0]];
        let entry = |i: usize, j: usize| {
            values[j * n + i] + full.iter().map(|row| weight * row[i] * row[j]).sum::<f64>()
        };
        let matrix = Weighted::new(n, &values, SparseRows::from_dense(n, full.as_flattened()), weight);
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        let block = [0, 1, 3, 5, 6];
        let lower = matrix.lower(&block);
        for (k, j) in block.into_iter().enumerate() {
            is(matrix.diagonal(j), entry(j, j));
            matrix.column(j).iter().enumerate().for_each(|(i, found)| is(*found, entry(i, j)));
            (k..block.len()).for_each(|l| is(lower[k * block.len() + l], entry(block[l], j)));
        }
    }
}
