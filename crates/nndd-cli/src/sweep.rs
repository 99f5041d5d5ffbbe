//! `nndd sweep`: a case for several values of one setting, a few iterations each.

use crate::args::Sweep as Options;
use crate::console;
use crate::failure::Failure;
use crate::outcome;
use crate::plot::{self, SweepSeries};
use crate::report;
use crate::run::{self, Follower};
use crate::signals::Signals;
use crate::stopwatch::Stopwatch;
use crate::words::counted;
use case_io::Case;
use case_io::case_file::{Sweep, split_override};
use case_io::output::{OutputDirectory, Presence, ResultKind};
use case_io::report::{CASE_HASH, IterationRow, SWEEP_SCHEMA, SweepPanel, SweepReport, SweepRow};
use case_io::table;
use serde_json::Map;
use std::path::PathBuf;

/// The key that a sweep sets itself.
const MAX_ITERATIONS: &str = "solver.max_iterations";

pub(crate) fn command(options: &Options) -> Result<u8, Failure> {
    let sweep = Sweep::parse(&options.over).map_err(|e| Failure::from(e).on_command_line())?;
    let base = run::overrides(&options.case.set)?;
    let mut variants = vec![Vec::new()];
    for panel in &options.panel {
        let settings = panel.split(';').map(str::trim).filter(|s| !s.is_empty());
        variants.push(settings.map(split_override).collect::<Result<Vec<_>, _>>()?);
    }
    let signals = Signals::listen()?;
    let (bytes, case) = run::read_case(&options.case, &base)?;
    for variant in &variants {
        check_values(options, &sweep, &bytes, &[base.as_slice(), variant.as_slice()].concat())
            .map_err(|failure| of_panel(failure, variant))?;
    }
    let path = options.run.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory() + "-sweep"));
    // Each sweep has its own mark, so that its directory differs from that of a solve.
    let mark = format!("sweep {} {} {:?} {}", options.over, options.iterations, options.panel, case.hash());
    let mut directory = OutputDirectory::open(&path, ResultKind::Sweep, &mark, options.run.force)
        .map_err(|e| Failure::output(&e))?;
    let mut panels: Vec<SweepPanel> = Vec::new();
    let mut failure = None;
    for variant in &variants {
        let run = (&signals, directory.presence());
        let (panel, failed) = run_panel(options, &sweep, [&base, variant], &panels, run);
        panels.push(panel);
        failure = failed.map(|failed| of_panel(failed, variant));
        if failure.is_some() || signals.status().is_some() {
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
    run.insert("case_file".into(), case.file_name().into());
    run.insert("overrides".into(), options.case.set.clone().into());
    run.insert("interrupted".into(), signals.status().is_some().into());
    let record = SweepReport {
        schema: SWEEP_SCHEMA,
        case: case.settings_json(),
        key: sweep.key.clone(),
        iterations: options.iterations,
        panels,
        run,
    };
    write(&record, &sweep, &mut directory)?;
    let written: Vec<String> = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish().map_err(|e| Failure::output(&e))?;
    if !options.run.quiet {
        for panel in &record.panels {
            console::print(&best(&sweep.key, panel))?;
        }
        let runs = || record.panels.iter().flat_map(|panel| &panel.rows);
        if !has_value(&record) && failure.is_none() && signals.status().is_none() {
            let word = runs().map(|row| row.status.as_str()).next().unwrap_or("stalled");
            console::print(&format!(
                "{word}: no run of this sweep has an eta_nndd; try other values of {}\n",
                sweep.key
            ))?;
        }
        if signals.status().is_some() {
            let done: usize = record.panels.iter().map(|panel| panel.rows.len()).sum();
            let all = variants.len() * sweep.values.len();
            console::print(&format!("interrupted: by a signal after {done} of {all} runs\n"))?;
        }
        console::print(&format!("wrote {}: {}\n", path.display(), written.join(" ")))?;
    }
    match failure {
        Some(failure) => Err(failure),
        None => Ok(signals.status().unwrap_or(if has_value(&record) { 0 } else { outcome::NOT_CONVERGED })),
    }
}

/// Lists the settings of one run.
fn settings_of_run(
    options: &Options,
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
    options: &Options,
    sweep: &Sweep,
    bytes: &[u8],
    overrides: &[(String, String)],
) -> Result<(), Failure> {
    let file = options.case.case.to_string_lossy();
    for value in &sweep.values {
        let all = settings_of_run(options, sweep, overrides, value);
        if let Err(error) = Case::parse_bytes(bytes, &file, &all) {
            let mut failure = Failure::from(error);
            failure.diagnostics.iter_mut().for_each(|d| d.given_by("--over", &sweep.key, value));
            return Err(failure);
        }
    }
    Ok(())
}

/// Says whether any run has a number to compare by.
fn has_value(record: &SweepReport) -> bool {
    record.panels.iter().flat_map(|panel| &panel.rows).any(|row| row.iteration.eta_nndd.is_some())
}

/// Calls the settings of a panel by the option that they came with.
fn of_panel(mut failure: Failure, settings: &[(String, String)]) -> Failure {
    for (key, value) in settings {
        failure.diagnostics.iter_mut().for_each(|d| d.given_by("--panel", key, value));
    }
    failure
}

/// Writes the tables and the picture, and sweep.json last: it makes the result complete.
fn write(record: &SweepReport, sweep: &Sweep, directory: &mut OutputDirectory) -> Result<(), Failure> {
    let mut put =
        |name: &str, text: &str| directory.write(name, text.as_bytes()).map_err(|e| Failure::output(&e));
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
    let series: Vec<SweepSeries> = record.panels.iter().map(|panel| series(panel, &numbers)).collect();
    put("figures/sweep.svg", &plot::sweep(&title, &sweep.key, &series)?)?;
    put(ResultKind::Sweep.record(), &record.to_json()?)
}

/// Runs one panel; a signal or a value that cannot be run ends it with the rows there are.
///
/// * `settings`: of the command line, and of the panel itself.
/// * `before`: the panels before it.
fn run_panel(
    options: &Options,
    sweep: &Sweep,
    settings: [&[(String, String)]; 2],
    before: &[SweepPanel],
    run: (&Signals, Presence),
) -> (SweepPanel, Option<Failure>) {
    let written = |settings: &[(String, String)]| -> Vec<String> {
        settings.iter().map(|(key, value)| format!("{key}={value}")).collect()
    };
    let mut panel = SweepPanel { settings: written(&settings.concat()), ..SweepPanel::default() };
    let own = written(settings[1]).join("; ");
    let failure = fill_panel(&mut panel, options, sweep, &settings.concat(), (before, &own), run).err();
    (panel, failure)
}

/// Adds the rows of a panel one by one.
///
/// * `naming`: the panels before it, and its own settings, which tell it from those of its size.
fn fill_panel(
    panel: &mut SweepPanel,
    options: &Options,
    sweep: &Sweep,
    overrides: &[(String, String)],
    naming: (&[SweepPanel], &str),
    (signals, output): (&Signals, Presence),
) -> Result<(), Failure> {
    let width = sweep.values.iter().chain([&sweep.key]).map(|text| text.chars().count()).max().unwrap_or(0);
    let width = width.clamp(12, 40);
    for (k, value) in sweep.values.iter().enumerate() {
        let all = settings_of_run(options, sweep, overrides, value);
        let read = run::read_case(&options.case, &all).and_then(|(_, mut case)| {
            let problem = if case.adapt.is_none() { Some(run::build(&mut case)?) } else { None };
            Ok((case, problem))
        });
        let (case, problem) = read.map_err(|mut failure| {
            failure.diagnostics.iter_mut().for_each(|d| d.given_by("--over", &sweep.key, value));
            failure
        })?;
        let Some(problem) = problem else {
            return Err(Failure::command_line(
                "a sweep compares runs on one mesh, and this case has [adapt]; leave that table out",
            ));
        };
        if k == 0 {
            panel.nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
            let (before, own) = naming;
            panel.name = format!("{} nodes", panel.nodes);
            if before.iter().any(|other| other.nodes == panel.nodes) {
                panel.name += &format!(" ({own})");
            }
            if !options.run.quiet {
                let head = &console::Layout::default().head()[1..];
                console::print(&format!("\n{}\n{:>width$} {head}", panel.name, sweep.key))?;
            }
        }
        let mut watch = Stopwatch::start();
        let follower = Follower::new(&case, &mut watch, signals, output.clone(), false);
        let solved = run::solve(&case, problem, follower, &mut |_| ())?;
        if signals.status().is_some() {
            break;
        }
        let row = solved.solution.rows.last();
        if let Some(row) = row.filter(|_| !options.run.quiet) {
            console::print(&format!("{value:>width$} {}", console::Layout::default().row(row, 0.0)))?;
        }
        if options.run.verbose {
            console::print(&console::choices(&case, &solved))?;
        }
        let iteration = row.map_or_else(IterationRow::default, report::iteration_row);
        panel.rows.push(SweepRow { value: value.clone(), status: solved.status.word, iteration });
    }
    Ok(())
}

fn series(panel: &SweepPanel, numbers: &[f64]) -> SweepSeries {
    let column = |of: fn(&IterationRow) -> Option<f64>| {
        let value = |row: &SweepRow| of(&row.iteration).filter(|_| row.status != "diverged");
        panel.rows.iter().map(value).collect()
    };
    SweepSeries {
        name: panel.name.clone(),
        // An interrupted sweep has no row for the last ones.
        theta: numbers.iter().copied().take(panel.rows.len()).collect(),
        eta_nndd: column(|it| it.eta_nndd),
        eta_dis: column(|it| it.eta_dis),
        e_cre: column(|it| it.e_cre),
    }
}

/// Says where the iteration's error is smallest.
fn best(key: &str, panel: &SweepPanel) -> String {
    let known = panel.rows.iter().filter_map(|row| Some((row.iteration.eta_nndd?, &row.value)));
    match known.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((eta, value)) => format!("{}: smallest eta_nndd {eta:.3e} at {key} = {value}\n", panel.name),
        None => format!("{}: no value\n", panel.name),
    }
}
