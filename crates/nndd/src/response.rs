//! Step 1 of one body: traces imposed in the rows where it carries λ (8), unilateral contact in the others (9).
//!
//! With `c = λ` in the rows where the body carries λ and `c = g − λ` in the others, its traces `v` satisfy `v = c` and `v ≤ c`. A held
//! body without friction has one unknown per unilateral row, its trace:
//! ```math
//! min_v ½ vᵀ S v − g̃ᵀ v,   v_i ≤ c_i                           P = g̃ − S v ≥ 0
//! ```
//! The forces that press on any other body solve the dual programme
//! ```math
//! min_P ½ Pᵀ Φ P + (c − B K⁺ f)ᵀ P,   P_i ≥ 0 in unilateral rows,   Qᵀ P = Qᵀ P_balance
//! ```
//! whose gradient is the opening `c − v`, and whose multipliers are the rigid motions. Against an obstacle `λ` is what is imposed on
//! it; what is free is one more rigid motion, since no other body touches it.
//!
//! With friction `−S ≤ P_i ≤ S` in the tangential rows, whose gap is the slip before the load step, and the gradient is the slip with the opposite sign.

use crate::error::NnddError;
use crate::subdomain::{LambdaOwner, Subdomain};
use contact_qp::{
    BoundState, BoxQp, KktResiduals, MatrixView, QpPath, QpSettings, QpStatus, SparseRows, solve_box,
};
use nalgebra::DVector;

/// The answer of a body to λ.
pub(crate) struct Response {
    /// Forces that press on the body, ≥ 0 in unilateral rows, N/m.
    pub(crate) force: Vec<f64>,
    /// Openings `c − v`, exactly 0 where the body carries λ and where there is a unilateral force, m.
    pub(crate) opening: Vec<f64>,
    /// Traces `v`, if they are the unknowns, m.
    pub(crate) trace: Option<Vec<f64>>,
    /// Coefficients of the rigid motions that its forces balance.
    pub(crate) motion: Vec<f64>,
    /// Where the forces are.
    pub(crate) states: Vec<BoundState>,
    pub(crate) status: QpStatus,
    pub(crate) path: QpPath,
    pub(crate) iterations: usize,
    pub(crate) clarabel_calls: usize,
    pub(crate) kkt: KktResiduals,
}

/// The programme of a body, without λ.
pub(crate) enum Unilateral<'a> {
    /// In the traces of the unilateral rows, with `S` of these rows.
    Traces(&'a [f64]),
    /// In the forces of all rows.
    Forces {
        /// `Φ`, column-major.
        flexibility: Vec<f64>,
        /// `Qᵀ`.
        balance: SparseRows,
        lower: Vec<f64>,
        upper: Vec<f64>,
    },
}

impl<'a> Unilateral<'a> {
    /// Sets up the programme; `None` if the body carries λ in all its rows.
    ///
    /// * `bounds`: of the forces in the unilateral rows, by row of the assembly, N/m.
    pub(crate) fn new(body: &'a Subdomain<'_>, [lower, upper]: &[Vec<f64>; 2]) -> Option<Self> {
        let unilateral = &body.unilateral;
        if unilateral.is_empty() {
            return None;
        }
        let presses = |i: &usize| lower[body.rows[*i]] == 0.0 && upper[body.rows[*i]] == f64::INFINITY;
        if let Some(values) = body.held_stiffness.as_deref().filter(|_| unilateral.iter().all(presses)) {
            return Some(Self::Traces(values));
        }
        let of_rows = |bounds: &[f64], none: f64| {
            let bound = |(carrier, row): (&LambdaOwner, &usize)| match carrier {
                LambdaOwner::Itself => none,
                LambdaOwner::Other | LambdaOwner::Obstacle => bounds[*row],
            };
            body.carriers.iter().zip(&body.rows).map(bound).collect()
        };
        Some(Self::Forces {
            flexibility: body.flexibility_matrix(),
            balance: SparseRows::from_dense(body.len(), body.balanced.basis.as_slice()),
            lower: of_rows(lower, f64::NEG_INFINITY),
            upper: of_rows(upper, f64::INFINITY),
        })
    }

