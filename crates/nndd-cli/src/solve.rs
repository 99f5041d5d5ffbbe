//! `nndd solve`: solves a case, certifies it, writes everything down.

use crate::adapt::{self, Event};
use crate::args::{Format, Solve};
use crate::check;
use crate::console;
use crate::failure::Failure;
use crate::files;
use crate::memory;
use crate::notes;
use crate::outcome;
use crate::resume::{self, Place, Resumed};
use crate::run::{self, Follower, Solved};
use crate::signals::Signals;
use crate::stopwatch::{Activity, Stopwatch};
use case_io::Case;
use case_io::checkpoint;
use case_io::output::OutputDirectory;
use case_io::report::{CASE_HASH, Report};
use certified_contact::{Row, Step};
use fem_core::interface::ContactProblem;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

pub(crate) fn command(options: &Solve) -> Result<u8, Failure> {
    let mut watch = Stopwatch::start();
    let signals = Signals::listen()?;
    let started = jiff::Timestamp::now().to_string();
    let (_, mut case) = run::read_case(&options.case, &run::overrides(&options.case.set)?)?;
    run::start_threads(&options.run)?;
    let problem = run::build(&mut case)?;
    check::supports(&case, &problem)?;
    let memory_estimate = memory::estimate(&problem).round();
    let path = options.run.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory()));
    let resumed = if options.resume { Some(resume::find(&case, &path)?) } else { None };
    let (mut directory, progress, notes) = match resumed {
        Some(Resumed { directory, progress, notes }) => (directory, progress, notes),
        None => {
            let directory = OutputDirectory::open(&path, &case.hash(), options.run.force)
                .map_err(|e| Failure::output(&e))?;
            (directory, None, Vec::new())
        }
    };
    let resumed_on = options.resume.then(|| progress.as_ref().map_or(1, |p| p.meshes.len() + 1));
    let mut printer = Printer {
        format: options.format,
        quiet: options.run.quiet,
        every_iteration: case.adapt.is_none() || options.run.verbose || options.format == Format::Json,
        rows: 0,
        steps: 0,
    };
    if !options.run.quiet {
        console::warnings(&case.warnings());
        console::notes(case.notes());
        console::notes(&notes);
    }
    printer.header(&case, &problem, &path.display().to_string())?;
    let show_progress = !options.run.quiet && options.format == Format::Human;
    let follower = Follower::new(&case, &mut watch, &signals, show_progress);
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
    let mut run_info = Map::new();
    run_info.insert(CASE_HASH.into(), case.hash().into());
    run_info.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    run_info.insert("started".into(), started.into());
    run_info.insert("host".into(), host().into());
    run_info.insert("threads".into(), rayon::current_num_threads().into());
    run_info.insert("memory_estimate".into(), memory_estimate.into());
    run_info.insert("memory_peak".into(), memory::peak().into());
    run_info.insert("output".into(), path.display().to_string().into());
    run_info.insert("case_file".into(), case.file_name().into());
    run_info.insert("overrides".into(), options.case.set.clone().into());
    run_info.insert("clarabel_calls".into(), solved.solution.nndd.clarabel_calls.into());
    if case.adapt.is_some() {
        run_info.insert("adaptive_seconds".into(), solved.step_seconds.clone().into());
    }
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
    let mut report = files::report(case, solved, run_info);
    files::write(case, solved, &report, directory)?;
    report.timings = watch.read();
    let text = report.to_json()?;
    directory.write("report.json", text.as_bytes()).map_err(|e| Failure::output(&e))?;
    Ok(report)
}

/// What is known of the case before it is solved: how it was read, and which data the first mesh only interpolates.
fn notes(case: &Case, problem: &ContactProblem) -> Vec<String> {
    let data = case.data_notes([&problem.bodies[0], &problem.bodies[1]], problem.interpolated_gap());
    case.notes().iter().cloned().chain(data).collect()
}

/// Prints the course of a run, for people or for programs.
struct Printer {
    format: Format,
    quiet: bool,
    /// Whether the iterations of an adaptive run are shown too.
    every_iteration: bool,
    rows: usize,
    steps: usize,
}

impl Printer {
    fn header(&mut self, case: &Case, problem: &ContactProblem, output: &str) -> Result<(), Failure> {
        match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => Ok(console::print(&console::header(case, problem, output))?),
            Format::Json => self.event(json!({
                "event": "started",
                "case": case.file_name(),
                "nodes": problem.bodies.iter().map(|b| b.mesh().points().len()).collect::<Vec<_>>(),
                "pairs": problem.interface.pairs().len(),
                "output": output,
                "notes": notes(case, problem),
                "warnings": case.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
            })),
        }
    }

    fn row(&mut self, row: &Row) {
        let result = match self.format {
            _ if self.quiet || !self.every_iteration => Ok(()),
            Format::Human => {
                let width = console::width();
                let head = if self.rows == 0 { console::table_head(width) } else { String::new() };
                console::print(&format!("{head}{}", console::row(row, width))).map_err(Failure::from)
            }
            Format::Json => {
                let mut object = json!(files::iteration_row(row));
                if let Some(map) = object.as_object_mut() {
                    map.insert("event".into(), "iteration".into());
                }
                self.event(object)
            }
        };
        self.rows += 1;
        // A console that cannot be written to must not cost the run its result.
        drop(result);
    }

    /// Prints a mesh of an adaptive run.
    fn step(&mut self, step: &Step) {
        let result = match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => {
                let head = if self.steps == 0 || self.every_iteration { console::STEP_HEAD } else { "" };
                console::print(&format!("{head}{}", console::step(step))).map_err(Failure::from)
            }
            Format::Json => {
                let mut object = json!(adapt::row(step));
                if let Some(map) = object.as_object_mut() {
                    map.insert("event".into(), "step".into());
                }
                self.event(object)
            }
        };
        self.steps += 1;
        // The next mesh has a table of iterations of its own.
        self.rows = 0;
        // A console that cannot be written to must not cost the run its result.
        drop(result);
    }

    fn end(
        &self,
        verbose: bool,
        case: &Case,
        solved: &Solved,
        report: &Report,
        directory: &str,
        written: &[String],
    ) -> Result<(), Failure> {
        match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => {
                let mut text = console::verdict(report);
                if verbose {
                    text += &console::choices(case, solved);
                }
                text += &format!("wrote {directory}: {}\n", written.join(" "));
                console::print(&text)?;
                // Those of the case were shown at the beginning.
                let shown = notes::of_case(case).len();
                console::notes(report.notes.get(shown..).unwrap_or_default());
                Ok(())
            }
            Format::Json => self.event(json!({
                "event": "finished",
                "notes": report.notes,
                "status": report.status,
                "certificate": report.certificate,
                "timings": report.timings,
                "files": written,
            })),
        }
    }

    fn event(&self, event: Value) -> Result<(), Failure> {
        Ok(console::print(&format!("{event}\n"))?)
    }
}
