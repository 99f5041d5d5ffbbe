//! Factorisation.

use crate::product::add_square;
use pulp::Simd;

/// At most this many columns are eliminated without products of blocks.
const NARROW: usize = 16;
/// Columns that are eliminated one by one, and subtracted together from as many others.
const GROUP: usize = 4;

/// A pivot that is not positive, or not a number: the matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite: pivot {column} is not positive")]
pub struct NotPositiveDefinite {
    /// The column, from 0.
    pub column: usize,
}

/// Overwrites the first columns of a symmetric matrix with those of its Cholesky factor.
///
/// The columns are halved until few remain: the first half is eliminated, its product with itself is subtracted from the second
/// half, which is eliminated then. So nearly all of the `k² (n − k) + k³/3` operations are products of blocks.
///
/// * `columns`: `k` columns of `n` entries each; of column `j` the entries from `j` on are read and overwritten.
/// * `n`: rows of the matrix.
///
/// # Errors
/// The first pivot that is not positive.
pub fn factorise(columns: &mut [f64], n: usize) -> Result<(), NotPositiveDefinite> {
    let count = columns.len().checked_div(n).unwrap_or(0);
    eliminate(columns, n, n, count).map_err(|column| NotPositiveDefinite { column })
}

/// Eliminates `count` columns.
///
/// * `columns`: from the diagonal entry of the first one on, each `stride` after the one before.
/// * `rows`: from that entry down.
pub(crate) fn eliminate(columns: &mut [f64], stride: usize, rows: usize, count: usize) -> Result<(), usize> {
    if count <= NARROW {
        return pulp::Arch::new().dispatch(Narrow { columns, stride, rows, count });
    }
    let half = count.div_ceil(2 * NARROW) * NARROW;
    let (first, second) = columns.split_at_mut(half * stride);
    eliminate(first, stride, rows, half)?;
    let second = &mut second[half..];
    let rows_below = rows - half;
    add_square(-1.0, (&first[half..], stride), [rows_below, half], 1.0, (&mut *second, stride), count - half);
    eliminate(second, stride, rows_below, count - half).map_err(|column| half + column)
}

/// Few columns, for [`pulp`] to compile their elimination for every kind of processor.
struct Narrow<'a> {
    columns: &'a mut [f64],
    stride: usize,
    rows: usize,
    count: usize,
}

impl pulp::WithSimd for Narrow<'_> {
    type Output = Result<(), usize>;

    /// Eliminates a group of columns one by one, and subtracts their products from the other ones, group by group.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<(), usize> {
        let Self { columns, stride, rows, count } = self;
        for first in (0..count).step_by(GROUP) {
            let end = (first + GROUP).min(count);
            let (group, later) = columns.split_at_mut((end * stride).min(columns.len()));
            let group = &mut group[first * stride..];
            for k in 0..end - first {
                let (column, others) = group.split_at_mut(((k + 1) * stride).min(group.len()));
                let column = &mut column[k * stride + first + k..k * stride + rows];
                if !(column[0] > 0.0 && column[0] < f64::INFINITY) {
                    return Err(first + k);
                }
                column[0] = column[0].sqrt();
                let inverse = 1.0 / column[0];
                column[1..].iter_mut().for_each(|value| *value *= inverse);
                for (j, other) in (k + 1..end - first).zip(others.chunks_mut(stride)) {
                    subtract(simd, [(&column[j - k..], column[j - k])], &mut other[first + j..rows]);
                }
            }
            if end == count {
                break;
            }
            let (a, rest) = group.split_at(stride);
            let (b, rest) = rest.split_at(stride);
            let (c, d) = rest.split_at(stride);
            for (j, other) in (end..count).zip(later.chunks_mut(stride)) {
                let sources = [a, b, c, d].map(|column| (&column[j..rows], column[j]));
                subtract(simd, sources, &mut other[j..rows]);
            }
        }
        Ok(())
    }
}

/// Subtracts multiples of columns from another one.
#[inline(always)]
fn subtract<S: Simd, const N: usize>(simd: S, sources: [(&[f64], f64); N], target: &mut [f64]) {
    let factors = sources.map(|(_, factor)| simd.splat_f64s(-factor));
    let split = sources.map(|(column, _)| S::as_simd_f64s(column));
    let (vectors, rest) = S::as_mut_simd_f64s(target);
    for (i, vector) in vectors.iter_mut().enumerate() {
        let mut sum = *vector;
        for n in 0..N {
            sum = simd.mul_add_e_f64s(factors[n], split[n].0[i], sum);
        }
        *vector = sum;
    }
    if rest.is_empty() {
        return;
    }
    let mut sum = simd.partial_load_f64s(rest);
    for n in 0..N {
        sum = simd.mul_add_e_f64s(factors[n], simd.partial_load_f64s(split[n].1), sum);
    }
    simd.partial_store_f64s(rest, sum);
}