    /// Solves it.
    ///
    /// * `bounds`: `c`; `states`: of the forces at the start.
    pub(crate) fn solve(
        &self,
        body: &Subdomain<'_>,
        bounds: &DVector<f64>,
        states: Option<&[BoundState]>,
        settings: &QpSettings,
    ) -> Result<Response, NnddError> {
        match self {
            Self::Traces(stiffness) => in_traces(stiffness, body, bounds, states, settings),
            Self::Forces { flexibility, balance, lower, upper } => {
                let linear: Vec<f64> = bounds.iter().zip(body.free.iter()).map(|(c, v)| c - v).collect();
                let qp = BoxQp {
                    matrix: MatrixView::Dense { n: linear.len(), values: flexibility },
                    linear: &linear,
                    lower,
                    upper,
                    rows: balance,
                    right_side: body.balanced.loads(),
                };
                // Clarabel takes a programme with rows whole, which on a large body costs more than all iterations.
                let found = solve_box(&qp, states, &settings.clone().active_sets_first())?;
                Ok(Response {
                    force: found.x,
                    opening: found.multipliers,
                    trace: None,
                    motion: found.row_multipliers,
                    states: found.states,
                    status: found.status,
                    path: found.path,
                    iterations: found.iterations,
                    clarabel_calls: found.counts.clarabel_calls(),
                    kkt: residuals(found.kkt),
                })
            }
        }
    }
}

/// Solves the programme in the traces; its unknowns are `−v ≥ −c`.
fn in_traces(
    stiffness: &[f64],
    body: &Subdomain<'_>,
    bounds: &DVector<f64>,
    states: Option<&[BoundState]>,
    settings: &QpSettings,
) -> Result<Response, NnddError> {
    let unilateral = &body.unilateral;
    let mut trace = bounds.clone();
    unilateral.iter().for_each(|i| trace[*i] = 0.0);
    let (rest, _) = body.forces_of_traces(&trace);
    let linear: Vec<f64> = unilateral.iter().map(|i| rest[*i]).collect();
    let lower: Vec<f64> = unilateral.iter().map(|i| -bounds[*i]).collect();
    let n = unilateral.len();
    let qp = BoxQp {
        matrix: MatrixView::Dense { n, values: stiffness },
        linear: &linear,
        lower: &lower,
        upper: &vec![f64::INFINITY; n],
        rows: &SparseRows::new(n),
        right_side: &[],
    };
    // A trace is at its bound if there may be a force.
    let place = |of_force: BoundState| {
        if of_force == BoundState::Free { BoundState::Lower } else { BoundState::Free }
    };
    let start = states.map(|of| unilateral.iter().map(|i| place(of[*i])).collect::<Vec<BoundState>>());
    let found = solve_box(&qp, start.as_deref(), settings)?;
    unilateral.iter().zip(&found.x).for_each(|(i, x)| trace[*i] = -x);
    let (mut opening, mut states) = (vec![0.0; body.len()], vec![BoundState::Free; body.len()]);
    let mut force = if unilateral.len() == body.len() { rest } else { body.forces_of_traces(&trace).0 };
    for (k, &i) in unilateral.iter().enumerate() {
        (force[i], opening[i]) = (found.multipliers[k], bounds[i] - trace[i]);
        if found.states[k] == BoundState::Free {
            states[i] = BoundState::Lower;
        }
    }
    Ok(Response {
        force: force.as_slice().to_vec(),
        opening,
        trace: Some(trace.as_slice().to_vec()),
        motion: Vec::new(),
        states,
        status: found.status,
        path: found.path,
        iterations: found.iterations,
        clarabel_calls: found.counts.clarabel_calls(),
        kkt: found.kkt,
    })
}

/// Imposes traces in all rows: no programme is needed.
pub(crate) fn imposed(body: &Subdomain<'_>, traces: &DVector<f64>) -> Response {
    let (force, motion) = body.forces_of_traces(traces);
    Response {
        force: force.as_slice().to_vec(),
        opening: vec![0.0; body.len()],
        trace: None,
        motion: motion.as_slice().to_vec(),
        states: vec![BoundState::Free; body.len()],
        status: QpStatus::Solved,
        path: QpPath::WarmStart,
        iterations: 0,
        clarabel_calls: 0,
        kkt: KktResiduals::default(),
    }
}

/// Names the residuals of the programme in the forces by what they are in the contact problem: its bounds are signs of forces
/// there, and its multipliers the openings.
pub(crate) fn residuals(of_forces: KktResiduals) -> KktResiduals {
    KktResiduals { primal: of_forces.dual, dual: of_forces.primal, ..of_forces }
}
