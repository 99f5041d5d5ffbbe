//! Small symmetric matrices: stiffnesses, and products of rigid motions.

use super::Item;
use nalgebra::{Matrix3, Matrix6};
use std::ops::{Index, IndexMut};

/// A square matrix that multiplies arrays `V`.
pub trait Matrix<V>: Item + Default + Index<(usize, usize), Output = f64> + IndexMut<(usize, usize)> {
    /// Multiplies an array.
    fn times(&self, v: &V) -> V;
    /// Adds the matrix `v vᵀ`.
    fn add_square(&mut self, v: &V);
    /// Computes the eigenvalues of a symmetric matrix, each with its unit vector.
    fn eigen(&self) -> Vec<(f64, V)>;
    /// Returns the largest magnitude of an entry.
    fn largest(&self) -> f64;
    /// Computes the inverse; `None` if the matrix is singular.
    fn inverse(&self) -> Option<Self>;
}

macro_rules! matrix {
    ($matrix:ident, $n:literal) => {
        impl Matrix<[f64; $n]> for $matrix<f64> {
            #[inline(always)]
            fn times(&self, v: &[f64; $n]) -> [f64; $n] {
                std::array::from_fn(|i| {
                    let mut sum = self[(i, 0)] * v[0];
                    for j in 1..$n {
                        sum += self[(i, j)] * v[j];
                    }
                    sum
                })
            }

            fn add_square(&mut self, v: &[f64; $n]) {
                *self += Self::from_fn(|i, j| v[i] * v[j]);
            }

            fn eigen(&self) -> Vec<(f64, [f64; $n])> {
                let eigen = self.symmetric_eigen();
                let vector = |k: usize| std::array::from_fn(|i| eigen.eigenvectors[(i, k)]);
                (0..$n).map(|k| (eigen.eigenvalues[k], vector(k))).collect()
            }

            fn largest(&self) -> f64 {
                self.amax()
            }

            fn inverse(&self) -> Option<Self> {
                self.try_inverse()
            }
        }
    };
}

matrix!(Matrix3, 3);
matrix!(Matrix6, 6);
