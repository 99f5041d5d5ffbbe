//! Sweeps: a case for several values of one setting, a few iterations each.

use crate::convert;
use crate::failure::Failure;
use crate::host::{Event, Host};
use crate::once;
use crate::plot;
use crate::report;
use crate::run::{self, Built, CaseFile, Source};
use crate::solved::Solved;
use crate::space::ReportSpace;
use crate::stopwatch::Stopwatch;
use crate::verdict::{self, is_round_off};
use crate::words::counted;
use case_io::Case;
use case_io::case::AnyCase;
use case_io::case_file::{Sweep, split_override};
use case_io::output::{OutputDirectory, Presence, ResultKind};
use case_io::report::{CASE_HASH, IterationRow, SWEEP_SCHEMA, SweepPanel, SweepReport, SweepRow};
use case_io::table;
use certified_contact::IterationRecord;
use fem_core::space::Space;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// The key that a sweep sets itself.
const MAX_ITERATIONS: &str = "solver.max_iterations";

/// The setting that is varied, its values, and the directory of the result.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SweepOptions {
    /// The case file.
    pub case: PathBuf,
    /// Settings of all runs, `KEY=VALUE`.
    pub set: Vec<String>,
    /// The setting and its values: `KEY=a:b:h` or `KEY=[v1, v2]`.
    pub over: String,
    /// Iterations of each run, at least 1.
    pub iterations: usize,
    /// Further panels with other settings, each `KEY=VALUE; KEY=VALUE`.
    pub panel: Vec<String>,
    /// The directory to write to, instead of the case's output directory with `-sweep` behind it.
    pub out: Option<PathBuf>,
    /// Set if the result is written even to a directory that contains something else.
    pub force: bool,
}

/// Iterations of each run, unless other options say so.
const ITERATIONS: usize = 3;

impl SweepOptions {
    /// A sweep of a case over `KEY=a:b:h` or `KEY=[v1, v2]`, three iterations each.
    pub fn new(case: &Path, over: &str) -> Self {
        Self { case: case.to_owned(), over: over.to_owned(), iterations: ITERATIONS, ..Self::default() }
    }
}

/// The result of a sweep, and the files that it wrote.
#[non_exhaustive]
pub struct Swept {
    /// The contents of sweep.json.
    pub record: SweepReport,
    /// The directory.
    pub path: PathBuf,
    /// The files, below the directory.
    pub files: Vec<String>,
    /// The number of runs that were asked for.
    pub asked: usize,
    /// Why the sweep ended before its last run, if not by request.
    pub failure: Option<Failure>,
}

impl Swept {
    /// Says whether any run has a number to compare by.
    pub fn has_value(&self) -> bool {
        self.rows().any(|row| row.iteration.eta_nndd.is_some())
    }

    /// Says whether the certificate of any run is valid.
    pub fn has_valid(&self) -> bool {
        self.rows().any(|row| row.valid)
    }

    /// Lists the runs of all panels.
    pub fn rows(&self) -> impl Iterator<Item = &SweepRow> {
        self.record.panels.iter().flat_map(|panel| &panel.rows)
    }
}

/// Runs a sweep and writes what it found. A request to end it, or a value that cannot be run, leaves the runs there are.
///
/// # Errors
/// Options, settings and values that make no sense, a first run that fails, and files that cannot be written.
pub fn sweep(options: &SweepOptions, host: &mut dyn Host) -> Result<Swept, Failure> {
    sweep_of(&CaseFile::open(&options.case)?, options, host)
}

/// Runs a sweep as [`sweep`] does, of a case from anywhere.
///
/// * `source`: the case, instead of the file of the options.
///
/// # Errors
/// See [`sweep`].
pub fn sweep_of(source: &dyn Source, options: &SweepOptions, host: &mut dyn Host) -> Result<Swept, Failure> {
    let sweep = Sweep::parse(&options.over).map_err(|e| Failure::from(e).on_command_line())?;
    let base = run::overrides(&options.set)?;
    let mut variants = vec![Vec::new()];
    for panel in &options.panel {
        let settings = panel.split(';').map(str::trim).filter(|s| !s.is_empty());
        variants.push(settings.map(split_override).collect::<Result<Vec<_>, _>>()?);
    }
    let (case, volumes) = match source.read(&base)? {
        AnyCase::Plane(case) => (About::of(&case), false),
        AnyCase::Solid(case) => (About::of(&case), true),
    };
    for variant in &variants {
        check_values(options, &sweep, (source, volumes), &[base.as_slice(), variant.as_slice()].concat())
            .map_err(|failure| of_panel(failure, variant))?;
    }
    let path = options.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory + "-sweep"));
    // Each sweep has its own mark, so that its directory is not taken for the directory of a solve.
    let mark = format!("sweep {} {} {:?} {}", options.over, options.iterations, options.panel, case.hash);
    let mut directory = OutputDirectory::open(&path, ResultKind::Sweep, &mark, options.force)?;
    let mut panels: Vec<SweepPanel> = Vec::new();
    let mut failure = None;
    for variant in &variants {
        let mut panel =
            SweepPanel { settings: written(&[&base[..], variant].concat()), ..SweepPanel::default() };
        let output = directory.presence();
        let of = (options, source, &sweep);
        let filled = fill_panel(&mut panel, of, [&base, variant], &panels, &output, host);
        panels.push(panel);
        failure = filled.err().map(|failed| of_panel(failed, variant));
        if failure.is_some() || host.interrupted().is_some() {
            break;
        }
    }
    if panels.iter().all(|panel| panel.rows.is_empty())
        && let Some(failure) = failure
    {
        return Err(failure);
    }
    let mut run = Map::new();
    run.insert(CASE_HASH.into(), mark.into());
    run.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    run.insert("case_file".into(), case.file_name.into());
    run.insert("overrides".into(), options.set.clone().into());
    run.insert("interrupted".into(), host.interrupted().is_some().into());
    let record = SweepReport {
        schema: SWEEP_SCHEMA,
        case: case.settings,
        key: sweep.key.clone(),
        iterations: options.iterations,
        panels,
        run,
    };
    write(&record, &sweep, &mut directory)?;
    let files = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish()?;
    Ok(Swept { record, path, files, asked: variants.len() * sweep.values.len(), failure })
}

