//! Rows most of whose entries are zero, and the factor of `G S Gᵀ + ρ I`.

use crate::error::QpError;
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};

/// The rows of a sparse matrix, entries in the order of their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseRows {
    columns: usize,
    /// End of each row among the entries.
    ends: Vec<usize>,
    places: Vec<usize>,
    values: Vec<f64>,
}

impl SparseRows {
    /// Makes a matrix without rows.
    pub fn new(columns: usize) -> Self {
        Self { columns, ..Self::default() }
    }

    /// Takes the entries of a full matrix that are not zero, row after row.
    pub fn from_dense(columns: usize, rows: &[f64]) -> Self {
        let mut sparse = Self::new(columns);
        rows.chunks_exact(columns.max(1)).for_each(|row| sparse.push(row.iter().copied().enumerate()));
        sparse
    }

    /// Appends a row: entries with their columns, in ascending order. Zeros are left out.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (usize, f64)>) {
        for (place, value) in entries.into_iter().filter(|(_, value)| *value != 0.0) {
            self.places.push(place);
            self.values.push(value);
        }
        self.ends.push(self.values.len());
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns all entries that are not zero, row after row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Lists the entries of a row with their columns.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        let entries = start..self.ends[k];
        self.places[entries.clone()].iter().copied().zip(self.values[entries].iter().copied())
    }

    /// Lists all rows.
    pub fn rows(&self) -> impl Iterator<Item = impl Iterator<Item = (usize, f64)> + '_> + '_ {
        (0..self.len()).map(|k| self.row(k))
    }

    /// Computes `G x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        self.rows().map(|row| row.map(|(j, g)| g * x[j]).sum()).collect()
    }

    /// Computes `Gᵀ a`.
    pub fn transposed_times(&self, a: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.columns];
        for (row, a) in self.rows().zip(a).filter(|(_, a)| **a != 0.0) {
            row.for_each(|(j, g)| sum[j] += g * a);
        }
        sum
    }

    /// Takes some rows.
    #[must_use]
    pub fn select(&self, rows: &[usize]) -> Self {
        let mut chosen = Self::new(self.columns);
        rows.iter().for_each(|k| chosen.push(self.row(*k)));
        chosen
    }

    /// Multiplies every row by a factor.
    #[must_use]
    pub(crate) fn with_scaled_rows(mut self, factors: &[f64]) -> Self {
        let mut start = 0;
        for (end, factor) in self.ends.iter().zip(factors) {
            self.values[start..*end].iter_mut().for_each(|value| *value *= factor);
            start = *end;
        }
        self
    }

    /// Returns `Gᵀ`.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut next = vec![0; self.columns + 1];
        self.places.iter().for_each(|j| next[j + 1] += 1);
        (0..self.columns).for_each(|j| next[j + 1] += next[j]);
        let ends = next[1..].to_vec();
        let (mut places, mut values) = (vec![0; self.values.len()], vec![0.0; self.values.len()]);
        for (k, row) in self.rows().enumerate() {
            for (j, g) in row {
                (places[next[j]], values[next[j]]) = (k, g);
                next[j] += 1;
            }
        }
        Self { columns: self.len(), ends, places, values }
    }

    /// Returns the full matrix, row after row.
    pub fn dense(&self) -> Vec<f64> {
        let mut rows = vec![0.0; self.len() * self.columns];
        for (k, row) in self.rows().enumerate() {
            row.for_each(|(j, g)| rows[k * self.columns + j] = g);
        }
        rows
    }
}

/// The upper triangle of a symmetric matrix in compressed columns, from entries in any order; equal places are summed.
pub(crate) fn compressed(n: usize, mut entries: Vec<(usize, usize, f64)>) -> CscMatrix<f64> {
    entries.sort_by_key(|(i, j, _)| (*j, *i));
    let (mut starts, mut rows, mut values) = (vec![0; n + 1], Vec::new(), Vec::new());
    let mut last = None;
    for (i, j, value) in entries {
        if last == Some((i, j)) {
            if let Some(sum) = values.last_mut() {
                *sum += value;
            }
            continue;
        }
        last = Some((i, j));
        rows.push(i);
        values.push(value);
        starts[j + 1] = values.len();
    }
    for j in 0..n {
        starts[j + 1] = starts[j + 1].max(starts[j]);
    }
    CscMatrix::new(n, n, starts, rows, values)
}

/// `L D Lᵀ` of a sparse symmetric matrix, positive definite or quasi-definite, in an approximate minimum degree order.
/// `None` of a matrix without rows, which the library does not take.
pub(crate) struct SparseFactor(Option<QDLDLFactorisation>);

