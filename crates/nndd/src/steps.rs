//! The two steps of the iteration for any number of bodies, and the bound of the iteration's error.
//!
//! Each pair has its λ, the trace of the body, or the obstacle, that carries it. A body may carry λ in some pairs and
//! be unilateral in others, so no order or colouring of the bodies is needed. All bodies answer to λ at the same time
//! (step 1) and correct it at the same time (step 2): preconditioned descent on a convex function of λ whose gradient
//! is the imbalance.

use crate::active_set::ActiveSet;
use crate::balance::{Balance, NearestForces};
use crate::correction::Correction;
use crate::error::NnddError;
use crate::iterate::{Iterate, QpStats, Recovery, Tangential, UnilateralSolution, precision};
use crate::response::{Response, Unilateral, imposed};
use crate::subdomain::{LambdaOwner, Subdomain};
use contact_qp::{BoundState, KktResiduals, QpPath, QpSettings, QpStatus};
use fem_core::contact_system::ContactSystem;
use fem_core::norm::from_squared;
use fem_core::{each_body, try_each_body};
use nalgebra::DVector;
use neumann_neumann::dot;

/// The operators of both steps, and what step 1 remembers.
pub(crate) struct Steps<'a> {
    system: &'a ContactSystem<'a>,
    /// Finds the forces in balance that are nearest to those of step 1.
    nearest: NearestForces,
    bodies: &'a [Subdomain<'a>],
    correction: &'a Correction<'a>,
    qp: &'a QpSettings,
    programmes: Vec<Option<Unilateral<'a>>>,
    /// Where the forces of each body were in the last iteration.
    states: Vec<Option<Vec<BoundState>>>,
}

/// Step 1, by row of the assembly.
pub(crate) struct StepOne {
    /// λ, with the free motions of the obstacles, m.
    pub(crate) lambda: Vec<f64>,
    /// Forces that press on the bodies that carry λ, `−r¹`, and on the others, `r²`, N/m.
    carried: Vec<f64>,
    unilateral: Vec<f64>,
    /// Trace of the unilateral bodies along the outward normal or tangent of the others, `v²`, m.
    trace: Vec<f64>,
    /// Along tangents the slip with the opposite sign.
    opening: Vec<f64>,
    active: Vec<bool>,
    /// Body after body.
    responses: Vec<Response>,
    /// The amounts of the rigid motions.
    amounts: Vec<f64>,
}

