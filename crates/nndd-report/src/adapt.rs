//! An adaptive run: one row and one set of ParaView files per mesh.

use crate::convert;
use crate::failure::{Failure, LIMIT, NOT_CERTIFIED};
use crate::host::Event;
use crate::memory;
use crate::motion::all_move;
use crate::outcome::{self, Ended, NOT_CONVERGED, stalled, word};
use crate::paraview;
use crate::resume::{self, RunDirectory};
use crate::run_observer::RunObserver;
use crate::solved::{Fields, RunResult, Solved};
use crate::space::ReportSpace;
use crate::stopwatch::Activity;
use crate::words::{self, short};
use case_io::Case;
use case_io::case::{Adapt, Criterion, Dimension, Target};
use case_io::diagnostic::significant;
use case_io::output::OutputDirectory;
use case_io::report::{AdaptiveRow, Status};
use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Checkpoint, CoulombResult,
    IterationRecord, Observer, Phase, SolveError, Step, resume_adaptively, resume_coulomb_adaptively,
    solve_adaptively, solve_coulomb_adaptively,
};
use fem_core::interface::{ContactProblem, Partner};
use fem_core::space::{Plane, Space};
use nndd::NnddStatus;
use serde_json::{Value, json};

/// Makes a row of `adaptive` in report.json; `None` for a mesh without bound or residual.
pub fn adaptive_row(step: &Step) -> Option<AdaptiveRow> {
    step.e_cre.or(step.e_b)?;
    Some(AdaptiveRow {
        step: step.step,
        nodes: step.nodes,
        pairs: step.pairs,
        e_cre: step.e_cre,
        relative: step.relative,
        e_b: step.e_b,
        relative_residual: step.relative_residual,
        iterations: step.iterations,
        energy_norm_squared: step.energy_norm_squared?,
        peak_stress: step.peak_stress,
    })
}

/// Makes an object with the same keys for a mesh without bound.
pub fn without_bound(step: &Step) -> Value {
    json!({
        "step": step.step,
        "nodes": step.nodes,
        "pairs": step.pairs,
        "e_cre": null,
        "relative": null,
        "iterations": step.iterations,
        "energy_norm_squared": step.energy_norm_squared,
        "peak_stress": step.peak_stress,
    })
}

/// Solves an adaptive case.
pub(crate) fn solve<S: ReportSpace>(
    (case, adapt): (&Case<S>, &Adapt),
    problem: ContactProblem<S>,
    mut follower: RunObserver<'_>,
    place: &mut RunDirectory,
) -> Result<Solved<S>, Failure> {
    let mut settings = AdaptSettings::new(adapt.target.value());
    settings.max_steps = adapt.max_steps;
    settings.max_nodes = adapt.max_nodes;
    settings.fraction = adapt.fraction;
    resume::prepare(case, place)?;
    let RunDirectory { directory, progress, .. } = place;
    let checkpoint = progress.as_ref().map(resume::read);
    let seconds: Vec<f64> = progress.iter().flat_map(|p| &p.steps).map(|s| s.seconds).collect();
    for (step, seconds) in checkpoint.iter().flat_map(|c| &c.history).zip(&seconds) {
        follower.tell(Event::EarlierStep(step, *seconds));
    }
    let mut steps = Steps {
        follower,
        case,
        directory,
        failure: None,
        before: seconds.last().copied().unwrap_or(0.0),
        seconds,
        nodes: 0,
        memory: None,
    };
    let undeclared = S::undeclared(&problem);
    let run = if case.coulomb_pair().is_none() { certified } else { coulomb };
    let answer = run(case, problem, checkpoint, &settings, &mut steps);
    let Steps { follower, failure, seconds, memory, directory, .. } = steps;
    if let Some(failure) = failure {
        return Err(resume::after_failure(failure, directory));
    }
    let course = answer.map_err(|e| follower.failure(case, &e))?;
    let status = judge(case, adapt, &course, follower.ended, memory.as_deref());
    let adaptive = course.history.iter().filter_map(adaptive_row).collect();
    let longest_step = follower.longest;
    let notes = S::notes_on_refinement(case, &undeclared, course.answer.fields().problem);
    let Course { answer, step, end, peak_change, .. } = course;
    let smallest_mesh = matches!(end, AdaptiveEnd::Rose).then_some(step);
    let solved = Solved::of(answer, status);
    Ok(Solved { adaptive, smallest_mesh, peak_change, notes, step_seconds: seconds, longest_step, ..solved })
}

