//! The programme given by the caller (borrowed data), and its checks.

use crate::error::QpError;
use crate::place::Place;
use crate::problem::{MatrixView, check_finite, check_length, check_values};
use crate::sparse::SparseRows;

/// The borrowed data of `min ½ xᵀP x + qᵀx` subject to `l ≤ x ≤ u`, `G x = e`.
#[derive(Clone, Copy, Debug)]
pub struct BoxQp<'a> {
    /// `P`, symmetric, positive semi-definite.
    pub matrix: MatrixView<'a>,
    /// `q`, n entries.
    pub linear: &'a [f64],
    /// `l`, n entries; −∞ for none.
    pub lower: &'a [f64],
    /// `u ≥ l`, n entries; ∞ for none.
    pub upper: &'a [f64],
    /// `G`, m rows with n columns.
    pub rows: &'a SparseRows,
    /// `e`, m entries.
    pub right_side: &'a [f64],
}

impl BoxQp<'_> {
    /// Checks lengths, finite numbers, and the order of the bounds.
    ///
    /// # Errors
    /// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`].
    pub fn check(&self) -> Result<(), QpError> {
        let n = self.linear.len();
        let lengths = [
            ("matrix", n, self.matrix.size()),
            ("lower", n, self.lower.len()),
            ("upper", n, self.upper.len()),
            ("rows", n, self.rows.columns()),
            ("right_side", self.rows.len(), self.right_side.len()),
        ];
        for (what, expected, found) in lengths {
            check_length(what, expected, found)?;
        }
        match self.matrix {
            MatrixView::Dense { values, .. } => check_values("matrix", n.saturating_mul(n), values)?,
            sparse @ MatrixView::SparseUpper { .. } => sparse.check_entries()?,
        }
        let finite = [("linear", self.linear), ("rows", self.rows.values()), ("right_side", self.right_side)];
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
    pub(crate) fn gradient(&self, x: &[f64], a: &[f64]) -> Vec<f64> {
        let mut gradient = self.linear.to_vec();
        self.matrix.add_product(x, &mut gradient);
        gradient.iter_mut().zip(self.rows.transposed_times(a)).for_each(|(g, of_rows)| *g -= of_rows);
        gradient
    }

    /// Computes `e − G x`.
    pub(crate) fn defect(&self, x: &[f64]) -> Vec<f64> {
        self.rows.times(x).iter().zip(self.right_side).map(|(product, e)| e - product).collect()
    }

    pub(crate) fn bound(&self, i: usize, place: Place) -> f64 {
        match place {
            Place::Lower => self.lower[i],
            Place::Upper => self.upper[i],
            Place::Free => 0.0,
        }
    }
}
