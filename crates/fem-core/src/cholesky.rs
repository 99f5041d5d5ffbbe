//! Sparse Cholesky factorisation `K = L Lᵀ` in a given order: the multifrontal method on a given tree.
//!
//! The caller gives the order: [`crate::ordering`] computes a good one with the interface last, so that
//! the trailing block of `L` is the factor of the interface's Schur complement. faer does the dense
//! algebra of the fronts; independent subtrees are factorised in parallel.

mod numeric;
mod substitution;
mod symbolic;
mod workspace;

use crate::sparse::SymmetricCsc;
use std::sync::Arc;
use thiserror::Error;

pub use symbolic::{Front, SymbolicCholesky};

/// Why a matrix could not be factorised.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CholeskyError {
    /// A pivot is not positive: the matrix is not positive definite.
    #[error("pivot {pivot} of {dimension} is not positive: the stiffness is not positive definite")]
    NotPositiveDefinite {
        /// Number of the pivot in the order of elimination, from 0.
        pivot: usize,
        /// Dimension of the matrix.
        dimension: usize,
    },
    /// The factor does not fit in memory.
    #[error("the factor of a matrix of dimension {dimension} does not fit in memory")]
    OutOfMemory {
        /// Dimension of the matrix.
        dimension: usize,
    },
    /// The tree does not belong to the matrix.
    #[error("the elimination tree does not belong to the matrix of dimension {dimension}: {reason}")]
    Tree {
        /// Dimension of the matrix.
        dimension: usize,
        /// The property that the data lack.
        reason: &'static str,
    },
}

/// The factor `L` of a positive definite matrix.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: Arc<SymbolicCholesky>,
    values: Vec<f64>,
    smallest: workspace::SmallestPivot,
}

/// Columns `first..first+width` of `L`: a dense trapezium of the lower diagonal block and the rows `below`.
struct Panel<'a> {
    first: usize,
    width: usize,
    below: &'a [u32],
    values: &'a [f64],
}

impl<'a> Panel<'a> {
    /// Returns a column: its pivot, the rest of the diagonal block's rows, and the rows below.
    #[inline(always)]
    fn column(&self, k: usize) -> (f64, &'a [f64], &'a [f64]) {
        let height = self.width + self.below.len();
        let start = symbolic::column_start(k, height);
        let (inside, below) = self.values[start..start + height - k].split_at(self.width - k);
        (inside[0], &inside[1..], below)
    }
}

impl Cholesky {
    /// Computes the factor of a matrix with the analysed pattern.
    ///
    /// # Errors
    /// A matrix that is not positive definite (with the pivot), or too little memory.
    pub fn factorise(symbolic: Arc<SymbolicCholesky>, matrix: &SymmetricCsc) -> Result<Self, CholeskyError> {
        let (values, smallest) = numeric::factorise(&symbolic, matrix)?;
        Ok(Self { symbolic, values, smallest })
    }

    /// Analyses and factorises a matrix in one call.
    ///
    /// # Errors
    /// See [`SymbolicCholesky::analyse`] and [`Self::factorise`].
    pub fn new(matrix: &SymmetricCsc, fronts: &[Front]) -> Result<Self, CholeskyError> {
        Self::factorise(Arc::new(SymbolicCholesky::analyse(matrix, fronts)?), matrix)
    }

    /// Returns the dimension of the matrix.
    pub fn dimension(&self) -> usize {
        self.symbolic.dimension()
    }

    /// Returns the number of values the factor stores.
    pub fn stored_values(&self) -> usize {
        self.values.len()
    }

    /// Returns the pivot `L_jj²` that is smallest relative to the diagonal entry `K_jj`: its number and that ratio.
    /// A ratio near the machine precision means that the pivot is round-off.
    pub fn smallest_pivot(&self) -> (usize, f64) {
        (self.smallest.pivot, self.smallest.ratio)
    }