/// What the record of a sweep says of its case.
struct About {
    file_name: String,
    output_directory: String,
    hash: String,
    settings: Value,
}

impl About {
    fn of<S: ReportSpace>(case: &Case<S>) -> Self {
        Self {
            file_name: case.file_name().to_owned(),
            output_directory: case.output_directory(),
            hash: case.hash(),
            settings: case.settings_json(),
        }
    }
}

/// Lists the settings of one run.
fn settings_of_run(
    options: &SweepOptions,
    sweep: &Sweep,
    overrides: &[(String, String)],
    value: &str,
) -> Vec<(String, String)> {
    let mut all = overrides.to_vec();
    all.push((MAX_ITERATIONS.into(), options.iterations.to_string()));
    all.push(("solver.stop.criterion".into(), "iterations".into()));
    // Last, so that these two can be swept as well.
    all.push((sweep.key.clone(), value.to_owned()));
    all
}

/// Refuses values that the case file cannot have, before the first of them is run.
fn check_values(
    options: &SweepOptions,
    sweep: &Sweep,
    (source, volumes): (&dyn Source, bool),
    overrides: &[(String, String)],
) -> Result<(), Failure> {
    for value in &sweep.values {
        let all = settings_of_run(options, sweep, overrides, value);
        source.parse(&all, volumes).map_err(|failure| failure.given_by("--over", &sweep.key, value))?;
    }
    Ok(())
}

/// Calls the settings of a panel by the option that they came with.
fn of_panel(failure: Failure, settings: &[(String, String)]) -> Failure {
    settings.iter().fold(failure, |failure, (key, value)| failure.given_by("--panel", key, value))
}

/// Writes the tables and the picture, and sweep.json last: it makes the result complete.
fn write(record: &SweepReport, sweep: &Sweep, directory: &mut OutputDirectory) -> Result<(), Failure> {
    let mut put = |name: &str, text: &str| directory.write(name, text.as_bytes());
    for (k, panel) in record.panels.iter().enumerate() {
        let name = if k == 0 { "sweep.csv".to_string() } else { format!("sweep-{}.csv", k + 1) };
        put(&name, &table::sweep_csv(&record.key, panel)?)?;
    }
    let title = match (sweep.key == MAX_ITERATIONS, record.iterations) {
        (true, _) => "Indicators at the last iteration".to_owned(),
        (_, n) => format!("Indicators after {}", counted(n, "iteration")),
    };
    let numbers: Vec<f64> = match sweep.numbers().into_iter().collect::<Option<Vec<f64>>>() {
        Some(numbers) => numbers,
        None => (1..=sweep.values.len()).map(|k| k as f64).collect(),
    };
    put("figures/sweep.svg", &plot::sweep(&title, &sweep.key, &numbers, &record.panels))?;
    Ok(put(ResultKind::Sweep.record(), &record.to_json()?)?)
}

/// Writes settings as `KEY=VALUE`.
fn written(settings: &[(String, String)]) -> Vec<String> {
    settings.iter().map(|(key, value)| format!("{key}={value}")).collect()
}

