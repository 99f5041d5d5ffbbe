//! Solutions with a factor and its transpose.

use crate::product::{Block, BlockMut, Triangle, block, block_mut, square_of_triangle};
use rayon::prelude::*;

/// Fewer right-hand sides are solved for one by one.
pub(crate) const FEW: usize = 4;
/// Rows of a factor that are solved for without products of blocks.
const BLOCK: usize = 48;
/// Right-hand sides that one thread solves for at once. Fewer would use the cache worse.
pub(crate) const SHARE: usize = 48;
/// The same of many right-hand sides: the factor is brought into the order of the products less often.
const LARGE_SHARE: usize = 192;
/// Right-hand sides from which on they are many.
const MANY: usize = 8 * LARGE_SHARE;

/// Solves `L y = x` in place, for every column of `x`.
///
/// * `factor`: L, `n` rows and columns, lower triangle.
/// * `x`: columns of `n` entries.
///
/// # Panics
/// If the factor has fewer entries.
pub fn forward(factor: &[f64], n: usize, x: &mut [f64]) {
    solve(factor, n, x, forward_by_columns, forward_by_blocks);
}

/// Solves `Lᵀ y = x` in place, for every column of `x`.
///
/// * `factor`: L, `n` rows and columns, lower triangle.
/// * `x`: columns of `n` entries.
///
/// # Panics
/// If the factor has fewer entries.
pub fn backward(factor: &[f64], n: usize, x: &mut [f64]) {
    solve(factor, n, x, backward_by_columns, backward_by_blocks);
}

type ByColumns = fn(Lower<'_>, &mut [f64]);
type ByBlocks = fn(Lower<'_>, BlockMut<'_>);

fn solve(factor: &[f64], n: usize, x: &mut [f64], by_columns: ByColumns, by_blocks: ByBlocks) {
    let count = x.len().checked_div(n).unwrap_or(0);
    let lower = Lower::new(factor, n, n);
    if count < FEW {
        x.chunks_exact_mut(n.max(1)).for_each(|x| by_columns(lower, x));
    } else {
        x.par_chunks_mut(n * share(count)).for_each(|x| by_blocks(lower, block_mut(x, [n, x.len() / n], n)));
    }
}

/// Returns how many of some right-hand sides one thread solves for at once.
fn share(count: usize) -> usize {
    if count < MANY { SHARE } else { LARGE_SHARE }
}

/// Computes `(L Lᵀ)⁻¹`, both triangles, column by column: `L⁻ᵀ` and its product with its transpose, in `2n³/3` operations.
///
/// * `factor`: L, `n` rows and columns, lower triangle.
///
/// # Panics
/// If the factor has fewer entries.
pub fn invert(factor: &[f64], n: usize) -> Vec<f64> {
    let mut transpose = vec![0.0; n * n];
    let share = share(n);
    transpose.par_chunks_mut((n * share).max(1)).enumerate().for_each(|(chunk, columns)| {
        let (first, count) = (chunk * share, columns.len() / n);
        (0..count).for_each(|k| columns[k * n + first + k] = 1.0);
        // Zero from there on.
        let end = first + count;
        let leading = Lower::new(factor, n, end);
        backward_by_blocks(leading, block_mut(columns, [end, count], n));
    });
    square_of_triangle(&transpose, n, Triangle::Upper)
}

/// A lower triangle within a matrix.
#[derive(Clone, Copy)]
pub(crate) struct Lower<'a> {
    /// From its first entry on.
    values: &'a [f64],
    stride: usize,
    /// Rows and columns.
    n: usize,
}

impl<'a> Lower<'a> {
    fn new(values: &'a [f64], stride: usize, n: usize) -> Self {
        Self { values, stride, n }
    }

    /// Returns column `k` from the diagonal down.
    fn column(self, k: usize) -> &'a [f64] {
        &self.values[k * self.stride + k..k * self.stride + self.n]
    }

    /// Splits the triangle into one of `half` rows, one of the others, and the block below the first one, left of the other.
    fn split(self, half: usize) -> (Self, Self, Block<'a>) {
        let rest = &self.values[half * self.stride + half..];
        let below = block(&self.values[half..], [self.n - half, half], self.stride);
        (Self::new(self.values, self.stride, half), Self::new(rest, self.stride, self.n - half), below)
    }
}

pub(crate) fn forward_by_blocks(lower: Lower<'_>, mut x: BlockMut<'_>) {
    if lower.n <= BLOCK {
        return each_column(lower, x, forward_by_columns);
    }
    let half = lower.n / 2;
    let (first, second, below) = lower.split(half);
    let (mut upper, mut rest) = x.rows_range_pair_mut(..half, half..);
    forward_by_blocks(first, upper.as_view_mut());
    rest.gemm(-1.0, &below, &upper, 1.0);
    forward_by_blocks(second, rest);
}

pub(crate) fn backward_by_blocks(lower: Lower<'_>, mut x: BlockMut<'_>) {
    if lower.n <= BLOCK {
        return each_column(lower, x, backward_by_columns);
    }
    let half = lower.n / 2;
    let (first, second, below) = lower.split(half);
    let (mut upper, mut rest) = x.rows_range_pair_mut(..half, half..);
    backward_by_blocks(second, rest.as_view_mut());
    upper.gemm(-1.0, &below.transpose(), &rest, 1.0);
    backward_by_blocks(first, upper);
}

/// Solves for the columns of a block one by one. Its rows are copied, since columns of a view are not slices.
fn each_column(lower: Lower<'_>, mut x: BlockMut<'_>, solve: ByColumns) {
    let mut copy = [0.0; BLOCK];
    for mut column in x.column_iter_mut() {
        let copy = &mut copy[..lower.n];
        copy.iter_mut().zip(column.iter()).for_each(|(to, from)| *to = *from);
        solve(lower, copy);
        column.iter_mut().zip(&*copy).for_each(|(to, from)| *to = *from);
    }
}

pub(crate) fn forward_by_columns(lower: Lower<'_>, x: &mut [f64]) {
    pulp::Arch::new().dispatch(Forward { lower, x });
}

pub(crate) fn backward_by_columns(lower: Lower<'_>, x: &mut [f64]) {
    pulp::Arch::new().dispatch(Backward { lower, x });
}

/// One right-hand side, for [`pulp`] to compile for every kind of processor.
struct Forward<'a> {
    lower: Lower<'a>,
    x: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for k in 0..self.lower.n {
            let column = self.lower.column(k);
            let value = self.x[k] / column[0];
            self.x[k] = value;
            self.x[k + 1..].iter_mut().zip(&column[1..]).for_each(|(x, l)| *x -= l * value);
        }
    }
}

/// As [`Forward`], with the transpose.
struct Backward<'a> {
    lower: Lower<'a>,
    x: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for k in (0..self.lower.n).rev() {
            let column = self.lower.column(k);
            let mut sums = [0.0; 8];
            let (left, left_rest) = column[1..].as_chunks::<8>();
            let (right, right_rest) = self.x[k + 1..].as_chunks::<8>();
            for (l, x) in left.iter().zip(right) {
                for c in 0..8 {
                    sums[c] += l[c] * x[c];
                }
            }
            let rest: f64 = left_rest.iter().zip(right_rest).map(|(l, x)| l * x).sum();
            self.x[k] = (self.x[k] - (sums.iter().sum::<f64>() + rest)) / column[0];
        }
    }
}