    /// Lists the panels with the columns from `start`, each with the number of its columns before.
    fn panels_from(&self, start: usize) -> impl DoubleEndedIterator<Item = (Panel<'_>, usize)> {
        let layouts = self.symbolic.layouts();
        let from = layouts.partition_point(|of| of.first + of.width <= start);
        layouts[from..].iter().map(move |layout| {
            let (first, width) = (layout.first, layout.width);
            let below = self.symbolic.below(layout);
            let panel = Panel { first, width, below, values: &self.values[layout.values.clone()] };
            (panel, start.saturating_sub(first))
        })
    }

    /// Returns the first of the last columns of `L`.
    fn first_of_last(&self, count: usize) -> usize {
        assert!(count <= self.dimension(), "{count} entries for {} unknowns", self.dimension());
        self.dimension() - count
    }

    /// Solves `L y = x` in place: of a shorter `x` with the last columns of `L` alone.
    ///
    /// # Panics
    /// If `x` is longer than the dimension.
    pub fn forward(&self, x: &mut [f64]) {
        let start = self.first_of_last(x.len());
        pulp::Arch::new().dispatch(substitution::Forward { factor: self, columns: &mut [x], start });
    }

    /// [`Self::forward`] for several right-hand sides of full length: it reads the factor once.
    ///
    /// # Panics
    /// If a column is shorter than the dimension.
    pub(crate) fn forward_all(&self, columns: &mut [&mut [f64]]) {
        pulp::Arch::new().dispatch(substitution::Forward { factor: self, columns, start: 0 });
    }

    /// Solves `Lᵀ x = y` in place, with the last `given` entries of `x` already known: then the leading
    /// part solves `L_IIᵀ x_I = y_I − L_CIᵀ x_C`. Of a shorter `x` with the last columns of `L` alone.
    ///
    /// # Panics
    /// If `x` is longer than the dimension.
    pub(crate) fn backward(&self, x: &mut [f64], given: usize) {
        let (start, end) = (self.first_of_last(x.len()), self.dimension() - given);
        pulp::Arch::new().dispatch(substitution::Backward { factor: self, x, start, end });
    }

    /// Solves `K x = b` in place.
    ///
    /// # Panics
    /// If `x` has not one entry per unknown.
    pub fn solve(&self, x: &mut [f64]) {
        assert!(x.len() == self.dimension(), "{} entries for {} unknowns", x.len(), self.dimension());
        self.forward(x);
        self.backward(x, 0);
    }

    /// Computes `L x` with the last columns of `L`, as many as `x` has entries.
    ///
    /// # Panics
    /// If `x` is longer than the dimension.
    pub(crate) fn product(&self, x: &[f64]) -> Vec<f64> {
        let (start, mut product) = (self.first_of_last(x.len()), vec![0.0; x.len()]);
        pulp::Arch::new().dispatch(substitution::Product { factor: self, x, product: &mut product, start });
        product
    }

    /// Computes `Lᵀ x` in place with the last columns of `L`, as many as `x` has entries.
    ///
    /// # Panics
    /// If `x` is longer than the dimension.
    pub(crate) fn transposed_product(&self, x: &mut [f64]) {
        let start = self.first_of_last(x.len());
        pulp::Arch::new().dispatch(substitution::TransposedProduct { factor: self, x, start });
    }

    /// Computes the sums of squares of the last `m` rows of `L`, each over the last `m` columns.
    pub(crate) fn trailing_squares(&self, m: usize) -> Vec<f64> {
        let start = self.dimension() - m;
        let mut squares = vec![0.0; m];
        for (panel, skipped) in self.panels_from(start) {
            for k in skipped..panel.width {
                let (pivot, inside, below) = panel.column(k);
                let own = &mut squares[panel.first + k - start..];
                own[0] += pivot * pivot;
                own[1..].iter_mut().zip(inside).for_each(|(sum, l)| *sum += l * l);
                for (&row, l) in panel.below.iter().zip(below) {
                    squares[row as usize - start] += l * l;
                }
            }
        }
        squares
    }

