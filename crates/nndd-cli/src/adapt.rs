//! An adaptive run: one row and one set of ParaView files per mesh.

use crate::convert;
use crate::failure::Failure;
use crate::memory::{self, mebibytes};
use crate::outcome::{self, Ended};
use crate::paraview;
use crate::resume::{self, Place};
use crate::run::{Follower, Solved};
use crate::stopwatch::Activity;
use case_io::Case;
use case_io::case::Adapt;
use case_io::output::OutputDirectory;
use case_io::report::{AdaptiveRow, Status};
use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Checkpoint, Observer, Phase, Row, Step,
    resume_adaptively, solve_adaptively,
};
use fem_core::interface::ContactProblem;
use nndd::NnddStatus;

/// What a printer hears of an adaptive run.
pub(crate) enum Event<'a> {
    /// An iteration on the present mesh.
    Iteration(&'a Row),
    /// A mesh has been solved.
    Step(&'a Step),
}

/// One row of `adaptive`; `None` for a mesh without bound.
pub(crate) fn row(step: &Step) -> Option<AdaptiveRow> {
    Some(AdaptiveRow {
        step: step.step,
        nodes: step.nodes,
        pairs: step.pairs,
        e_cre: step.e_cre?,
        relative: step.relative,
        iterations: step.iterations,
        energy_norm_squared: step.energy_norm_squared?,
    })
}

/// Solves an adaptive case.
pub(crate) fn solve(
    case: &Case,
    adapt: &Adapt,
    problem: ContactProblem,
    follower: Follower<'_>,
    mut place: Place<'_>,
    print: &mut dyn FnMut(Event<'_>),
) -> Result<Solved, Failure> {
    let mut settings = AdaptSettings::new(adapt.target_relative_error);
    settings.max_steps = adapt.max_steps;
    settings.max_nodes = adapt.max_nodes;
    settings.fraction = adapt.fraction;
    resume::prepare(case, &mut place)?;
    let Place { directory, progress } = place;
    let checkpoint = progress.as_ref().map(resume::read);
    for step in checkpoint.iter().flat_map(|c| &c.history) {
        print(Event::Step(step));
    }
    let seconds: Vec<f64> = progress.iter().flat_map(|p| &p.steps).map(|s| s.seconds).collect();
    let mut steps = Steps {
        follower,
        case,
        directory,
        print,
        failure: None,
        before: seconds.last().copied().unwrap_or(0.0),
        seconds,
        memory: None,
    };
    let solver = convert::settings(case);
    let answer = match checkpoint {
        Some(checkpoint) => resume_adaptively(problem, checkpoint, &solver, &settings, &mut steps),
        None => solve_adaptively(problem, &solver, &settings, &mut steps),
    };
    let answer = answer.map_err(|e| Failure::solve(case, &e))?;
    let Steps { follower, failure, seconds, memory, .. } = steps;
    if let Some(failure) = failure {
        return Err(failure);
    }
    let status = judge(case, adapt, &answer, follower.ended, memory.as_deref());
    let adaptive = answer.history.iter().filter_map(row).collect();
    Ok(Solved { solution: answer.solution, status, adaptive, step_seconds: seconds })
}

/// Follows the run, writes each mesh's files, and keeps it within the memory limit.
struct Steps<'a> {
    follower: Follower<'a>,
    case: &'a Case,
    directory: &'a mut OutputDirectory,
    print: &'a mut dyn FnMut(Event<'_>),
    /// What went wrong in writing; the run then ends.
    failure: Option<Failure>,
    /// When each mesh had been solved, in seconds of work.
    seconds: Vec<f64>,
    /// Seconds of work before the run was resumed.
    before: f64,
    /// Why the next mesh has no room.
    memory: Option<String>,
}

