//! The four KKT residuals, as numbers.

use crate::error::QpError;
use crate::problem::{BoundQp, MatrixView};

/// Measures how far `(x, r)` is from satisfying the KKT conditions; all four are dimensionless.
///
/// Each unknown is measured by the energy it carries alone, `|x|_D = max_i √P_ii |x_i|`, and each force by
/// `|f|_D = max_i |f_i| / √P_ii`, so that soft and stiff unknowns have equal weight and the result does not depend on
/// units. With the force scale `F = ‖P‖_D |x|_D + |q|_D`, `‖P‖_D = max_i Σ_j |P_ij| / √(P_ii P_jj)` (the size of the
/// terms that must cancel), and the length scale `X = |x|_D`, both replaced by 1 if they vanish:
///
/// ```text
/// stationarity    |P x + q − R r|_D / F        R r puts r on the bounded unknowns
/// primal          |(l − x)⁺|_D / X
/// dual            |(−r)⁺|_D / F
/// complementarity max_k |r_k (x_k − l_k)| / (F X)
/// ```
///
/// So a stationarity of a few 1e-16 is round-off, whatever the conditioning of `P`. A NaN residual is reported as
/// infinity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KktResiduals {
    /// `|P x + q − R r|_D / F`.
    pub stationarity: f64,
    /// `|(l − x)⁺|_D / X`; exactly 0 in a [`QpSolution`](crate::QpSolution).
    pub primal: f64,
    /// `|(−r)⁺|_D / F`; exactly 0 in a [`QpSolution`](crate::QpSolution).
    pub dual: f64,
    /// `max |r (x − l)| / (F X)`; exactly 0 in a [`QpSolution`](crate::QpSolution).
    pub complementarity: f64,
}

impl KktResiduals {
    /// Returns the largest of the four.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.stationarity.max(self.primal).max(self.dual).max(self.complementarity)
    }
}

/// Measures the KKT residuals of any pair: `x` (n entries), `multipliers` (one per bounded index).
///
/// # Errors
/// Those of [`BoundQp::check`]; [`QpError::Length`] when `x` or `multipliers` has the wrong length.
pub fn kkt_residuals(qp: &BoundQp<'_>, x: &[f64], multipliers: &[f64]) -> Result<KktResiduals, QpError> {
    let matrix = CheckedMatrix::new(qp.matrix)?;
    qp.check_vectors()?;
    for (what, expected, found) in
        [("x", qp.linear.len(), x.len()), ("multipliers", qp.bounded.len(), multipliers.len())]
    {
        if found != expected {
            return Err(QpError::Length { what, expected, found });
        }
    }
    Ok(residuals(qp, &Scales::new(&matrix, qp.linear), x, multipliers))
}

/// A matrix that is checked and measured once, for several programmes with different vectors: see
/// [`solve_with`](crate::solve_with). Both operations pass over the whole matrix.
#[derive(Clone, Debug)]
pub struct CheckedMatrix<'a> {
    pub(crate) view: MatrixView<'a>,
    /// `√P_ii`.
    roots: Vec<f64>,
    /// `‖P‖_D`.
    norm: f64,
}

impl<'a> CheckedMatrix<'a> {
    /// Checks a matrix for everything except positive definiteness.
    ///
    /// # Errors
    /// Those of [`BoundQp::check`] that concern the matrix.
    pub fn new(view: MatrixView<'a>) -> Result<Self, QpError> {
        view.check()?;
        let roots: Vec<f64> = (0..view.size()).map(|i| view.diagonal(i).sqrt()).collect();
        let inverse: Vec<f64> = roots.iter().map(|root| 1.0 / root).collect();
        Ok(Self { view, norm: view.scaled_norm(&inverse), roots })
    }
}

/// The scales that errors are compared with, see [`KktResiduals`].
pub(crate) struct Scales {
    /// `√P_ii`.
    roots: Vec<f64>,
    /// `‖P‖_D`.
    matrix: f64,
    /// `|q|_D`.
    linear: f64,
}

impl Scales {
    /// Computes the scales of checked data.
    pub(crate) fn new(matrix: &CheckedMatrix<'_>, linear: &[f64]) -> Self {
        let roots = matrix.roots.clone();
        let linear = largest(linear.iter().zip(&roots).map(|(force, root)| force / root));
        Self { roots, matrix: matrix.norm, linear }
    }

