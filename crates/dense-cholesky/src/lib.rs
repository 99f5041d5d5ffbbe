//! Cholesky factors of dense matrices, in place.
//!
//! A matrix of `n` rows is a slice, column by column. [`factorise`] overwrites the first columns of a symmetric positive definite
//! matrix with those of its factor `L`, `A = L Lᵀ`: all of them, or those that a front of a multifrontal factorisation
//! eliminates. [`add_square`] computes what such a front passes on, `−L₂₁ L₂₁ᵀ`; [`forward`] and [`backward`] solve with `L` and
//! `Lᵀ`; [`invert`] computes `A⁻¹`.
//!
//! Only lower triangles are read. What is above the diagonal has no meaning before and after.
//!
//! The work is done by products of blocks, which nalgebra leaves to the kernels of `matrixmultiply`, chosen at run time for the
//! processor. Large ones are shared out to the threads of rayon; the values do not depend on their number.
//!
//! ```
//! let mut a = vec![4.0, 2.0, 2.0, 5.0];
//! dense_cholesky::factorise(&mut a, 2)?;
//! let mut x = vec![8.0, 12.0];
//! dense_cholesky::forward(&a, 2, &mut x);
//! dense_cholesky::backward(&a, 2, &mut x);
//! assert_eq!(x, [1.0, 2.0]);
//! # Ok::<(), dense_cholesky::NotPositiveDefinite>(())
//! ```

mod factor;
mod product;
mod solve;

pub use factor::{NotPositiveDefinite, factorise};
pub use product::{Triangle, add_square, mirror, multiply, square_of_triangle};
pub use solve::{backward, forward, invert};

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

#[cfg(test)]
mod tests;