impl SparseFactor {
    /// Factorises; pivots must be positive in the first rows and negative in the last `negative` ones.
    ///
    /// # Errors
    /// [`QpError::Library`] if a pivot is zero.
    pub(crate) fn quasi_definite(matrix: &CscMatrix<f64>, negative: usize) -> Result<Self, QpError> {
        let n = matrix.n;
        let signs = (0..n).map(|i| if i + negative < n { 1 } else { -1 }).collect();
        let settings =
            QDLDLSettings { Dsigns: Some(signs), regularize_enable: false, ..QDLDLSettings::default() };
        Self::new(matrix, settings)
    }

    fn new(matrix: &CscMatrix<f64>, settings: QDLDLSettings<f64>) -> Result<Self, QpError> {
        if matrix.n == 0 {
            return Ok(Self(None));
        }
        QDLDLFactorisation::new(matrix, Some(settings))
            .map(|factor| Self(Some(factor)))
            .map_err(|error| QpError::Library { library: "clarabel", message: error.to_string() })
    }

    /// Lists the unknowns that were left out, in ascending order.
    pub(crate) fn left_out(&self) -> Vec<usize> {
        let Self(Some(factor)) = self else { return Vec::new() };
        let infinite = factor.D.iter().zip(&factor.perm).filter(|(pivot, _)| !pivot.is_finite());
        let mut unknowns: Vec<usize> = infinite.map(|(_, unknown)| *unknown).collect();
        unknowns.sort_unstable();
        unknowns
    }

    /// Overwrites a right-hand side with the solution.
    pub(crate) fn solve(&self, rhs: &mut [f64]) {
        if let Self(Some(factor)) = self {
            solve_sparse(factor, rhs);
        }
    }
}

/// Solves with `L D Lᵀ` and its order. Clarabel's own function needs the factor for itself.
fn solve_sparse(factor: &QDLDLFactorisation, rhs: &mut [f64]) {
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

/// `G S Gᵀ + ρ I` for any diagonal `S`, in one order.
#[derive(Debug)]
pub(crate) struct Normal {
    size: usize,
    /// The products of the entries of each column of `G`, with their place among the values.
    products: Vec<(usize, usize, f64)>,
    diagonal: Vec<usize>,
    matrix: CscMatrix<f64>,
    order: Option<Vec<usize>>,
}

impl Normal {
    /// * `columns`: `Gᵀ`.
    pub(crate) fn new(columns: &SparseRows) -> Self {
        let size = columns.columns();
        let mut entries: Vec<(usize, usize, usize, f64)> = Vec::new();
        for (column, entries_of) in columns.rows().enumerate() {
            let of_column: Vec<(usize, f64)> = entries_of.collect();
            for (k, (j, b)) in of_column.iter().enumerate() {
                entries.extend(of_column[..=k].iter().map(|(i, a)| (*i, *j, column, a * b)));
            }
        }
        let all = entries.iter().map(|(i, j, ..)| (*i, *j, 0.0)).chain((0..size).map(|i| (i, i, 0.0)));
        let matrix = compressed(size, all.collect());
        let place = |i: usize, j: usize| {
            let start = matrix.colptr[j];
            start + matrix.rowval[start..matrix.colptr[j + 1]].partition_point(|row| *row < i)
        };
        let products =
            entries.into_iter().map(|(i, j, column, value)| (column, place(i, j), value)).collect();
        let diagonal = (0..size).map(|i| place(i, i)).collect();
        Self { size, products, diagonal, matrix, order: None }
    }

    /// Computes the matrix.
    fn assemble(&mut self, weights: &[f64], added: f64) {
        self.matrix.nzval.fill(0.0);
        for (column, place, value) in &self.products {
            self.matrix.nzval[*place] += weights[*column] * value;
        }
        self.diagonal.iter().for_each(|place| self.matrix.nzval[*place] += added);
    }

    /// Factorises the matrix.
    ///
    /// * `weights`: the diagonal of `S`, not negative; `added`: `ρ`; unknowns whose pivots are at most `zero` are left out: a solution has zeros there.
    pub(crate) fn factorise(
        &mut self,
        weights: &[f64],
        added: f64,
        zero: f64,
    ) -> Result<SparseFactor, QpError> {
        self.assemble(weights, added);
        let settings = QDLDLSettings {
            regularize_eps: zero,
            regularize_delta: f64::INFINITY,
            perm: self.order.clone(),
            ..QDLDLSettings::default()
        };
        let factor = SparseFactor::new(&self.matrix, settings)?;
        if self.order.is_none() {
            self.order = factor.0.as_ref().map(|factor| factor.perm.clone());
        }
        Ok(factor)
    }

    /// Returns the mean of the diagonal of `G S Gᵀ`.
    pub(crate) fn mean_diagonal(&mut self, weights: &[f64]) -> f64 {
        self.assemble(weights, 0.0);
        self.diagonal.iter().map(|place| self.matrix.nzval[*place]).sum::<f64>() / self.size.max(1) as f64
    }
}
