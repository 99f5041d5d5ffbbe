//! Clarabel (Goulart and Chen 2024): scaling of the problem, the call, and its status. The only file that uses
//! Clarabel.

use crate::active_set::ActiveSet;
use crate::error::QpError;
use crate::kkt;
use crate::place::Place;
use crate::polish::{Admissible, Prepared, positive_part};
use crate::problem::{BoundQp, MatrixView};
use crate::programme::BoxQp;
use crate::settings::QpSettings;
use crate::solution::QpStatus;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT, ZeroConeT,
};

/// A bound further than this below zero, in scaled length, is not passed to Clarabel: it is very unlikely to become
/// active, and Clarabel stalls on very large right-hand sides. The polish checks it like any other.
const FAR_BOUND: f64 = 1e8;

/// Tolerance for an unconstrained direction of `x`. The relaxation of a badly conditioned problem grows along its
/// softest mode; with Clarabel's 1e-8 that mode would count as unconstrained.
const UNBOUNDED: f64 = 1e-12;

/// The result of Clarabel.
pub(crate) struct InteriorPoint {
    /// How the call ended.
    pub(crate) status: QpStatus,
    /// Interior-point iterations.
    pub(crate) iterations: usize,
    /// The last iterate, moved onto the bounds that are active in it.
    pub(crate) iterate: Admissible,
}

/// Calls Clarabel.
///
/// # Errors
/// [`QpError::Library`] when Clarabel rejects the data.
pub(crate) fn solve(problem: &Prepared<'_>, settings: &QpSettings) -> Result<InteriorPoint, QpError> {
    Scaled::new(problem).solve(&problem.qp, settings)
}

/// The problem in units that make a tolerance dimensionless and give all unknowns the same scale: with `d_i = √P_ii`
/// and the load `f`, `P'_ij = P_ij / (d_i d_j)`, `q'_i = q_i / (d_i f)`, `x'_i = d_i x_i / f`, `r'_i = r_i / (d_i f)`.
struct Scaled<'a> {
    /// `d`.
    roots: &'a [f64],
    /// `f`.
    load: f64,
    matrix: CscMatrix<f64>,
    linear: Vec<f64>,
    /// Places in `bounded` of the bounds that are passed to Clarabel.
    near: Vec<usize>,
    rows: CscMatrix<f64>,
    rhs: Vec<f64>,
}

impl<'a> Scaled<'a> {
    fn new(problem: &'a Prepared<'_>) -> Self {
        let (qp, roots) = (&problem.qp, problem.scales.roots());
        let load = load(qp, roots);
        let bound = |k: usize| qp.lower[k] * roots[qp.bounded[k]] / load;
        let near: Vec<usize> = (0..qp.lower.len()).filter(|&k| bound(k) > -FAR_BOUND).collect();
        Self {
            roots,
            load,
            matrix: upper_triangle(&qp.matrix, roots),
            linear: qp.linear.iter().zip(roots).map(|(value, root)| value / root / load).collect(),
            rows: selection(qp, &near),
            rhs: near.iter().map(|&k| -bound(k)).collect(),
            near,
        }
    }

    fn solve(&self, qp: &BoundQp<'_>, settings: &QpSettings) -> Result<InteriorPoint, QpError> {
        let cones: Vec<SupportedConeT<f64>> =
            if self.near.is_empty() { Vec::new() } else { vec![NonnegativeConeT(self.near.len())] };
        let mut solver = DefaultSolver::new(
            &self.matrix,
            &self.linear,
            &self.rows,
            &self.rhs,
            &cones,
            clarabel_settings(settings),
        )
        .map_err(|error| QpError::Library { library: "clarabel", message: error.to_string() })?;
        solver.solve();
        let answer = &solver.solution;
        Ok(InteriorPoint {
            status: status(answer.status),
            iterations: answer.iterations as usize,
            iterate: self.admissible(qp, &answer.x, &answer.z),
        })
    }

    /// Determines the active set by comparing slack and dual, and moves the iterate onto it: `k` is active when
    /// `r'_k > x'_k − l'_k`, that is `r_k > P_kk (x_k − l_k)`.
    fn admissible(&self, qp: &BoundQp<'_>, x: &[f64], z: &[f64]) -> Admissible {
        let mut x: Vec<f64> =
            x.iter().zip(self.roots).map(|(value, root)| finite_or_zero(value * self.load / root)).collect();
        let mut multipliers = vec![0.0; qp.bounded.len()];
        for (&k, &value) in self.near.iter().zip(z) {
            multipliers[k] = positive_part(finite_or_zero(value * self.load * self.roots[qp.bounded[k]]));
        }
        let mut flags = vec![false; qp.bounded.len()];
        for (k, &i) in qp.bounded.iter().enumerate() {
            let opening = x[i] - qp.lower[k];
            flags[k] = opening <= 0.0 || multipliers[k] > qp.matrix.diagonal(i) * opening;
            if flags[k] {
                x[i] = qp.lower[k];
            } else {
                multipliers[k] = 0.0;
            }
        }
        Admissible { x, multipliers, active: ActiveSet::new(flags) }
    }
}

/// Returns `f = max(|q|_D, |P l⁺|_D)`: the loads that `x` must balance. Only the positive part of `l` is a load,
/// so distant bounds do not distort the unit. Without loads the solution is 0 and any unit is suitable.
fn load(qp: &BoundQp<'_>, roots: &[f64]) -> f64 {
    let mut pushed = vec![0.0; qp.linear.len()];
    for (&i, &lower) in qp.bounded.iter().zip(qp.lower) {
        pushed[i] = positive_part(lower);
    }
    let mut reaction = vec![0.0; pushed.len()];
    qp.matrix.add_product(&pushed, &mut reaction);
    let force = |values: &[f64]| kkt::largest(values.iter().zip(roots).map(|(value, root)| value / root));
    let load = force(qp.linear).max(force(&reaction));
    if load > 0.0 {
        return load;
    }
    let length = kkt::largest(qp.bounded.iter().zip(qp.lower).map(|(&i, lower)| lower * roots[i]));
    if length > 0.0 { length } else { 1.0 }
}