/// Adds the rows of a panel one by one; a request to end or a value that cannot be run ends it with the rows there are.
///
/// * `settings`: of all panels, then of this panel alone; the name has these if an earlier panel has as many nodes.
/// * `before`: the panels before it.
/// * `output`: the directory that must stay until the end.
fn fill_panel(
    panel: &mut SweepPanel,
    (options, source, sweep): (&SweepOptions, &dyn Source, &Sweep),
    settings: [&[(String, String)]; 2],
    before: &[SweepPanel],
    output: &Presence,
    host: &mut dyn Host,
) -> Result<(), Failure> {
    for value in &sweep.values {
        let all = settings_of_run(options, sweep, &settings.concat(), value);
        let around = (options, sweep, value.as_str());
        let names = (settings[1], before);
        let given = |failure: Failure| failure.given_by("--over", &sweep.key, value);
        let goes_on = match source.read(&all).map_err(given)? {
            AnyCase::Plane(case) => add_row(panel, &case, around, names, output, host)?,
            AnyCase::Solid(case) => add_row(panel, &case, around, names, output, host)?,
        };
        if !goes_on {
            break;
        }
    }
    Ok(())
}

/// Adds the row of one value; `false` if the sweep is to end.
///
/// * `settings`: of this panel alone; `before`: the panels before it.
fn add_row<S: ReportSpace>(
    panel: &mut SweepPanel,
    case: &Case<S>,
    (options, sweep, value): (&SweepOptions, &Sweep, &str),
    (settings, before): (&[(String, String)], &[SweepPanel]),
    output: &Presence,
    host: &mut dyn Host,
) -> Result<bool, Failure> {
    if case.adapt.is_some() {
        return Err(Failure::command_line(
            "a sweep compares runs on one mesh, and this case has [adapt]; leave that table out",
        ));
    }
    let built = run::build_last(case, host);
    let Built { problem, plan, .. } =
        built.map_err(|failure| failure.given_by("--over", &sweep.key, value))?;
    case.refuse_coulomb(
        "a sweep compares eta_nndd and e_cre, which do not exist with Coulomb friction",
        "run the values one by one with `nndd solve --set`",
    )?;
    if convert::is_exact(case, &problem)
        && case.iteration_settings().iter().any(|key| sweep.key == format!("solver.{key}"))
    {
        return Err(Failure::invalid(format!(
            "`--over {}`: this case is solved exactly, without an iteration, so that `{}` has no effect\n  expected: a setting \
             that the exact solution uses\n  fix: ask for the iteration with --set solver.method=nndd",
            options.over, sweep.key
        )));
    }
    if panel.rows.is_empty() {
        panel.nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
        panel.name = format!("{} nodes", panel.nodes);
        if before.iter().any(|other| other.nodes == panel.nodes) {
            panel.name += &format!(" ({})", written(settings).join("; "));
        }
        host.event(Event::Panel { name: &panel.name, sweep })?;
    }
    let mut watch = Stopwatch::start(host.elapsed());
    let solved = once::solve((case, &plan), problem, output.clone(), (&mut watch, host))?;
    if host.interrupted().is_some() {
        return Ok(false);
    }
    let row = last_row(&solved);
    let choices = verdict::choices(case, &solved);
    host.event(Event::Value { value, row: row.as_ref(), status: &solved.status, choices: &choices })?;
    let certified = solved.answer.certified().filter(|solution| solution.is_certified());
    let estimate = certified.and_then(|solution| solution.estimate.as_ref());
    panel.rows.push(SweepRow {
        value: value.to_owned(),
        valid: certified.is_some(),
        iteration: row.as_ref().map_or_else(IterationRow::default, report::iteration_row),
        round_off: estimate.map(|estimate| estimate.unchecked().parts.round_off),
        status: solved.status.word,
    });
    Ok(true)
}

/// Returns the last iteration of a run, without the bounds unless its certificate is valid.
fn last_row<S: Space>(solved: &Solved<S>) -> Option<IterationRecord> {
    let solution = solved.answer.certified()?;
    let mut row = *solution.rows.last()?;
    if !solution.is_certified() {
        (row.eta_dis, row.e_cre) = (None, None);
    }
    Some(row)
}

/// Says for which valid run the iteration's error is smallest, how many are not valid, and of how many the bound is round-off.
pub fn best(key: &str, panel: &SweepPanel) -> String {
    let valid = panel.rows.iter().filter(|row| row.valid);
    let known = valid.clone().filter_map(|row| Some((row.iteration.eta_nndd?, &row.value)));
    let failed = panel.rows.len() - valid.count();
    let lost = if failed > 0 {
        format!("; the certificate of {failed} of {} runs is not valid", panel.rows.len())
    } else {
        String::new()
    };
    let is_noise = |row: &&SweepRow| {
        row.iteration
            .e_cre
            .zip(row.round_off)
            .is_some_and(|(bound, allowance)| is_round_off(allowance, bound))
    };
    let noise = panel.rows.iter().filter(is_noise).count();
    let lost = match noise {
        0 => lost,
        _ => format!("{lost}; the bound of {noise} of {} runs is round-off", panel.rows.len()),
    };
    match known.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((eta, value)) => {
            format!("{}: smallest eta_nndd {eta:.3e} at {key} = {value}{lost}\n", panel.name)
        }
        None => format!("{}: no value{lost}\n", panel.name),
    }
}