impl<'a> Steps<'a> {
    pub(crate) fn new(
        system: &'a ContactSystem<'a>,
        balance: &Balance<'_>,
        (bodies, correction): (&'a [Subdomain<'a>], &'a Correction<'a>),
        qp: &'a QpSettings,
    ) -> Self {
        let rows = &system.rows;
        let bounds = rows.bounds(&rows.limits());
        Self {
            system,
            nearest: NearestForces::new(balance),
            bodies,
            correction,
            qp,
            programmes: each_body(bodies.len(), |b| Unilateral::new(&bodies[b], &bounds)),
            states: vec![None; bodies.len()],
        }
    }

    /// Starts with a known active set of all rows along normals, and full stick.
    pub(crate) fn start_from(&mut self, active: &ActiveSet) {
        let normal: Vec<bool> = (0..active.len()).map(|i| active.is_active(i)).collect();
        let stick: Vec<bool> =
            self.system.rows.tangentials(&self.system.rows.limits()).iter().map(|s| *s > 0.0).collect();
        let free = self.system.rows.joined(&normal, &stick);
        let place = |(carrier, row): (&LambdaOwner, &usize)| {
            let free = *carrier == LambdaOwner::Itself || free[*row];
            if free { BoundState::Free } else { BoundState::Lower }
        };
        let of_body = |body: &Subdomain<'_>| Some(body.carriers.iter().zip(&body.rows).map(place).collect());
        self.states = self.bodies.iter().map(of_body).collect();
    }

    /// Step 1: each body answers to λ, imposed in the rows where it carries λ (8) and unilateral in the others (9).
    pub(crate) fn step_1(&mut self, mut lambda: Vec<f64>) -> Result<StepOne, NnddError> {
        let rows = &self.system.rows.rows;
        let imposes = lambda.iter_mut().zip(rows);
        imposes.for_each(|(lambda, row)| *lambda = row.obstacle.unwrap_or(*lambda));
        let respond = |b: usize| {
            let body = &self.bodies[b];
            let bound = |(carrier, row): (&LambdaOwner, &usize)| match carrier {
                LambdaOwner::Itself => lambda[*row],
                LambdaOwner::Other | LambdaOwner::Obstacle => rows[*row].gap - lambda[*row],
            };
            let bounds = DVector::from_iterator(body.len(), body.carriers.iter().zip(&body.rows).map(bound));
            match &self.programmes[b] {
                None => Ok(imposed(body, &bounds)),
                Some(programme) => programme.solve(body, &bounds, self.states[b].as_deref(), self.qp),
            }
        };
        let responses: Vec<Response> = try_each_body(self.bodies.len(), respond)?;
        self.states = responses.iter().map(|response| Some(response.states.clone())).collect();
        let amounts = self.amounts(&responses);
        self.move_obstacles(&amounts, &mut lambda);
        Ok(self.answers(lambda, responses, amounts))
    }

    /// Step 2: the Neumann problems (10) and (11) of all bodies under their shares of the imbalance `j = P¹ − P² = −(r¹ + r²)`,
    /// and the direction `w¹ − w²` in which their traces change λ. [`Correction`] has the signs of the shares.
    pub(crate) fn step_2(&self, answers: &StepOne) -> Vec<f64> {
        let pressing = answers.carried.iter().zip(&answers.unilateral);
        let imbalance: Vec<f64> = pressing.map(|(first, second)| first - second).collect();
        self.correction.apply(&imbalance)
    }

    /// Sorts the responses of the bodies by row.
    fn answers(&self, lambda: Vec<f64>, responses: Vec<Response>, amounts: Vec<f64>) -> StepOne {
        let rows = &self.system.rows.rows;
        let zero = vec![0.0; rows.len()];
        let [mut carried, mut unilateral, mut trace, mut opening] =
            [zero.clone(), zero.clone(), zero.clone(), zero];
        let mut active = vec![false; rows.len()];
        for (body, response) in self.bodies.iter().zip(&responses) {
            for (i, &row) in body.rows.iter().enumerate() {
                if body.carriers[i] != LambdaOwner::Other {
                    carried[row] = response.force[i];
                }
                if body.carriers[i] != LambdaOwner::Itself {
                    unilateral[row] = response.force[i];
                    opening[row] = response.opening[i];
                    active[row] = response.states[i] == BoundState::Free;
                    let from_opening = || lambda[row] - rows[row].gap + opening[row];
                    trace[row] = response.trace.as_ref().map_or_else(from_opening, |v| 0.0 - v[i]);
                }
            }
        }
        StepOne { lambda, carried, unilateral, trace, opening, active, responses, amounts }
    }

    /// Computes `η² = Σ_α (P̃ − P^α)ᵀ Φ_α (P̃ − P^α) + 2 P̃ᵀ o` with the forces `P̃ ≥ 0` in balance that are
    /// nearest, as pressures, to those of the unilateral bodies; infinite if no forces are in balance. Friction adds
    /// `2 Σ (S|w| − Q̃ w)`, with `|Q̃| ≤ S`. For two held bodies `P̃ = r²`, and this is (22), `η = ‖w̄‖` with `S₁ w̄ = r¹ + r²`.
    pub(crate) fn eta_nndd(&mut self, answers: &StepOne) -> Result<f64, NnddError> {
        let StepOne { unilateral, opening, responses, .. } = answers;
        let Some(forces) = self.nearest.to(unilateral, |i| unilateral[i] > 0.0)? else {
            return Ok(f64::INFINITY);
        };
        let squares = each_body(self.bodies.len(), |b| {
            let body = &self.bodies[b];
            let change = body.gather(&forces) - DVector::from_column_slice(&responses[b].force);
            // A body that is unilateral in all its rows, and in balance.
            if change.amax() == 0.0 { 0.0 } else { change.dot(&body.flexibility(&change)) }
        });
        let work = dot(&forces, opening) + self.sliding(opening);
        Ok(from_squared(squares.iter().sum::<f64>() + 2.0 * work))
    }

    /// Computes `Σ S|w|`, J/m.
    fn sliding(&self, opening: &[f64]) -> f64 {
        let limits = self.system.rows.tangentials(&self.system.rows.limits());
        self.system.rows.tangentials(opening).iter().zip(limits).map(|(y, limit)| limit * y.abs()).sum()
    }

    /// Puts the iterate together; its number and θ are not known yet. `ε_t` is (24).
    pub(crate) fn iterate_of(&self, eta_nndd: f64, answers: StepOne) -> Iterate {
        let rows = &self.system.rows;
        let StepOne { lambda, carried, unilateral, trace, opening, active, responses, amounts } = answers;
        let reaction: Vec<f64> = carried.iter().map(|p| 0.0 - p).collect();
        let tangential = Tangential {
            lambda: rows.tangentials(&lambda),
            reaction: rows.tangentials(&reaction),
            force: rows.tangentials(&unilateral),
            slip: rows.tangentials(&opening).iter().map(|y| 0.0 - y).collect(),
            limit: rows.tangentials(&rows.limits()),
        };
        let unsolved = responses.iter().map(|r| r.status).find(|status| !status.is_solved());
        let contact = UnilateralSolution {
            normal_trace: rows.normals(&trace),
            normal_reaction: rows.normals(&unilateral),
            active: ActiveSet::new(rows.normals(&active)),
            status: unsolved.unwrap_or(QpStatus::Solved),
            path: slowest(&responses),
            iterations: responses.iter().map(|r| r.iterations).max().unwrap_or(0),
            clarabel_calls: responses.iter().map(|r| r.clarabel_calls).sum(),
            kkt: worst(&responses),
        };
        let reaction = rows.normals(&reaction);
        Iterate {
            iteration: 0,
            theta: 0.0,
            precision: precision(rows, &reaction, &contact.normal_reaction),
            eta_nndd,
            lambda: rows.normals(&lambda),
            reaction,
            opening: rows.normals(&opening),
            programme: QpStats { path: contact.path, iterations: contact.iterations },
            contact,
            recovery: Recovery::Traces,
            amounts,
            tangential,
            step: [0; 2],
            own: None,
        }
    }

    /// Returns the amounts of the rigid motions of all bodies and obstacles.
    fn amounts(&self, responses: &[Response]) -> Vec<f64> {
        let mut amounts = vec![0.0; self.system.rows.motions.len()];
        for (body, response) in self.bodies.iter().zip(responses) {
            for (number, amount) in body.balanced.amounts(&response.motion) {
                amounts[number] = amount;
            }
        }
        amounts
    }

    /// Adds the free motions of the obstacles to their λ.
    fn move_obstacles(&self, amounts: &[f64], lambda: &mut [f64]) {
        let motions = self.system.rows.motions.iter().zip(amounts);
        for (motion, amount) in motions.filter(|(motion, _)| motion.partner.is_obstacle()) {
            motion.traces.iter().for_each(|(row, trace)| lambda[*row] += amount * trace);
        }
    }
}

/// Returns the slowest method that solved the programme of a body.
fn slowest(responses: &[Response]) -> QpPath {
    let any = |path: QpPath| responses.iter().any(|r| r.path == path).then_some(path);
    any(QpPath::Clarabel).or(any(QpPath::ActiveSet)).unwrap_or(QpPath::WarmStart)
}

/// Returns the largest residuals of the programmes of all bodies.
fn worst(responses: &[Response]) -> KktResiduals {
    responses.iter().fold(KktResiduals::default(), |worst, Response { kkt, .. }| KktResiduals {
        stationarity: worst.stationarity.max(kkt.stationarity),
        rows: worst.rows.max(kkt.rows),
        primal: worst.primal.max(kkt.primal),
        dual: worst.dual.max(kkt.dual),
        complementarity: worst.complementarity.max(kkt.complementarity),
    })
}
