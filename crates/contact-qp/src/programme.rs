//! The programme given by the caller (borrowed data), and its checks.

use crate::bound_state::BoundState;
use crate::dense::largest;
use crate::error::QpError;
use crate::problem::{MatrixView, check_finite, check_length};
use crate::sparse::SparseRows;

/// A bound on the far side of zero is left out of account if it exceeds what the loads alone would move by this factor: it is very
/// unlikely to be reached, and its size would hide all others.
const FAR: f64 = 1e8;

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

/// Units in which a tolerance is dimensionless and all unknowns have the same scale.
pub(crate) struct Units {
    /// `√P_ii`.
    pub(crate) roots: Vec<f64>,
    /// Lengths of the rows for unknowns `√P_ii x_i`.
    pub(crate) lengths: Vec<f64>,
    /// The largest load that `x` must balance: of `q`, of what the bounds push, and of `e`. Without loads the largest bound; positive.
    pub(crate) load: f64,
}

impl BoxQp<'_> {
    /// Checks everything except that the matrix is positive semi-definite, of which only the signs of the diagonal: lengths, finite numbers,
    /// symmetry or triangle, and the order of the bounds. Costs one pass over the data.
    ///
    /// # Errors
    /// Any [`QpError`] except `Setting` and `Library`; [`QpError::NotPositiveDefinite`] for a negative diagonal entry.
    pub fn check(&self) -> Result<(), QpError> {
        let n = self.matrix.size();
        let lengths = [
            ("linear", n, self.linear.len()),
            ("lower", n, self.lower.len()),
            ("upper", n, self.upper.len()),
            ("rows", n, self.rows.columns()),
            ("right_side", self.rows.len(), self.right_side.len()),
        ];
        for (what, expected, found) in lengths {
            check_length(what, expected, found)?;
        }
        self.matrix.check()?;
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

    /// Returns the admissible numbers nearest to zero.
    pub(crate) fn at_rest(&self) -> Vec<f64> {
        self.lower.iter().zip(self.upper).map(|(l, u)| 0f64.max(*l).min(*u)).collect()
    }

    /// Places unknowns between equal bounds there, and all others between their bounds.
    pub(crate) fn states_at_rest(&self) -> Vec<BoundState> {
        let place = |(l, u): (&f64, &f64)| if l == u { BoundState::Lower } else { BoundState::Free };
        self.lower.iter().zip(self.upper).map(place).collect()
    }

    /// Tells whether both bounds of an unknown are equal.
    pub(crate) fn is_fixed(&self, i: usize) -> bool {
        self.lower[i] == self.upper[i]
    }

    /// Computes the units of the data.
    pub(crate) fn units(&self) -> Units {
        let n = self.linear.len();
        let stiffest = (0..n).map(|i| self.matrix.diagonal(i)).fold(0.0, f64::max);
        // An unknown without stiffness of its own gets the largest one. Of a fixed one neither the stiffness, which may be rounding, nor
        // the load counts.
        let own = |i: usize| Some(self.matrix.diagonal(i)).filter(|d| *d > 0.0 && !self.is_fixed(i));
        let root = |i: usize| Some(own(i).unwrap_or(stiffest).sqrt()).filter(|root| *root > 0.0);
        let roots: Vec<f64> = (0..n).map(|i| root(i).unwrap_or(1.0)).collect();
        let length = |k: usize| self.rows.row(k).map(|(i, g)| (g / roots[i]).powi(2)).sum::<f64>().sqrt();
        let lengths = (0..self.rows.len()).map(length).map(|length| if length > 0.0 { length } else { 1.0 });
        let lengths: Vec<f64> = lengths.collect();
        let mut pushed = vec![0.0; n];
        self.matrix.add_product(&self.at_rest(), &mut pushed);
        let force = |i: usize| self.linear[i].abs().max(pushed[i].abs()) / roots[i];
        let forces = (0..n).filter(|i| !self.is_fixed(*i)).map(force);
        let load = largest(forces.chain(self.right_side.iter().zip(&lengths).map(|(e, length)| e / length)));
        let finite = |bounds: &[f64], i: usize| Some(bounds[i] * roots[i]).filter(|bound| bound.is_finite());
        let distances = || (0..n).flat_map(|i| [self.lower, self.upper].map(|bounds| finite(bounds, i)));
        let load = if load > 0.0 { load } else { largest(distances().flatten()) };
        Units { roots, lengths, load: if load > 0.0 { load } else { 1.0 } }
    }

    /// Returns the bounds, infinite if they are far from what the loads alone would move.
    pub(crate) fn near_bounds(&self) -> [Vec<f64>; 2] {
        let Units { roots, load, .. } = self.units();
        let is_far = |i: usize, beyond: f64| beyond * roots[i] > FAR * load;
        let lower = |i: usize| if is_far(i, -self.lower[i]) { f64::NEG_INFINITY } else { self.lower[i] };
        let upper = |i: usize| if is_far(i, self.upper[i]) { f64::INFINITY } else { self.upper[i] };
        let n = self.linear.len();
        [(0..n).map(lower).collect(), (0..n).map(upper).collect()]
    }

    pub(crate) fn bound(&self, i: usize, place: BoundState) -> f64 {
        match place {
            BoundState::Lower => self.lower[i],
            BoundState::Upper => self.upper[i],
            BoundState::Free => 0.0,
        }
    }
}
