//! How far a point and its multipliers are from the KKT conditions.

use crate::dense::{largest, norm};
use crate::programme::BoxQp;

/// Residuals of the KKT conditions, each over the scale of its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KktResiduals {
    /// `max |P x + q − Gᵀ a − y|` over the largest sum of the sizes of its terms, `max (|P| |x| + |q| + |Gᵀ| |a|)`: a few 1e-16 are
    /// round-off, whatever the conditioning of `P`.
    pub stationarity: f64,
    /// `max |G x − e|` of a row `g` over `|g| |x| + |e|`.
    pub rows: f64,
    /// The part of `x` outside its bounds, over the largest `|x|`.
    pub primal: f64,
    /// The part of `y` with the wrong sign, over the scale of the stationarity.
    pub dual: f64,
    /// `max |y (x − bound)|` over the product of both scales.
    pub complementarity: f64,
}

impl KktResiduals {
    /// Returns the largest of them.
    #[must_use]
    pub fn max(&self) -> f64 {
        largest([self.stationarity, self.rows, self.primal, self.dual, self.complementarity])
    }
}

/// Measures the KKT residuals of any `x`, multipliers `y` of the bounds and `a` of the rows.
///
/// # Panics
/// If a length does not fit the programme.
pub fn kkt_residuals(
    qp: &BoxQp<'_>,
    x: &[f64],
    multipliers: &[f64],
    row_multipliers: &[f64],
) -> KktResiduals {
    let n = x.len();
    let gradient = qp.gradient(x, row_multipliers);
    let mut terms: Vec<f64> = qp.linear.iter().map(|q| q.abs()).collect();
    qp.matrix.add_magnitudes(x, &mut terms);
    for (row, a) in qp.rows.rows().zip(row_multipliers) {
        row.for_each(|(i, g)| terms[i] += (g * a).abs());
    }
    let force = largest(terms);
    let length = largest(x.iter().copied());
    let over = |value: f64, scale: f64| if value == 0.0 { 0.0 } else { value / scale };
    let mut found = KktResiduals::default();
    for i in 0..n {
        let y = multipliers[i];
        let below = (qp.lower[i] - x[i]).max(x[i] - qp.upper[i]).max(0.0);
        found.primal = found.primal.max(over(below, length));
        found.stationarity = found.stationarity.max(over((gradient[i] - y).abs(), force));
        let bound = if y > 0.0 { qp.lower[i] } else { qp.upper[i] };
        let distance = if y == 0.0 { 0.0 } else { (x[i] - bound).abs() };
        if distance.is_infinite() {
            found.dual = found.dual.max(over(y.abs(), force));
        } else {
            found.complementarity = found.complementarity.max(over(y.abs() * distance, force * length));
        }
    }
    let whole = norm(x);
    for ((row, e), defect) in qp.rows.rows().zip(qp.right_side).zip(qp.defect(x)) {
        // Not the terms themselves: a row may meet only unknowns for which its entries are round-off.
        let size = row.map(|(_, g)| g * g).sum::<f64>().sqrt() * whole + e.abs();
        found.rows = found.rows.max(over(defect.abs(), size));
    }
    found
}
