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
    /// Why the last one tried could not be made.
    pub(crate) no_estimate: Option<EstimatorError>,
}

impl<'a> Follow<'a> {
    pub(crate) fn new(
        problem: &'a ContactProblem,
        bodies: &'a [CondensedBody; 2],
        settings: &'a Settings,
        observer: &'a mut dyn Observer,
    ) -> Self {
        Self { problem, bodies, settings, observer, rows: Vec::new(), latest: None, no_estimate: None }
    }

    /// Says whether an iteration has been estimated, or there is still time for it.
    pub(crate) fn may_estimate(&mut self, iterate: &Iterate) -> bool {
        self.latest.as_ref().is_some_and(|(number, _)| *number == iterate.iteration)
            || !self.observer.must_stop()
    }

    /// Estimates an iteration, unless it has been.
    pub(crate) fn estimate(&mut self, iterate: &Iterate) -> Result<(), EstimatorError> {
        if self.latest.as_ref().is_some_and(|(number, _)| *number == iterate.iteration) {
            return Ok(());
        }
        self.observer.phase(Phase::Iterations);
        let displacement = displacements(self.bodies, iterate);
        self.observer.phase(Phase::Estimate);
        let state = ContactState {
            displacement: [&displacement[0], &displacement[1]],
            contact_force: &iterate.contact.normal_reaction,
            opening: &iterate.opening,
        };
        let estimate = estimate_with(self.problem, self.bodies, &state, self.settings.relaxation)?;
        if let Some(row) = self.rows.iter_mut().find(|row| row.iteration.iteration == iterate.iteration) {
            row.eta_dis = Some(estimate.eta_dis);
            row.e_cre = Some(estimate.e_cre);
        }
        self.latest = Some((iterate.iteration, estimate));
        self.observer.phase(Phase::Iterations);
        Ok(())
    }

    /// Estimates an iteration; `false` if a diverging one has left the range of finite numbers, if squares underflow, or if
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

    /// Says whether an estimate failed since memory ran out.
    fn is_out_of_memory(&self) -> bool {
        matches!(self.no_estimate, Some(EstimatorError::OutOfMemory { .. }))
    }

    /// Tells whether η_NNDD is small against η_dis: first against the latest one, then against a fresh one.
    /// Where the mesh is exact (η_dis is round-off), round-off is small enough: see [`Estimate::round_off`].
    ///
    /// An estimate costs as much as very many iterations: the first one waits until η_NNDD has fallen so far
    /// that it should be the last, or until the iterations run out.
    fn matches_mesh(&mut self, iterate: &Iterate, ratio: f64) -> Result<bool, EstimatorError> {
        let small = |latest: &Option<(usize, Estimate)>| {
            latest.as_ref().is_none_or(|(_, e)| {
                // Far from the solution η_dis may be larger than the whole bound: then it says nothing of the mesh.
                let mesh = e.eta_dis.min(e.e_cre);
                let enough = if mesh <= e.round_off { e.round_off } else { ratio * mesh };
                iterate.eta_nndd <= enough
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
        Ok(match (done, self.observer.should_stop() || self.is_out_of_memory()) {
            (true, _) => Decision::Stop,
            (false, true) => Decision::Interrupt,
            (false, false) => Decision::Continue,
        })
    }
}

/// Recovers the displacements of both bodies from an iteration's interface values.
pub(crate) fn displacements(bodies: &[CondensedBody; 2], iterate: &Iterate) -> [Vec<Vector>; 2] {
    let (first, second) = rayon::join(
        || bodies[0].displacement_from_trace(&iterate.lambda),
        || bodies[1].displacement_from_trace(&iterate.contact.normal_trace),
    );
    [first, second]
}
