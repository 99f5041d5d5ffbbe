//! Products of vectors, and small dense systems that may be singular. Besides `cholesky` the only file that uses faer.

use faer::linalg::solvers::{ColPivQr, SolveLstsq};
use faer::{Mat, Side};

/// Computes `a·b`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Computes `√(v·v)`.
pub(crate) fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// Solves `min |Σ x_j c_j − b|` by a QR factorisation with pivots.
///
/// * `columns`: c, each as long as `right_side`.
pub(crate) fn least_squares(columns: &[&[f64]], right_side: &[f64]) -> Vec<f64> {
    let matrix = Mat::from_fn(right_side.len(), columns.len(), |i, j| columns[j][i]);
    let rhs = Mat::from_fn(right_side.len(), 1, |i, _| right_side[i]);
    let solution = ColPivQr::new(matrix.as_ref()).solve_lstsq(rhs.as_ref());
    (0..columns.len()).map(|j| solution[(j, 0)]).collect()
}

/// A small symmetric positive semi-definite matrix, by its eigenvectors and eigenvalues.
pub(crate) struct SemiDefinite {
    vectors: Vec<Vec<f64>>,
    values: Vec<f64>,
    /// Eigenvalues up to this one are zero.
    zero: f64,
}

impl SemiDefinite {
    /// Computes the eigenvalues; `None` if they do not converge.
    ///
    /// * `size`: number of rows; `entry`: of the matrix, by row and column; only the lower triangle is used.
    /// * `dependent`: eigenvalues up to this fraction of the largest one are zero.
    pub(crate) fn new(size: usize, entry: impl Fn(usize, usize) -> f64, dependent: f64) -> Option<Self> {
        if size == 0 {
            return Some(Self { vectors: Vec::new(), values: Vec::new(), zero: 0.0 });
        }
        let eigen = Mat::from_fn(size, size, entry).self_adjoint_eigen(Side::Lower).ok()?;
        let vectors = (0..size).map(|k| (0..size).map(|i| eigen.U()[(i, k)]).collect()).collect();
        let values: Vec<f64> = (0..size).map(|k| eigen.S().column_vector()[k]).collect();
        let zero = dependent * values.iter().copied().fold(0.0, f64::max);
        Some(Self { vectors, values, zero })
    }

    /// Returns the solution of least norm, and the largest part of the right-hand side along an eigenvector of a zero
    /// eigenvalue, for which there is no solution.
    pub(crate) fn solve(&self, rhs: &[f64]) -> (Vec<f64>, f64) {
        let (mut solution, mut contradiction) = (vec![0.0; rhs.len()], 0.0f64);
        for (vector, value) in self.vectors.iter().zip(&self.values) {
            let part = dot(vector, rhs);
            if *value <= self.zero {
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
    fn a_singular_matrix_has_a_solution_of_least_norm_and_says_what_is_left() {
        // v vᵀ with v = (1, 2).
        let matrix = SemiDefinite::new(2, |i, j| [1.0, 2.0][i] * [1.0, 2.0][j], 1e-12).unwrap();
        let (x, left) = matrix.solve(&[5.0, 10.0]);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14 && left < 1e-14, "{x:?} {left:e}");
        let (x, left) = matrix.solve(&[-2.0, 1.0]);
        assert!(norm(&x) < 1e-14 && (left - 5f64.sqrt()).abs() < 1e-14, "{x:?} {left:e}");
        let nothing = SemiDefinite::new(0, |_, _| 0.0, 1e-12).unwrap();
        assert_eq!(nothing.solve(&[]), (Vec::new(), 0.0));
    }
}
