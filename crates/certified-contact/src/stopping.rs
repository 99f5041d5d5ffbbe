//! The criterion that compares the iteration error with the mesh error.

use crate::history::IterationRecord;
use crate::observer::{Observer, Phase};
use crate::settings::{Criterion, Settings};
use crate::state::state_of;
use cre_estimator::{Estimate, Estimator, EstimatorError, Recovery};
use fem_core::condensation::InterfaceOperator;
use fem_core::contact_system::ContactSystem;
use fem_core::prepared::PreparedProblem;
use fem_core::space::{Plane, Space};
use nndd::Iterate;
use nndd::stopping::{Decision, StoppingCriterion};

/// The mesh error is expected to exceed this fraction of the first η_NNDD.
const FIRST_ESTIMATE: f64 = 0.1;

/// On fine meshes it is expected to exceed this over the square root of the number of nodes, of the first η_NNDD. Measured on the paper's
/// problem with 380 to 411,000 nodes: 3.0 to 4.4.
const OVER_ROOT_OF_NODES: f64 = 2.0;

/// If round-off is at least this fraction of the mesh error, an iteration error of its size is small enough.
const NEAR_ROUND_OFF: f64 = 0.01;

/// An η_NNDD below this fraction of the first one is rounding.
const ROUND_OFF: f64 = 1e-14;

/// Follows the iteration, estimates when asked, and decides.
pub(crate) struct EstimatorStop<'a, S: Recovery = Plane> {
    problem: &'a PreparedProblem<S>,
    system: &'a ContactSystem<'a>,
    estimator: Estimator<'a, S>,
    settings: &'a Settings<S>,
    observer: &'a mut dyn Observer<S>,
    pub(crate) rows: Vec<IterationRecord>,
    /// The number of an iteration, and its estimate.
    pub(crate) latest: Option<(usize, Estimate<S>)>,
    /// Why the last attempted estimate failed.
    pub(crate) no_estimate: Option<EstimatorError>,
}

