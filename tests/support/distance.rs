//! Bounds against the solution of a finer mesh, for problems without reference values.
//!
//! The exact solution `u` has the least potential energy `J` of all admissible fields, and `e_CRE² ≥ 2 (J(u_h) − J(u))`. The solution `u_f` of a
//! mesh that is refined from the one of `u_h` is admissible, and `‖u_f − u_h‖² ≤ 2 (J(u_h) − J(u_f))`, since it has the least energy in a space that
//! holds `u_h`. So its distance from `u_h` must not be larger than the bound.

use crate::finer::finer;
use crate::model::{ContactProblem, Made, Vector};
use case_io::Case;
use certified_contact::{Settings, Silent, solve};
use contact_qp::QpSettings;
use fem_core::norm::energy_distance_squared;
use fem_core::prepared::PreparedProblem;
use nndd::solve_exactly;

/// How the bound of a problem ended.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It is certified.
    Certified {
        /// `e_CRE`, square root of J/m.
        bound: f64,
        /// The distance to the solution of the finer mesh.
        error: f64,
    },
    /// It is not valid, with the checks that fail.
    NotValid {
        /// Name and value of each.
        checks: Vec<(&'static str, f64)>,
    },
    /// The case is refused, with the message.
    Refused(String),
}

/// Computes the distance of displacements to the discrete solution on a mesh that is refined `times` times, square root of J/m.
///
/// # Errors
/// A finer problem that cannot be solved.
pub fn distance(problem: &ContactProblem, u: &[Vec<Vector>], times: usize) -> Made<f64> {
    let (problem, u) = finer(problem.clone(), u.to_vec(), times)?;
    let prepared = PreparedProblem::new(problem)?;
    let exact = solve_exactly(&prepared.system(), &QpSettings::default())?;
    if !exact.status.is_solved() {
        return Err(format!("the finer problem is not solved: {:?}", exact.status).into());
    }
    let displacement = prepared.displacements(&exact.fields);
    let bodies = prepared.problem().bodies.iter().zip(u.iter().zip(&displacement));
    Ok(bodies.map(|(body, (u, v))| energy_distance_squared(body, u, v)).sum::<f64>().sqrt())
}

/// Solves a problem with the default settings, and measures the error of a certified bound on a mesh that is refined `times` times.
///
/// # Errors
/// A finer problem that cannot be solved.
pub fn outcome(problem: ContactProblem, times: usize) -> Made<Outcome> {
    let solution = match solve(problem, &Settings::default(), &mut Silent) {
        Ok(solution) => solution,
        Err(error) => return Ok(Outcome::Refused(error.to_string())),
    };
    let Some(estimate) = &solution.estimate else {
        return Ok(Outcome::Refused("no estimate".to_owned()));
    };
    if !solution.is_certified() {
        return Ok(Outcome::NotValid { checks: estimate.admissibility.failed().collect() });
    }
    let u: Vec<Vec<Vector>> = estimate.pair.displacements().into_iter().map(<[Vector]>::to_vec).collect();
    Ok(Outcome::Certified {
        bound: estimate.unchecked().e_cre,
        error: distance(&solution.problem, &u, times)?,
    })
}

/// [`outcome`] of the problem of a case file.
///
/// # Errors
/// As [`outcome`].
pub(crate) fn outcome_of_text(text: &str, times: usize) -> Made<Outcome> {
    match Case::parse(text, "random.toml", &[]).and_then(|case| case.build()) {
        Ok((problem, _)) => outcome(problem, times),
        Err(error) => Ok(Outcome::Refused(error.to_string())),
    }
}
