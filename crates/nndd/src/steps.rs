//! The four problems of an iteration, (8)-(11), in the interface unknowns.

use crate::error::NnddError;
use crate::iterate::ContactAnswer;
use contact_qp::{ActiveSet, CheckedMatrix, MatrixView, QpSettings, QpSolution};
use fem_core::condensation::OrientedBody;

/// Solves the steps' problems. This is the only difference between the condensed path and the literal one.
pub(crate) trait Steps: Sync {
    /// (8): imposes λ on Ω₁ and returns its reaction `r¹`.
    fn dirichlet(&self, lambda: &[f64]) -> Vec<f64>;

    /// (9): solves Ω₂'s unilateral problem `v² ≥ lower`.
    fn contact(
        &self,
        lower: &[f64],
        warm_start: Option<&ActiveSet>,
        settings: &QpSettings,
    ) -> Result<ContactAnswer, NnddError>;

    /// (10), (11): returns the trace of the correction of a body under a normal force.
    fn neumann(&self, body: usize, force: &[f64]) -> Vec<f64>;
}

/// Steps by the interface operators: `r = S v − g̃`, `w = S⁻¹ r`.
pub(crate) struct CondensedSteps<'a> {
    bodies: &'a [OrientedBody<'a>; 2],
    matrix: CheckedMatrix<'a>,
    linear: Vec<f64>,
    bounded: Vec<usize>,
}

impl<'a> CondensedSteps<'a> {
    pub(crate) fn new(bodies: &'a [OrientedBody<'a>; 2]) -> Result<Self, NnddError> {
        let n = bodies[1].len();
        let matrix = CheckedMatrix::new(MatrixView::Dense { n, values: bodies[1].schur() })?;
        let linear = bodies[1].condensed_load().iter().map(|g| -g).collect();
        Ok(Self { bodies, matrix, linear, bounded: (0..n).collect() })
    }
}

impl Steps for CondensedSteps<'_> {
    fn dirichlet(&self, lambda: &[f64]) -> Vec<f64> {
        let mut reaction = vec![0.0; lambda.len()];
        self.bodies[0].reaction(lambda, &mut reaction);
        reaction
    }

    fn contact(
        &self,
        lower: &[f64],
        warm_start: Option<&ActiveSet>,
        settings: &QpSettings,
    ) -> Result<ContactAnswer, NnddError> {
        let solution =
            contact_qp::solve_with(&self.matrix, &self.linear, &self.bounded, lower, warm_start, settings)?;
        let trace = solution.x.clone();
        Ok(answer(solution, trace))
    }

    fn neumann(&self, body: usize, force: &[f64]) -> Vec<f64> {
        let mut trace = vec![0.0; force.len()];
        self.bodies[body].trace_from_force(force, &mut trace);
        trace
    }
}

/// Computes something for Ω₁ and Ω₂, in parallel.
pub(crate) fn each_role<T: Send>(of_role: impl Fn(usize) -> T + Sync) -> [T; 2] {
    let (first, second) = rayon::join(|| of_role(0), || of_role(1));
    [first, second]
}

/// Extracts the interface part of a programme's solution.
pub(crate) fn answer(solution: QpSolution, normal_trace: Vec<f64>) -> ContactAnswer {
    ContactAnswer {
        normal_trace,
        normal_reaction: solution.multipliers,
        active: solution.active,
        status: solution.status,
        path: solution.path,
        iterations: solution.iterations,
        clarabel_calls: solution.clarabel_calls,
        kkt: solution.kkt,
    }
}
