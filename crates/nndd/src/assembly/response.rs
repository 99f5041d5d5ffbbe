//! Step 1 of one body: traces imposed in the rows where it carries λ, unilateral contact in the others.
//!
//! With `c = λ` in the rows where the body carries λ and `c = g − λ` in the others, its traces `v` satisfy `v = c` and `v ≤ c`.
//! The forces that press on it solve the dual programme
//! ```math
//! min_P ½ Pᵀ Φ P + (c − B K⁺ f)ᵀ P,   P_i ≥ 0 in unilateral rows,   Qᵀ P = Qᵀ P_balance
//! ```
//! whose gradient is the opening `c − v`, and whose multipliers are the rigid motions. Against an obstacle `λ` is what is imposed on
//! it; what is free is one more rigid motion, since no other body touches it.
//!
//! With friction `−S ≤ P_i ≤ S` in the tangential rows, whose gap is the slip before the load step, and the gradient is the slip with the opposite sign.

use super::subdomain::{Carrier, Subdomain};
use crate::error::NnddError;
use contact_qp::{
    BoxQp, BoxResiduals, MatrixView, Place, QpPath, QpSettings, QpStatus, SparseRows, solve_box,
};
use nalgebra::DVector;

/// The answer of a body to λ.
pub(super) struct Response {
    /// Forces that press on the body, ≥ 0 in unilateral rows, N/m.
    pub(super) force: Vec<f64>,
    /// Openings `c − v`, exactly 0 where the body carries λ and where there is a unilateral force, m.
    pub(super) opening: Vec<f64>,
    /// Coefficients of the rigid motions that its forces balance.
    pub(super) motion: Vec<f64>,
    /// Where the forces are.
    pub(super) places: Vec<Place>,
    pub(super) status: QpStatus,
    pub(super) path: QpPath,
    pub(super) iterations: usize,
    pub(super) clarabel_calls: usize,
    pub(super) kkt: BoxResiduals,
}

/// The programme of a body, without λ.
pub(super) struct Unilateral {
    flexibility: Vec<f64>,
    /// `Qᵀ`.
    rows: SparseRows,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Unilateral {
    /// Sets up the programme; `None` if the body carries λ in all its rows.
    ///
    /// * `bounds`: of the forces in the unilateral rows, by row of the assembly, N/m.
    pub(super) fn new(body: &Subdomain<'_>, [lower, upper]: &[Vec<f64>; 2]) -> Option<Self> {
        let carries = |carrier: &Carrier| *carrier == Carrier::Itself;
        if body.carriers.iter().all(carries) {
            return None;
        }
        let of_rows = |bounds: &[f64], none: f64| {
            let bound = |(of, row): (&Carrier, &usize)| if carries(of) { none } else { bounds[*row] };
            body.carriers.iter().zip(&body.rows).map(bound).collect()
        };
        Some(Self {
            flexibility: body.flexibility_matrix(),
            rows: SparseRows::from_dense(body.len(), body.balanced.basis.as_slice()),
            lower: of_rows(lower, f64::NEG_INFINITY),
            upper: of_rows(upper, f64::INFINITY),
        })
    }

    /// Solves it.
    ///
    /// * `traces`: `c`; `places`: where the forces are at the start.
    pub(super) fn solve(
        &self,
        body: &Subdomain<'_>,
        traces: &DVector<f64>,
        places: Option<&[Place]>,
        settings: &QpSettings,
    ) -> Result<Response, NnddError> {
        let linear: Vec<f64> = traces.iter().zip(body.free.iter()).map(|(c, v)| c - v).collect();
        let qp = BoxQp {
            matrix: MatrixView::Dense { n: linear.len(), values: &self.flexibility },
            linear: &linear,
            lower: &self.lower,
            upper: &self.upper,
            rows: &self.rows,
            right_side: body.balanced.loads(),
        };
        let found = solve_box(&qp, places, settings)?;
        Ok(Response {
            force: found.x,
            opening: found.multipliers,
            motion: found.row_multipliers,
            places: found.places,
            status: found.status,
            path: found.path,
            iterations: found.iterations,
            clarabel_calls: found.clarabel_calls,
            kkt: found.kkt,
        })
    }
}

/// Imposes traces in all rows: no programme is needed.
pub(super) fn imposed(body: &Subdomain<'_>, traces: &DVector<f64>) -> Response {
    let (force, motion) = body.forces_of_traces(traces);
    Response {
        force: force.as_slice().to_vec(),
        opening: vec![0.0; body.len()],
        motion: motion.as_slice().to_vec(),
        places: vec![Place::Free; body.len()],
        status: QpStatus::Solved,
        path: QpPath::WarmStart,
        iterations: 0,
        clarabel_calls: 0,
        kkt: BoxResiduals::default(),
    }
}
