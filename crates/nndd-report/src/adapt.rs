//! An adaptive run: one row and one set of ParaView files per mesh.

mod status;

use crate::convert;
use crate::failure::Failure;
use crate::host::Event;
use crate::memory::{self, Plan};
use crate::paraview;
use crate::resume::{self, RunDirectory};
use crate::run_observer::RunObserver;
use crate::solved::{Fields, RunResult, Solved, SolvedStep};
use crate::space::ReportSpace;
use crate::steps;
use crate::stopwatch::Activity;
use case_io::Case;
use case_io::case::{Adapt, Dimension};
use case_io::output::OutputDirectory;
use case_io::report::{AdaptiveRow, Status};
use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Checkpoint, CoulombResult,
    IterationRecord, Observer, Phase, Step, StepFactors, resume_adaptively, resume_coulomb_adaptively,
    solve_adaptively, solve_coulomb_adaptively, solve_coulomb_steps_adaptively, solve_steps_adaptively,
};
use fem_core::body::ConditionPlace;
use fem_core::interface::ContactProblem;
use fem_core::space::{Plane, Space};
use serde_json::{Value, json};

/// Makes a row of `adaptive` in report.json; `None` for a mesh without bound or residual.
pub fn adaptive_row(step: &Step) -> Option<AdaptiveRow> {
    step.e_cre.or(step.e_b)?;
    Some(AdaptiveRow {
        step: step.step,
        nodes: step.nodes,
        pairs: step.pairs,
        load_step: step.load_step,
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
    (case, adapt, plan): (&Case<S>, &Adapt, Plan),
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
        plan,
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
    let found = solve_all(case, problem, checkpoint, &settings, &mut steps);
    let Steps { mut follower, failure, seconds, memory, directory, .. } = steps;
    if let Some(failure) = failure {
        return Err(resume::after_failure(failure, directory));
    }
    let course = found?;
    let status = status::judge(case, adapt, &course, follower.ended, memory.as_deref());
    let adaptive = course.history.iter().filter_map(adaptive_row).collect();
    let longest_step = follower.longest;
    let mut notes = S::notes_on_refinement(case, &undeclared, course.answer.fields().problem);
    let smallest_mesh = matches!(course.end, AdaptiveEnd::Rose).then_some(course.step);
    let peak_change = course.peak_change;
    let (solved, steps) = load_steps(case, course, &mut follower, directory)?;
    notes.extend(steps.first().and_then(|_| steps::note(&solved)));
    let solved = Solved { status, steps, ..solved };
    Ok(Solved { adaptive, smallest_mesh, peak_change, notes, step_seconds: seconds, longest_step, ..solved })
}

/// Returns the answer of a run and, in load steps, the results of each, whose fields it writes.
fn load_steps<S: ReportSpace>(
    case: &Case<S>,
    course: Course<S>,
    follower: &mut RunObserver<'_>,
    directory: &mut OutputDirectory,
) -> Result<(Solved<S>, Vec<SolvedStep>), Failure> {
    let increments = case.increments();
    let (mut kept, mut solved) = (Vec::new(), None);
    let Course { earlier, answer, .. } = course;
    let of = increments.len();
    if of == 0 {
        return Ok((Solved::of(answer, Status::default()), kept));
    }
    for ((step, factors), answer) in (1..).zip(&increments).zip(earlier.into_iter().chain([answer])) {
        let (found, summary) = steps::judge(case, answer, (step, of), factors, follower.ended)?;
        follower.tell(Event::LoadStep { step: &summary, of });
        follower.switch(Activity::Write);
        kept.push(steps::keep(case, &found, summary, of, directory)?);
        solved = Some(found);
    }
    let solved = solved.ok_or_else(|| Failure::defect("a run without an answer"))?;
    Ok((solved, kept))
}

/// Solves the case on finer and finer meshes, once or in load steps, for a certified error or, with Coulomb friction, for a residual.
fn solve_all<S: ReportSpace>(
    case: &Case<S>,
    problem: ContactProblem<S>,
    checkpoint: Option<Checkpoint>,
    settings: &AdaptSettings,
    steps: &mut Steps<'_, '_, S>,
) -> Result<Course<S>, Failure> {
    let increments = case.increments();
    let of_conditions: Vec<_> = increments
        .iter()
        .map(|factors| move |body: usize, place: ConditionPlace| case.factor(factors, body, place))
        .collect();
    let gaps = |factors| (0..case.contacts.len()).map(|pair| case.gap_factor(factors, pair)).collect();
    let factors = increments.iter().zip(&of_conditions);
    let factors: Vec<StepFactors<'_>> =
        factors.map(|(factors, conditions)| StepFactors { conditions, gaps: gaps(factors) }).collect();
    let coulomb = case.coulomb_pair().map(|_| (convert::coulomb(case), convert::relaxation(case)));
    let solver = steps.plan.settings(case);
    let found = match (&coulomb, factors.as_slice()) {
        (None, []) => match checkpoint {
            Some(checkpoint) => resume_adaptively(problem, checkpoint, &solver, settings, steps),
            None => solve_adaptively(problem, &solver, settings, steps),
        }
        .map(|found| Course::new(found, |one| vec![one], RunResult::Certified)),
        (Some((solver, relaxation)), []) => match checkpoint {
            Some(checkpoint) => {
                resume_coulomb_adaptively(problem, checkpoint, solver, *relaxation, settings, steps)
            }
            None => solve_coulomb_adaptively(problem, solver, *relaxation, settings, steps),
        }
        .map(|found| Course::new(found, |one| vec![one], RunResult::Coulomb)),
        (None, factors) => solve_steps_adaptively(problem, factors, checkpoint, &solver, settings, steps)
            .map(|found| Course::new(found, |all| all.steps, RunResult::Certified)),
        (Some(solver), factors) => {
            solve_coulomb_steps_adaptively(problem, factors, checkpoint, solver, settings, steps)
                .map(|found| Course::new(found, |all| all.steps, RunResult::Coulomb))
        }
    };
    let found = found.map_err(|error| steps.follower.failure(case, &error))?;
    found.ok_or_else(|| Failure::defect("an adaptive run without an answer"))
}

/// An adaptive run that has ended, with or without a certificate.
pub(crate) struct Course<S: Space = Plane> {
    /// In load steps the last one.
    answer: RunResult<S>,
    /// The load steps before.
    earlier: Vec<RunResult<S>>,
    /// The mesh of the answer, from 1.
    step: usize,
    history: Vec<Step>,
    end: AdaptiveEnd<S>,
    peak_change: Option<f64>,
}

impl<S: Space> Course<S> {
    /// * `all`: takes the solutions of all load steps out of that of a mesh, which has at least one.
    fn new<A, B>(
        found: AdaptiveSolution<A, S>,
        all: fn(A) -> Vec<B>,
        answer: fn(Box<B>) -> RunResult<S>,
    ) -> Option<Self> {
        let peak_change = found.peak_change();
        let AdaptiveSolution { solution, step, history, end, .. } = found;
        let mut earlier: Vec<_> = all(solution).into_iter().map(|one| answer(Box::new(one))).collect();
        Some(Self { answer: earlier.pop()?, earlier, step, history, end, peak_change })
    }

    /// Returns the load step, from 1, with the largest relative error, if there are load steps.
    fn largest_step(&self) -> Option<usize> {
        self.history.get(self.step.checked_sub(1)?)?.load_step
    }

    /// Returns the solution that the target is about: of load steps that with the largest relative error.
    fn largest(&self) -> &RunResult<S> {
        let earlier = self.largest_step().and_then(|k| self.earlier.get(k.checked_sub(1)?));
        earlier.unwrap_or(&self.answer)
    }

    /// Returns the relative number that the target is about.
    fn relative(&self) -> Option<f64> {
        match self.largest() {
            RunResult::Certified(solution) => solution.relative(),
            RunResult::Coulomb(result) => result.relative_residual(),
        }
    }

    fn holds_no_energy(&self) -> bool {
        match self.largest() {
            RunResult::Certified(solution) => solution.holds_no_energy(),
            RunResult::Coulomb(result) => result.residual().is_some() && result.relative_residual().is_none(),
        }
    }

    /// Computes the allowance for round-off over the energy norm.
    fn round_off(&self) -> f64 {
        match self.largest() {
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
    plan: Plan,
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
        // The fields of load steps are written at the end of the run.
        if self.case.output.vtu && self.case.steps.is_empty() && adaptive_row(step).is_some() {
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
        self.memory = memory::no_room(
            self.case,
            memory::estimate_finer((self.case, &self.plan), problem, self.nodes),
            &*self.follower.host,
        );
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
