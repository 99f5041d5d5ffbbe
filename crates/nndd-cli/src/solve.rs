//! `nndd solve`: solves a case, certifies it, writes everything down.

use crate::adapt::{self, Event};
use crate::args::{Format, Solve};
use crate::check;
use crate::failure::Failure;
use crate::files;
use crate::memory;
use crate::outcome;
use crate::printer::Printer;
use crate::report;
use crate::resume::{self, Place, Resumed};
use crate::run::{self, Follower, Solved};
use crate::signals::Signals;
use crate::stopwatch::{Activity, Stopwatch};
use case_io::Case;
use case_io::checkpoint;
use case_io::output::{OutputDirectory, ResultKind};
use case_io::report::{CASE_HASH, Report};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

pub(crate) fn command(options: &Solve) -> Result<u8, Failure> {
    let mut watch = Stopwatch::start();
    let signals = Signals::listen()?;
    let started = humantime::format_rfc3339_nanos(std::time::SystemTime::now()).to_string();
    let (_, mut case) = run::read_case(&options.case, &run::overrides(&options.case.set)?)?;
    let problem = run::build(&mut case)?;
    check::supports(&case, &problem)?;
    let memory_estimate = memory::estimate(&problem).round();
    let path = options.run.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory()));
    let resumed = if options.resume { Some(resume::find(&case, &path)?) } else { None };
    let (mut directory, progress, notes) = match resumed {
        Some(Resumed { directory, progress, notes }) => (directory, progress, notes),
        None => {
            let directory = OutputDirectory::open(&path, ResultKind::Solve, &case.hash(), options.run.force)
                .map_err(|e| Failure::output(&e))?;
            (directory, None, Vec::new())
        }
    };
    let resumed_on = options.resume.then(|| progress.as_ref().map_or(1, |p| p.meshes.len() + 1));
    let mut printer = Printer::new(options, &case, watch.started());
    printer.begin(&case, &problem, &path.display().to_string(), &notes)?;
    let show_progress = !options.run.quiet && options.format == Format::Human;
    let presence = directory.presence();
    let follower = Follower::new(&case, &mut watch, &signals, presence, show_progress);
    let solved = match &case.adapt {
        None => run::solve(&case, problem, follower, &mut |row| printer.row(row))?,
        Some(adapt) => {
            let mut print = |event: Event<'_>| match event {
                Event::Iteration(row) => printer.row(row),
                Event::Step(step) => printer.step(step),
            };
            let place = Place { directory: &mut directory, progress };
            adapt::solve(&case, adapt, problem, follower, place, &mut print)?
        }
    };
    watch.switch(Activity::Write);
    let mut run_info = describe(options, &case, &solved);
    run_info.insert("started".into(), started.into());
    run_info.insert("memory_estimate".into(), memory_estimate.into());
    run_info.insert("output".into(), path.display().to_string().into());
    if let Some(mesh) = resumed_on {
        run_info.insert("resumed_on_mesh".into(), mesh.into());
    }
    let report = write_all(&case, &solved, run_info, &mut watch, &mut directory)?;
    if !outcome::may_go_on(&report.status) {
        checkpoint::remove(&mut directory).map_err(|e| Failure::output(&e))?;
    }
    let written: Vec<String> = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish().map_err(|e| Failure::output(&e))?;
    printer.end(options.run.verbose, &case, &solved, &report, &path.display().to_string(), &written)?;
    Ok(report.status.code)
}

/// Lists with what a case was solved: `run` of report.json, as far as it is known here.
fn describe(options: &Solve, case: &Case, solved: &Solved) -> Map<String, Value> {
    let mut run_info = Map::new();
    run_info.insert(CASE_HASH.into(), case.hash().into());
    run_info.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    run_info.insert("host".into(), host().into());
    run_info.insert("threads".into(), rayon::current_num_threads().into());
    run_info.insert("memory_peak".into(), memory::peak().into());
    run_info.insert("case_file".into(), case.file_name().into());
    run_info.insert("overrides".into(), options.case.set.clone().into());
    run_info.insert("clarabel_calls".into(), solved.solution.nndd.clarabel_calls.into());
    if solved.status.word == "limit"
        && let Some((step, seconds)) = solved.longest_step
    {
        // What kept the run from ending at the limit of its time.
        run_info.insert("longest_step".into(), json!({ "step": step, "seconds": seconds }));
    }
    if case.adapt.is_some() {
        run_info.insert("adaptive_seconds".into(), solved.step_seconds.clone().into());
    }
    run_info
}

fn host() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname")
        .map_or_else(|_| "unknown".into(), |s| s.trim().into())
}

/// Writes the pictures and tables, and report.json last: it makes the result complete.
fn write_all(
    case: &Case,
    solved: &Solved,
    run_info: Map<String, Value>,
    watch: &mut Stopwatch,
    directory: &mut OutputDirectory,
) -> Result<Report, Failure> {
    let mut report = report::report(case, solved, run_info);
    files::write(case, solved, &report, directory)?;
    report.timings = watch.read();
    let text = report.to_json()?;
    directory.write("report.json", text.as_bytes()).map_err(|e| Failure::output(&e))?;
    Ok(report)
}
