//! The exact solution as one iteration.

use crate::active_set::ActiveSet;
use crate::error::NnddError;
use crate::exact::{ExactSolution, solve_exactly};
use crate::friction::PairFriction;
use crate::iterate::{Iterate, IterationRow, QpStats, Recovery, Tangential, UnilateralSolution};
use crate::response::residuals;
use crate::settings::NewtonSettings;
use crate::solution::{NnddSolution, NnddStatus};
use crate::stopping::{Decision, StoppingCriterion};
use fem_core::contact_system::ContactSystem;
use fem_core::norm::from_squared;

/// Solves the discrete problem exactly: the only iterate.
pub(crate) fn solve(
    system: &ContactSystem<'_>,
    settings: &NewtonSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let NewtonSettings { max_iterations, qp } = settings;
    let qp = qp.clone().with_max_iterations((*max_iterations).max(1).min(qp.max_iterations));
    let last = solve_exactly(system, &qp)?.iterate(system);
    let UnilateralSolution { status, clarabel_calls, .. } = last.contact;
    let status = if !status.is_solved() {
        NnddStatus::ContactQpUnsolved(status)
    } else {
        match stop.check(&last).map_err(NnddError::Criterion)? {
            Decision::Interrupt => NnddStatus::Interrupted,
            // The discrete problem is solved; no iteration follows.
            Decision::Stop | Decision::Continue => NnddStatus::StoppedByCriterion,
        }
    };
    let history = vec![IterationRow::from(&last)];
    Ok(NnddSolution { status, history, last, theta: 0.0, spectrum: None, clarabel_calls })
}

impl ExactSolution {
    /// Returns the solution as an iterate, with number 1. Its `η_NNDD` is the energy of the rounding errors `δ` of the openings,
    /// `√(Σ S_ii δ_i²)`.
    ///
    /// * `system`: the one that was solved.
    pub fn iterate(&self, system: &ContactSystem<'_>) -> Iterate {
        let rows = &system.rows;
        let stiffness = row_stiffness(system);
        let slip: Vec<f64> = self.friction.iter().flat_map(|of| of.slip.iter().map(|w| 0.0 - w)).collect();
        let openings = rows.joined(&self.opening.concat(), &slip);
        let (mut lambda, mut second_trace, mut squared) = (Vec::new(), Vec::new(), 0.0);
        for (i, (row, opening)) in rows.rows.iter().zip(openings).enumerate() {
            let roles = rows.pairs[row.pair].roles;
            // Along the outward normal of Ω₁.
            let first = self.traces[roles.imposed()][i];
            let second = 0.0 - self.traces[roles.unilateral()][i];
            let defect = row.gap - (first - second) - opening;
            squared += stiffness[i] * defect * defect;
            lambda.push(first);
            second_trace.push(second);
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
            programme: QpStats { path: self.path, iterations: self.iterations },
            theta: 0.0,
            precision: 0.0,
            eta_nndd: from_squared(squared),
            recovery: Recovery::Forces,
            amounts: self.fields.amounts.clone(),
            tangential,
            step: [0; 2],
            own: None,
            contact: UnilateralSolution {
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

/// Computes `S_ii` of each row, N/m²: of Ω₁, or of the body against an obstacle, which has no stiffness of its own.
fn row_stiffness(system: &ContactSystem<'_>) -> Vec<f64> {
    let mut stiffness = vec![0.0; system.rows.len()];
    for (body, of_body) in system.bodies.iter().zip(&system.of_body) {
        let diagonal = body.diagonal();
        for row in of_body {
            let pair = &system.rows.pairs[system.rows.rows[row.row].pair];
            if pair.partner.is_obstacle() || pair.roles.imposed() == row.side {
                stiffness[row.row] = row.terms.iter().map(|(k, a)| a * a * diagonal[*k]).sum();
            }
        }
    }
    stiffness
}
