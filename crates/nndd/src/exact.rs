//! The exact solution of the discrete problem, for any number of bodies and pairs, floating ones among them.
//!
//! With one row per pair of nodes, `B_α` the normal trace of body α along the normals (+ for the first body of a pair,
//! − for the second), `K_α⁺` an inverse that is exact for loads in balance, and `R` the rigid motions of the floating bodies:
//! ```math
//! \min_P \; ½ P^T F P + q^T P, \quad P ≥ 0, \quad G P = e, \qquad
//! F = \sum_α B_α K_α^+ B_α^T, \quad q = g - \sum_α B_α K_α^+ f_α, \quad G = (B R)^T, \quad e = R^T f
//! ```
//! `G P = e` is the balance of the floating bodies, its multiplier `a` their rigid motion, and the gradient `F P + q − Gᵀ a` the
//! opening. `u_α = K_α⁺ (f_α − B_αᵀ P) + R_α a`.

use crate::balance::Balance;
use crate::error::NnddError;
use crate::recovery;
use crate::rows::{Rows, sign};
use contact_qp::{BoxQp, BoxResiduals, QpPath, QpSettings, QpStatus, solve_box};
use fem_core::body::RigidMotion;
use fem_core::geometry::Vector;
use fem_core::prepared::PreparedProblem;

/// The exact solution of the discrete problem.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ExactSolution {
    /// Displacement of each body, Cartesian, m.
    pub displacement: Vec<Vec<Vector>>,
    /// Contact force at the pairs of nodes of each pair, `P ≥ 0`, N/m.
    pub contact_force: Vec<Vec<f64>>,
    /// Opening at the pairs of nodes of each pair, ≥ 0, exactly 0 where there is a force, m.
    pub opening: Vec<Vec<f64>>,
    /// The rigid motions of the floating bodies: body, motion, and by how much.
    pub motions: Vec<(usize, RigidMotion, f64)>,
    /// How the programme ended.
    pub status: QpStatus,
    /// Method that solved it.
    pub path: QpPath,
    /// Active sets tried, or iterations of Clarabel.
    pub iterations: usize,
    /// Number of calls of Clarabel.
    pub clarabel_calls: usize,
    /// Residuals of its KKT conditions.
    pub kkt: BoxResiduals,
}

/// Solves the discrete contact problem.
///
/// # Errors
/// [`NnddError::NotHeld`] if the loads move bodies that nothing holds, with the motion; a programme that is rejected.
pub fn solve_exactly(problem: &PreparedProblem, settings: &QpSettings) -> Result<ExactSolution, NnddError> {
    let rows = Rows::new(problem);
    let balance = Balance::new(problem.problem(), problem.rigid_motions());
    balance.check_held(problem.problem())?;
    let (flexibility, linear) = programme(problem, &rows);
    let n = linear.len();
    let qp = BoxQp {
        matrix: &flexibility,
        linear: &linear,
        lower: &vec![0.0; n],
        upper: &vec![f64::INFINITY; n],
        rows: &balance.independent.rows,
        right_side: &balance.independent.right_side,
    };
    let found = solve_box(&qp, None, settings)?;
    let contact_force = rows.by_pair(&found.x);
    let motions = balance.motions.iter().zip(balance.independent.expanded(&found.row_multipliers));
    let motions: Vec<(usize, RigidMotion, f64)> = motions.map(|(of, a)| (of.body, of.motion, a)).collect();
    let force = |k: usize, side: usize| contact_force[k].iter().map(|p| -sign(side) * p).collect();
    let displacement = recovery::displacements(problem, force, &motions);
    Ok(ExactSolution {
        displacement,
        opening: rows.by_pair(&found.multipliers),
        contact_force,
        motions,
        status: found.status,
        path: found.path,
        iterations: found.iterations,
        clarabel_calls: found.clarabel_calls,
        kkt: found.kkt,
    })
}

/// Computes `F`, column-major, and `q`.
fn programme(problem: &PreparedProblem, rows: &Rows) -> (Vec<f64>, Vec<f64>) {
    let count = rows.len();
    let mut flexibility = vec![0.0; count * count];
    let mut linear = rows.gaps(problem);
    for (b, condensed) in problem.bodies().iter().enumerate() {
        let n = condensed.len();
        let inverse = condensed.flexibility();
        let mut free = vec![0.0; n];
        condensed.trace_from_force(condensed.condensed_load(), &mut free);
        let rows = rows.of_body(problem, b);
        for row in &rows {
            linear[row.row] -= row.of(&free) + row.imposed;
        }
        for of_j in &rows {
            let column = &mut flexibility[of_j.row * count..(of_j.row + 1) * count];
            for (q, b) in &of_j.terms {
                for of_i in &rows {
                    column[of_i.row] += b * of_i.of(&inverse[q * n..(q + 1) * n]);
                }
            }
        }
    }
    for (linear, trace) in linear.iter_mut().zip(rows.obstacles(problem)) {
        *linear -= trace.unwrap_or(0.0);
    }
    // Round-off must not make F unsymmetric.
    for j in 0..count {
        for i in 0..j {
            flexibility[j * count + i] = flexibility[i * count + j];
        }
    }
    (flexibility, linear)
}
