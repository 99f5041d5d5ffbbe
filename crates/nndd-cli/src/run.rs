//! What `solve` and `sweep` share: from a case to a solved problem.

use crate::args::CaseOptions;
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
use case_io::output::{OutputError, Presence};
use case_io::report::{AdaptiveRow, Status};
use certified_contact::{CertifiedSolution, Observer, Phase, Row, SolveError};
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

/// A solved case.
pub(crate) struct Solved {
    pub(crate) solution: CertifiedSolution,
    pub(crate) status: Status,
    /// One row per mesh of an adaptive run.
    pub(crate) adaptive: Vec<AdaptiveRow>,
    /// Seconds from the start to the end of each of these meshes.
    pub(crate) step_seconds: Vec<f64>,
    /// The longest step between two checks of the clock: its name and its seconds.
    pub(crate) longest_step: Option<(&'static str, f64)>,
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
        .map_err(|e| follower.follower.failure(case, &e))?;
    let status = outcome::judge(case, &solution, follower.follower.ended);
    let longest_step = follower.follower.longest;
    Ok(Solved { solution, status, adaptive: Vec::new(), step_seconds: Vec::new(), longest_step })
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

    fn must_stop(&mut self) -> bool {
        self.follower.must_stop()
    }
}

/// A run may exceed its time limit by this, in seconds, and still start on a certificate.
const GRACE: f64 = 0.1;

/// Times the phases, and ends the run on a signal or at the time limit.
pub(crate) struct Follower<'a> {
    pub(crate) watch: &'a mut Stopwatch,
    signals: &'a Signals,
    output: Presence,
    limit: Option<f64>,
    /// What is being done, and when the clock was last checked, in seconds.
    step: (Phase, f64),
    /// The longest step between two checks of the clock: its name and its seconds.
    pub(crate) longest: Option<(&'static str, f64)>,
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
        output: Presence,
        show_progress: bool,
    ) -> Self {
        let limit = case.limits.time.as_ref().map(|limit| limit.value);
        let stop = &case.solver.stop;
        let goal = Goal {
            ratio: (stop.criterion == Criterion::Estimator).then_some(stop.ratio),
            relative: case.adapt.as_ref().map(|adapt| adapt.target_relative_error),
        };
        let step = (Phase::Assembly, watch.elapsed());
        let progress = Progress::start(goal, show_progress);
        Self { watch, signals, output, limit, step, longest: None, progress, ended: None }
    }

    /// Looks at the clock: returns the seconds since the start, and measures the step that ends here.
    fn look(&mut self, next: Option<Phase>) -> f64 {
        let now = self.watch.elapsed();
        let (phase, since) = self.step;
        if self.longest.is_none_or(|(_, longest)| now - since > longest) {
            self.longest = Some((step_name(phase), now - since));
        }
        self.step = (next.unwrap_or(phase), now);
        now
    }

    pub(crate) fn phase(&mut self, phase: Phase) {
        self.look(Some(phase));
        self.watch.switch(Activity::Solve(phase));
        self.progress.phase(phase);
    }

    /// Whether the run should end with what it has, at its next certificate.
    pub(crate) fn should_stop(&mut self) -> bool {
        let signal = self.signals.status().map(Ended::Signal);
        self.end(signal, 0.0)
    }

    /// Whether the run must end, with or without a certificate.
    pub(crate) fn must_stop(&mut self) -> bool {
        self.end(None, GRACE)
    }

    /// Finds a reason to end.
    ///
    /// * `grace`: seconds that the time limit may be exceeded by.
    fn end(&mut self, signal: Option<Ended>, grace: f64) -> bool {
        let now = self.look(None);
        let step = self.longest.map_or("none", |(step, _)| step);
        let time = self.limit.filter(|limit| now > limit + grace).map(|limit| Ended::TimeLimit(limit, step));
        let gone = (!self.output.lasts()).then_some(Ended::OutputGone);
        let ended = gone.or(signal).or(time);
        self.ended = ended.or(self.ended);
        ended.is_some()
    }

    /// Says why a solve failed.
    pub(crate) fn failure(&self, case: &Case, error: &SolveError) -> Failure {
        match (error, self.ended) {
            (SolveError::Stopped, Some(Ended::OutputGone)) => {
                Failure::output(&OutputError::Vanished { path: self.output.path().to_owned() })
            }
            (SolveError::Stopped, Some(Ended::TimeLimit(limit, _))) => {
                let (step, seconds) = self.longest.unwrap_or(("none", 0.0));
                Failure::limit(format!(
                    "limits.time = {limit} s reached before the first iteration, so there is no result; the longest \
                     step between two checks of the clock was {step}, {seconds:.1} s\n  \
                     expected: a problem that is solved in time\n  fix: raise limits.time, or take fewer cells"
                ))
            }
            _ => Failure::solve(case, error),
        }
    }
}

/// The steps between two checks of the clock.
fn step_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Assembly => "assembly",
        Phase::Factorisation => "factorisation",
        Phase::Iterations => "an iteration",
        Phase::Estimate => "the estimate of the error",
        Phase::Refinement => "refinement",
    }
}
