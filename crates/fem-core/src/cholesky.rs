//! Sparse Cholesky factorisation `K = L Lᵀ` in the given order, by faer's supernodal algorithm.
//!
//! The order is the caller's: [`crate::ordering`] makes a good one, and puts the interface last, so that
//! the trailing block of `L` is the factor of the interface's Schur complement.

use crate::sparse::SymmetricCsc;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError as DenseError, LltRegularization};
use faer::sparse::linalg::cholesky::{
    self as sparse_cholesky, CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, supernodal,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};
use std::sync::Arc;
use thiserror::Error;

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
    /// The matrix is not one.
    #[error("a matrix of dimension {dimension} was refused by the symbolic factorisation: {reason}")]
    Structure {
        /// Dimension of the matrix.
        dimension: usize,
        /// What is wrong.
        reason: String,
    },
}

/// The structure of a factor: it serves every matrix of the same pattern.
#[derive(Clone, Debug)]
pub struct SymbolicCholesky {
    inner: Arc<sparse_cholesky::SymbolicCholesky<u32>>,
    dimension: usize,
}

fn pattern(matrix: &SymmetricCsc) -> SymbolicSparseColMatRef<'_, u32> {
    let n = matrix.dimension();
    SymbolicSparseColMatRef::new_checked(n, n, &matrix.starts, None, &matrix.rows)
}

impl SymbolicCholesky {
    /// Analyses the pattern of a matrix; no reordering takes place.
    ///
    /// # Errors
    /// A factor that does not fit in memory.
    pub fn analyse(matrix: &SymmetricCsc) -> Result<Self, CholeskyError> {
        let dimension = matrix.dimension();
        let params = CholeskySymbolicParams {
            // One layout for every size: the solves below walk supernodes.
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            supernodal_params: SymbolicSupernodalParams::default(),
            ..Default::default()
        };
        // With the identity as its order, faer analyses the upper triangle, whichever side it is told.
        let (starts, rows) = matrix.upper_pattern();
        let inner = sparse_cholesky::factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(dimension, dimension, &starts, None, &rows),
            Side::Upper,
            SymmetricOrdering::Identity,
            params,
        )
        .map_err(|e| match e {
            faer::sparse::FaerError::OutOfMemory => CholeskyError::OutOfMemory { dimension },
            other => CholeskyError::Structure { dimension, reason: format!("{other:?}") },
        })?;
        Ok(Self { inner: Arc::new(inner), dimension })
    }

    /// Returns the number of values the factor stores.
    pub fn stored_values(&self) -> usize {
        self.inner.len_val()
    }

    fn supernodes(&self) -> Option<&supernodal::SymbolicSupernodalCholesky<u32>> {
        match self.inner.raw() {
            SymbolicCholeskyRaw::Supernodal(s) => Some(s),
            SymbolicCholeskyRaw::Simplicial(_) => None,
        }
    }
}

/// The factor `L` of a positive definite matrix.
#[derive(Clone, Debug)]
pub struct Cholesky {
    symbolic: SymbolicCholesky,
    values: Vec<f64>,
}

/// Columns `first..first+width` of `L`: a dense trapezium of the diagonal block and the rows `below`.
struct Supernode<'a> {
    first: usize,
    width: usize,
    below: &'a [u32],
    values: &'a [f64],
}

impl Supernode<'_> {
    /// Returns the stored part of a column, rows of the diagonal block first.
    fn column(&self, k: usize) -> &[f64] {
        let height = self.width + self.below.len();
        &self.values[k * height..(k + 1) * height]
    }
}

impl Cholesky {
    /// Computes the factor of a matrix with the analysed pattern.
    ///
    /// # Errors
    /// A matrix that is not positive definite (with the pivot), or memory that runs out.
    pub fn factorise(symbolic: &SymbolicCholesky, matrix: &SymmetricCsc) -> Result<Self, CholeskyError> {
        let dimension = symbolic.dimension;
        let params = Default::default();
        let scratch = symbolic.inner.factorize_numeric_llt_scratch::<f64>(Par::Seq, params);
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| CholeskyError::OutOfMemory { dimension })?;
        let mut values = Vec::new();
        values
            .try_reserve_exact(symbolic.stored_values())
            .map_err(|_| CholeskyError::OutOfMemory { dimension })?;
        values.resize(symbolic.stored_values(), 0.0);
        symbolic
            .inner
            .factorize_numeric_llt::<f64>(
                &mut values,
                SparseColMatRef::new(pattern(matrix), &matrix.values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                params,
            )
            .map_err(|DenseError::NonPositivePivot { index }| CholeskyError::NotPositiveDefinite {
                pivot: index,
                dimension,
            })?;
        Ok(Self { symbolic: symbolic.clone(), values })
    }

    /// Returns the dimension of the matrix.
    pub fn dimension(&self) -> usize {
        self.symbolic.dimension
    }

    /// Returns the number of values the factor stores.
    pub fn stored_values(&self) -> usize {
        self.values.len()
    }

