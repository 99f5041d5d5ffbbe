//! The steps from a problem to a certified solution.

use crate::bonded;
use crate::bounds::Bounds;
use crate::defect_correction::{self, Corrected};
use crate::error::SolveError;
use crate::history::IterationRecord;
use crate::observer::{Observer, Phase};
use crate::pretension;
use crate::results;
use crate::settings::{Criterion, Imposed, Settings, suits_iteration};
use crate::solution::{CertifiedSolution, RoleReason};
use crate::space::ContactSpace;
use crate::state::state_of;
use crate::stopping::{EstimatorStop, enough, rounding};
use cre_estimator::{Estimate, Estimator, ROUND_OFF_SHARE};
use fem_core::boundary::ScalarData;
use fem_core::interface::{Bonds, ContactPair, ContactProblem, Roles};
use fem_core::prepared::{FactorisedBody, PrepareError, PreparedProblem, Stage};
use fem_core::residual::SplitField;
use fem_core::space::{Plane, Space};
use nndd::{Iterate, Method, NnddSolution, NnddStatus, Recovery, Start};

/// Solves a contact problem and certifies the solution.
///
/// * `problem`: bodies in the user's order; the settings choose which of them carries λ. Its pairs may have Tresca friction; for Coulomb
///   friction see [`crate::solve_coulomb`].
///
/// # Errors
/// A body without unique solution, or invalid settings; Coulomb friction. No convergence is a status in `nndd.status`, not an error; the
/// certificate then belongs to the last iterate.
pub fn solve<S: ContactSpace>(
    problem: ContactProblem<S>,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<CertifiedSolution<S>, SolveError<S>> {
    Ok(solve_step(problem, Previous::default(), settings, observer)?.0)
}

/// The data that a load step passes to the next one: the factorised bodies, and the start of the iteration.
#[derive(Clone, Debug)]
pub(crate) struct Previous<T, S: Space = Plane> {
    /// None before the first step.
    pub(crate) bodies: Vec<FactorisedBody<S>>,
    pub(crate) start: Option<T>,
}

impl<T, S: Space> Default for Previous<T, S> {
    fn default() -> Self {
        Self { bodies: Vec::new(), start: None }
    }
}

/// A solution, and the factorised bodies.
type StepSolution<S> = (CertifiedSolution<S>, Vec<FactorisedBody<S>>);

/// Solves and certifies a load step, and returns the factorised bodies as well.
pub(crate) fn solve_step<S: ContactSpace>(
    problem: ContactProblem<S>,
    mut previous: Previous<Start, S>,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<StepSolution<S>, SolveError<S>> {
    let Some(mut bonds) = Bonds::new(&problem)? else {
        return solve_joined(problem, previous, settings, observer);
    };
    previous.start = previous.start.map(|start| bonded::start_of(&bonds, &start));
    let settings = bonded::settings_of(&bonds, settings);
    let joined = bonds.take_joined();
    let found = solve_joined(joined, previous, &settings, observer);
    let (solution, bodies) = found.map_err(|error| error.of_members(&bonds))?;
    Ok((bonded::separated(problem, bonds, solution), bodies))
}

/// [`solve_step`] of a problem without bonded pairs.
fn solve_joined<S: ContactSpace>(
    problem: ContactProblem<S>,
    previous: Previous<Start, S>,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<StepSolution<S>, SolveError<S>> {
    let subdomains = settings.subdomains_of(&problem)?;
    let settings = &settings.clone().with_method(settings.method_for(&problem));
    pretension::check(&problem, matches!(settings.method, Method::Newton(_)))?;
    let mut problem = prepare(problem, previous.bodies, &subdomains, observer)?;
    let (roles, reason) = choose_roles(&problem, settings);
    for (pair, roles) in roles.into_iter().enumerate() {
        problem.set_roles(pair, roles);
    }
    let first = || Start { lambda: initial_lambda(problem.problem(), &settings.lambda), active: None };
    let start = previous.start.unwrap_or_else(first);
    iterate(problem, reason, start, settings, observer)
}

/// Evaluates the initial λ at the nodes of the body that carries it, m; zero along tangents.
fn initial_lambda<S: Space>(problem: &ContactProblem<S>, lambda: &ScalarData<S>) -> Vec<f64> {
    let of_pair = |pair: &ContactPair<S>| -> Vec<f64> {
        // An obstacle moves as it is told.
        let Some(carrier) = pair.imposed().body() else {
            return vec![0.0; pair.row_count()];
        };
        let nodes = pair.interface.pairs().iter().map(|p| p.nodes[pair.roles.imposed()]);
        let mut found: Vec<f64> =
            nodes.map(|node| lambda.at(problem.bodies[carrier].mesh().points()[node])).collect();
        found.resize(pair.row_count(), 0.0);
        found
    };
    problem.contacts.iter().flat_map(of_pair).collect()
}

/// Solves a finer problem in the order of the coarser one, starting from its solution.
pub(crate) fn solve_again<S: ContactSpace>(
    problem: ContactProblem<S>,
    reason: RoleReason,
    start: Start,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<CertifiedSolution<S>, SolveError<S>> {
    let Some(mut bonds) = Bonds::new(&problem)? else {
        return iterate_again(problem, reason, start, settings, observer);
    };
    let (start, settings) = (bonded::start_of(&bonds, &start), bonded::settings_of(&bonds, settings));
    let joined = bonds.take_joined();
    let found = iterate_again(joined, reason, start, &settings, observer);
    let found = found.map_err(|error| error.of_members(&bonds))?;
    Ok(bonded::separated(problem, bonds, found))
}

/// [`solve_again`] without bonded pairs.
fn iterate_again<S: ContactSpace>(
    problem: ContactProblem<S>,
    reason: RoleReason,
    start: Start,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<CertifiedSolution<S>, SolveError<S>> {
    let subdomains = settings.subdomains_of(&problem)?;
    let settings = &settings.clone().with_method(settings.method_for(&problem));
    pretension::check(&problem, matches!(settings.method, Method::Newton(_)))?;
    let problem = prepare(problem, Vec::new(), &subdomains, observer)?;
    Ok(iterate(problem, reason, start, settings, observer)?.0)
}

/// Iterates, certifies the last iterate, and computes the results; all in the order of the iteration.
fn iterate<S: ContactSpace>(
    mut problem: PreparedProblem<S>,
    role_reason: RoleReason,
    start: Start,
    settings: &Settings<S>,
    observer: &mut dyn Observer<S>,
) -> Result<StepSolution<S>, SolveError<S>> {
    observer.phase(Phase::Iterations);
    let system = problem.system();
    let mut follow = EstimatorStop::new((&problem, &system), settings, observer);
    let mut nndd = nndd::solve_from(&system, start, &settings.method, &mut follow)
        .map_err(|error| SolveError::of_nndd(problem.problem(), error))?;
    let last = &nndd.last;
    if follow.rows.last().is_none_or(|row| row.iteration.iteration != last.iteration) {
        // An iteration whose contact problem was not solved has not met the criterion.
        follow.rows.push(IterationRecord::new(last, problem.problem()));
    }
    // A diverged iteration may have overflowed: then there is no certificate, but a report.
    // A run that must end at once keeps its current certificate.
    let certified = follow.may_estimate(last) && follow.try_estimate(last).unwrap_or(false);
    let mut rows = std::mem::take(&mut follow.rows);
    let no_estimate = follow.no_estimate.take().filter(|_| !certified);
    let mut estimate = follow.latest.take().filter(|_| certified).map(|(_, estimate)| estimate);
    // With the memory of its stars.
    drop(follow);
    let mut low = None;
    if let Some(found) = &estimate
        && needs_correction(found, last)
    {
        observer.phase(Phase::Iterations);
        if let Some(better) = corrected(&mut problem, &nndd, found, settings)? {
            if let Some(row) = rows.last_mut() {
                *row = IterationRecord::new(&better.iterate, problem.problem());
                row.take(&better.estimate);
            }
            nndd.last = better.iterate;
            estimate = Some(better.estimate);
            low = Some(better.low);
        }
    }
    if let Some(found) = &estimate {
        recheck_stop(problem.problem(), &mut nndd, &mut rows, found, settings);
    }
    let last = &nndd.last;
    observer.phase(Phase::Estimate);
    let subdomains: Vec<usize> = problem.bodies().iter().map(FactorisedBody::factors).collect();
    let results = estimate
        .as_ref()
        .map(|e| results::results((problem.problem(), problem.external_forces(), &subdomains), last, e, low));
    let bounds = estimate.as_ref().map(|e| Bounds::new(&problem, last, e));
    let unknowns = problem.bodies().iter().map(FactorisedBody::unknowns).collect();
    let (problem, bodies) = problem.into_parts();
    let solution = CertifiedSolution {
        role_reason,
        method: settings.method.clone(),
        nndd,
        rows,
        estimate,
        no_estimate,
        bounds,
        results,
        unknowns,
        subdomains,
        problem,
    };
    Ok((solution, bodies))
}

/// Tells whether rounding of the solution is a noticeable part of its bound.
///
/// η_NNDD of an iteration comes from its operators, without an allowance for rounding; all of that of an exact solution is rounding.
fn needs_correction<S: Space>(estimate: &Estimate<S>, iterate: &Iterate) -> bool {
    let found = estimate.unchecked();
    let eta_nndd = match iterate.recovery {
        Recovery::Traces => iterate.eta_nndd,
        Recovery::Forces => 0.0,
    };
    let rounding = (found.eta_nndd.powi(2) - eta_nndd.powi(2)).max(0.0).sqrt();
    rounding > ROUND_OFF_SHARE * found.e_cre
}

/// A corrected solution with its estimate.
struct Better<S: Space> {
    iterate: Iterate,
    estimate: Estimate<S>,
    /// Low-order parts of the displacements (their rounding errors).
    low: Vec<Vec<S::Vector>>,
}

/// Corrects the solution by its defect; `None` if that gives no improvement.
fn corrected<S: ContactSpace>(
    problem: &mut PreparedProblem<S>,
    nndd: &NnddSolution,
    estimate: &Estimate<S>,
    settings: &Settings<S>,
) -> Result<Option<Better<S>>, SolveError<S>> {
    let fields = estimate.pair.bodies.iter().map(|body| SplitField::new(body.displacement.clone())).collect();
    // λ may change only if the iterate is meant to be the discrete solution.
    let advance = matches!(nndd.status, NnddStatus::StoppedByCriterion | NnddStatus::Stalled { .. })
        && settings.criterion != Criterion::Iterations;
    let found = defect_correction::correct(problem, &nndd.last, fields, &settings.method, advance);
    let found = found.map_err(SolveError::Nndd)?;
    let Some(Corrected { iterate, fields }) = found else { return Ok(None) };
    let high = fields.iter().map(|field| field.high.as_slice()).collect();
    let state = state_of(problem, &iterate, high);
    let mut estimator = Estimator::new(problem, settings.relaxation).recomputing(settings.recomputes);
    let Ok(better) = estimator.estimate(&state) else { return Ok(None) };
    let gains = better.unchecked().e_cre < estimate.unchecked().e_cre
        || better.unchecked().eta_nndd < estimate.unchecked().eta_nndd;
    Ok(gains.then_some(Better {
        iterate,
        estimate: better,
        low: fields.into_iter().map(|f| f.low).collect(),
    }))
}

/// The exact solution of an assembly has converged if its η_NNDD is below this fraction of the mesh error.
const FREE_MOTIONS: f64 = 0.1;

/// Stores the measured η_NNDD and checks whether the criterion still holds with it.
fn recheck_stop<S: Space>(
    problem: &ContactProblem<S>,
    nndd: &mut NnddSolution,
    rows: &mut [IterationRecord],
    estimate: &Estimate<S>,
    settings: &Settings<S>,
) {
    let rounding = rounding(rows);
    let eta_nndd = nndd.last.eta_nndd.max(estimate.unchecked().eta_nndd);
    nndd.last.eta_nndd = eta_nndd;
    for row in rows.last_mut().map(|row| &mut row.iteration).into_iter().chain(nndd.history.last_mut()) {
        row.eta_nndd = eta_nndd;
    }
    // The exact solution of an assembly leaves motions free that only the error of the normals resists.
    let exact = !matches!(settings.method, Method::Nndd(_)) && !suits_iteration(problem);
    if let Criterion::Estimator { ratio, .. } = settings.criterion
        && let ratio = if exact { ratio.max(FREE_MOTIONS) } else { ratio }
        && nndd.status == NnddStatus::StoppedByCriterion
        && eta_nndd > enough(estimate, ratio, rounding)
    {
        nndd.status = match exact {
            true => NnddStatus::BalanceError { eta_nndd },
            false => NnddStatus::Stalled { floor: eta_nndd, at_round_off: true },
        };
    }
}

/// Assembles and factorises all bodies, in parallel, and tightens their cuts.
///
/// * `factorised`: the bodies with other loads, if an earlier load step has factorised them; `subdomains`: of each body, how many.
pub(crate) fn prepare<S: ContactSpace>(
    problem: ContactProblem<S>,
    factorised: Vec<FactorisedBody<S>>,
    subdomains: &[usize],
    observer: &mut dyn Observer<S>,
) -> Result<PreparedProblem<S>, SolveError<S>> {
    let problem = S::without_spin(problem)?;
    let mut started = false;
    let found = PreparedProblem::prepare_again(problem, factorised, subdomains, |stage| {
        // The order belongs to the factorisation.
        let phase = match stage {
            Stage::Ordering | Stage::Factorisation => Some(Phase::Factorisation),
            Stage::Assembly => Some(Phase::Assembly),
            Stage::Ready => None,
        };
        let proceed = !std::mem::replace(&mut started, true) || !observer.must_stop();
        if let Some(phase) = phase.filter(|_| proceed) {
            observer.phase(phase);
        }
        proceed
    });
    let prepared = found.map_err(|error| match error {
        PrepareError::Stopped => SolveError::Stopped,
        other => SolveError::Prepare(other),
    })?;
    pretension::tighten(prepared, observer)
}

/// Bodies whose compliances differ by less than this fraction are equal but for rounding: the first one carries λ.
const STIFFER: f64 = 1e-9;

/// Decides which body of each pair carries λ.
fn choose_roles<S: Space>(problem: &PreparedProblem<S>, settings: &Settings<S>) -> (Vec<Roles>, RoleReason) {
    let contacts = &problem.problem().contacts;
    let of_pair = |k: usize| settings.imposed_by_pair.get(k).copied().flatten().unwrap_or(settings.imposed);
    let only = problem.problem().plain_pair();
    let only = only.and_then(|pair| Some((pair, pair.bodies()?)));
    let whole = |b: usize| problem.bodies()[b].whole();
    let only = only.and_then(|(pair, both)| Some((pair, [whole(both[0])?, whole(both[1])?])));
    if let (Some((pair, both)), Imposed::Auto) = (only, of_pair(0)) {
        let force: Vec<f64> = pair.interface.pairs().iter().map(|p| p.weight).collect();
        let compliance = both.map(|body| {
            let mut w = vec![0.0; force.len()];
            body.interface().trace_from_force(&force, &mut w);
            w.iter().zip(&force).map(|(w, f)| w * f).sum::<f64>()
        });
        let is_stiffer = compliance[1] < (1.0 - STIFFER) * compliance[0];
        let roles = if is_stiffer { Roles::SECOND } else { Roles::FIRST };
        return (vec![roles], RoleReason::Stiffer { compliance });
    }
    // Only the paper's iteration depends on it.
    let stiffer = match settings.method {
        Method::Nndd(_) => nndd::stiffer_roles(&problem.system()),
        _ => vec![Roles::FIRST; contacts.len()],
    };
    let chosen = contacts.iter().zip(stiffer).enumerate().map(|(k, (pair, stiffer))| match of_pair(k) {
        _ if pair.partner.is_obstacle() => Roles::SECOND,
        Imposed::First => Roles::FIRST,
        Imposed::Second => Roles::SECOND,
        Imposed::Auto => stiffer,
    });
    (chosen.collect(), RoleReason::Given)
}