/// Solves an adaptive case whose target is a certified error.
fn certified<S: ReportSpace>(
    case: &Case<S>,
    problem: ContactProblem<S>,
    checkpoint: Option<Checkpoint>,
    settings: &AdaptSettings,
    steps: &mut Steps<'_, '_, S>,
) -> Result<Course<S>, SolveError<S>> {
    let solver = convert::settings(case);
    let found = match checkpoint {
        Some(checkpoint) => resume_adaptively(problem, checkpoint, &solver, settings, steps),
        None => solve_adaptively(problem, &solver, settings, steps),
    };
    found.map(|found| Course::new(found, RunResult::Certified))
}

/// Solves an adaptive case whose target is a residual with Coulomb friction.
fn coulomb<S: ReportSpace>(
    case: &Case<S>,
    problem: ContactProblem<S>,
    checkpoint: Option<Checkpoint>,
    settings: &AdaptSettings,
    steps: &mut Steps<'_, '_, S>,
) -> Result<Course<S>, SolveError<S>> {
    let (solver, relaxation) = (convert::coulomb(case), convert::relaxation(case));
    let found = match checkpoint {
        Some(checkpoint) => {
            resume_coulomb_adaptively(problem, checkpoint, &solver, relaxation, settings, steps)
        }
        None => solve_coulomb_adaptively(problem, &solver, relaxation, settings, steps),
    };
    found.map(|found| Course::new(found, RunResult::Coulomb))
}

/// An adaptive run that has ended, with or without a certificate.
pub(crate) struct Course<S: Space = Plane> {
    answer: RunResult<S>,
    /// The mesh of the answer, from 1.
    step: usize,
    history: Vec<Step>,
    end: AdaptiveEnd<S>,
    peak_change: Option<f64>,
}

impl<S: Space> Course<S> {
    fn new<A>(found: AdaptiveSolution<A, S>, answer: fn(Box<A>) -> RunResult<S>) -> Self {
        let peak_change = found.peak_change();
        let AdaptiveSolution { solution, step, history, end, .. } = found;
        Self { answer: answer(Box::new(solution)), step, history, end, peak_change }
    }

    /// Returns the relative number that the target is about.
    fn relative(&self) -> Option<f64> {
        match &self.answer {
            RunResult::Certified(solution) => solution.relative(),
            RunResult::Coulomb(result) => result.relative_residual(),
        }
    }

    fn holds_no_energy(&self) -> bool {
        match &self.answer {
            RunResult::Certified(solution) => solution.holds_no_energy(),
            RunResult::Coulomb(result) => result.residual().is_some() && result.relative_residual().is_none(),
        }
    }

    /// Computes the allowance for round-off over the energy norm.
    fn round_off(&self) -> f64 {
        match &self.answer {
            RunResult::Certified(solution) => solution.round_off(),
            RunResult::Coulomb(result) => {
                let found = Some(result.estimate().round_off / result.energy_norm());
                found.filter(|floor| floor.is_finite()).unwrap_or(0.0)
            }
        }
    }
}

/// Follows the run, writes each mesh's files, and keeps it within the memory limit.
pub(crate) struct Steps<'a, 'h, S: Dimension = Plane> {
    follower: RunObserver<'h>,
    case: &'a Case<S>,
    directory: &'a mut OutputDirectory,
    /// The error in writing that ends the run.
    failure: Option<Failure>,
    /// When each mesh had been solved, in seconds of work.
    seconds: Vec<f64>,
    /// Seconds of work before the run was resumed.
    before: f64,
    /// Nodes of the mesh that was solved last.
    nodes: usize,
    /// Why there is not enough memory for the next mesh.
    memory: Option<String>,
}

impl<S: ReportSpace> Steps<'_, '_, S> {
    /// Tells of a mesh that has been solved, and writes its files.
    fn solved(&mut self, step: &Step, fields: &Fields<'_, S>) {
        self.follower.switch(Activity::Write);
        self.nodes = step.nodes;
        self.seconds.truncate(step.step - 1);
        self.seconds.push(self.before + self.follower.elapsed());
        self.follower.tell(Event::Step(step));
        if self.case.output.vtu && adaptive_row(step).is_some() {
            self.failure = paraview::write_step(self.case, fields, step.step, self.directory).err();
        }
    }
}

impl<S: ReportSpace> Observer<S> for Steps<'_, '_, S> {
    fn phase(&mut self, phase: Phase) {
        Observer::<S>::phase(&mut self.follower, phase);
    }

    fn iteration(&mut self, row: &IterationRecord) {
        Observer::<S>::iteration(&mut self.follower, row);
    }

    fn step(&mut self, step: &Step, solution: &CertifiedSolution<S>) {
        self.solved(step, &Fields::certified(solution));
    }

    fn coulomb_step(&mut self, step: &Step, result: &CoulombResult<S>) {
        self.follower.tell(Event::Iteration(&result.row()));
        self.solved(step, &Fields::coulomb(result));
    }

