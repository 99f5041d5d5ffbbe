//! What `solve` and `sweep` share: from a case to a solved problem.

use crate::args::{CaseOptions, RunOptions};
use crate::convert;
use crate::failure::Failure;
use crate::memory;
use crate::outcome::{self, Ended};
use crate::progress::{Goal, Progress};
use crate::signals::Signals;
use crate::stopwatch::{Activity, Stopwatch};
use case_io::Case;
use case_io::case::Criterion;
use case_io::case_file::split_override;
use case_io::report::{AdaptiveRow, Status};
use certified_contact::{CertifiedSolution, Observer, Phase, Row};
use fem_core::interface::ContactProblem;
use std::path::Path;

/// Reads the overrides of the command line.
pub(crate) fn overrides(set: &[String]) -> Result<Vec<(String, String)>, Failure> {
    set.iter().map(|argument| split_override(argument).map_err(Failure::from)).collect()
}

/// Reads a case file with overrides.
pub(crate) fn read_case(
    options: &CaseOptions,
    overrides: &[(String, String)],
) -> Result<(Vec<u8>, Case), Failure> {
    let bytes =
        case_io::case_file::read(&options.case).map_err(|e| Failure::unreadable(&options.case, &e))?;
    let mut case = Case::parse_bytes(&bytes, &options.case.to_string_lossy(), overrides)?;
    // Mesh files lie beside the case file.
    case.read_mesh_files(options.case.parent().unwrap_or(Path::new("")))?;
    Ok((bytes, case))
}

/// Makes the contact problem of a case, bodies in the file's order, if there is memory to solve it; the case may get notes.
pub(crate) fn build(case: &mut Case) -> Result<ContactProblem, Failure> {
    memory::check_counts(case)?;
    let problem = case.build_problem()?;
    memory::check_problem(case, &problem)?;
    Ok(problem)
}

/// Starts the threads.
pub(crate) fn start_threads(options: &RunOptions) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build_global()
        .map_err(|e| Failure::threads(options.threads, &e))
}

/// A solved case.
pub(crate) struct Solved {
    pub(crate) solution: CertifiedSolution,
    pub(crate) status: Status,
    /// One row per mesh of an adaptive run.
    pub(crate) adaptive: Vec<AdaptiveRow>,
    /// Seconds from the start to the end of each of these meshes.
    pub(crate) step_seconds: Vec<f64>,
}

/// Solves a case.
pub(crate) fn solve(
    case: &Case,
    problem: ContactProblem,
    follower: Follower<'_>,
    row: &mut dyn FnMut(&Row),
) -> Result<Solved, Failure> {
    let mut follower = Rows { follower, row };
    let solution = certified_contact::solve(problem, &convert::settings(case), &mut follower)
        .map_err(|e| Failure::solve(case, &e))?;
    let status = outcome::judge(case, &solution, follower.follower.ended);
    Ok(Solved { solution, status, adaptive: Vec::new(), step_seconds: Vec::new() })
}

/// Hands the rows on.
struct Rows<'a> {
    follower: Follower<'a>,
    row: &'a mut dyn FnMut(&Row),
}

impl Observer for Rows<'_> {
    fn phase(&mut self, phase: Phase) {
        self.follower.phase(phase);
    }

    fn iteration(&mut self, row: &Row) {
        self.follower.progress.clear();
        (self.row)(row);
        self.follower.progress.iteration(row);
    }

    fn should_stop(&mut self) -> bool {
        self.follower.should_stop()
    }
}

/// Times the phases, and ends the run on a signal or at the time limit.
pub(crate) struct Follower<'a> {
    pub(crate) watch: &'a mut Stopwatch,
    signals: &'a Signals,
    limit: Option<f64>,
    /// The line on the terminal.
    pub(crate) progress: Progress,
    /// Why the run was ended.
    pub(crate) ended: Option<Ended>,
}

impl<'a> Follower<'a> {
    pub(crate) fn new(
        case: &Case,
        watch: &'a mut Stopwatch,
        signals: &'a Signals,
        show_progress: bool,
    ) -> Self {
        let limit = case.limits.time.as_ref().map(|limit| limit.value);
        let stop = &case.solver.stop;
        let goal = Goal {
            ratio: (stop.criterion == Criterion::Estimator).then_some(stop.ratio),
            relative: case.adapt.as_ref().map(|adapt| adapt.target_relative_error),
        };
        Self { watch, signals, limit, progress: Progress::start(goal, show_progress), ended: None }
    }

    pub(crate) fn phase(&mut self, phase: Phase) {
        self.watch.switch(Activity::Solve(phase));
        self.progress.phase(phase);
    }

    pub(crate) fn should_stop(&mut self) -> bool {
        let time = self.limit.filter(|limit| self.watch.elapsed() > *limit).map(Ended::TimeLimit);
        self.ended = self.signals.status().map(Ended::Signal).or(time);
        self.ended.is_some()
    }
}