impl Observer for Steps<'_> {
    fn phase(&mut self, phase: Phase) {
        self.follower.phase(phase);
    }

    fn iteration(&mut self, row: &Row) {
        self.follower.progress.clear();
        (self.print)(Event::Iteration(row));
        self.follower.progress.iteration(row);
    }

    fn step(&mut self, step: &Step, solution: &CertifiedSolution) {
        self.follower.watch.switch(Activity::Write);
        self.seconds.truncate(step.step - 1);
        self.seconds.push(self.before + self.follower.watch.elapsed());
        self.follower.progress.clear();
        (self.print)(Event::Step(step));
        self.follower.progress.step(step);
        if self.case.output.vtu && step.e_cre.is_some() {
            self.failure = paraview::write_step(self.case, solution, step.step, self.directory).err();
        }
    }

    fn has_room_for(&mut self, problem: &ContactProblem) -> bool {
        let needed = memory::estimate(problem);
        let Some((_, words)) = memory::limit(self.case).filter(|(limit, _)| needed > *limit) else {
            return true;
        };
        self.memory = Some(format!("about {} and {words}", mebibytes(needed)));
        false
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.follower.watch.switch(Activity::Write);
        let written = resume::write(self.case, checkpoint, &self.seconds, self.directory);
        self.failure = self.failure.take().or(written.err());
    }

    fn should_stop(&mut self) -> bool {
        self.failure.is_some() || self.follower.should_stop()
    }
}

fn judge(
    case: &Case,
    adapt: &Adapt,
    answer: &AdaptiveSolution,
    ended: Option<Ended>,
    memory: Option<&str>,
) -> Status {
    let word = |word: &str, code: u8, reason: String| Status { word: word.into(), code, reason };
    let target = adapt.target_relative_error;
    let relative = answer.solution.relative();
    let reached =
        relative.map_or_else(|| "the bound".into(), |r| format!("certified relative error {r:.3e}"));
    let missed = |reason: String| word("target_missed", 6, format!("{reached} > {target}: {reason}"));
    let meshes = answer.history.len();
    // The best certificate may be that of an earlier mesh.
    let last = answer.step == meshes;
    let mut status = match &answer.end {
        AdaptiveEnd::TargetMet => {
            let reached = relative.map_or_else(|| "no error".into(), |_| reached.clone());
            word("converged", 0, format!("{reached} <= {target} on mesh {meshes}"))
        }
        AdaptiveEnd::MaxSteps => {
            missed(format!("all adapt.max_steps = {} meshes are used; raise it", adapt.max_steps))
        }
        AdaptiveEnd::MaxNodes => missed(format!(
            "adapt.max_nodes = {} leaves no room for a mesh that is worth it; raise it",
            adapt.max_nodes
        )),
        AdaptiveEnd::RoundOff { floor } => word(
            "stalled",
            5,
            format!(
                "the target {target:e} lies below the attainable floor {floor:.1e}, the round-off of this problem; ask for \
                 more than that"
            ),
        ),
        AdaptiveEnd::Iteration(_) | AdaptiveEnd::NotCertified if last => {
            outcome::judge(case, &answer.solution, ended)
        }
        AdaptiveEnd::Iteration(status) => {
            let failed = match status {
                NnddStatus::MaxIterations => "max_iterations",
                NnddStatus::Diverged { .. } => "diverged",
                _ => "stalled",
            };
            word(failed, 5, format!("the iteration on mesh {meshes} did not meet its criterion"))
        }
        AdaptiveEnd::IterationError => word(
            "stalled",
            5,
            format!(
                "{reached} > {target}, and nearly all of it is the iteration's error, which no finer mesh lowers; use \
                 solver.stop.criterion = \"estimator\", or more iterations"
            ),
        ),
        AdaptiveEnd::NotCertified => {
            word("not_certified", 6, format!("the bound of mesh {meshes} does not pass its checks"))
        }
        AdaptiveEnd::Interrupted => outcome::interrupted(ended, &format!("mesh {meshes}")),
        AdaptiveEnd::NoRoom { nodes } => {
            let needed = memory.unwrap_or("too much memory");
            word("limit", 8, format!("the next mesh of {nodes} nodes needs {needed}"))
        }
        AdaptiveEnd::Failed(error) => {
            let failure = Failure::solve(case, error);
            let reason = failure.message.unwrap_or_else(|| error.to_string());
            match failure.code {
                8 => word("limit", 8, format!("the next mesh: {reason}")),
                _ => missed(format!("the next mesh cannot be solved: {reason}")),
            }
        }
        _ => missed("the run ended in an unknown way".into()),
    };
    if !last {
        status.reason += &format!("; the certificate is that of mesh {}", answer.step);
    }
    status
}
