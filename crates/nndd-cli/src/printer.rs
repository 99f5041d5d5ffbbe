//! The output of a run from its beginning to its end, for people or for programs.

use crate::args::{Format, Solve};
use crate::console;
use case_io::Case;
use case_io::report::{Report, StepSummary};
use certified_contact::{IterationRecord, Step};
use fem_core::interface::ContactProblem;
use nndd_report::words::{self, counted};
use nndd_report::{Failure, ReportSpace, Solved, adaptive_row, notes, report, verdict, without_bound};
use serde_json::{Value, json};
use std::time::Instant;

/// Prints the course of a run, for people or for programs.
pub(crate) struct Printer {
    format: Format,
    quiet: bool,
    /// Set if the iterations of an adaptive run are shown too.
    every_iteration: bool,
    /// The name of the contact force.
    force: String,
    /// True if Coulomb friction leaves a residual in place of a bound.
    residual: bool,
    /// When the program began.
    started: Instant,
    /// Set if times are shown: on a terminal only. The output to a file is then the same in every run, unless more is
    /// asked for.
    timed: bool,
    rows: usize,
    steps: usize,
    /// The notes that were printed before the run began.
    said: Vec<String>,
}

impl Printer {
    /// Prepares for a case: the iterations of an adaptive run are shown if they are asked for.
    pub(crate) fn new<S: ReportSpace>(options: &Solve, case: &Case<S>, started: Instant) -> Self {
        let format = options.format;
        let one_solve = case.adapt.is_none() && case.steps.is_empty();
        let every_iteration = one_solve || options.run.verbose || format == Format::Json;
        let timed = options.run.verbose || console::width().is_some();
        let quiet = options.run.quiet;
        let (residual, said) = (case.coulomb_pair().is_some(), Vec::new());
        let force = verdict::contact_force(case.contacts.len(), "contact force");
        Self { format, quiet, every_iteration, force, residual, started, timed, rows: 0, steps: 0, said }
    }

