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

use crate::error::NnddError;
use crate::held::{Balance, sign};
use crate::recovery;
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
    if let Some(motion) = balance.unheld(problem.problem(), problem.rigid_motions())? {
        return Err(NnddError::NotHeld { motion });
    }
    let (flexibility, linear) = rows.programme(problem);
    let n = linear.len();
    let qp = BoxQp {
        matrix: &flexibility,
        linear: &linear,
        lower: &vec![0.0; n],
        upper: &vec![f64::INFINITY; n],
        rows: &balance.rows.rows,
        right_side: &balance.rows.right_side,
    };
    let found = solve_box(&qp, None, settings)?;
    let contact_force = rows.by_pair(&found.x);
    let motions = problem.rigid_motions().iter().zip(balance.rows.expanded(&found.row_multipliers));
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

/// The rows of all pairs.
struct Rows {
    /// Where the rows of each pair begin.
    starts: Vec<usize>,
    count: usize,
}

impl Rows {
    fn new(problem: &PreparedProblem) -> Self {
        let (mut starts, mut count) = (Vec::new(), 0);
        for pair in &problem.problem().contacts {
            starts.push(count);
            count += pair.interface.pairs().len();
        }
        Self { starts, count }
    }

    fn by_pair(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let ends = self.starts.iter().skip(1).chain([&self.count]);
        self.starts.iter().zip(ends).map(|(start, end)| values[*start..*end].to_vec()).collect()
    }

    /// Computes `F`, column-major, and `q`.
    fn programme(&self, problem: &PreparedProblem) -> (Vec<f64>, Vec<f64>) {
        let contact = problem.problem();
        let mut flexibility = vec![0.0; self.count * self.count];
        let gaps = contact.contacts.iter().flat_map(|pair| pair.interface.pairs().iter().map(|p| p.gap));
        let mut linear: Vec<f64> = gaps.collect();
        for (b, condensed) in problem.bodies().iter().enumerate() {
            let n = condensed.len();
            let inverse = condensed.flexibility();
            let mut free = vec![0.0; n];
            condensed.trace_from_force(condensed.condensed_load(), &mut free);
            let mut rows = Vec::new();
            for (block, (k, side)) in contact.sides_of(b).enumerate() {
                for (i, row) in condensed.dofs().rows(block).iter().enumerate() {
                    let terms = row.terms.map(|(unknown, a)| (unknown as usize, sign(side) * a));
                    let trace: f64 = terms.iter().filter(|t| t.1 != 0.0).map(|(j, a)| a * free[*j]).sum();
                    linear[self.starts[k] + i] -= trace + sign(side) * row.imposed;
                    rows.push((self.starts[k] + i, terms));
                }
            }
            for (j, of_j) in &rows {
                let column = &mut flexibility[j * self.count..(j + 1) * self.count];
                for (q, b) in of_j.iter().filter(|t| t.1 != 0.0) {
                    for (i, of_i) in &rows {
                        let sum: f64 =
                            of_i.iter().filter(|t| t.1 != 0.0).map(|(p, a)| a * inverse[q * n + p]).sum();
                        column[*i] += b * sum;
                    }
                }
            }
        }
        for (k, pair) in contact.contacts.iter().enumerate() {
            let Some(obstacle) = contact.obstacle_of(pair) else { continue };
            for (i, (pair, u)) in pair.interface.pairs().iter().zip(obstacle.imposed()).enumerate() {
                linear[self.starts[k] + i] += u.dot(&pair.normal);
            }
        }
        // Round-off must not make F unsymmetric.
        for j in 0..self.count {
            for i in 0..j {
                flexibility[j * self.count + i] = flexibility[i * self.count + j];
            }
        }
        (flexibility, linear)
    }
}