    fn fits_in_memory(&mut self, problem: &ContactProblem<S>) -> bool {
        self.memory =
            memory::no_room(self.case, memory::estimate_finer(problem, self.nodes), &*self.follower.host);
        self.memory.is_none()
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.follower.switch(Activity::Write);
        let written = resume::write(self.case, checkpoint, &self.seconds, self.directory);
        self.failure = self.failure.take().or(written.err());
    }

    fn should_stop(&mut self) -> bool {
        self.failure.is_some() || Observer::<S>::should_stop(&mut self.follower)
    }

    fn must_stop(&mut self) -> bool {
        self.failure.is_some() || Observer::<S>::must_stop(&mut self.follower)
    }
}

/// Judges a finished run.
///
/// * `memory`: why there is not enough memory for the next mesh.
fn judge<S: ReportSpace>(
    case: &Case<S>,
    adapt: &Adapt,
    answer: &Course<S>,
    ended: Option<Ended>,
    memory: Option<&str>,
) -> Status {
    // The best certificate may belong to an earlier mesh.
    let last = answer.step == answer.history.len();
    let mut status = match &answer.end {
        AdaptiveEnd::Iteration(_) | AdaptiveEnd::FixedPoint(_) | AdaptiveEnd::NotCertified { .. } if last => {
            outcome::judge_answer(case, &answer.answer, ended)
        }
        AdaptiveEnd::Interrupted => outcome::interrupted(ended, &format!("mesh {}", answer.history.len())),
        AdaptiveEnd::OutOfMemory { nodes } => {
            let needed = memory.unwrap_or("too much memory");
            word("limit", LIMIT, format!("the next mesh of {nodes} nodes needs {needed}"))
        }
        AdaptiveEnd::Failed(error) => failed(case, adapt, answer, error),
        _ => of_end(case, adapt, answer),
    };
    status.reason += match status.word.as_str() {
        "interrupted" => "; continue with --resume",
        "limit" => "; raise the limit and continue with --resume",
        _ => "",
    };
    if !last {
        let what = if answer.answer.certified().is_some() { "certificate" } else { "residual" };
        status.reason += &format!("; the {what} is that of mesh {}", answer.step);
    }
    status
}

/// Says how small the certified error, or the residual, is.
fn reached<S: ReportSpace>(answer: &Course<S>) -> String {
    let [alone, named] = match answer.answer {
        RunResult::Certified(_) => ["the bound", "certified relative error"],
        RunResult::Coulomb(_) => ["the residual", "relative residual"],
    };
    answer
        .relative()
        .map_or_else(|| alone.into(), |relative| format!("{named} {}", words::rounded_up(relative)))
}

/// The reason why a relative target cannot be met if the bodies hold no strain energy.
const NO_ENERGY: &str = "the bodies hold no strain energy, and a relative target has no meaning here";

fn missed<S: ReportSpace>(adapt: &Adapt, answer: &Course<S>, reason: &str) -> Status {
    let target = short(adapt.target.value());
    if answer.holds_no_energy() {
        return word("target_missed", NOT_CERTIFIED, format!("{NO_ENERGY}; {reason}"));
    }
    word("target_missed", NOT_CERTIFIED, format!("{} > {target}: {reason}", reached(answer)))
}

/// Says how the bound, or the residual, rose on the last three meshes.
fn rose<S: ReportSpace>(answer: &Course<S>) -> String {
    let last = answer.history.get(answer.history.len().saturating_sub(3)..).unwrap_or_default();
    let relative = last.iter().filter_map(|step| step.relative.or(step.relative_residual));
    let relative: Vec<String> = relative.map(words::rounded_up).collect();
    let what = if answer.answer.certified().is_some() { "bound" } else { "residual" };
    format!("the {what} rose on two meshes in a row, {}", relative.join(" < "))
}

/// Says that the next mesh is not held along a motion whose load the polygon of this one explained; `None` for other errors.
fn no_longer_explained<S: ReportSpace>(
    case: &Case<S>,
    answer: &Course<S>,
    error: &SolveError<S>,
) -> Option<String> {
    let SolveError::NotHeld { motion } = error else { return None };
    let left_out = &answer.answer.fields().problem.left_out;
    left_out.iter().find(|of| motion.bodies.iter().any(|(partner, _)| *partner == Partner::Body(of.body)))?;
    Some(format!(
        "the load that is left out on mesh {} is more than the error of the polygon of the next mesh, so it turns the body there: {} (load {} in \
         that direction, nothing resists); add a [[body.displacement]] that prevents this motion, or change the load",
        answer.step,
        all_move(case, motion),
        significant(motion.load)
    ))
}

