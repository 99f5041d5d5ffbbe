//! The files that a run writes.

use crate::failure::Failure;
use crate::host::Host;
use crate::html;
use crate::outcome;
use crate::paraview;
use crate::paths;
use crate::report::{self, contact_rows};
use crate::resume::RunDirectory;
use crate::solved::Solved;
use crate::space::ReportSpace;
use crate::stopwatch::{Activity, Stopwatch};
use crate::view;
use case_io::Case;
use case_io::checkpoint;
use case_io::output::OutputDirectory;
use case_io::report::{CASE_HASH, Report};
use case_io::table::{self, ContactRow};
use serde_json::{Map, Value, json};

/// The report of a run and the files that it wrote.
#[non_exhaustive]
pub struct Written {
    /// The contents of report.json.
    pub report: Report,
    /// The files, below the directory.
    pub files: Vec<String>,
}

/// Writes everything that a run found, report.json last: it makes the result complete.
///
/// * `run`: what else `run` of report.json shall hold, such as the host.
///
/// # Errors
/// Files that cannot be written.
pub fn write<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    place: RunDirectory,
    run: Map<String, Value>,
    watch: &mut Stopwatch,
    host: &dyn Host,
) -> Result<Written, Failure> {
    watch.switch(Activity::Write, host.elapsed());
    let resumed_on = place.resumed_on();
    let mut directory = place.directory;
    let mut run = run;
    if let Some(mesh) = resumed_on {
        run.insert("resumed_on_mesh".into(), mesh.into());
    }
    let mut report = self::report(case, solved, run);
    write_files(case, solved, &report, &mut directory)?;
    report.timings = watch.read(host.elapsed());
    let text = report.to_json()?;
    directory.write("report.json", text.as_bytes())?;
    if !outcome::may_go_on(&report.status) {
        checkpoint::remove(&mut directory)?;
    }
    let files = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish()?;
    Ok(Written { report, files })
}

/// Makes the contents of report.json, without times.
///
/// * `run`: what else `run` shall hold, such as the host.
pub fn report<S: ReportSpace>(case: &Case<S>, solved: &Solved<S>, run: Map<String, Value>) -> Report {
    let mut run_info = describe(case, solved);
    run_info.extend(run);
    report::report(case, solved, run_info)
}

/// Lists with what a case was solved: `run` of report.json, as far as it is known here.
fn describe<S: ReportSpace>(case: &Case<S>, solved: &Solved<S>) -> Map<String, Value> {
    let mut run_info = Map::new();
    run_info.insert(CASE_HASH.into(), case.hash().into());
    run_info.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    run_info.insert("case_file".into(), case.file_name().into());
    if let Some(solution) = solved.answer.certified() {
        run_info.insert("clarabel_calls".into(), solution.nndd.clarabel_calls.into());
    }
    if solved.status.word == "limit"
        && let Some((step, seconds)) = solved.longest_step
    {
        // This step kept the run from ending at its time limit.
        run_info.insert("longest_step".into(), json!({ "step": step, "seconds": seconds }));
    }
    if case.adapt.is_some() {
        run_info.insert("adaptive_seconds".into(), solved.step_seconds.clone().into());
    }
    run_info
}

/// Writes tables, pictures, ParaView files and the page; everything but report.json.
fn write_files<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    report: &Report,
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    let mut put = |name: &str, text: &str| directory.write(name, text.as_bytes());
    put("history.csv", &table::history_csv(&report.iterations)?)?;
    let solution = &solved.answer.fields();
    let pairs = case.contacts.iter().enumerate();
    let contact: Vec<(&str, Vec<ContactRow>)> =
        pairs.map(|(k, pair)| (pair.name.as_str(), contact_rows(solution, k))).collect();
    let in_steps = solved.steps.iter().flat_map(|step| {
        let names = case.contacts.iter().map(|pair| pair.name.as_str());
        names.zip(step.rows.iter().cloned())
    });
    let in_steps: Vec<(&str, Vec<ContactRow>)> = in_steps.collect();
    if !in_steps.is_empty() {
        put("contact.csv", &table::contact_csv(&in_steps)?)?;
    } else if solution.estimate.is_some() && !contact.is_empty() {
        put("contact.csv", &table::contact_csv(&contact)?)?;
    }
    if !report.adaptive.is_empty() {
        put("adaptive.csv", &table::adaptive_csv(&report.adaptive)?)?;
    }
    let paths = paths::all(case, solution);
    for (path, rows) in case.paths.iter().zip(&paths) {
        put(&paths::file(path), &table::path_csv(rows)?)?;
    }
    // The figures need no file, the fields need no figure.
    let (pictures, fields) = rayon::join(
        || view::drawn(case, solved, report, &contact, &paths),
        || write_fields(case, solved, report, directory),
    );
    fields?;
    let mut put = |name: &str, text: &str| directory.write(name, text.as_bytes());
    for picture in &pictures {
        put(&format!("figures/{}.svg", picture.name), &picture.svg)?;
    }
    put("report.html", &html::page(case, solution.problem, report, &pictures))?;
    Ok(())
}

/// Writes the files for ParaView, if the case asks for them.
fn write_fields<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    report: &Report,
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    if !case.output.vtu {
        return Ok(());
    }
    let solution = &solved.answer.fields();
    // With load steps their fields are those of the last mesh.
    let meshes = report.adaptive.iter().filter(|_| solution.estimate.is_some() && solved.steps.is_empty());
    let adaptive = meshes.map(|row| row.step).collect::<Vec<_>>();
    let steps = solved.steps.iter().filter(|step| step.has_fields);
    let steps = steps.map(|step| step.summary.step).collect::<Vec<_>>();
    paraview::write(case, solution, &[("adaptive.pvd", adaptive), ("steps.pvd", steps)], directory)
}
