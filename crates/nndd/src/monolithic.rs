//! The interface Newton method: the reference for testing every other path.
//!
//! With `F = S₁⁻¹ + S₂⁻¹` and `c` the opening without contact force, the discrete contact problem is
//! `r ≥ 0, o = c + F r ≥ 0, r·o = 0`, the optimality conditions of `min ½ rᵀF r + cᵀr, r ≥ 0`. Semi-smooth
//! Newton on them is the primal-dual active-set method of `contact-qp`; the result is exact.

use crate::error::NnddError;
use crate::steps::each_role;
use contact_qp::{ActiveSet, BoundQp, MatrixView, QpSettings, QpSolution};
use fem_core::condensation::OrientedBody;
use fem_core::interface::ContactInterface;

/// The result of the Newton method: λ, and the solution of the quadratic programme.
pub(crate) struct NewtonAnswer {
    pub(crate) lambda: Vec<f64>,
    pub(crate) solution: QpSolution,
}

/// Solves the discrete contact problem.
///
/// * `open`: the pairs that are open at the start, if a good guess is known.
pub(crate) fn solve(
    interface: &ContactInterface,
    bodies: &[OrientedBody<'_>; 2],
    open: Option<&ActiveSet>,
    settings: &QpSettings,
) -> Result<NewtonAnswer, NnddError> {
    let n = bodies[0].len();
    let [mut flexibility, second] = each_role(|role| bodies[role].flexibility());
    flexibility.iter_mut().zip(&second).for_each(|(a, b)| *a += b);
    drop(second);
    let free = |b: &OrientedBody<'_>| {
        let mut v = vec![0.0; n];
        b.trace_from_force(&b.condensed_load(), &mut v);
        v
    };
    let (v1, v2) = (free(&bodies[0]), free(&bodies[1]));
    let opening: Vec<f64> =
        interface.pairs().iter().zip(v1.iter().zip(&v2)).map(|(p, (a, b))| p.gap - a + b).collect();
    let bounded: Vec<usize> = (0..n).collect();
    let qp = BoundQp {
        matrix: MatrixView::Dense { n, values: &flexibility },
        linear: &opening,
        bounded: &bounded,
        lower: &vec![0.0; n],
    };
    let solution = contact_qp::solve(&qp, open, settings)?;
    let force: Vec<f64> = bodies[0].condensed_load().iter().zip(&solution.x).map(|(g, r)| g - r).collect();
    let mut lambda = vec![0.0; n];
    bodies[0].trace_from_force(&force, &mut lambda);
    Ok(NewtonAnswer { lambda, solution })
}
