//! Dense Cholesky factors on slices, by faer.
//!
//! A matrix of `n` rows is a slice, column by column. Every call runs on the thread that makes it, so the values do not depend on the
//! number of threads: callers have fronts and bodies to share out.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, MatMut, MatRef, Par};

/// Rows and columns that are mirrored at once, so that both are in the cache.
const MIRRORED: usize = 32;

/// Columns of an inverse that are solved together: a column of `L⁻ᵀ` has no entry below its diagonal.
const TOGETHER: usize = 128;

/// Overwrites the first columns of a symmetric matrix with those of its Cholesky factor: `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`.
///
/// * `columns`: `width` columns of `height` entries, from the diagonal down; entries above it have no meaning before and after.
///
/// # Errors
/// The first pivot that is not positive and finite, from 0.
pub(crate) fn eliminate(columns: &mut [f64], [height, width]: [usize; 2]) -> Result<(), usize> {
    let panel = MatMut::from_column_major_slice_mut(columns, height, width);
    let (mut top, bottom) = panel.split_at_row_mut(width);
    let mut scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut scratch);
    cholesky_in_place(top.as_mut(), Default::default(), Par::Seq, stack, Default::default())
        .map_err(|LltError::NonPositivePivot { index }| index)?;
    solve_lower_triangular_in_place(top.as_ref(), bottom.transpose_mut(), Par::Seq);
    Ok(())
}

/// Computes `U = −L₂₁ L₂₁ᵀ`, lower triangle: the update that a front passes on.
///
/// * `columns`: of [`eliminate`].
/// * `update`: `height − width` rows and columns, not read.
pub(crate) fn update(columns: &[f64], [height, width]: [usize; 2], update: &mut [f64]) {
    let below = MatRef::from_column_major_slice(columns, height, width).split_at_row(width).1;
    let n = height - width;
    let update = MatMut::from_column_major_slice_mut(update, n, n);
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    triangular::matmul(update, lower, Accum::Replace, below, whole, below.transpose(), whole, -1.0, Par::Seq);
}

/// Computes `L Lᵀ`, both triangles.
///
/// * `factor`: L, `n` rows and columns, lower triangle.
///
/// # Panics
/// If it has not `n²` entries.
pub fn square(factor: &[f64], n: usize) -> Vec<f64> {
    times_transpose(factor, n, [BlockStructure::TriangularLower, BlockStructure::TriangularUpper])
}

/// Computes `(L Lᵀ)⁻¹`, both triangles: `L⁻ᵀ` by substitution, which is more accurate than the inverse of `L`, and its product with
/// its transpose.
///
/// * `factor`: L, `n` rows and columns, lower triangle.
pub(crate) fn invert(factor: &[f64], n: usize) -> Vec<f64> {
    let mut transpose = vec![0.0; n * n];
    transpose.iter_mut().step_by(n + 1).for_each(|diagonal| *diagonal = 1.0);
    let upper = MatRef::from_column_major_slice(factor, n, n).transpose();
    for first in (0..n).step_by(TOGETHER) {
        let end = n.min(first + TOGETHER);
        let columns = MatMut::from_column_major_slice_mut(&mut transpose, n, n);
        let columns = columns.submatrix_mut(0, first, end, end - first);
        solve_upper_triangular_in_place(upper.submatrix(0, 0, end, end), columns, Par::Seq);
    }
    times_transpose(&transpose, n, [BlockStructure::TriangularUpper, BlockStructure::TriangularLower])
}

/// Computes `T Tᵀ` of a triangular matrix, both triangles.
///
/// * `structure`: of T and of its transpose.
fn times_transpose(triangle: &[f64], n: usize, [structure, transposed]: [BlockStructure; 2]) -> Vec<f64> {
    let mut square = vec![0.0; n * n];
    let t = MatRef::from_column_major_slice(triangle, n, n);
    let to = MatMut::from_column_major_slice_mut(&mut square, n, n);
    let lower = BlockStructure::TriangularLower;
    triangular::matmul(to, lower, Accum::Replace, t, structure, t.transpose(), transposed, 1.0, Par::Seq);
    mirror(&mut square, n);
    square
}

/// Computes `VᵀL LᵀV`, both triangles.
///
/// * `factor`: L, `n` rows and columns, lower triangle; `columns`: V, column-major.
pub(crate) fn energies(factor: &[f64], n: usize, columns: &[f64]) -> Vec<f64> {
    let count = columns.len() / n.max(1);
    let (mut product, mut energies) = (vec![0.0; n * count], vec![0.0; count * count]);
    let (upper, whole) = (BlockStructure::TriangularUpper, BlockStructure::Rectangular);
    let [l, v] = [(factor, n), (columns, count)].map(|(m, k)| MatRef::from_column_major_slice(m, n, k));
    let x = MatMut::from_column_major_slice_mut(&mut product, n, count);
    triangular::matmul(x, whole, Accum::Replace, l.transpose(), upper, v, whole, 1.0, Par::Seq);
    let x = MatRef::from_column_major_slice(&product, n, count);
    let (to, lower) =
        (MatMut::from_column_major_slice_mut(&mut energies, count, count), BlockStructure::TriangularLower);
    triangular::matmul(to, lower, Accum::Replace, x.transpose(), whole, x, whole, 1.0, Par::Seq);
    mirror(&mut energies, count);
    energies
}

/// Overwrites the upper triangle of a matrix with the transpose of its lower one.
///
/// # Panics
/// If it has not `n²` entries.
pub fn mirror(matrix: &mut [f64], n: usize) {
    for first in (0..n).step_by(MIRRORED) {
        for from in (first..n).step_by(MIRRORED) {
            for j in first..n.min(first + MIRRORED) {
                for i in from.max(j + 1)..n.min(from + MIRRORED) {
                    matrix[i * n + j] = matrix[j * n + i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