impl<'a, S: Recovery> EstimatorStop<'a, S> {
    pub(crate) fn new(
        (problem, system): (&'a PreparedProblem<S>, &'a ContactSystem<'a>),
        settings: &'a Settings<S>,
        observer: &'a mut dyn Observer<S>,
    ) -> Self {
        let estimator = Estimator::new(problem, settings.relaxation).recomputing(settings.recomputes);
        Self {
            problem,
            system,
            estimator,
            settings,
            observer,
            rows: Vec::new(),
            latest: None,
            no_estimate: None,
        }
    }

    /// Tells whether an iteration has been estimated, or there is still time for it.
    pub(crate) fn may_estimate(&mut self, iterate: &Iterate) -> bool {
        self.latest.as_ref().is_some_and(|(number, _)| *number == iterate.iteration)
            || !self.observer.must_stop()
    }

    /// Estimates an iteration unless it has already been estimated.
    pub(crate) fn estimate(&mut self, iterate: &Iterate) -> Result<(), EstimatorError> {
        if self.latest.as_ref().is_some_and(|(number, _)| *number == iterate.iteration) {
            return Ok(());
        }
        // Its memory is needed now.
        self.latest = None;
        self.observer.phase(Phase::Iterations);
        let displacement = self.problem.displacements(&iterate.fields(self.system));
        self.observer.phase(Phase::Estimate);
        let fields = displacement.iter().map(Vec::as_slice).collect();
        let state = state_of(self.problem, iterate, fields);
        let estimate = self.estimator.estimate(&state)?;
        if let Some(row) = self.rows.iter_mut().find(|row| row.iteration.iteration == iterate.iteration) {
            row.take(&estimate);
        }
        self.latest = Some((iterate.iteration, estimate));
        self.observer.phase(Phase::Iterations);
        Ok(())
    }

    /// Estimates an iteration; `false` if a diverging one has overflowed, if squares underflow, or if
    /// memory runs out.
    pub(crate) fn try_estimate(&mut self, iterate: &Iterate) -> Result<bool, EstimatorError> {
        let found = self.estimate(iterate);
        self.no_estimate = found.clone().err();
        match found {
            Err(
                EstimatorError::NotFinite { .. }
                | EstimatorError::TooSmall { .. }
                | EstimatorError::OutOfMemory { .. },
            ) => Ok(false),
            other => other.map(|()| true),
        }
    }

    /// Tells whether an estimate failed because memory ran out.
    fn is_out_of_memory(&self) -> bool {
        matches!(self.no_estimate, Some(EstimatorError::OutOfMemory { .. }))
    }

    /// Tells whether η_NNDD is small compared with η_dis: first against the latest one, then against a fresh one.
    /// If round-off is at least a fraction [`NEAR_ROUND_OFF`] of η_dis, an η_NNDD of its size is small enough: see
    /// [`Estimate::round_off`].
    ///
    /// An estimate costs as much as very many iterations: the first one waits until η_NNDD has fallen so far
    /// that it should be the last, or until the iterations run out.
    fn matches_mesh(&mut self, iterate: &Iterate, ratio: f64) -> Result<bool, EstimatorError> {
        let first = self.rows[0].iteration.eta_nndd;
        let rounding = rounding(&self.rows);
        let small = |latest: &Option<(usize, Estimate<S>)>| {
            latest.as_ref().is_none_or(|(_, e)| iterate.eta_nndd <= enough(e, ratio, rounding))
        };
        // If the initial λ cannot be improved, η_NNDD does not fall.
        let before = self.rows.iter().rev().nth(1).map_or(f64::INFINITY, |row| row.iteration.eta_nndd);
        let falls = iterate.eta_nndd < 0.9 * before;
        let mesh = FIRST_ESTIMATE.min(OVER_ROOT_OF_NODES / (self.problem.problem().nodes() as f64).sqrt());
        let early = self.latest.is_none() && falls && iterate.eta_nndd > mesh * ratio * first;
        if !small(&self.latest) || early && iterate.iteration < self.settings.method.max_iterations() {
            return Ok(false);
        }
        Ok(self.try_estimate(iterate)? && small(&self.latest))
    }
}

/// Tells whether the contact forces of the two bodies differ by at most `tolerance` of the larger one, or by round-off.
fn forces_agree(system: &ContactSystem<'_>, iterate: &Iterate, tolerance: f64) -> bool {
    let [first, second] = iterate.contact_forces();
    let difference = (first - second).abs();
    difference <= tolerance * first.abs().max(second.abs()) || difference <= force_round_off(system, iterate)
}

/// Computes the possible rounding error of the contact forces `F_α = ∓Σ (S_α v − g̃_α)`: `n ε` times the sum of the
/// sizes of all terms, N/m. Without it two forces that vanish would never agree.
fn force_round_off(system: &ContactSystem<'_>, iterate: &Iterate) -> f64 {
    let traces = iterate.traces().into_iter().flatten().chain(&iterate.tangential.lambda);
    let largest = traces.fold(0.0f64, |most, v| most.max(v.abs()));
    let of_body = |(b, body): (usize, &&InterfaceOperator)| {
        let loads = body.condensed_load().iter().map(|g| g.abs()).sum::<f64>();
        if !system.subdomains[b].numbers.is_empty() {
            // Their unknowns are many, and the diagonal is the largest part of each column.
            return largest * body.diagonal().iter().sum::<f64>() + loads;
        }
        let unknowns = iterate.interface_unknowns(system, b).unwrap_or_else(|| vec![largest; body.len()]);
        let columns = body.schur().chunks_exact(unknowns.len().max(1)).zip(unknowns);
        let products = columns.map(|(column, v)| v.abs() * column.iter().map(|s| s.abs()).sum::<f64>());
        products.sum::<f64>() + loads
    };
    let terms: f64 = system.bodies.iter().enumerate().map(of_body).sum();
    iterate.lambda.len() as f64 * f64::EPSILON * terms
}

impl<S: Recovery> StoppingCriterion for EstimatorStop<'_, S> {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        self.rows.push(IterationRecord::new(iterate, self.problem.problem()));
        let every = self.settings.estimate_every;
        if every > 0 && iterate.iteration.is_multiple_of(every) {
            self.try_estimate(iterate)?;
        }
        let first = self.rows[0].iteration.eta_nndd;
        let done = match self.settings.criterion {
            Criterion::Estimator { ratio, force_balance } => {
                let agree = force_balance.is_none_or(|part| {
                    iterate.eta_nndd <= rounding(&self.rows) || forces_agree(self.system, iterate, part)
                });
                agree && self.matches_mesh(iterate, ratio)?
            }
            Criterion::Precision { tolerance } => iterate.precision <= tolerance,
            Criterion::EtaNndd { tolerance } => iterate.eta_nndd <= tolerance * first,
            Criterion::Iterations => false,
        };
        if let Some(row) = self.rows.last() {
            self.observer.iteration(row);
        }
        Ok(match (done, self.observer.should_stop() || self.is_out_of_memory()) {
            (true, _) => Decision::Stop,
            (false, true) => Decision::Interrupt,
            (false, false) => Decision::Continue,
        })
    }

    fn can_stop(&self) -> bool {
        self.settings.criterion != Criterion::Iterations
    }

    fn is_interrupted(&mut self) -> bool {
        self.observer.should_stop()
    }
}

/// Returns an η_NNDD that is rounding of where the iteration started. Without loads η_NNDD, η_dis and the forces fall to zero
/// together, and none of them is ever small beside another.
pub(crate) fn rounding(rows: &[IterationRecord]) -> f64 {
    rows.first().map_or(0.0, |row| ROUND_OFF * row.iteration.eta_nndd)
}

/// Returns the η_NNDD that is small enough compared with the mesh error. If round-off, of the estimate or of the iteration, is at least a
/// fraction [`NEAR_ROUND_OFF`] of the mesh error, an η_NNDD of the size of round-off is small enough.
///
/// * `rounding`: see [`rounding`].
pub(crate) fn enough<S: Space>(estimate: &Estimate<S>, ratio: f64, rounding: f64) -> f64 {
    let found = estimate.unchecked();
    // Far from the solution η_dis may exceed the whole bound; then it does not measure the mesh error.
    let mesh = found.eta_dis.min(found.e_cre);
    let beside_mesh = |size: f64| if size >= NEAR_ROUND_OFF * mesh { size } else { 0.0 };
    beside_mesh(estimate.round_off).max(beside_mesh(rounding)).max(ratio * mesh)
}