    /// Prints what is known before the run begins.
    ///
    /// * `memory`: the estimate, bytes; `notes`: on the case, see [`nndd_report::run::build`], and on the state it resumes from.
    pub(crate) fn begin<S: ReportSpace>(
        &mut self,
        case: &Case<S>,
        problem: &ContactProblem<S>,
        (output, memory): (&str, f64),
        notes: [&[String]; 2],
    ) -> Result<(), Failure> {
        self.said = notes::of_case(case, notes[0]);
        let about_case = self.said.len();
        // On the meshes of an adaptive run data are interpolated ever better: only the last mesh counts.
        let later = if case.adapt.is_some() { case.data_notes(problem) } else { vec![] };
        self.said.extend(notes::of_problem(case, problem).into_iter().filter(|note| !later.contains(note)));
        if !self.quiet {
            console::warnings(&case.warnings());
            console::notes(notes[0]);
            console::notes(&self.said[about_case..]);
            console::notes(notes[1]);
        }
        match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => Ok(console::print(&console::header(case, problem, (output, memory)))?),
            Format::Json => self.event(&json!({
                "event": "started",
                "case": case.file_name(),
                "nodes": problem.bodies.iter().map(|b| b.mesh().points().len()).collect::<Vec<_>>(),
                "pairs": problem.node_pairs(),
                "output": output,
                "notes": self.said,
                "warnings": case.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
            })),
        }
    }

    pub(crate) fn row(&mut self, row: &IterationRecord) {
        let result = match self.format {
            _ if self.quiet || !self.every_iteration => Ok(()),
            Format::Human => {
                let layout = console::Layout { width: console::width(), timed: self.timed };
                let head = if self.rows == 0 { layout.head() } else { String::new() };
                let seconds = self.started.elapsed().as_secs_f64();
                console::print(&format!("{head}{}", layout.row(row, seconds))).map_err(Failure::from)
            }
            Format::Json => {
                let mut object = json!(report::iteration_row(row));
                object["event"] = "iteration".into();
                self.event(&object)
            }
        };
        self.rows += 1;
        // A console that cannot be written to must not cost the run its result.
        drop(result);
    }

    /// Prints a mesh of an adaptive run.
    ///
    /// * `at`: when it was solved, s; `None`: now.
    pub(crate) fn step(&mut self, step: &Step, at: Option<f64>) {
        let result = match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => {
                let first = self.steps == 0 || self.every_iteration;
                let head = if first { console::step_head(self.residual, self.timed) } else { String::new() };
                let seconds = at.unwrap_or_else(|| self.started.elapsed().as_secs_f64());
                let seconds = self.timed.then_some(seconds);
                console::print(&format!("{head}{}", console::step(step, seconds))).map_err(Failure::from)
            }
            Format::Json => {
                // A mesh without bound has no row in the report; here it still has an event.
                let mut object = adaptive_row(step).map_or_else(|| without_bound(step), |row| json!(row));
                object["event"] = "step".into();
                self.event(&object)
            }
        };
        self.steps += 1;
        // The next mesh has a table of iterations of its own.
        self.rows = 0;
        // A console that cannot be written to must not cost the run its result.
        drop(result);
    }

    /// Prints a load step.
    ///
    /// * `of`: the number of load steps.
    pub(crate) fn load_step(&mut self, summary: &StepSummary, of: usize) {
        let step = summary.step;
        let force = summary.results.contact_force;
        let certificate = summary.certificate.as_ref();
        let relative = certificate.and_then(|certificate| certificate.relative);
        let residual = summary.coulomb.as_ref().and_then(|coulomb| coulomb.relative);
        let percent = |x: f64| words::rounded_up(100.0 * x);
        // Without strain energy the numbers are absolute.
        let bound = certificate.filter(|certificate| certificate.valid).and_then(|found| found.e_cre);
        let absolute = summary.coulomb.as_ref().and_then(|coulomb| coulomb.e_b);
        let result = match self.format {
            _ if self.quiet => Ok(()),
            Format::Human => {
                let bounded = relative.map(|x| format!("{} %", percent(x))).or(bound.map(words::rounded_up));
                let left = residual.map(|x| format!("{} % of the energy norm", percent(x)));
                let error = match (bounded, left.or(absolute.map(words::rounded_up))) {
                    (Some(bound), _) => format!("certified error of the increment <= {bound}"),
                    (None, Some(residual)) => format!("residual e_b = {residual}, no bound"),
                    (None, None) if certificate.is_some() => "no certificate".to_owned(),
                    (None, None) => "no residual".to_owned(),
                };
                let force = force
                    .map_or_else(String::new, |f| format!("{} {}, ", self.force, words::with_digits(f, 4)));
                console::print(&format!("load step {step} of {of}: {force}{error}\n")).map_err(Failure::from)
            }
            Format::Json => self.event(&json!({
                "event": "load_step",
                "step": step,
                "of": of,
                "relative": relative,
                "relative_residual": residual,
                "contact_force": force,
            })),
        };
        // A console that cannot be written to must not cost the run its result.
        drop(result);
    }

    pub(crate) fn end<S: ReportSpace>(
        &self,
        verbose: bool,
        case: &Case<S>,
        solved: &Solved<S>,
        report: &Report,
        directory: &str,
        written: &[String],
    ) -> Result<(), Failure> {
        match self.format {
            _ if self.quiet => {
                if report.status.code != 0 {
                    console::reason(&verdict::verdict(report));
                }
                Ok(())
            }
            Format::Human => {
                let mut text = verdict::verdict(report) + &verdict::peak(report);
                text += &verdict::key_results(case, report);
                let remark = console::remark(case, report).filter(|_| self.every_iteration);
                text.extend(remark.map(|remark| format!("note: {remark}\n")));
                if verbose {
                    text += &verdict::choices(case, solved);
                }
                text += &wrote(directory, written);
                console::print(&text)?;
                let new = report.notes.iter().filter(|note| !self.said.contains(note));
                console::notes(&new.cloned().collect::<Vec<_>>());
                Ok(())
            }
            Format::Json => self.event(&json!({
                "event": "finished",
                "notes": report.notes,
                "status": report.status,
                "certificate": report.certificate,
                "coulomb": report.coulomb,
                "timings": report.timings,
                "files": written,
            })),
        }
    }

    fn event(&self, event: &Value) -> Result<(), Failure> {
        Ok(console::print_json(event)?)
    }
}
/// Names the directory and the files to open first: the page, the numbers, a body for ParaView.
fn wrote(directory: &str, written: &[String]) -> String {
    let is_body =
        |name: &&String| name.ends_with(".vtu") && !name.starts_with("contact") && !name.contains('/');
    let first = ["report.html", "report.json"].into_iter().filter(|name| written.iter().any(|w| w == name));
    let first: Vec<&str> = first.chain(written.iter().find(is_body).map(String::as_str)).collect();
    let more = match written.len().saturating_sub(first.len()) {
        0 => String::new(),
        more => format!(" and {}", counted(more, "more file")),
    };
    format!("wrote {directory}: {}{more}\n", first.join(", "))
}
