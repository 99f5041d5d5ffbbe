//! The two steps for two held bodies with one pair, and the dispatch. The interface Newton method is in `newton`.

mod newton;

use crate::assembly;
use crate::error::NnddError;
use crate::iterate::{ContactAnswer, Iterate, Programme, Recovery, Tangential, precision};
use crate::iteration::{Pass, Start, explain, iterate, successor, switch};
use crate::literal::LiteralSteps;
use crate::settings::{Method, NnddSettings, Path, Weights};
use crate::solution::{NnddSolution, NnddStatus};
use crate::spectrum;
use crate::steps::{CondensedSteps, Steps, each_role};
use crate::stopping::StoppingCriterion;
use crate::vector::{add, dot};
use crate::weights::NodalWeights;
use contact_qp::{ActiveSet, QpSettings};
use fem_core::condensation::OrientedBody;
use fem_core::interface::{ContactInterface, ContactPair};
use fem_core::norm::from_squared;
use fem_core::prepared::PreparedProblem;

impl Run<'_> {
    /// The algorithm box, without the update.
    fn pass(&mut self, lambda: Vec<f64>) -> Result<Pass, NnddError> {
        // Step 1: λ imposed on Ω₁ (8), unilateral contact of Ω₂ (9).
        let (reaction, contact) = self.step_1(&lambda)?;
        // Step 2: the Neumann problems (10) and (11) under the imbalance r¹ + r².
        let imbalance = add(&reaction, &contact.normal_reaction);
        let [w1, w2] = self.step_2(&imbalance);
        // The indicators: η_NNDD (22), ε_t (24).
        let eta_nndd = self.eta_nndd(&imbalance, &w1);
        let direction = self.weights.update([&w1, &w2]);
        let iterate = self.iterate_of(eta_nndd, lambda.clone(), reaction, contact);
        Ok(Pass { iterate, lambda, direction })
    }

    /// Step 1: imposes λ on Ω₁ (8) and solves Ω₂'s contact problem (9).
    fn step_1(&mut self, lambda: &[f64]) -> Result<(Vec<f64>, ContactAnswer), NnddError> {
        let lower: Vec<f64> = lambda.iter().zip(self.interface.pairs()).map(|(l, p)| l - p.gap).collect();
        let (steps, warm, qp) = (self.steps, self.warm_start.as_ref(), self.qp);
        let (reaction, contact) = rayon::join(|| steps.dirichlet(lambda), || steps.contact(&lower, warm, qp));
        let contact = contact?;
        self.warm_start = Some(contact.active.clone());
        Ok((reaction, contact))
    }

    /// Step 2: the traces of the corrections, (10) and (11), under shares of the imbalance.
    fn step_2(&self, imbalance: &[f64]) -> [Vec<f64>; 2] {
        let loads = self.weights.loads(imbalance);
        each_role(|role| self.steps.neumann(role, &loads[role]))
    }

    /// Computes `η_NNDD = ‖w̄‖ = √((r¹+r²)·w̄)` with `S₁ w̄ = r¹ + r²`, (22). With half weights `w̄ = −2 w¹`.
    fn eta_nndd(&self, imbalance: &[f64], w1: &[f64]) -> f64 {
        from_squared(if self.weights.is_half() {
            -2.0 * dot(imbalance, w1)
        } else {
            dot(imbalance, &self.steps.neumann(0, imbalance))
        })
    }

    /// The iterate, whose number and θ are not known yet.
    fn iterate_of(
        &self,
        eta_nndd: f64,
        lambda: Vec<f64>,
        reaction: Vec<f64>,
        contact: ContactAnswer,
    ) -> Iterate {
        let pairs = self.interface.pairs();
        let opening =
            (0..pairs.len()).map(|i| contact.normal_trace[i] - (lambda[i] - pairs[i].gap)).collect();
        let precision = precision(pairs.iter(), &reaction, &contact.normal_reaction);
        let programme = Programme { path: contact.path, iterations: contact.iterations };
        let (recovery, motions) = (Recovery::Traces, Vec::new());
        Iterate {
            iteration: 0,
            lambda,
            opening,
            theta: 0.0,
            precision,
            eta_nndd,
            reaction,
            contact,
            programme,
            recovery,
            motions,
            tangential: Tangential::default(),
        }
    }
}

/// The operators and settings of the iteration.
struct Run<'a> {
    interface: &'a ContactInterface,
    /// Ω₁ and Ω₂, along the outward normal of Ω₁.
    bodies: &'a [OrientedBody<'a>; 2],
    steps: &'a dyn Steps,
    weights: &'a NodalWeights,
    qp: &'a QpSettings,
    warm_start: Option<ActiveSet>,
}