    /// Returns `√P_ii` for every unknown.
    pub(crate) fn roots(&self) -> &[f64] {
        &self.roots
    }

    /// Returns `X = |x|_D`.
    pub(crate) fn length(&self, x: &[f64]) -> f64 {
        largest(x.iter().zip(&self.roots).map(|(x, root)| x * root))
    }

    /// Returns `F`.
    pub(crate) fn force(&self, x: &[f64]) -> f64 {
        self.matrix * self.length(x) + self.linear
    }
}

/// Like [`kkt_residuals`], for checked data whose scales are known.
pub(crate) fn residuals(qp: &BoundQp<'_>, scales: &Scales, x: &[f64], multipliers: &[f64]) -> KktResiduals {
    let mut imbalance = qp.linear.to_vec();
    qp.matrix.add_product(x, &mut imbalance);
    let (force, length) = (divisor(scales.force(x)), divisor(scales.length(x)));
    let mut worst = KktResiduals::default();
    for ((&i, &lower), &r) in qp.bounded.iter().zip(qp.lower).zip(multipliers) {
        imbalance[i] -= r;
        let root = scales.roots[i];
        let (opening, reaction) = ((x[i] - lower) * root / length, r / root / force);
        worst.primal = worst.primal.max(negative_part(opening));
        worst.dual = worst.dual.max(negative_part(reaction));
        // With a contact force of exactly 0 the product is 0, however distant the bound.
        let product = if r == 0.0 { 0.0 } else { reaction * opening };
        worst.complementarity = worst.complementarity.max(magnitude(product));
    }
    for (value, root) in imbalance.iter().zip(&scales.roots) {
        worst.stationarity = worst.stationarity.max(magnitude(value / root / force));
    }
    worst
}

/// Returns `max |v_i|`; NaN if an entry is NaN, so that it does not count as a small value.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger =
        |most: f64, value: f64| if value.abs() > most || value.is_nan() { value.abs() } else { most };
    values.into_iter().fold(0.0, larger)
}

/// Converts a scale into a divisor. An infinite scale becomes NaN, because it would hide any finite error.
fn divisor(scale: f64) -> f64 {
    if scale == 0.0 {
        1.0
    } else if scale.is_finite() {
        scale
    } else {
        f64::NAN
    }
}

/// Returns `|v|`, and infinity for NaN, because every comparison with NaN is false.
fn magnitude(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value.abs() }
}

/// Returns `max(−v, 0)`, and infinity for NaN.
fn negative_part(value: f64) -> f64 {
    if value >= 0.0 { 0.0 } else { magnitude(value) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::MatrixView;

    #[test]
    fn each_residual_sees_its_own_error() {
        // min 2 x² − 8 x with x ≥ 3: x = 3, r = 4·3 − 8 = 4. √P = 2, ‖P‖_D = 1, |q|_D = 4, so X = 6 and F = 10.
        let qp = BoundQp {
            matrix: MatrixView::Dense { n: 1, values: &[4.0] },
            linear: &[-8.0],
            bounded: &[0],
            lower: &[3.0],
        };
        assert_eq!(kkt_residuals(&qp, &[3.0], &[4.0]).unwrap().max(), 0.0);
        assert_eq!(kkt_residuals(&qp, &[3.0], &[2.0]).unwrap().stationarity, 0.1);
        let low = kkt_residuals(&qp, &[2.0], &[0.0]).unwrap();
        assert_eq!((low.primal, low.stationarity, low.dual), (0.5, 0.0, 0.0));
        // x = 6: X = 12, F = 16, r = 16, so 8/16 times 6/12.
        let high = kkt_residuals(&qp, &[6.0], &[16.0]).unwrap();
        assert_eq!((high.complementarity, high.stationarity, high.primal), (0.25, 0.0, 0.0));
        assert_eq!(kkt_residuals(&qp, &[3.0], &[-2.0]).unwrap().dual, 0.1);
        assert_eq!(kkt_residuals(&qp, &[f64::NAN], &[0.0]).unwrap().max(), f64::INFINITY);
        assert!(matches!(kkt_residuals(&qp, &[], &[0.0]), Err(QpError::Length { what: "x", .. })));
        assert!(matches!(kkt_residuals(&qp, &[0.0], &[]), Err(QpError::Length { what: "multipliers", .. })));
    }
}
