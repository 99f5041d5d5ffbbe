//! A solved case.

use case_io::case::Notes;
use case_io::report::{AdaptiveRow, Status, StepSummary};
use case_io::table::ContactRow;
use certified_contact::{CertifiedSolution, CoulombResult, IterationRecord, Results};
use cre_estimator::Estimate;
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};
use nndd::Iterate;
use serde_json::Value;

/// A solved case.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solved<S: Space = Plane> {
    /// The answer.
    pub answer: RunResult<S>,
    /// How the run ended.
    pub status: Status,
    /// One row per mesh of an adaptive run.
    pub adaptive: Vec<AdaptiveRow>,
    /// The mesh of the answer, from 1, if an adaptive run ended because its bound rose.
    pub smallest_mesh: Option<usize>,
    /// The relative change of the largest recovered stress from the mesh before.
    pub peak_change: Option<f64>,
    /// Notes about the refinement.
    pub notes: Vec<String>,
    /// On the case and its first meshes, see [`crate::run::build`].
    pub case_notes: Notes,
    /// Seconds from the start to the end of each of these meshes.
    pub step_seconds: Vec<f64>,
    /// The load steps that were solved; empty if the case has none. `answer` belongs to the last one.
    pub steps: Vec<SolvedStep>,
    /// The longest step between two checks of the clock: its name and its seconds.
    pub longest_step: Option<(&'static str, f64)>,
}

/// The results of a load step that are kept.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SolvedStep {
    /// Its entry in report.json.
    pub summary: StepSummary,
    /// The rows of contact.csv, pair by pair.
    pub rows: Vec<Vec<ContactRow>>,
    /// True if its fields were written for ParaView.
    pub has_fields: bool,
    /// Its fields for the view that turns.
    pub(crate) view: Option<Value>,
}

impl<S: Space> Solved<S> {
    /// Takes the answer of one solve.
    pub(crate) fn of(answer: RunResult<S>, status: Status) -> Self {
        Self {
            answer,
            status,
            adaptive: Vec::new(),
            smallest_mesh: None,
            peak_change: None,
            notes: Vec::new(),
            case_notes: Notes::new(),
            step_seconds: Vec::new(),
            steps: Vec::new(),
            longest_step: None,
        }
    }
}

/// The solution of a run, with its certificate or, with Coulomb friction, without one.
#[derive(Clone, Debug)]
pub enum RunResult<S: Space = Plane> {
    /// A solution with its certificate.
    Certified(Box<CertifiedSolution<S>>),
    /// One solution with Coulomb friction, with a residual that bounds no error.
    Coulomb(Box<CoulombResult<S>>),
}

impl<S: Space> RunResult<S> {
    /// Returns the solution with its certificate; `None` with Coulomb friction.
    pub fn certified(&self) -> Option<&CertifiedSolution<S>> {
        match self {
            Self::Certified(solution) => Some(solution),
            Self::Coulomb(_) => None,
        }
    }

    /// Returns the solution with Coulomb friction, if it is that.
    pub(crate) fn coulomb(&self) -> Option<&CoulombResult<S>> {
        match self {
            Self::Certified(_) => None,
            Self::Coulomb(result) => Some(result),
        }
    }

    /// Returns the fields of the solution.
    pub(crate) fn fields(&self) -> Fields<'_, S> {
        match self {
            Self::Certified(solution) => Fields::certified(solution),
            Self::Coulomb(result) => Fields::coulomb(result),
        }
    }
}

/// The parts of a solution that tables, figures and ParaView files show, certified or not.
#[derive(Clone)]
pub struct Fields<'a, S: Space = Plane> {
    pub(crate) problem: &'a ContactProblem<S>,
    pub(crate) last: &'a Iterate,
    pub(crate) rows: Vec<IterationRecord>,
    /// Its stresses and its density of the squared error, or of the squared residual.
    pub(crate) estimate: Option<&'a Estimate<S>>,
    pub(crate) results: Option<&'a Results<S>>,
    pub(crate) unknowns: &'a [usize],
    /// None with Coulomb friction: bodies are in one piece.
    pub(crate) subdomains: &'a [usize],
    pub(crate) is_certified: bool,
    /// With Coulomb friction the limit of friction of the residual, at the pairs of nodes of each pair, Pa.
    pub(crate) frozen_limit: Option<Vec<&'a [f64]>>,
}

impl<'a, S: Space> Fields<'a, S> {
    pub(crate) fn certified(solution: &'a CertifiedSolution<S>) -> Self {
        Self {
            problem: &solution.problem,
            last: solution.last(),
            rows: solution.rows.clone(),
            estimate: solution.estimate.as_ref(),
            results: solution.results.as_ref(),
            unknowns: &solution.unknowns,
            subdomains: &solution.subdomains,
            is_certified: solution.is_certified(),
            frozen_limit: None,
        }
    }

    pub(crate) fn coulomb(result: &'a CoulombResult<S>) -> Self {
        Self {
            problem: &result.problem,
            last: &result.last,
            rows: vec![result.row()],
            estimate: Some(result.estimate()),
            results: Some(&result.results),
            unknowns: &result.unknowns,
            subdomains: &[],
            is_certified: false,
            frozen_limit: Some(result.frozen_limit().collect()),
        }
    }

    /// Names what the estimate is.
    pub(crate) fn what(&self) -> &'static str {
        if self.is_residual() { "the residual" } else { "the bound" }
    }

    /// Tells whether the estimate is the residual of Coulomb friction, which bounds no error.
    pub(crate) fn is_residual(&self) -> bool {
        self.frozen_limit.is_some()
    }
}
