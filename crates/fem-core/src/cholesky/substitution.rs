//! Forward and backward substitution, for [`pulp`] to compile for every kind of processor. Both are as fast as the memory that the
//! factor is read from, as long as they read it in its order.

use super::Cholesky;
use pulp::Simd;

/// Unknowns of a front that are solved for one by one. The others' parts are subtracted before, by scalar products.
const GROUP: usize = 8;

/// Solves `L y = x` for every column `x`, with the columns of `L` from `start`.
pub(super) struct Forward<'a, 'x> {
    pub(super) factor: &'a Cholesky,
    /// The entries from `start`.
    pub(super) columns: &'a mut [&'x mut [f64]],
    pub(super) start: usize,
}

impl pulp::NullaryFnOnce for Forward<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { factor, columns, start } = self;
        let mut tails = vec![Vec::new(); columns.len()];
        for (panel, skipped) in factor.panels_from(start) {
            for tail in &mut tails {
                tail.clear();
                tail.resize(panel.below.len(), 0.0);
            }
            let own = panel.first + skipped - start..panel.first + panel.width - start;
            for k in skipped..panel.width {
                let (pivot, inside, below) = panel.column(k);
                for (x, tail) in columns.iter_mut().zip(&mut tails) {
                    let own = &mut x[own.clone()][k - skipped..];
                    let value = own[0] / pivot;
                    own[0] = value;
                    own[1..].iter_mut().zip(inside).for_each(|(x, l)| *x -= l * value);
                    tail.iter_mut().zip(below).for_each(|(t, l)| *t += l * value);
                }
            }
            for (x, tail) in columns.iter_mut().zip(&tails) {
                for (&row, t) in panel.below.iter().zip(tail) {
                    x[row as usize - start] -= t;
                }
            }
        }
    }
}

/// Solves `Lᵀ x = y` for the unknowns from `start` to `end`; the later ones are known.
pub(super) struct Backward<'a> {
    pub(super) factor: &'a Cholesky,
    /// The entries from `start`.
    pub(super) x: &'a mut [f64],
    pub(super) start: usize,
    pub(super) end: usize,
}

impl pulp::WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, x, start, end } = self;
        let mut tail = Vec::new();
        for (panel, skipped) in factor.panels_from(start).rev() {
            let width = panel.width.min(end.saturating_sub(panel.first));
            tail.clear();
            tail.extend(panel.below.iter().map(|&row| x[row as usize - start]));
            let own = &mut x[panel.first + skipped - start..panel.first + panel.width - start];
            let column = |k: usize| panel.column(k + skipped);
            let width = width.saturating_sub(skipped);
            // The columns in their order, as memory is read fastest.
            for k in 0..width {
                own[k] -= dot(simd, column(k).2, &tail);
            }
            for first in (0..width).step_by(GROUP).rev() {
                let last = (first + GROUP).min(width);
                let (group, known) = own.split_at_mut(last);
                for k in first..last {
                    group[k] -= dot(simd, &column(k).1[last - k - 1..], known);
                }
                for k in (first..last).rev() {
                    let (pivot, inside, _) = column(k);
                    let (before, after) = group.split_at_mut(k + 1);
                    let inverse = 1.0 / pivot;
                    // The last one computed comes last, since the sum waits for it.
                    let known = inside.iter().zip(&*after).rev().fold(before[k], |sum, (l, x)| sum - l * x);
                    before[k] = known * inverse;
                }
            }
        }
    }
}

/// Computes `L x`, with the columns of `L` from `start`.
pub(super) struct Product<'a> {
    pub(super) factor: &'a Cholesky,
    /// The entries from `start`, and those of the product: zero on entry.
    pub(super) x: &'a [f64],
    pub(super) product: &'a mut [f64],
    pub(super) start: usize,
}

impl pulp::NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { factor, x, product, start } = self;
        let mut tail = Vec::new();
        for (panel, skipped) in factor.panels_from(start) {
            tail.clear();
            tail.resize(panel.below.len(), 0.0);
            for k in skipped..panel.width {
                let (pivot, inside, below) = panel.column(k);
                let j = panel.first + k - start;
                product[j] += pivot * x[j];
                product[j + 1..].iter_mut().zip(inside).for_each(|(y, l)| *y += l * x[j]);
                tail.iter_mut().zip(below).for_each(|(y, l): (&mut f64, _)| *y += l * x[j]);
            }
            panel.below.iter().zip(&tail).for_each(|(row, t)| product[*row as usize - start] += t);
        }
    }
}

/// Computes `Lᵀ x`, with the columns of `L` from `start`.
pub(super) struct TransposedProduct<'a> {
    pub(super) factor: &'a Cholesky,
    /// The entries from `start`; on exit those of the product.
    pub(super) x: &'a mut [f64],
    pub(super) start: usize,
}

impl pulp::WithSimd for TransposedProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, x, start } = self;
        let mut tail = Vec::new();
        for (panel, skipped) in factor.panels_from(start) {
            tail.clear();
            tail.extend(panel.below.iter().map(|&row| x[row as usize - start]));
            for k in skipped..panel.width {
                let (pivot, inside, below) = panel.column(k);
                let (own, later) = x[panel.first + k - start..].split_at_mut(1);
                own[0] = pivot * own[0] + dot(simd, inside, &later[..inside.len()]) + dot(simd, below, &tail);
            }
        }
    }
}

/// Scalar product.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (S::as_simd_f64s(a), S::as_simd_f64s(b));
    let ((a, a_last), (b, b_last)) = (pulp::as_arrays::<2, _>(a), pulp::as_arrays::<2, _>(b));
    let mut sums = [simd.splat_f64s(0.0); 2];
    for (a, b) in a.iter().zip(b) {
        for c in 0..2 {
            sums[c] = simd.mul_add_e_f64s(a[c], b[c], sums[c]);
        }
    }
    for (a, b) in a_last.iter().zip(b_last) {
        sums[0] = simd.mul_add_e_f64s(*a, *b, sums[0]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    simd.reduce_sum_f64s(simd.add_f64s(sums[0], sums[1])) + rest
}
