//! The algorithm box of the paper: one loop. The interface Newton method is in `newton`.

mod newton;

use crate::acceleration::Accelerator;
use crate::assembly;
use crate::error::NnddError;
use crate::iterate::{ContactAnswer, Iterate, IterationRow, Programme, Recovery};
use crate::literal::LiteralSteps;
use crate::monitor::Monitor;
use crate::settings::{Acceleration, Method, NnddSettings, Path, Weights};
use crate::solution::{NnddSolution, NnddStatus};
use crate::spectrum;
use crate::steps::{CondensedSteps, Steps, each_role};
use crate::stopping::{Decision, StoppingCriterion};
use crate::vector::{add, dot};
use crate::weights::NodalWeights;
use contact_qp::{ActiveSet, QpSettings};
use fem_core::condensation::OrientedBody;
use fem_core::interface::{ContactInterface, ContactPair, NodePair};
use fem_core::norm::from_squared;
use fem_core::prepared::PreparedProblem;

impl Run<'_> {
    /// The algorithm box.
    fn iterate(
        &mut self,
        mut lambda: Vec<f64>,
        (settings, theta): (&NnddSettings, f64),
        stop: &mut dyn StoppingCriterion,
    ) -> Result<NnddSolution, NnddError> {
        let mut update = Accelerator::new(settings.acceleration, theta);
        let mut monitor = Monitor::default();
        let (mut history, mut clarabel_calls) = (Vec::new(), 0);
        loop {
            // Step 1: λ imposed on Ω₁ (8), unilateral contact of Ω₂ (9).
            let (reaction, contact) = self.step_1(&lambda)?;
            clarabel_calls += contact.clarabel_calls;
            // Step 2: the Neumann problems (10) and (11) under the imbalance r¹ + r².
            let imbalance = add(&reaction, &contact.normal_reaction);
            let [w1, w2] = self.step_2(&imbalance);
            // The indicators: η_NNDD (22), ε_t (24).
            let eta_nndd = self.eta_nndd(&imbalance, &w1);
            // The update: λ ← λ + θ (w¹ − w²)·n.
            let step = update.step(&lambda, self.weights.update([&w1, &w2]), eta_nndd);
            let iteration = history.len() + 1;
            let last = self.iterate_of(iteration, step.theta, eta_nndd, lambda, reaction, contact);
            history.push(IterationRow::from(&last));
            // Stop, or give up?
            let mut status = self.verdict(&last, settings, &mut monitor, stop)?;
            lambda = if status.is_none() { step.lambda } else { Vec::new() };
            if lambda.iter().any(|x| !x.is_finite()) {
                status = Some(NnddStatus::Diverged { best: monitor.smallest(), theta_limit: None });
            }
            if let Some(status) = status {
                let (switch, spectrum) = (None, None);
                return Ok(NnddSolution { status, switch, history, last, theta, spectrum, clarabel_calls });
            }
        }
    }

    /// Tells whether and how the iteration ends with this iterate.
    fn verdict(
        &self,
        iterate: &Iterate,
        settings: &NnddSettings,
        monitor: &mut Monitor,
        stop: &mut dyn StoppingCriterion,
    ) -> Result<Option<NnddStatus>, NnddError> {
        if !iterate.contact.status.is_solved() {
            return Ok(Some(NnddStatus::ContactQpUnsolved(iterate.contact.status)));
        }
        Ok(match stop.check(iterate).map_err(NnddError::Criterion)? {
            Decision::Stop => Some(NnddStatus::StoppedByCriterion),
            Decision::Interrupt => Some(NnddStatus::Interrupted),
            Decision::Continue if iterate.iteration >= settings.max_iterations => {
                Some(NnddStatus::MaxIterations)
            }
            Decision::Continue => {
                monitor.judge(iterate.eta_nndd, settings.acceleration == Acceleration::None)
            }
        })
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

    fn iterate_of(
        &self,
        iteration: usize,
        theta: f64,
        eta_nndd: f64,
        lambda: Vec<f64>,
        reaction: Vec<f64>,
        contact: ContactAnswer,
    ) -> Iterate {
        let pairs = self.interface.pairs();
        let opening =
            (0..pairs.len()).map(|i| contact.normal_trace[i] - (lambda[i] - pairs[i].gap)).collect();
        let precision = precision(pairs, &reaction, &contact.normal_reaction);
        let programme = Programme { path: contact.path, iterations: contact.iterations };
        let (recovery, motions) = (Recovery::Traces, Vec::new());
        Iterate {
            iteration,
            lambda,
            opening,
            theta,
            precision,
            eta_nndd,
            reaction,
            contact,
            programme,
            recovery,
            motions,
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

/// Computes `ε_t = 2 max|t¹+t²| / (max|t¹|+max|t²|)`, the paper's precision, (24), with `t_i = r_i/ℓ_i`.
fn precision(pairs: &[NodePair], r1: &[f64], r2: &[f64]) -> f64 {
    let largest = |r: &dyn Fn(usize) -> f64| {
        let tractions = (0..pairs.len()).map(|i| (r(i) / pairs[i].tributary_length).abs());
        // A NaN must show: it would pass for a small imbalance.
        tractions.fold(0.0, |largest: f64, t| if t > largest || t.is_nan() { t } else { largest })
    };
    let scale = largest(&|i| r1[i]) + largest(&|i| r2[i]);
    if scale == 0.0 { 0.0 } else { 2.0 * largest(&|i| r1[i] + r2[i]) / scale }
}

/// Solves a contact problem by the Neumann-Neumann iteration (8)-(11), or by the interface Newton method.
///
/// For anything but two held bodies with one pair the second method is [`crate::solve_exactly`], whose solution is the only
/// iterate.
///
/// * `lambda`: the initial normal trace λ of each Ω₁ at its pairs of nodes, pair after pair, m; the Newton method does not
///   use it.
/// * `method`: settings of either, such as [`NnddSettings::default`].
/// * `stop`: called after every iteration.
///
/// The pair of step 1 of the last iteration is in `last`; it is kinematically admissible exactly.
///
/// # Errors
/// Sizes that do not match, a θ that is not positive, a contact problem that is rejected, a
/// criterion that fails. No convergence is a status, not an error.
pub fn solve(
    problem: &PreparedProblem,
    lambda: Vec<f64>,
    method: impl Into<Method>,
    stop: &mut dyn StoppingCriterion,
) -> Result<NnddSolution, NnddError> {
    solve_from(problem, Start { lambda, active: None }, &method.into(), stop)
}

/// The initial values of an iteration.
#[derive(Clone, Debug)]
pub struct Start {
    /// The normal trace λ of each Ω₁ at its pairs of nodes, pair after pair, m.
    pub lambda: Vec<f64>,
    /// The active set of Ω₂'s contact problem, if one is known: it is tried before Clarabel.
    pub active: Option<ActiveSet>,
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
    let held = problem.problem().bodies.iter().all(|body| body.free_motion().is_none());
    let Some(pair) = problem.problem().only_pair().filter(|_| held) else {
        return assembly::solve(problem, method, stop);
    };
    let bodies = &problem.sides(0);
    match method {
        Method::Newton(settings) => {
            let steps = CondensedSteps::new(bodies)?;
            let weights = NodalWeights::new(bodies, Weights::Half);
            let mut run = Run::new(pair, bodies, &steps, &weights, &settings.qp);
            run.newton(settings, stop)
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
    let (theta, spectrum) = spectrum::choose_theta(settings.theta, bodies, &weights);
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
    let mut solution = run.iterate(start.lambda, (settings, theta), stop)?;
    let open = match solution.status {
        NnddStatus::StoppedByCriterion | NnddStatus::Interrupted => false,
        // Energies that overflow in the first iteration do so with any method.
        NnddStatus::Diverged { best, .. } => best.is_finite(),
        _ => true,
    };
    if let Some(newton) = &settings.newton
        && open
        && settings.theta.is_none()
        && stop.can_stop()
    {
        solution = run.switch(solution, newton, stop)?;
    }
    solution.spectrum = spectrum;
    let failed = match solution.status {
        NnddStatus::Diverged { .. } | NnddStatus::Stalled { at_round_off: false, .. } => true,
        NnddStatus::MaxIterations => stop.can_stop(),
        _ => false,
    };
    if failed {
        // Report which θ would converge.
        solution.spectrum = spectrum.or_else(|| spectrum::estimate(bodies, &weights));
    }
    if let NnddStatus::Diverged { theta_limit, .. } = &mut solution.status {
        *theta_limit = solution.spectrum.map(|s| s.theta_limit());
    }
    Ok(solution)
}

/// Checks what is given.
fn check(
    problem: &PreparedProblem,
    Start { lambda, active }: &Start,
    method: &Method,
) -> Result<(), NnddError> {
    let (expected, found) = (problem.node_pairs(), lambda.len());
    if found != expected {
        return Err(NnddError::Length { what: "lambda", found, expected });
    }
    if let Some(pair) = lambda.iter().position(|l| !l.is_finite()) {
        return Err(NnddError::Lambda { pair, found: lambda[pair] });
    }
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