impl<'a> Run<'a> {
    fn new(
        pair: &'a ContactPair,
        bodies: &'a [OrientedBody<'a>; 2],
        steps: &'a dyn Steps,
        weights: &'a NodalWeights,
        qp: &'a QpSettings,
    ) -> Self {
        Self { interface: &pair.interface, bodies, steps, weights, qp, warm_start: None }
    }
}

/// Solves a contact problem by the Neumann-Neumann iteration (8)-(11), or by the interface Newton method.
///
/// Two held bodies with one pair have an algorithm of their own. Anything else is an assembly: see the page of this crate; the
/// interface Newton method is then [`crate::solve_exactly`], whose solution is the only iterate.
///
/// * `lambda`: the initial normal trace λ of each Ω₁ at its pairs of nodes, pair after pair, m; with friction each pair's tangential
///   traces follow its normal ones. The Newton method does not use it.
/// * `method`: settings of either, such as [`NnddSettings::default`].
/// * `stop`: called after every iteration.
///
/// The pair of step 1 of the last iteration is in `last`; it is kinematically admissible exactly.
///
/// # Errors
/// Sizes that do not match, a θ that is not positive, a contact problem that is rejected, a
/// criterion that fails. No convergence is a status, not an error. For an assembly: [`NnddError::NotHeld`]; for its iteration
/// [`NnddError::DependentRows`] and, with [`Path::Literal`], [`NnddError::Unsupported`].
pub fn solve(
    problem: &PreparedProblem,
    lambda: Vec<f64>,
    method: impl Into<Method>,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    solve_from(problem, Start { lambda, active: None }, &method.into(), stop)
}

/// Solves a contact problem like [`solve`], starting from the result of a similar one.
///
/// # Errors
/// See [`solve`].
pub fn solve_from(
    problem: &PreparedProblem,
    start: Start,
    method: &Method,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    check(problem, &start, method)?;
    let Some(pair) = problem.problem().held_pair() else {
        return assembly::solve(problem, start, method, stop);
    };
    let bodies = &problem.sides(0);
    match method {
        Method::Newton(settings) => {
            let steps = CondensedSteps::new(bodies)?;
            let weights = NodalWeights::new(bodies, Weights::Half);
            let mut run = Run::new(pair, bodies, &steps, &weights, &settings.qp);
            run.exact(None, settings, 1)?.alone(stop)
        }
        Method::Nndd(settings) => iteration(problem, pair, start, settings, stop),
    }
}

/// Iterates, and uses the Newton method if that fails.
fn iteration(
    problem: &PreparedProblem,
    pair: &ContactPair,
    start: Start,
    settings: &NnddSettings,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    let bodies = &problem.sides(0);
    let weights = NodalWeights::new(bodies, settings.weights);
    let estimate = || spectrum::estimate(bodies, &weights);
    // The best value for identical bodies.
    let identical = if weights.is_half() { 0.5 } else { 1.0 };
    let (theta, spectrum) = spectrum::choose_theta(settings.theta, identical, estimate);
    let literal;
    let condensed;
    let steps: &dyn Steps = match settings.path {
        Path::Condensed => {
            condensed = CondensedSteps::new(bodies)?;
            &condensed
        }
        Path::Literal => {
            literal = LiteralSteps::new(problem.problem(), pair)?;
            &literal
        }
    };
    let mut run = Run::new(pair, bodies, steps, &weights, &settings.qp);
    run.warm_start = start.active;
    let mut solution = iterate(start.lambda, (settings, theta), stop, |lambda| run.pass(lambda))?;
    if let Some(newton) = successor(&solution, settings, stop) {
        // The contact nodes of a diverged iteration are useless.
        let closed = match solution.status {
            NnddStatus::Diverged { .. } => None,
            _ => Some(solution.last.contact.active.clone()),
        };
        let found = run.exact(closed, newton, solution.history.len() + 1);
        solution = switch(solution, found, stop)?;
    }
    Ok(explain(solution, spectrum, estimate, stop))
}

/// Checks what is given.
fn check(
    problem: &PreparedProblem,
    Start { lambda, active }: &Start,
    method: &Method,
) -> Result<(), NnddError> {
    let (expected, found) = (problem.rows(), lambda.len());
    if found != expected {
        return Err(NnddError::Length { what: "lambda", found, expected });
    }
    if let Some(pair) = lambda.iter().position(|l| !l.is_finite()) {
        return Err(NnddError::Lambda { pair, found: lambda[pair] });
    }
    let expected = problem.node_pairs();
    let found = active.as_ref().map_or(expected, ActiveSet::len);
    if found != expected {
        return Err(NnddError::Length { what: "the active set at the start", found, expected });
    }
    match method {
        Method::Nndd(NnddSettings { theta: Some(found), .. }) if !(*found > 0.0 && found.is_finite()) => {
            Err(NnddError::Theta { found: *found })
        }
        _ => Ok(()),
    }
}