/// Judges a run whose next mesh cannot be solved.
fn failed<S: ReportSpace>(
    case: &Case<S>,
    adapt: &Adapt,
    answer: &Course<S>,
    error: &SolveError<S>,
) -> Status {
    let failure = Failure::solve(case, error);
    let reason = failure.message.unwrap_or_else(|| error.to_string());
    match failure.code {
        LIMIT => word("limit", LIMIT, format!("the next mesh: {reason}")),
        _ if let Some(reason) = no_longer_explained(case, answer, error) => missed(adapt, answer, &reason),
        _ => missed(adapt, answer, &format!("the next mesh cannot be solved: {reason}")),
    }
}

/// Bounds up to this many times the allowance for round-off are round-off of the iteration too.
const NEAR_ROUND_OFF: f64 = 100.0;

/// A target this many times the allowance for round-off can be met.
const ABOVE_FLOOR: f64 = 10.0;

/// Names the target that a run at its round-off can be given.
///
/// * `floor`: the allowance for round-off over the energy norm.
fn attainable<S: ReportSpace>(adapt: &Adapt, answer: &Course<S>, floor: f64) -> String {
    let near = answer.relative().filter(|relative| *relative <= NEAR_ROUND_OFF * floor);
    let least = words::raised(near.unwrap_or(ABOVE_FLOOR * floor), 2);
    if least >= 1.0 {
        return "no target can be met; leave out [adapt], and check the units".into();
    }
    format!("set adapt.{} to {} or more", adapt.target.key(), short(least))
}

/// Judges a run that was not interrupted.
fn of_end<S: ReportSpace>(case: &Case<S>, adapt: &Adapt, answer: &Course<S>) -> Status {
    let meshes = answer.history.len();
    let target = short(adapt.target.value());
    match &answer.end {
        AdaptiveEnd::TargetMet => {
            let met = match adapt.target {
                Target::RelativeError(_) => "converged",
                Target::CoulombResidual(_) => "residual_reached",
            };
            let found = match answer.relative() {
                Some(_) => format!("{} <= {target}", reached(answer)),
                None => format!("{NO_ENERGY}: {} is zero to round-off", reached(answer)),
            };
            word(met, 0, format!("{found} on mesh {meshes}"))
        }
        AdaptiveEnd::MaxSteps => missed(
            adapt,
            answer,
            &format!("all adapt.max_steps = {} meshes are used; raise it", adapt.max_steps),
        ),
        AdaptiveEnd::Rose => missed(adapt, answer, &rose(answer)),
        AdaptiveEnd::MaxNodes => missed(
            adapt,
            answer,
            &format!("adapt.max_nodes = {} is too small for another useful mesh; raise it", adapt.max_nodes),
        ),
        AdaptiveEnd::RoundOff { .. } if answer.holds_no_energy() => {
            stalled(format!("{NO_ENERGY}; leave out [adapt]"))
        }
        AdaptiveEnd::RoundOff { floor } => stalled(format!(
            "the target {target} lies below the attainable floor {floor:.1e}, the round-off of this problem; {}",
            attainable(adapt, answer, *floor)
        )),
        AdaptiveEnd::Iteration(status) => {
            let failed = match status {
                NnddStatus::MaxIterations => "max_iterations",
                NnddStatus::Diverged { .. } => "diverged",
                _ => "stalled",
            };
            word(failed, NOT_CONVERGED, format!("the iteration on mesh {meshes} did not meet its criterion"))
        }
        AdaptiveEnd::FixedPoint(_) => {
            stalled(format!("the fixed point of Coulomb friction on mesh {meshes} did not converge"))
        }
        AdaptiveEnd::IterationError if answer.answer.certified().is_none() => stalled(format!(
            "{} > {target}, and nearly all of it is not the mesh's, so that no finer mesh lowers it; {}",
            reached(answer),
            attainable(adapt, answer, answer.round_off())
        )),
        AdaptiveEnd::IterationError => stalled(format!(
            "{} > {target}, and nearly all of it is the iteration's error, which no finer mesh lowers; {}",
            reached(answer),
            match case.solver.stop.criterion {
                Criterion::Estimator => attainable(adapt, answer, answer.round_off()),
                _ => "use solver.stop.criterion = \"estimator\", or more iterations".into(),
            }
        )),
        AdaptiveEnd::NotCertified { failed } => {
            let names: Vec<String> =
                failed.iter().map(|(name, found)| format!("{name} {found:.1e}")).collect();
            let which = if names.is_empty() { "does not exist".into() } else { names.join(", ") };
            let [name, what] = match answer.answer {
                RunResult::Certified(_) => ["not_certified", "bound"],
                RunResult::Coulomb(_) => ["no_residual", "residual"],
            };
            word(
                name,
                NOT_CERTIFIED,
                format!("the {what} of mesh {meshes} does not pass its checks: {which}"),
            )
        }
        _ => missed(adapt, answer, "the run ended in an unknown way"),
    }
}
