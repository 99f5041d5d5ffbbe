//! The exact solution as one iteration.

use crate::active_set::ActiveSet;
use crate::error::NnddError;
use crate::exact::{ExactSolution, solve_exactly};
use crate::friction::PairFriction;
use crate::iterate::{ContactAnswer, Iterate, Programme, Recovery, Tangential};
use crate::iteration::Exact;
use crate::response::residuals;
use crate::rows::Rows;
use crate::settings::NewtonSettings;
use fem_core::geometry::Vector;
use fem_core::norm::from_squared;
use fem_core::prepared::PreparedProblem;

/// Solves the discrete problem exactly, and returns it as the iterate with the given number.
pub(crate) fn solve(
    problem: &PreparedProblem,
    settings: &NewtonSettings,
    number: usize,
) -> Result<Exact, NnddError> {
    let NewtonSettings { max_iterations, qp } = settings;
    let qp = qp.clone().with_max_iterations((*max_iterations).max(1).min(qp.max_iterations));
    let iterate = Iterate { iteration: number, ..solve_exactly(problem, &qp)?.iterate(problem) };
    let ContactAnswer { status, clarabel_calls, .. } = iterate.contact;
    Ok(Exact { iterate, status, clarabel_calls })
}

impl ExactSolution {
    /// Returns the solution as an iterate, with number 1. Its `η_NNDD` is the energy of the rounding errors `δ` of the openings,
    /// `√(Σ S_ii δ_i²)`.
    ///
    /// * `problem`: the one that was solved.
    pub fn iterate(&self, problem: &PreparedProblem) -> Iterate {
        let rows = Rows::new(problem.problem());
        let gaps = rows.gaps(problem);
        let (mut lambda, mut second_trace, mut squared) = (Vec::new(), Vec::new(), 0.0);
        for (k, pair) in problem.problem().contacts.iter().enumerate() {
            let sides = pair.roles.sides();
            // An obstacle has no stiffness of its own.
            let elastic = problem.problem().bodies_of(pair).map(|(side, _)| side);
            let stiffness = row_stiffness(
                problem,
                k,
                elastic.min_by_key(|side| pair.roles.of_side(*side)).unwrap_or_default(),
            );
            let openings = self.opening[k].iter().copied().chain(self.friction[k].slip.iter().map(|w| -w));
            let known = gaps[rows.at(k, 0)..].iter().zip(openings);
            for ((row, (gap, opening)), stiffness) in pair.rows().zip(known).zip(stiffness) {
                let trace = |side: usize| {
                    let u: Vector = self.displacement[pair.bodies[side]][row.nodes[side].index()];
                    pair.roles.sign() * u.dot(&row.direction)
                };
                let [first, second] = sides.map(trace);
                let defect = gap - (first - second) - opening;
                squared += stiffness * defect * defect;
                lambda.push(first);
                second_trace.push(second);
            }
        }
        let of_pairs =
            |take: fn(&PairFriction) -> &Vec<f64>| self.friction.iter().flat_map(take).copied().collect();
        let friction: Vec<f64> = of_pairs(|of| &of.force);
        let tangential = Tangential {
            lambda: rows.tangentials(&lambda),
            reaction: friction.iter().map(|q| 0.0 - q).collect(),
            force: friction,
            slip: of_pairs(|of| &of.slip),
            limit: of_pairs(|of| &of.limit),
        };
        let (lambda, normal_trace) = (rows.normals(&lambda), rows.normals(&second_trace));
        let force = self.contact_force.concat();
        let opening = self.opening.concat();
        Iterate {
            iteration: 1,
            lambda,
            reaction: force.iter().map(|p| 0.0 - p).collect(),
            programme: Programme { path: self.path, iterations: self.iterations },
            theta: 0.0,
            precision: 0.0,
            eta_nndd: from_squared(squared),
            recovery: Recovery::Forces,
            motions: self.motions.clone(),
            tangential,
            contact: ContactAnswer {
                normal_trace,
                normal_reaction: force,
                active: ActiveSet::new(opening.iter().map(|o| *o == 0.0).collect()),
                status: self.status,
                path: self.path,
                iterations: self.iterations,
                clarabel_calls: self.clarabel_calls,
                kkt: residuals(self.kkt),
            },
            opening,
        }
    }
}

/// Computes `S_ii` of a side of a pair, N/m².
fn row_stiffness(problem: &PreparedProblem, pair: usize, side: usize) -> Vec<f64> {
    let body = problem.problem().contacts[pair].bodies[side];
    let condensed = &problem.bodies()[body];
    let Some(block) = problem.problem().sides_of(body).position(|of| of == (pair, side)) else {
        unreachable!("side {side} of pair {pair} is not one of body {body}")
    };
    let diagonal = |k: u32| condensed.schur()[k as usize * (condensed.len() + 1)];
    let rows = condensed.dofs().rows(block).iter();
    rows.map(|row| row.terms.iter().filter(|t| t.1 != 0.0).map(|(k, a)| a * a * diagonal(*k)).sum()).collect()
}
