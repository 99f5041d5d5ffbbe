//! The criterion that compares the iteration's error with the mesh's.

use crate::history::Row;
use crate::observer::{Observer, Phase};
use crate::settings::{Criterion, Settings};
use cre_estimator::{Estimate, EstimatorError, estimate_with};
use fem_core::condensation::CondensedBody;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, ContactState};
use nndd::stopping::{Decision, StoppingCriterion};
use nndd::{Iterate, IterationRow};

/// The mesh's error is expected above this fraction of the first η_NNDD.
const FIRST_ESTIMATE: f64 = 0.1;

/// Follows the iteration, estimates where asked, and decides.
pub(crate) struct Follow<'a> {
    problem: &'a ContactProblem,
    bodies: &'a [CondensedBody; 2],
    settings: &'a Settings,
    observer: &'a mut dyn Observer,
    pub(crate) rows: Vec<Row>,
    /// The estimate of the iteration of that number.
    pub(crate) latest: Option<(usize, Estimate)>,
}

impl<'a> Follow<'a> {
    pub(crate) fn new(
        problem: &'a ContactProblem,
        bodies: &'a [CondensedBody; 2],
        settings: &'a Settings,
        observer: &'a mut dyn Observer,
    ) -> Self {
        Self { problem, bodies, settings, observer, rows: Vec::new(), latest: None }
    }

    /// Estimates an iteration, unless it has been.
    pub(crate) fn estimate(&mut self, iterate: &Iterate) -> Result<(), EstimatorError> {
        if self.latest.as_ref().is_some_and(|(number, _)| *number == iterate.iteration) {
            return Ok(());
        }
        self.observer.phase(Phase::Iterations);
        let displacement = displacements(self.bodies, iterate);
        self.observer.phase(Phase::Estimate);
        let displacement = [displacement[0].as_slice(), &displacement[1]];
        let estimate = estimate_of(self.problem, self.bodies, iterate, displacement, self.settings)?;
        if let Some(row) = self.rows.iter_mut().find(|row| row.iteration.iteration == iterate.iteration) {
            row.take(&estimate);
        }
        self.latest = Some((iterate.iteration, estimate));
        self.observer.phase(Phase::Iterations);
        Ok(())
    }

    /// Estimates an iteration; `false` where a diverging one has left the range of finite numbers, or squares underflow.
    fn try_estimate(&mut self, iterate: &Iterate) -> Result<bool, EstimatorError> {
        match self.estimate(iterate) {
            Err(EstimatorError::NotFinite { .. } | EstimatorError::TooSmall { .. }) => Ok(false),
            other => other.map(|()| true),
        }
    }

    /// Tells whether η_NNDD is small against η_dis: first against the latest one, then against a fresh one.
    /// Where the mesh is exact (η_dis is round-off), round-off is small enough: see [`Estimate::round_off`].
    ///
    /// An estimate costs as much as very many iterations: the first one waits until η_NNDD has fallen so far
    /// that it should be the last, or until the iterations run out.
    fn matches_mesh(&mut self, iterate: &Iterate, ratio: f64) -> Result<bool, EstimatorError> {
        let small = |latest: &Option<(usize, Estimate)>| {
            latest.as_ref().is_none_or(|(_, e)| {
                iterate.eta_nndd <= enough(e, ratio)
            })
        };
        let first = self.rows[0].iteration.eta_nndd;
        // A start that cannot be improved does not fall at all.
        let before = self.rows.iter().rev().nth(1).map_or(f64::INFINITY, |row| row.iteration.eta_nndd);
        let falls = iterate.eta_nndd < 0.9 * before;
        let early = self.latest.is_none() && falls && iterate.eta_nndd > FIRST_ESTIMATE * ratio * first;
        if !small(&self.latest) || early && iterate.iteration < self.settings.nndd.max_iterations {
            return Ok(false);
        }
        Ok(self.try_estimate(iterate)? && small(&self.latest))
    }
}

impl StoppingCriterion for Follow<'_> {
    fn check(&mut self, iterate: &Iterate) -> Result<Decision, Box<dyn std::error::Error + Send + Sync>> {
        let iteration = IterationRow::from(iterate);
        self.rows.push(Row { iteration, eta_dis: None, e_cre: None });
        let every = self.settings.estimate_every;
        if every > 0 && iterate.iteration.is_multiple_of(every) {
            self.try_estimate(iterate)?;
        }
        let first = self.rows[0].iteration.eta_nndd;
        let done = match self.settings.criterion {
            Criterion::Estimator { ratio } => self.matches_mesh(iterate, ratio)?,
            Criterion::Precision { tolerance } => iterate.precision <= tolerance,
            Criterion::EtaNndd { tolerance } => iterate.eta_nndd <= tolerance * first,
            Criterion::Iterations => false,
        };
        if let Some(row) = self.rows.last() {
            self.observer.iteration(row);
        }
        Ok(match (done, self.observer.should_stop()) {
            (true, _) => Decision::Stop,
            (false, true) => Decision::Interrupt,
            (false, false) => Decision::Continue,
        })
    }
}

/// Returns the η_NNDD that is small enough against the mesh's error: round-off if the mesh is exact.
pub(crate) fn enough(estimate: &Estimate, ratio: f64) -> f64 {
    let found = estimate.unchecked();
    // Far from the solution η_dis may be larger than the whole bound: then it says nothing of the mesh.
    let mesh = found.eta_dis.min(found.e_cre);
    // Both contain the allowance.
    if mesh <= 2.0 * estimate.round_off { estimate.round_off } else { ratio * mesh }
}

/// Estimates the error of an iterate with its displacements.
pub(crate) fn estimate_of(
    problem: &ContactProblem,
    bodies: &[CondensedBody; 2],
    iterate: &Iterate,
    displacement: [&[Vector]; 2],
    settings: &Settings,
) -> Result<Estimate, EstimatorError> {
    let state = ContactState {
        displacement,
        contact_force: &iterate.contact.normal_reaction,
        opening: &iterate.opening,
    };
    estimate_with(problem, bodies, &state, settings.relaxation)
}

/// Recovers the displacements of both bodies from an iteration's interface values.
pub(crate) fn displacements(bodies: &[CondensedBody; 2], iterate: &Iterate) -> [Vec<Vector>; 2] {
    let (first, second) = rayon::join(
        || bodies[0].displacement_from_trace(&iterate.lambda),
        || bodies[1].displacement_from_trace(&iterate.contact.normal_trace),
    );
    [first, second]
}