/// The result of Clarabel for a [`BoxQp`].
pub(crate) struct BoxedPoint {
    pub(crate) status: QpStatus,
    pub(crate) iterations: usize,
    pub(crate) x: Vec<f64>,
    pub(crate) row_multipliers: Vec<f64>,
    pub(crate) places: Vec<Place>,
}

/// Calls Clarabel for a programme with bounds on both sides and equality rows, in the units of [`Scaled`].
///
/// # Errors
/// [`QpError::Library`] when Clarabel rejects the data.
pub(crate) fn solve_boxed(qp: &BoxQp<'_>, settings: &QpSettings) -> Result<BoxedPoint, QpError> {
    let (n, m) = (qp.linear.len(), qp.right_side.len());
    let stiffest = (0..n).map(|i| qp.matrix.diagonal(i)).fold(0.0, f64::max);
    // A fixed unknown is a row: between two equal bounds there is no interior. Neither its stiffness, which may be rounding, nor its load counts.
    let is_fixed = |i: usize| qp.lower[i] == qp.upper[i];
    let moves = |i: usize| f64::from(u8::from(!is_fixed(i)));
    // An unknown without stiffness of its own gets the largest one.
    let own = |i: usize| Some(qp.matrix.diagonal(i)).filter(|d| *d > 0.0 && !is_fixed(i));
    let root = |i: usize| own(i).unwrap_or(stiffest).sqrt();
    let roots: Vec<f64> = (0..n).map(root).map(|r| if r > 0.0 { r } else { 1.0 }).collect();
    let finite = |v: f64| if v.is_finite() { v.abs() } else { 0.0 };
    let norms: Vec<f64> = qp
        .rows
        .rows()
        .map(|row| row.map(|(i, g)| (g / roots[i]).powi(2)).sum::<f64>().sqrt())
        .map(|norm| if norm > 0.0 { norm } else { 1.0 })
        .collect();
    let of_linear = (0..n).map(|i| moves(i) * (qp.linear[i] / roots[i]).abs());
    let of_bounds = (0..n).map(|i| finite(qp.lower[i]).max(finite(qp.upper[i])) * roots[i]);
    let of_rows = (0..m).map(|k| (qp.right_side[k] / norms[k]).abs());
    let load = of_linear.chain(of_bounds).chain(of_rows).fold(0.0, f64::max);
    let load = if load > 0.0 { load } else { 1.0 };
    let fixed: Vec<usize> = (0..n).filter(|i| is_fixed(*i)).collect();
    let bounded = |bounds: &[f64]| -> Vec<usize> {
        (0..n).filter(|i| bounds[*i].is_finite() && !is_fixed(*i)).collect()
    };
    let (below, above) = (bounded(qp.lower), bounded(qp.upper));
    let [first_below, first_above] = [m + fixed.len(), m + fixed.len() + below.len()];
    // Column by column: the equality rows, then x = l, then −x ≤ −l, then x ≤ u.
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
        starts.push(places.len());
    }
    let bounds = below.len() + above.len();
    let matrix = CscMatrix::new(first_below + bounds, n, starts, places, entries);
    let scaled = |i: usize, bound: f64| bound * roots[i] / load;
    let rhs: Vec<f64> = (0..m)
        .map(|k| qp.right_side[k] / norms[k] / load)
        .chain(fixed.iter().map(|&i| scaled(i, qp.lower[i])))
        .chain(below.iter().map(|&i| -scaled(i, qp.lower[i])))
        .chain(above.iter().map(|&i| scaled(i, qp.upper[i])))
        .collect();
    let linear: Vec<f64> = (0..n).map(|i| moves(i) * qp.linear[i] / roots[i] / load).collect();
    let mut cones: Vec<SupportedConeT<f64>> = Vec::new();
    if first_below > 0 {
        cones.push(ZeroConeT(first_below));
    }
    if bounds > 0 {
        cones.push(NonnegativeConeT(bounds));
    }
    let hessian = upper_triangle(&qp.matrix, &roots);
    let mut solver =
        DefaultSolver::new(&hessian, &linear, &matrix, &rhs, &cones, clarabel_settings(settings))
            .map_err(|error| QpError::Library { library: "clarabel", message: error.to_string() })?;
    solver.solve();
    let answer = &solver.solution;
    let mut places = vec![Place::Free; n];
    fixed.iter().for_each(|i| places[*i] = Place::Lower);
    for (first, list, place) in [(first_below, &below, Place::Lower), (first_above, &above, Place::Upper)] {
        for (k, &i) in list.iter().enumerate() {
            if answer.z[first + k] > answer.s[first + k] {
                places[i] = place;
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
        places,
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

/// Makes the rows `−x_i ≤ −l_i`, one per bound in `near`: an entry −1 in column i.
fn selection(qp: &BoundQp<'_>, near: &[usize]) -> CscMatrix<f64> {
    let n = qp.linear.len();
    let mut starts = vec![0; n + 1];
    for &k in near {
        starts[qp.bounded[k] + 1] = 1;
    }
    for j in 0..n {
        starts[j + 1] += starts[j];
    }
    // The bounded unknowns are sorted, so that row k is entry k.
    CscMatrix::new(near.len(), n, starts, (0..near.len()).collect(), vec![-1.0; near.len()])
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
