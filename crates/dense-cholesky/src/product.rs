//! Products.

use nalgebra::{Const, DMatrixView, DMatrixViewMut, Dyn, U1};
use rayon::prelude::*;

/// Columns of a square that are computed together, from their diagonal down.
const PIECE: usize = 96;
/// Squares of more rows are shared out to all threads.
const LARGE: usize = 512;

/// Rows and columns of a block of a triangle's square.
const TILE: usize = 192;
/// Rows and columns that are mirrored at once, so that both are in the cache.
const MIRRORED: usize = 32;

/// A block, whose columns are slices. Left factors of products have this type: for some sizes nalgebra 0.35 reads beyond the end of a
/// left factor whose rows are not next to each other.
pub(crate) type Block<'a> = DMatrixView<'a, f64, U1, Dyn>;
pub(crate) type BlockMut<'a> = DMatrixViewMut<'a, f64, U1, Dyn>;
/// The transpose of a block.
type Transposed<'a> = DMatrixView<'a, f64, Dyn, U1>;

/// Makes a block of some rows and columns from its first entry on.
pub(crate) fn block(values: &[f64], [rows, columns]: [usize; 2], stride: usize) -> Block<'_> {
    Block::from_slice_with_strides_generic(values, Dyn(rows), Dyn(columns), Const, Dyn(stride))
}

/// As [`block`].
pub(crate) fn block_mut(values: &mut [f64], [rows, columns]: [usize; 2], stride: usize) -> BlockMut<'_> {
    BlockMut::from_slice_with_strides_generic(values, Dyn(rows), Dyn(columns), Const, Dyn(stride))
}

/// Makes the transpose of a block.
fn transposed(values: &[f64], [rows, columns]: [usize; 2], stride: usize) -> Transposed<'_> {
    Transposed::from_slice_with_strides_generic(values, Dyn(columns), Dyn(rows), Dyn(stride), Const)
}

/// Computes the first columns of `C ← β C + α B Bᵀ`, from the diagonal down.
///
/// Entries above the diagonal are overwritten by numbers without meaning, as far as they are in one block with it.
///
/// * `b`: B, column after column, and the distance of two columns.
/// * `[n, k]`: its rows and columns.
/// * `beta`: if it is 0, C is not read.
/// * `c`: C, likewise, `n` rows.
/// * `columns`: to compute, at most `n`.
///
/// # Panics
/// If a slice ends before its last entry.
pub fn add_square(
    alpha: f64,
    (b, stride): (&[f64], usize),
    [n, k]: [usize; 2],
    beta: f64,
    (c, c_stride): (&mut [f64], usize),
    columns: usize,
) {
    let square = Square { alpha, b, stride, k, beta, c_stride };
    square.trapezium(0, n, c, columns);
}

/// A product of a block with its transpose.
#[derive(Clone, Copy)]
struct Square<'a> {
    alpha: f64,
    b: &'a [f64],
    stride: usize,
    k: usize,
    beta: f64,
    c_stride: usize,
}

impl Square<'_> {
    /// Computes some columns from their diagonal down.
    ///
    /// * `first`: the first column's number.
    /// * `c`: from its diagonal entry on.
    fn trapezium(self, first: usize, end: usize, c: &mut [f64], columns: usize) {
        if columns <= PIECE {
            return self.rectangle([first, end], first, c, columns);
        }
        let half = columns / 2;
        let (left, right) = c.split_at_mut(half * self.c_stride);
        let mut left = || {
            self.rectangle([first + half, end], first, &mut left[half..], half);
            self.trapezium(first, first + half, left, half);
        };
        let mut right = || self.trapezium(first + half, end, &mut right[half..], columns - half);
        if end - first > LARGE {
            rayon::join(left, right);
        } else {
            left();
            right();
        }
    }

    /// Computes some rows of some columns.
    ///
    /// * `[from, end]`: the rows; `first`: the first column's number.
    /// * `c`: from the first row of the first column on.
    fn rectangle(self, [from, end]: [usize; 2], first: usize, c: &mut [f64], columns: usize) {
        if from >= end || columns == 0 {
            return;
        }
        if end - from > LARGE && columns > 2 * PIECE {
            let half = columns / 2;
            let (left, right) = c.split_at_mut(half * self.c_stride);
            rayon::join(
                || self.rectangle([from, end], first, left, half),
                || self.rectangle([from, end], first + half, right, columns - half),
            );
            return;
        }
        // Without columns B may have no entry at all.
        let rows_from = |row: usize| if self.k == 0 { &[] } else { &self.b[row..] };
        let left = block(rows_from(from), [end - from, self.k], self.stride);
        let right = transposed(rows_from(first), [columns, self.k], self.stride);
        let mut c = block_mut(c, [end - from, columns], self.c_stride);
        c.gemm(self.alpha, &left, &right, self.beta);
    }
}

