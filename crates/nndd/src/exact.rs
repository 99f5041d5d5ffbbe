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
use crate::unheld::UnheldMotion;
use contact_qp::{BoxQp, BoxResiduals, QpPath, QpSettings, QpStatus, nonnegative_least_squares, solve_box};
use fem_core::body::RigidMotion;
use fem_core::each_body;
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
    /// Opening at the pairs of nodes of each pair, ≥ 0, exactly 0 if there is a force, m.
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

/// A load of a motion below this fraction of all loads is round-off.
const NO_LOAD: f64 = 1e-10;

/// Solves the discrete contact problem.
///
/// # Errors
/// [`NnddError::NotHeld`] if the loads move bodies that nothing holds, with the motion; a programme that is rejected.
pub fn solve_exactly(problem: &PreparedProblem, settings: &QpSettings) -> Result<ExactSolution, NnddError> {
    let rows = Rows::new(problem);
    let motions = motions(problem);
    let (balance, loads) = balance(problem, &motions, &rows);
    if let Some(motion) = unheld(problem, &motions, &balance, &loads)? {
        return Err(NnddError::NotHeld { motion });
    }
    let (flexibility, linear) = rows.programme(problem);
    let n = linear.len();
    let qp = BoxQp {
        matrix: &flexibility,
        linear: &linear,
        lower: &vec![0.0; n],
        upper: &vec![f64::INFINITY; n],
        rows: &balance,
        right_side: &loads,
    };
    let found = solve_box(&qp, None, settings)?;
    let contact_force = rows.by_pair(&found.x);
    let displacement = each_body(problem.bodies().len(), |b| {
        let condensed = &problem.bodies()[b];
        let forces: Vec<Vec<f64>> = problem
            .problem()
            .sides_of(b)
            .map(|(k, side)| contact_force[k].iter().map(|p| -sign(side) * p).collect())
            .collect();
        let mut u = condensed.displacement_from_force(&condensed.dofs().interface_forces(&forces));
        let body = &problem.problem().bodies[b];
        for ((_, motion), a) in motions.iter().zip(&found.row_multipliers).filter(|((of, _), _)| *of == b) {
            u.iter_mut().zip(motion.displacements(body)).for_each(|(u, moved)| *u += *a * moved);
        }
        u
    });
    let moved = motions.into_iter().zip(found.row_multipliers).map(|((b, motion), a)| (b, motion, a));
    Ok(ExactSolution {
        displacement,
        opening: rows.by_pair(&found.multipliers),
        contact_force,
        motions: moved.collect(),
        status: found.status,
        path: found.path,
        iterations: found.iterations,
        clarabel_calls: found.clarabel_calls,
        kkt: found.kkt,
    })
}

/// The sign of a side in the rows: the normal points out of the first body.
fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// Lists the rigid motions of all floating bodies.
fn motions(problem: &PreparedProblem) -> Vec<(usize, RigidMotion)> {
    let bodies = problem.problem().bodies.iter().enumerate();
    bodies.flat_map(|(b, body)| body.rigid_motions().into_iter().map(move |motion| (b, motion))).collect()
}

/// Computes `G`, row after row, and `e`.
fn balance(problem: &PreparedProblem, motions: &[(usize, RigidMotion)], rows: &Rows) -> (Vec<f64>, Vec<f64>) {
    let contact = problem.problem();
    let mut matrix = vec![0.0; motions.len() * rows.count];
    let mut loads = vec![0.0; motions.len()];
    for (m, (b, motion)) in motions.iter().enumerate() {
        let moved = motion.displacements(&contact.bodies[*b]);
        for (k, side) in contact.sides_of(*b) {
            for (i, pair) in contact.contacts[k].interface.pairs().iter().enumerate() {
                let trace = moved[pair.nodes[side]].dot(&pair.normal);
                matrix[m * rows.count + rows.starts[k] + i] += sign(side) * trace;
            }
        }
        loads[m] = problem.external_forces()[*b].iter().zip(&moved).map(|(force, u)| force.dot(u)).sum();
    }
    (matrix, loads)
}

/// Finds the motion that the loads cause and nothing resists; `None` if the assembly is held.
fn unheld(
    problem: &PreparedProblem,
    motions: &[(usize, RigidMotion)],
    balance: &[f64],
    loads: &[f64],
) -> Result<Option<UnheldMotion>, NnddError> {
    if motions.is_empty() {
        return Ok(None);
    }
    let (_, free) = nonnegative_least_squares(balance, loads)?;
    let forces = problem.external_forces().iter().flatten();
    let size = forces.map(|f| f.norm()).sum::<f64>();
    let norm = free.iter().map(|a| a * a).sum::<f64>().sqrt();
    if norm <= NO_LOAD * size {
        return Ok(None);
    }
    let mut bodies: Vec<(usize, RigidMotion)> = Vec::new();
    for ((b, motion), a) in motions.iter().zip(&free) {
        let mut scaled = *motion;
        scaled.translation *= *a;
        scaled.spin *= *a;
        match bodies.iter_mut().find(|(of, known)| of == b && known.piece == motion.piece) {
            Some((_, sum)) => {
                sum.translation += scaled.translation;
                sum.spin += scaled.spin;
            }
            None => bodies.push((*b, scaled)),
        }
    }
    let largest = |(b, motion): &(usize, RigidMotion)| {
        let moved = motion.displacements(&problem.problem().bodies[*b]);
        moved.iter().map(|u| u.norm()).fold(0.0, f64::max)
    };
    let most = bodies.iter().map(largest).fold(0.0, f64::max);
    bodies.retain(|moved| largest(moved) > NO_LOAD * most);
    for (_, motion) in &mut bodies {
        motion.translation /= most;
        motion.spin /= most;
    }
    let work: f64 = loads.iter().zip(&free).map(|(e, a)| e * a).sum();
    Ok(Some(UnheldMotion { bodies, load: work / most }))
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
        // Round-off must not make F unsymmetric.
        for j in 0..self.count {
            for i in 0..j {
                flexibility[j * self.count + i] = flexibility[i * self.count + j];
            }
        }
        (flexibility, linear)
    }
}
