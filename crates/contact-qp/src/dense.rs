//! Products of vectors, and small dense systems that may be singular.

use crate::cholesky::{Factor, PIVOT_FLOOR};
use nalgebra::{ColPivQR, DMatrix, DVector, SymmetricEigen};

/// Sweeps for each eigenvalue, of which two or three are usual.
const SWEEPS: usize = 100;

/// Computes `a·b`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Computes `√(v·v)`.
pub(crate) fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// Returns `max |v_i|`; NaN if an entry is NaN, so that it does not count as a small value.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger =
        |most: f64, value: f64| if value.abs() > most || value.is_nan() { value.abs() } else { most };
    values.into_iter().fold(0.0, larger)
}

/// Solves `min |Σ x_j c_j − b|` by a QR factorisation with pivots. Columns that depend on others to round-off are left out.
///
/// * `columns`: c, each as long as `right_side`.
pub(crate) fn least_squares(columns: &[&[f64]], right_side: &[f64]) -> Vec<f64> {
    let qr = ColPivQR::new(DMatrix::from_fn(right_side.len(), columns.len(), |i, j| columns[j][i]));
    let mut rotated = DVector::from_column_slice(right_side);
    qr.q_tr_mul(&mut rotated);
    let r = qr.r();
    let size = |k: usize| r[(k, k)].abs();
    let rank = (0..r.nrows()).take_while(|&k| size(k) > f64::EPSILON * size(0)).count();
    let mut solution = DVector::zeros(columns.len());
    for k in (0..rank).rev() {
        let known: f64 = (k + 1..rank).map(|j| r[(k, j)] * solution[j]).sum();
        solution[k] = (rotated[k] - known) / r[(k, k)];
    }
    qr.p().inv_permute_rows(&mut solution);
    solution.as_slice().to_vec()
}

/// A symmetric positive semi-definite matrix, ready for right-hand sides.
pub(crate) enum SemiDefinite {
    /// Far from singular: `L Lᵀ`, which is many times cheaper than eigenvalues.
    Definite(Factor),
    /// By its eigenvectors and eigenvalues.
    Spectral {
        vectors: Vec<Vec<f64>>,
        values: Vec<f64>,
        /// Eigenvalues up to this one are zero.
        zero: f64,
    },
}

impl SemiDefinite {
    /// Factorises the matrix, or computes its eigenvalues if a pivot may be round-off; `None` if they do not converge.
    ///
    /// * `size`: number of rows; `entry`: of the matrix, by row and column; only the lower triangle is used.
    /// * `dependent`: eigenvalues up to this fraction of the largest one are zero.
    pub(crate) fn new(size: usize, entry: impl Fn(usize, usize) -> f64, dependent: f64) -> Option<Self> {
        let lower: Vec<f64> =
            (0..size * size).map(|k| entry((k % size).max(k / size), (k % size).min(k / size))).collect();
        let floor = PIVOT_FLOOR * largest((0..size).map(|i| lower[i * (size + 1)]));
        let matrix = DMatrix::from_column_slice(size, size, &lower);
        let factor = Factor::new(size, lower).ok();
        if let Some(factor) = factor.filter(|factor| factor.pivots().all(|pivot| pivot * pivot > floor)) {
            return Some(Self::Definite(factor));
        }
        let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, SWEEPS * size)?;
        let vectors = eigen.eigenvectors.column_iter().map(|v| v.iter().copied().collect()).collect();
        let values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        let zero = dependent * values.iter().copied().fold(0.0, f64::max);
        Some(Self::Spectral { vectors, values, zero })
    }

    /// Returns the solution of least norm, and the largest part of the right-hand side along an eigenvector of a zero
    /// eigenvalue, for which there is no solution.
    pub(crate) fn solve(&self, rhs: &[f64]) -> (Vec<f64>, f64) {
        let (vectors, values, zero) = match self {
            Self::Definite(factor) => {
                let mut solution = rhs.to_vec();
                factor.solve(&mut solution);
                return (solution, 0.0);
            }
            Self::Spectral { vectors, values, zero } => (vectors, values, *zero),
        };
        let (mut solution, mut contradiction) = (vec![0.0; rhs.len()], 0.0f64);
        for (vector, value) in vectors.iter().zip(values) {
            let part = dot(vector, rhs);
            if *value <= zero {
                contradiction = contradiction.max(part.abs());
            } else {
                solution.iter_mut().zip(vector).for_each(|(s, v)| *s += v * part / value);
            }
        }
        (solution, contradiction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_with_dependent_columns_have_the_least_residual() {
        let (a, b) = ([1.0, 2.0, 2.0], [0.0, 1.0, -1.0]);
        let doubled = a.map(|x| 2.0 * x);
        let right_side = [3.0, 7.0, 5.0];
        for columns in [vec![&a[..], &b], vec![&a, &doubled, &b], vec![&b, &doubled]] {
            let x = least_squares(&columns, &right_side);
            let left = |i: usize| right_side[i] - columns.iter().zip(&x).map(|(c, x)| c[i] * x).sum::<f64>();
            let left: Vec<f64> = (0..3).map(left).collect();
            assert!(dot(&left, &a).abs() < 1e-13 && dot(&left, &b).abs() < 1e-13, "{left:?}");
        }
        assert!(least_squares(&[], &right_side).is_empty());
    }

    #[test]
    fn a_singular_matrix_has_a_solution_of_least_norm_and_says_what_is_left() {
        // v vᵀ with v = (1, 2).
        let matrix = SemiDefinite::new(2, |i, j| [1.0, 2.0][i] * [1.0, 2.0][j], 1e-12).unwrap();
        let (x, left) = matrix.solve(&[5.0, 10.0]);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14 && left < 1e-14, "{x:?} {left:e}");
        let (x, left) = matrix.solve(&[-2.0, 1.0]);
        assert!(norm(&x) < 1e-14 && (left - 5f64.sqrt()).abs() < 1e-14, "{x:?} {left:e}");
        // Far from singular: the same solution by a factor.
        let matrix = SemiDefinite::new(2, |i, j| if i == j { 2.0 } else { 1.0 }, 1e-12).unwrap();
        assert!(matches!(matrix, SemiDefinite::Definite(_)));
        let (x, left) = matrix.solve(&[4.0, 5.0]);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14 && left == 0.0, "{x:?} {left:e}");
        let nothing = SemiDefinite::new(0, |_, _| 0.0, 1e-12).unwrap();
        assert_eq!(nothing.solve(&[]), (Vec::new(), 0.0));
    }
}