    /// Finds the pivot `L_jj²` that is smallest against the diagonal entry `K_jj`: its number and that ratio.
    /// A ratio near the machine precision means that the pivot is round-off.
    pub fn smallest_pivot(&self, matrix: &SymmetricCsc) -> (usize, f64) {
        let mut smallest = (0, f64::INFINITY);
        for s in self.supernodes() {
            for k in 0..s.width {
                let j = s.first + k;
                let pivot = s.column(k)[k];
                let ratio = pivot * pivot / matrix.values[matrix.starts[j] as usize];
                if !(ratio >= smallest.1) {
                    smallest = (j, ratio);
                }
            }
        }
        smallest
    }

    fn supernodes(&self) -> impl DoubleEndedIterator<Item = Supernode<'_>> {
        let symbolic = self.symbolic.supernodes();
        let count = symbolic.map_or(0, |s| s.n_supernodes());
        (0..count).filter_map(move |s| {
            let symbolic = symbolic?;
            let first = symbolic.supernode_begin()[s] as usize;
            let width = symbolic.supernode_end()[s] as usize - first;
            let below = symbolic.supernode(s).pattern();
            let start = symbolic.col_ptr_for_val()[s] as usize;
            let values = &self.values[start..start + width * (width + below.len())];
            Some(Supernode { first, width, below, values })
        })
    }

    /// Solves `L y = x` in place.
    ///
    /// # Panics
    /// If `x` is shorter than the dimension.
    pub fn forward(&self, x: &mut [f64]) {
        let mut tail = Vec::new();
        for s in self.supernodes() {
            tail.clear();
            tail.resize(s.below.len(), 0.0);
            for k in 0..s.width {
                let column = s.column(k);
                let (diagonal, below) = column.split_at(s.width);
                let value = x[s.first + k] / diagonal[k];
                x[s.first + k] = value;
                for (xi, l) in x[s.first + k + 1..s.first + s.width].iter_mut().zip(&diagonal[k + 1..]) {
                    *xi -= l * value;
                }
                for (t, l) in tail.iter_mut().zip(below) {
                    *t += l * value;
                }
            }
            for (&row, t) in s.below.iter().zip(&tail) {
                x[row as usize] -= t;
            }
        }
    }

    /// Solves `Lᵀ x = y` in place, with the last `given` entries of `x` already known: then the leading
    /// part solves `L_IIᵀ x_I = y_I − L_CIᵀ x_C`.
    ///
    /// # Panics
    /// If `x` is shorter than the dimension.
    pub fn backward(&self, x: &mut [f64], given: usize) {
        let end = self.dimension() - given;
        let mut tail = Vec::new();
        for s in self.supernodes().rev() {
            let width = s.width.min(end.saturating_sub(s.first));
            if width == 0 {
                continue;
            }
            tail.clear();
            tail.extend(s.below.iter().map(|&row| x[row as usize]));
            for k in (0..width).rev() {
                let column = s.column(k);
                let (diagonal, below) = column.split_at(s.width);
                let inside: f64 = x[s.first + k + 1..s.first + s.width]
                    .iter()
                    .zip(&diagonal[k + 1..])
                    .map(|(x, l)| x * l)
                    .sum();
                let outside: f64 = tail.iter().zip(below).map(|(x, l)| x * l).sum();
                x[s.first + k] = (x[s.first + k] - inside - outside) / diagonal[k];
            }
        }
    }

    /// Solves `K x = b` in place.
    pub fn solve(&self, x: &mut [f64]) {
        self.forward(x);
        self.backward(x, 0);
    }

    /// Returns the trailing `m × m` block of `L`, column-major with zeros above the diagonal.
    pub fn trailing_block(&self, m: usize) -> Vec<f64> {
        let start = self.dimension() - m;
        let mut block = vec![0.0; m * m];
        for s in self.supernodes().filter(|s| s.first + s.width > start) {
            for k in start.saturating_sub(s.first)..s.width {
                let column = s.column(k);
                let j = s.first + k - start;
                for (i, value) in column[k..s.width].iter().enumerate() {
                    block[j * m + j + i] = *value;
                }
                for (&row, value) in s.below.iter().zip(&column[s.width..]) {
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

    /// A random-looking, diagonally dominant band matrix, and the same as a dense one.
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

    #[test]
    fn solves_and_partial_solves_agree_with_the_matrix() {
        let m = sample(40);
        let c = Cholesky::factorise(&SymbolicCholesky::analyse(&m).unwrap(), &m).unwrap();
        let exact: Vec<f64> = (0..40).map(|i| (i as f64).sin()).collect();
        let b = m.multiply(&exact);
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

    #[test]
    fn trailing_block_is_the_factor_of_the_schur_complement() {
        let m = sample(12);
        let c = Cholesky::factorise(&SymbolicCholesky::analyse(&m).unwrap(), &m).unwrap();
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
        let e = Cholesky::factorise(&SymbolicCholesky::analyse(&m).unwrap(), &m).unwrap_err();
        assert_eq!(e, CholeskyError::NotPositiveDefinite { pivot: 9, dimension: 10 });
    }
}
