//! The rigid motions of one body as its rows see them.

use nalgebra::{DMatrix, DVector};

/// Singular values below this fraction of the largest one are zero: such a motion has no trace.
const NO_TRACE: f64 = 1e-10;

/// The traces `B R` of the rigid motions of a floating body, by an orthonormal basis `Q` of n rows and r columns.
pub(super) struct RigidTraces {
    /// `Q`.
    pub(super) basis: DMatrix<f64>,
    /// `Qᵀ P` of all forces in balance, r entries, N/m.
    pub(super) loads: DVector<f64>,
    /// The amounts of the motions that have the traces `Q`, of least norm, m × r.
    amounts: DMatrix<f64>,
}

impl RigidTraces {
    /// Decomposes `(B R)ᵀ = V Σ Qᵀ`.
    ///
    /// * `traces`: m × n; `loads`: `Rᵀ f`, m entries.
    pub(super) fn new(traces: &DMatrix<f64>, loads: &DVector<f64>) -> Self {
        let (m, n) = traces.shape();
        let none =
            Self { basis: DMatrix::zeros(n, 0), loads: DVector::zeros(0), amounts: DMatrix::zeros(m, 0) };
        if m == 0 || n == 0 {
            return none;
        }
        let svd = traces.transpose().svd(true, true);
        let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return none };
        let largest = svd.singular_values.max();
        let kept: Vec<usize> =
            (0..svd.singular_values.len()).filter(|k| svd.singular_values[*k] > NO_TRACE * largest).collect();
        let amounts = DMatrix::from_fn(m, kept.len(), |i, k| v[(kept[k], i)] / svd.singular_values[kept[k]]);
        Self { basis: u.select_columns(&kept), loads: amounts.transpose() * loads, amounts }
    }

    /// Converts coefficients of the basis into amounts of the motions.
    pub(super) fn amounts(&self, coefficients: &[f64]) -> Vec<f64> {
        (&self.amounts * DVector::from_column_slice(coefficients)).as_slice().to_vec()
    }

    /// Removes the part of `v` along the basis, and returns its coefficients.
    pub(super) fn project_out(&self, v: &mut DVector<f64>) -> DVector<f64> {
        let part = self.basis.tr_mul(v);
        *v -= &self.basis * &part;
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_without_trace_gets_no_part() {
        // Three motions in two rows: the first is seen in both, the second in none, the third is twice the first.
        let traces = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 0.0, 0.0, 2.0, 2.0]);
        let rigid = RigidTraces::new(&traces, &DVector::from_column_slice(&[3.0, 0.0, 6.0]));
        assert_eq!(rigid.basis.ncols(), 1);
        // P with P_1 + P_2 = 3.
        let along = rigid.basis.column(0).dot(&DVector::from_column_slice(&[1.0, 2.0]));
        assert!((along - rigid.loads[0]).abs() < 1e-15);
        let amounts = rigid.amounts(&[1.0]);
        let trace = DVector::from_column_slice(&amounts).tr_mul(&traces);
        assert!((trace.transpose() - rigid.basis.column(0)).norm() < 1e-15);
        assert_eq!(amounts[1], 0.0);
        let mut v = DVector::from_column_slice(&[1.0, 3.0]);
        rigid.project_out(&mut v);
        assert!((v[0] + v[1]).abs() < 1e-15 && (v[1] - v[0] - 2.0).abs() < 1e-14);
    }
}
