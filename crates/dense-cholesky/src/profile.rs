//! Factors of matrices whose entries are near the diagonal.

use crate::factor::{NotPositiveDefinite, eliminate};
use crate::product::{add_square, block, block_mut};
use crate::solve::{
    FEW, Lower, SHARE, backward_by_blocks, backward_by_columns, forward_by_blocks, forward_by_columns,
};
use rayon::prelude::*;
use std::ops::Range;

/// Columns that are eliminated together.
const STEP: usize = 128;

/// Where the columns of a lower triangle end: its entries from there on are zero, and so are those of its factor, which are neither read
/// nor written.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    ends: Vec<usize>,
}

/// Some columns with the end of their rows.
struct Step {
    columns: Range<usize>,
    end: usize,
}

impl Profile {
    /// Makes a profile of `n` columns.
    ///
    /// * `ends`: one past the last row of each column that is not zero. A column that ends before an earlier one, or before one that is
    ///   eliminated together with it, is continued as far.
    pub fn new(ends: impl IntoIterator<Item = usize>) -> Self {
        let mut ends: Vec<usize> = ends.into_iter().collect();
        let (mut most, mut last) = (0, 0);
        for columns in ends.chunks_mut(STEP) {
            last += columns.len();
            most = columns.iter().copied().fold(most.max(last), usize::max);
            columns.fill(most);
        }
        Self { ends }
    }

    /// Returns where the columns end, in ascending order.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// Overwrites a symmetric matrix with its Cholesky factor, see [`factorise`](crate::factorise).
    ///
    /// * `matrix`: `n` rows and columns.
    ///
    /// # Errors
    /// The first pivot that is not positive.
    ///
    /// # Panics
    /// If the matrix has fewer entries, or a column ends behind the last row.
    pub fn factorise(&self, matrix: &mut [f64]) -> Result<(), NotPositiveDefinite> {
        let n = self.ends.len();
        for Step { columns: Range { start, end: last }, end } in self.steps() {
            let (panel, rest) = matrix.split_at_mut(last * n);
            let (panel, width) = (&mut panel[start * (n + 1)..], last - start);
            eliminate(panel, n, end - start, width)
                .map_err(|column| NotPositiveDefinite { column: start + column })?;
            if end > last {
                let below = (&panel[width..], n);
                add_square(-1.0, below, [end - last, width], 1.0, (&mut rest[last..], n), end - last);
            }
        }
        Ok(())
    }

    /// Solves `L y = x` in place, see [`forward`](crate::forward).
    ///
    /// # Panics
    /// If the factor has fewer entries.
    pub fn forward(&self, factor: &[f64], x: &mut [f64]) {
        let n = self.ends.len();
        self.each_share(x, &|x| {
            for Step { columns: Range { start, end: last }, end } in self.steps() {
                let lower = Lower::trapezium(&factor[start * (n + 1)..], n, [end - start, last - start]);
                if x.len() < FEW * n {
                    x.chunks_exact_mut(n).for_each(|x| forward_by_columns(lower, &mut x[start..end]));
                    continue;
                }
                let size = [end - start, x.len() / n];
                let mut x = block_mut(&mut x[start..], size, n);
                let (mut upper, mut rest) = x.rows_range_pair_mut(..last - start, last - start..);
                forward_by_blocks(lower.triangle(), upper.as_view_mut());
                let below = block(&factor[start * n + last..], [end - last, last - start], n);
                rest.gemm(-1.0, &below, &upper, 1.0);
            }
        });
    }

    /// Solves `Lᵀ y = x` in place, see [`backward`](crate::backward).
    ///
    /// # Panics
    /// If the factor has fewer entries.
    pub fn backward(&self, factor: &[f64], x: &mut [f64]) {
        let n = self.ends.len();
        self.each_share(x, &|x| {
            for Step { columns: Range { start, end: last }, end } in self.steps().rev() {
                let lower = Lower::trapezium(&factor[start * (n + 1)..], n, [end - start, last - start]);
                if x.len() < FEW * n {
                    x.chunks_exact_mut(n).for_each(|x| backward_by_columns(lower, &mut x[start..end]));
                    continue;
                }
                let size = [end - start, x.len() / n];
                let mut x = block_mut(&mut x[start..], size, n);
                let (mut upper, rest) = x.rows_range_pair_mut(..last - start, last - start..);
                let below = block(&factor[start * n + last..], [end - last, last - start], n);
                upper.gemm(-1.0, &below.transpose(), &rest, 1.0);
                backward_by_blocks(lower.triangle(), upper);
            }
        });
    }

    fn steps(&self) -> impl DoubleEndedIterator<Item = Step> {
        let n = self.ends.len();
        (0..n.div_ceil(STEP)).map(move |step| {
            let last = n.min((step + 1) * STEP);
            Step { columns: step * STEP..last, end: self.ends[last - 1] }
        })
    }

    /// Shares out right-hand sides to all threads.
    fn each_share(&self, x: &mut [f64], solve: &(dyn Fn(&mut [f64]) + Sync)) {
        x.par_chunks_mut((self.ends.len() * SHARE).max(1)).for_each(solve);
    }
}