    /// Returns the trailing `m × m` block of `L`, column-major with zeros above the diagonal.
    pub fn trailing_block(&self, m: usize) -> Vec<f64> {
        let start = self.dimension() - m;
        let mut block = vec![0.0; m * m];
        for (panel, skipped) in self.panels_from(start) {
            for k in skipped..panel.width {
                let (pivot, inside, below) = panel.column(k);
                let j = panel.first + k - start;
                block[j * m + j] = pivot;
                block[j * m + j + 1..j * m + j + 1 + inside.len()].copy_from_slice(inside);
                for (&row, value) in panel.below.iter().zip(below) {
                    block[j * m + row as usize - start] = *value;
                }
            }
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordering::ROOT;

    /// A random-looking, diagonally dominant band matrix.
    fn sample(n: usize) -> SymmetricCsc {
        let mut m = SymmetricCsc { starts: vec![0], rows: vec![], values: vec![] };
        for j in 0..n {
            for i in [j, j + 1, j + 3].into_iter().filter(|&i| i < n) {
                m.rows.push(i as u32);
                m.values.push(if i == j { 5.0 + j as f64 } else { 1.0 / (1.0 + i as f64) - 0.8 });
            }
            m.starts.push(m.rows.len() as u32);
        }
        m
    }

    /// A chain of fronts of the given widths.
    fn chain(widths: &[u32]) -> Vec<Front> {
        let mut first = 0;
        let count = widths.len() as u32;
        (0..count)
            .zip(widths)
            .map(|(k, &width)| {
                let columns = first..first + width;
                first += width;
                Front { columns, parent: if k + 1 < count { k + 1 } else { ROOT } }
            })
            .collect()
    }

    #[test]
    fn solves_and_partial_solves_agree_with_the_matrix() {
        let m = sample(40);
        for widths in [vec![40], vec![1; 40], vec![7, 3, 20, 10]] {
            let c = Cholesky::new(&m, &chain(&widths)).unwrap();
            let exact: Vec<f64> = (0..40).map(|i| f64::from(i).sin()).collect();
            let b = m.multiply(&exact);
            let (pivot, ratio) = c.smallest_pivot();
            let own = |j: usize| m.values[m.starts[j] as usize];
            let l = c.trailing_block(40);
            let ratios: Vec<f64> = (0..40).map(|j| l[j * 41] * l[j * 41] / own(j)).collect();
            assert!(ratios[pivot] == ratio && ratios.iter().all(|r| *r >= ratio));
            let mut x = b.clone();
            c.solve(&mut x);
            for (a, e) in x.iter().zip(&exact) {
                assert!((a - e).abs() < 1e-14);
            }
            // With the last ten given, the leading part of the solution follows.
            let mut y = b;
            c.forward(&mut y);
            y[30..].copy_from_slice(&exact[30..]);
            c.backward(&mut y, 10);
            for (a, e) in y.iter().zip(&exact) {
                assert!((a - e).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_last_columns_are_a_factor_of_their_own() {
        let matrix = sample(40);
        for widths in [vec![40], vec![1; 40], vec![7, 3, 20, 10]] {
            let c = Cholesky::new(&matrix, &chain(&widths)).unwrap();
            for m in [0, 1, 9, 10, 17, 30, 40] {
                let l = nalgebra::DMatrix::from_vec(m, m, c.trailing_block(m));
                let x = nalgebra::DVector::from_fn(m, |i, _| (3.0 * i as f64).cos());
                let near = |found: &[f64], expected: &nalgebra::DVector<f64>| {
                    assert_eq!(found.len(), m);
                    found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-13, "{a} {b}"));
                };
                near(&c.product(x.as_slice()), &(&l * &x));
                let mut product = x.as_slice().to_vec();
                c.transposed_product(&mut product);
                near(&product, &l.tr_mul(&x));
                near(&c.trailing_squares(m), &(&l * l.transpose()).diagonal());
                let mut solution = (&l * &x).as_slice().to_vec();
                c.forward(&mut solution);
                near(&solution, &x);
                let mut solution = l.tr_mul(&x).as_slice().to_vec();
                c.backward(&mut solution, 0);
                near(&solution, &x);
            }
        }
    }

    #[test]
    fn several_columns_are_solved_as_each_alone() {
        let m = sample(40);
        let c = Cholesky::new(&m, &chain(&[7, 3, 20, 10])).unwrap();
        let columns: Vec<Vec<f64>> =
            (1..4).map(|k| (0..40).map(|i| f64::from(k * i).cos()).collect()).collect();
        let (mut all, mut alone) = (columns.clone(), columns);
        c.forward_all(&mut all.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
        alone.iter_mut().for_each(|x| c.forward(x));
        assert_eq!(all, alone);
    }

    #[test]
    fn trailing_block_is_the_factor_of_the_schur_complement() {
        let m = sample(12);
        let c = Cholesky::new(&m, &chain(&[5, 7])).unwrap();
        let l = nalgebra::DMatrix::from_vec(4, 4, c.trailing_block(4));
        let mut dense = nalgebra::DMatrix::zeros(12, 12);
        for j in 0..12 {
            for (i, a) in m.column(j) {
                dense[(i, j)] = a;
                dense[(j, i)] = a;
            }
        }
        let interior = dense.view((0, 0), (8, 8)).clone_owned().try_inverse().unwrap();
        let coupling = dense.view((8, 0), (4, 8));
        let schur = dense.view((8, 8), (4, 4)) - coupling * interior * coupling.transpose();
        assert!((&l * l.transpose() - schur).amax() < 1e-13);
    }

    #[test]
    fn an_indefinite_matrix_is_refused_with_its_pivot() {
        let mut m = sample(10);
        let last = m.values.len() - 1;
        m.values[last] = -3.0;
        for widths in [vec![10], vec![1; 10], vec![4, 6]] {
            let e = Cholesky::new(&m, &chain(&widths)).unwrap_err();
            assert_eq!(e, CholeskyError::NotPositiveDefinite { pivot: 9, dimension: 10 });
        }
    }

    #[test]
    fn a_branch_that_fails_leaves_the_other_one_alone() {
        // Two branches of two fronts below a root; everything in a branch couples, and with the root. Indefinite in the first branch.
        let branch = |i: usize| i / 20;
        let mut m = SymmetricCsc { starts: vec![0], rows: vec![], values: vec![] };
        for j in 0..50 {
            for i in (j..50).filter(|i| branch(*i) == branch(j) || *i >= 40) {
                m.rows.push(i as u32);
                m.values.push(match (i == j, i) {
                    (true, 15) => -1.0,
                    (true, _) => 60.0,
                    (false, _) => 1.0 / (1.0 + (i - j) as f64),
                });
            }
            m.starts.push(m.rows.len() as u32);
        }
        let front = |k: u32, parent| Front { columns: 10 * k..10 * (k + 1), parent };
        let fronts = [front(0, 1), front(1, 4), front(2, 3), front(3, 4), front(4, ROOT)];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let over = std::sync::atomic::AtomicBool::new(false);
        let order = std::sync::atomic::Ordering::SeqCst;
        // The other thread is busy, so that one thread does both branches.
        let (found, ()) = pool.install(|| {
            rayon::join(
                || {
                    let found = Cholesky::new(&m, &fronts);
                    over.store(true, order);
                    found
                },
                || {
                    while !over.load(order) {
                        std::hint::spin_loop();
                    }
                },
            )
        });
        assert_eq!(found.unwrap_err(), CholeskyError::NotPositiveDefinite { pivot: 15, dimension: 50 });
    }

    #[test]
    fn a_tree_of_another_matrix_is_refused() {
        let m = sample(10);
        assert!(matches!(Cholesky::new(&m, &chain(&[9])), Err(CholeskyError::Tree { .. })));
        // Two roots are invalid for a matrix that couples them.
        let split = vec![Front { columns: 0..5, parent: ROOT }, Front { columns: 5..10, parent: ROOT }];
        assert!(matches!(Cholesky::new(&m, &split), Err(CholeskyError::Tree { .. })));
    }
}
