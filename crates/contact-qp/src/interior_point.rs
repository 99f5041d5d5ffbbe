//! Clarabel (Goulart and Chen 2024): scaling of the problem, the call, and its status. The only file that uses
//! Clarabel.

use crate::bound_state::BoundState;
use crate::disc::Disc;
use crate::error::QpError;
use crate::problem::MatrixView;
use crate::programme::{BoxQp, Units};
use crate::settings::QpSettings;
use crate::solution::QpStatus;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
    SupportedConeT, ZeroConeT,
};

/// Tolerance for an unconstrained direction of `x`. The relaxation of a badly conditioned problem grows along its
/// softest mode; with Clarabel's 1e-8 that mode would count as unconstrained.
const UNBOUNDED: f64 = 1e-12;

/// The last iterate of Clarabel.
pub(crate) struct BoxedPoint {
    /// How the call ended.
    pub(crate) status: QpStatus,
    /// Interior-point iterations.
    pub(crate) iterations: usize,
    /// `x`, perhaps outside its bounds by the tolerance.
    pub(crate) x: Vec<f64>,
    /// `a`.
    pub(crate) row_multipliers: Vec<f64>,
    /// An unknown is at a bound if its scaled multiplier exceeds its scaled distance from there.
    pub(crate) states: Vec<BoundState>,
}

/// Calls Clarabel in units that make its tolerance dimensionless and give all unknowns the same scale: with `d_i = √P_ii` and the load `f`,
/// `P'_ij = P_ij / (d_i d_j)`, `q'_i = q_i / (d_i f)`, `x'_i = d_i x_i / f`, and rows of length one.
///
/// * `discs`: whose unknowns have no bounds of their own; each is a cone `(r, x_i, x_j) √(d_i d_j) / f`.
///
/// # Errors
/// [`QpError::Library`] when Clarabel rejects the data.
pub(crate) fn solve_boxed(
    qp: &BoxQp<'_>,
    discs: &[Disc],
    settings: &QpSettings,
) -> Result<BoxedPoint, QpError> {
    let (n, m) = (qp.linear.len(), qp.right_side.len());
    let Units { roots, lengths: norms, load } = qp.units();
    // A fixed unknown is a row: between two equal bounds there is no interior.
    let mut in_disc = vec![false; n];
    let discs: Vec<&Disc> = discs.iter().filter(|disc| disc.radius > 0.0).collect();
    discs.iter().flat_map(|disc| disc.unknowns).for_each(|i| in_disc[i] = true);
    let is_fixed = |i: usize| qp.is_fixed(i) && !in_disc[i];
    let moves = |i: usize| f64::from(u8::from(!is_fixed(i)));
    let fixed: Vec<usize> = (0..n).filter(|i| is_fixed(*i)).collect();
    let bounded = |bounds: &[f64]| -> Vec<usize> {
        (0..n).filter(|i| bounds[*i].is_finite() && !is_fixed(*i) && !in_disc[*i]).collect()
    };
    let (below, above) = (bounded(qp.lower), bounded(qp.upper));
    let [first_below, first_above] = [m + fixed.len(), m + fixed.len() + below.len()];
    // Column by column: the equality rows, then x = l, then −x ≤ −l, then x ≤ u, then the cones.
    let first_disc = first_above + above.len();
    let size = |disc: &Disc| disc.unknowns.iter().map(|i| roots[*i]).product::<f64>().sqrt();
    let mut of_disc = vec![None; n];
    for (k, disc) in discs.iter().enumerate() {
        for (place, i) in disc.unknowns.into_iter().enumerate() {
            of_disc[i] = Some((first_disc + 3 * k + 1 + place, -size(disc) / roots[i]));
        }
    }
    let (mut starts, mut places, mut entries) = (vec![0], Vec::new(), Vec::new());
    let columns = qp.rows.transposed();
    for i in 0..n {
        for (k, g) in columns.row(i) {
            places.push(k);
            entries.push(g / roots[i] / norms[k]);
        }
        for (list, first, entry) in
            [(&fixed, m, 1.0), (&below, first_below, -1.0), (&above, first_above, 1.0)]
        {
            if let Ok(place) = list.binary_search(&i) {
                places.push(first + place);
                entries.push(entry);
            }
        }
        if let Some((place, entry)) = of_disc[i] {
            places.push(place);
            entries.push(entry);
        }
        starts.push(places.len());
    }
    let bounds = below.len() + above.len();
    let matrix = CscMatrix::new(first_disc + 3 * discs.len(), n, starts, places, entries);
    let scaled = |i: usize, bound: f64| bound * roots[i] / load;
    let rhs: Vec<f64> = (0..m)
        .map(|k| qp.right_side[k] / norms[k] / load)
        .chain(fixed.iter().map(|&i| scaled(i, qp.lower[i])))
        .chain(below.iter().map(|&i| -scaled(i, qp.lower[i])))
        .chain(above.iter().map(|&i| scaled(i, qp.upper[i])))
        .chain(discs.iter().flat_map(|disc| [size(disc) * disc.radius / load, 0.0, 0.0]))
        .collect();
    let linear: Vec<f64> = (0..n).map(|i| moves(i) * qp.linear[i] / roots[i] / load).collect();
    let mut cones: Vec<SupportedConeT<f64>> = Vec::new();
    if first_below > 0 {
        cones.push(ZeroConeT(first_below));
    }
    if bounds > 0 {
        cones.push(NonnegativeConeT(bounds));
    }
    cones.extend(discs.iter().map(|_| SecondOrderConeT(3)));
    let hessian = upper_triangle(&qp.matrix, &roots);
    let mut solver =
        DefaultSolver::new(&hessian, &linear, &matrix, &rhs, &cones, clarabel_settings(settings))
            .map_err(|error| QpError::Library { library: "clarabel", message: error.to_string() })?;
    solver.solve();
    let answer = &solver.solution;
    let mut states = vec![BoundState::Free; n];
    fixed.iter().for_each(|i| states[*i] = BoundState::Lower);
    for (first, list, place) in
        [(first_below, &below, BoundState::Lower), (first_above, &above, BoundState::Upper)]
    {
        for (k, &i) in list.iter().enumerate() {
            // Rows that leave no room make the multipliers of both bounds large.
            let above = scaled(i, qp.upper[i]) - answer.x[i] < answer.x[i] - scaled(i, qp.lower[i]);
            if answer.z[first + k] > answer.s[first + k] && above == (place == BoundState::Upper) {
                states[i] = place;
            }
        }
    }
    Ok(BoxedPoint {
        status: match answer.status {
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => QpStatus::Infeasible,
            other => status(other),
        },
        iterations: answer.iterations as usize,
        x: (0..n).map(|i| finite_or_zero(answer.x[i] * load / roots[i])).collect(),
        row_multipliers: (0..m).map(|k| finite_or_zero(-answer.z[k] * load / norms[k])).collect(),
        states,
    })
}

fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

fn upper_triangle(matrix: &MatrixView<'_>, roots: &[f64]) -> CscMatrix<f64> {
    match *matrix {
        MatrixView::Dense { n, values } => {
            let (mut starts, mut rows, mut entries) = (vec![0], Vec::new(), Vec::new());
            for j in 0..n {
                rows.extend(0..=j);
                entries.extend((0..=j).map(|i| values[j * n + i] / roots[i] / roots[j]));
                starts.push(entries.len());
            }
            CscMatrix::new(n, n, starts, rows, entries)
        }
        MatrixView::SparseUpper { n, column_starts, row_indices, values } => {
            let mut entries = Vec::with_capacity(values.len());
            for j in 0..n {
                let column = column_starts[j]..column_starts[j + 1];
                entries.extend(column.map(|k| values[k] / roots[row_indices[k]] / roots[j]));
            }
            CscMatrix::new(n, n, column_starts.to_vec(), row_indices.to_vec(), entries)
        }
    }
}

fn clarabel_settings(settings: &QpSettings) -> DefaultSettings<f64> {
    let tolerance = settings.tolerance;
    DefaultSettings {
        verbose: false,
        max_iter: u32::try_from(settings.max_iterations).unwrap_or(u32::MAX),
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        tol_infeas_abs: UNBOUNDED,
        tol_infeas_rel: UNBOUNDED,
        static_regularization_constant: settings.static_regularization,
        presolve_enable: false,
        max_threads: 1,
        ..DefaultSettings::default()
    }
}

fn status(status: SolverStatus) -> QpStatus {
    match status {
        SolverStatus::Solved => QpStatus::Solved,
        SolverStatus::AlmostSolved => QpStatus::AlmostSolved,
        SolverStatus::DualInfeasible => QpStatus::Unbounded,
        SolverStatus::MaxIterations => QpStatus::MaxIterations,
        SolverStatus::InsufficientProgress => QpStatus::InsufficientProgress,
        // Lower bounds always leave a feasible point, and there is no time limit and no callback: every other
        // status is a numerical error.
        _ => QpStatus::NumericalError,
    }
}