/// The kind of a triangular matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Triangle {
    /// Entries above the diagonal are zero.
    Lower,
    /// Entries below the diagonal are zero.
    Upper,
}

/// Computes `T Tᵀ` of a triangular matrix, both triangles, column by column, in `n³/3` operations.
///
/// * `t`: T, `n` rows and columns. Its other triangle is zero.
///
/// # Panics
/// If it has fewer entries.
pub fn square_of_triangle(t: &[f64], n: usize, triangle: Triangle) -> Vec<f64> {
    let mut square = vec![0.0; n * n];
    square.par_chunks_mut((n * TILE).max(1)).enumerate().for_each(|(stripe, c)| {
        let (first, columns) = (stripe * TILE, c.len() / n);
        for from in (first..n).step_by(TILE) {
            let rows = TILE.min(n - from);
            // The columns of T in which both its rows and those of its transpose have entries.
            let terms = match triangle {
                Triangle::Lower => 0..first + columns,
                Triangle::Upper => from..n,
            };
            let (start, k) = (terms.start * n, terms.len());
            let left = block(&t[start + from..], [rows, k], n);
            let right = transposed(&t[start + first..], [columns, k], n);
            block_mut(&mut c[from..], [rows, columns], n).gemm(1.0, &left, &right, 0.0);
        }
    });
    mirror(&mut square, n);
    square
}

/// Overwrites the upper triangle of a matrix with the transpose of its lower one.
///
/// * `matrix`: column by column, `n` rows and columns.
///
/// # Panics
/// If it has fewer entries.
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

/// Computes `y = A x`.
///
/// * `matrix`: A, column after column, `y.len()` rows and `x.len()` columns.
///
/// # Panics
/// If it has fewer columns.
pub fn multiply(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    pulp::Arch::new().dispatch(MatrixVector { matrix, x, y });
}

/// A matrix times a vector, for [`pulp`] to compile for every kind of processor.
struct MatrixVector<'a> {
    matrix: &'a [f64],
    x: &'a [f64],
    y: &'a mut [f64],
}

impl pulp::NullaryFnOnce for MatrixVector<'_> {
    type Output = ();

    /// Four columns at once, so that `y` is read and written less often.
    #[inline(always)]
    fn call(self) {
        let Self { matrix, x, y } = self;
        let n = y.len();
        y.fill(0.0);
        let (fours, rest) = x.as_chunks::<4>();
        let (first, last) = matrix.split_at(4 * fours.len() * n);
        for (columns, x) in first.chunks_exact((4 * n).max(1)).zip(fours) {
            let (a, others) = columns.split_at(n);
            let (b, others) = others.split_at(n);
            let (c, d) = others.split_at(n);
            for i in 0..n {
                y[i] += (a[i] * x[0] + b[i] * x[1]) + (c[i] * x[2] + d[i] * x[3]);
            }
        }
        for (column, x) in last.chunks_exact(n.max(1)).zip(rest) {
            y.iter_mut().zip(column).for_each(|(y, a)| *y += a * x);
        }
    }
}
