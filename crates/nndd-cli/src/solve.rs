//! `nndd solve`: solves a case, certifies it, writes everything down.

use crate::args::{Format, Solve};
use crate::machine::{Machine, Showing};
use crate::printer::Printer;
use crate::progress::{Goal, Progress};
use case_io::Case;
use case_io::case::{AnyCase, Criterion};
use nndd_report::memory_limit;
use nndd_report::{Event, Failure, Host, ReportSpace, RunDirectory, Stopwatch, check, files, run};
use serde_json::{Map, Value};
use std::path::PathBuf;

pub(crate) fn command(options: &Solve) -> Result<u8, Failure> {
    let machine = Machine::listen(options.format == Format::Json)?;
    let watch = Stopwatch::start(machine.elapsed());
    let started = humantime::format_rfc3339_nanos(std::time::SystemTime::now()).to_string();
    match run::read_case(&options.case.case, &run::overrides(&options.case.set)?)? {
        AnyCase::Plane(case) => solve(options, &case, machine, watch, &started),
        AnyCase::Solid(case) => solve(options, &case, machine, watch, &started),
    }
}

fn solve<S: ReportSpace>(
    options: &Solve,
    case: &Case<S>,
    machine: Machine,
    mut watch: Stopwatch,
    started: &str,
) -> Result<u8, Failure> {
    let mut built = run::build(case, &machine)?;
    run::begins(case, "the question whether the bodies are held", &machine);
    check::held(case, &mut built.problem)?;
    let memory_estimate = built.memory.round();
    let path = options.run.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory()));
    let mut place = match options.resume {
        true => RunDirectory::resume(case, &path)?,
        false => RunDirectory::open(case, &path, options.run.force)?,
    };
    let mut printer = Printer::new(options, case, machine.started);
    printer.begin(
        case,
        &built.problem,
        (&path.display().to_string(), memory_estimate),
        [&built.notes, place.notes()],
    )?;
    let stop = &case.solver.stop;
    let goal = Goal {
        ratio: (stop.criterion == Criterion::Estimator).then_some(stop.ratio),
        relative: case.adapt.as_ref().map(|adapt| adapt.target.value()),
    };
    let mut progress = Progress::start(goal, !options.run.quiet && options.format == Format::Human);
    let show = |event: Event<'_>| {
        show(&mut printer, &mut progress, &event);
        Ok(())
    };
    let mut host = Showing { machine, show };
    let solved = run::solve(case, built, &mut place, &mut watch, &mut host)?;
    let Showing { machine, .. } = host;
    drop(progress);
    let mut about = describe(options);
    about.insert("started".into(), started.into());
    about.insert("memory_estimate".into(), memory_estimate.into());
    about.insert("output".into(), path.display().to_string().into());
    let written = files::write(case, &solved, place, about, &mut watch, &machine)?;
    let (report, files) = (&written.report, &written.files);
    printer.end(options.run.verbose, case, &solved, report, &path.display().to_string(), files)?;
    Ok(report.status.code)
}

/// Shows an event of the run.
fn show(printer: &mut Printer, progress: &mut Progress, event: &Event<'_>) {
    match *event {
        Event::Phase(phase) => progress.phase(phase),
        Event::Iteration(row) => {
            progress.clear();
            printer.row(row);
            progress.iteration(row);
        }
        Event::EarlierStep(step, seconds) => printer.step(step, Some(seconds)),
        Event::Step(step) => {
            progress.clear();
            printer.step(step, None);
            progress.step(step);
        }
        Event::LoadStep { step, of } => {
            progress.clear();
            printer.load_step(step, of);
        }
        _ => {}
    }
}

/// Lists with what a case was solved, as far as this program alone knows it.
fn describe(options: &Solve) -> Map<String, Value> {
    let mut about = Map::new();
    about.insert("host".into(), memory_limit::host().into());
    about.insert("threads".into(), rayon::current_num_threads().into());
    about.insert("memory_peak".into(), memory_limit::peak().into());
    about.insert("overrides".into(), options.case.set.clone().into());
    about
}
