//! Dense matrices: Cholesky factors of fronts and interfaces, and least squares, compiled once for all crates.

pub(crate) mod triangular;

pub use triangular::{mirror, square};

use nalgebra::{DMatrix, DVector};

/// Computes the pseudo-inverse of a matrix; `None` if `zero` is negative.
///
/// * `zero`: singular values up to this are zero.
pub fn pseudo_inverse(matrix: DMatrix<f64>, zero: f64) -> Option<DMatrix<f64>> {
    matrix.pseudo_inverse(zero).ok()
}

/// Computes `(AᵀA)⁻¹ Aᵀ` of a matrix of full column rank by its QR factors; `None` if one of its pivots is zero.
pub fn left_inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (q, r) = matrix.qr().unpack();
    r.solve_upper_triangular(&q.transpose())
}

/// Computes the `x` of least norm among those that minimise `|A x − b|`: 0 if `A` is empty; `None` if `zero` is negative.
///
/// * `zero`: singular values up to this are zero.
pub fn least_squares(matrix: DMatrix<f64>, right: &DVector<f64>, zero: f64) -> Option<DVector<f64>> {
    if matrix.is_empty() {
        return Some(DVector::zeros(matrix.ncols()));
    }
    matrix.svd(true, true).solve(right, zero).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_equations_the_least_solution_is_zero() {
        let found = least_squares(DMatrix::zeros(0, 2), &DVector::zeros(0), 1e-12);
        assert_eq!(found, Some(DVector::zeros(2)));
    }

    #[test]
    fn a_dependent_equation_changes_nothing() {
        let matrix = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 2.0, 2.0, 0.0, 0.0]);
        let right = DVector::from_vec(vec![2.0, 4.0, 1.0]);
        let found = least_squares(matrix.clone(), &right, 1e-12).unwrap();
        assert!((&found - DVector::from_vec(vec![1.0, 1.0])).amax() < 1e-14, "{found}");
        assert!((pseudo_inverse(matrix, 1e-12).unwrap() * right - found).amax() < 1e-14);
    }
}
