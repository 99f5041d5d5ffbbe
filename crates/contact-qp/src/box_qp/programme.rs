//! The programme given by the caller (borrowed data), and its checks.

use crate::error::QpError;
use crate::place::Place;
use crate::problem::{MatrixView, check_finite, check_length};

/// The borrowed data of `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`.
#[derive(Clone, Copy, Debug)]
pub struct BoxQp<'a> {
    /// `P`, symmetric, positive semi-definite, n² entries, both triangles.
    pub matrix: &'a [f64],
    /// `q`, n entries.
    pub linear: &'a [f64],
    /// `l`, n entries; −∞ for none.
    pub lower: &'a [f64],
    /// `u ≥ l`, n entries; ∞ for none.
    pub upper: &'a [f64],
    /// `G`, row after row, m·n entries.
    pub rows: &'a [f64],
    /// `e`, m entries.
    pub right_side: &'a [f64],
}

impl BoxQp<'_> {
    /// Checks lengths, finite numbers, and the order of the bounds.
    ///
    /// # Errors
    /// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`].
    pub fn check(&self) -> Result<(), QpError> {
        let (n, m) = (self.linear.len(), self.right_side.len());
        let lengths = [
            ("matrix", n.saturating_mul(n), self.matrix.len()),
            ("lower", n, self.lower.len()),
            ("upper", n, self.upper.len()),
            ("rows", n.saturating_mul(m), self.rows.len()),
        ];
        for (what, expected, found) in lengths {
            check_length(what, expected, found)?;
        }
        let finite = [
            ("matrix", self.matrix),
            ("linear", self.linear),
            ("rows", self.rows),
            ("right_side", self.right_side),
        ];
        for (what, values) in finite {
            check_finite(what, values)?;
        }
        let mut bounds = self.lower.iter().zip(self.upper);
        let wrong = |(l, u): (&f64, &f64)| !(l <= u && *l < f64::INFINITY && *u > f64::NEG_INFINITY);
        match bounds.position(wrong) {
            Some(place) => Err(QpError::Bounds { place, lower: self.lower[place], upper: self.upper[place] }),
            None => Ok(()),
        }
    }

    /// Computes `P x + q − Gᵀ a`.
    pub(super) fn gradient(&self, x: &[f64], a: &[f64]) -> Vec<f64> {
        let mut gradient = self.linear.to_vec();
        MatrixView::Dense { n: x.len(), values: self.matrix }.add_product(x, &mut gradient);
        self.subtract_rows(a, &mut gradient);
        gradient
    }

    /// Subtracts `Gᵀ a`.
    pub(super) fn subtract_rows(&self, a: &[f64], from: &mut [f64]) {
        for (row, a) in self.rows.chunks_exact(from.len().max(1)).zip(a) {
            from.iter_mut().zip(row).for_each(|(g, entry)| *g -= entry * a);
        }
    }

    /// Computes `e − G x`.
    pub(super) fn defect(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.rows.chunks_exact(x.len().max(1)).zip(self.right_side);
        rows.map(|(row, e)| e - row.iter().zip(x).map(|(g, x)| g * x).sum::<f64>()).collect()
    }

    pub(super) fn bound(&self, i: usize, place: Place) -> f64 {
        match place {
            Place::Lower => self.lower[i],
            Place::Upper => self.upper[i],
            Place::Free => 0.0,
        }
    }
}
