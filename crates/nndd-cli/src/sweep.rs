//! `nndd sweep`: a case for several values of one setting, a few iterations each.

use crate::args::Sweep as Options;
use crate::console;
use crate::failure::Failure;
use crate::files;
use crate::plot::{self, SweepSeries};
use crate::run::{self, Follower};
use crate::signals::Signals;
use crate::stopwatch::Stopwatch;
use case_io::case_file::{Sweep, split_override};
use case_io::output::{OutputDirectory, ResultKind};
use case_io::report::{CASE_HASH, IterationRow, SWEEP_SCHEMA, SweepPanel, SweepReport, SweepRow};
use case_io::table;
use serde_json::Map;
use std::path::PathBuf;

/// The key that a sweep sets itself.
const MAX_ITERATIONS: &str = "solver.max_iterations";

pub(crate) fn command(options: &Options) -> Result<u8, Failure> {
    let sweep = Sweep::parse(&options.over)?;
    let base = run::overrides(&options.case.set)?;
    let mut variants = vec![Vec::new()];
    for panel in &options.panel {
        let settings = panel.split(';').map(str::trim).filter(|s| !s.is_empty());
        variants.push(settings.map(split_override).collect::<Result<Vec<_>, _>>()?);
    }
    run::start_threads(&options.run)?;
    let signals = Signals::listen()?;
    let (_, case) = run::read_case(&options.case, &base)?;
    let path = options.run.out.clone().unwrap_or_else(|| PathBuf::from(case.output_directory() + "-sweep"));
    // Each sweep has its own mark, so that its directory can be told from that of a solve.
    let mark = format!("sweep {} {} {:?} {}", options.over, options.iterations, options.panel, case.hash());
    let mut directory = OutputDirectory::open(&path, ResultKind::Sweep, &mark, options.run.force)
        .map_err(|e| Failure::output(&e))?;
    let mut panels = Vec::new();
    for variant in &variants {
        let mut overrides = base.clone();
        overrides.extend(variant.iter().cloned());
        match run_panel(options, &sweep, &overrides, &signals)? {
            Ok(panel) => panels.push(panel),
            Err(signal) => return Ok(signal),
        }
    }
    for (k, panel) in panels.iter().enumerate() {
        let name = if k == 0 { "sweep.csv".to_string() } else { format!("sweep-{}.csv", k + 1) };
        let text = table::sweep_csv(&sweep.key, &panel.rows)?;
        directory.write(&name, text.as_bytes()).map_err(|e| Failure::output(&e))?;
    }
    let title = match (sweep.key == MAX_ITERATIONS, options.iterations) {
        (true, _) => "Indicators at the last iteration".to_owned(),
        (_, 0 | 1) => "Indicators after 1 iteration".to_owned(),
        (_, n) => format!("Indicators after {n} iterations"),
    };
    let numbers: Vec<f64> = match sweep.numbers().into_iter().collect::<Option<Vec<f64>>>() {
        Some(numbers) => numbers,
        None => (1..=sweep.values.len()).map(|k| k as f64).collect(),
    };
    let series: Vec<SweepSeries> = panels.iter().map(|panel| series(panel, &numbers)).collect();
    let figure = plot::sweep(&title, &sweep.key, &series)?;
    directory.write("figures/sweep.svg", figure.as_bytes()).map_err(|e| Failure::output(&e))?;
    let mut run = Map::new();
    run.insert(CASE_HASH.into(), mark.into());
    run.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    run.insert("case_file".into(), case.file_name().into());
    run.insert("overrides".into(), options.case.set.clone().into());
    let record = SweepReport {
        schema: SWEEP_SCHEMA,
        case: case.settings_json(),
        key: sweep.key.clone(),
        iterations: options.iterations,
        panels,
        run,
    };
    let panels = &record.panels;
    let text = record.to_json()?;
    directory.write(ResultKind::Sweep.record(), text.as_bytes()).map_err(|e| Failure::output(&e))?;
    let written: Vec<String> = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish().map_err(|e| Failure::output(&e))?;
    if !options.run.quiet {
        for panel in panels {
            console::print(&best(&sweep.key, panel))?;
        }
        console::print(&format!("wrote {}: {}\n", path.display(), written.join(" ")))?;
    }
    Ok(0)
}

/// Runs one panel; `Err` is the exit status of a signal.
fn run_panel(
    options: &Options,
    sweep: &Sweep,
    overrides: &[(String, String)],
    signals: &Signals,
) -> Result<Result<SweepPanel, u8>, Failure> {
    let mut panel = SweepPanel {
        settings: overrides.iter().map(|(key, value)| format!("{key}={value}")).collect(),
        ..SweepPanel::default()
    };
    for (k, value) in sweep.values.iter().enumerate() {
        let mut all = overrides.to_vec();
        all.push((MAX_ITERATIONS.into(), options.iterations.to_string()));
        all.push(("solver.stop.criterion".into(), "iterations".into()));
        // Last, so that these two can be swept as well.
        all.push((sweep.key.clone(), value.clone()));
        let (_, mut case) = run::read_case(&options.case, &all)?;
        if case.adapt.is_some() {
            return Err(Failure::command_line(
                "a sweep compares runs on one mesh, and this case has [adapt]; leave that table out",
            ));
        }
        let problem = run::build(&mut case)?;
        if k == 0 {
            panel.nodes = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
            if !options.run.quiet {
                console::print(&format!(
                    "\n{}\n{:>12} {}",
                    name(&panel),
                    sweep.key,
                    &console::Layout::default().head()[1..]
                ))?;
            }
        }
        let mut watch = Stopwatch::start();
        let follower = Follower::new(&case, &mut watch, signals, false);
        let solved = run::solve(&case, problem, follower, &mut |_| ())?;
        if let Some(code) = signals.status() {
            return Ok(Err(code));
        }
        let row = solved.solution.rows.last();
        if let Some(row) = row.filter(|_| !options.run.quiet) {
            console::print(&format!("{value:>12} {}", console::Layout::default().row(row, 0.0)))?;
        }
        let iteration = row.map_or_else(IterationRow::default, files::iteration_row);
        panel.rows.push(SweepRow { value: value.clone(), status: solved.status.word, iteration });
    }
    Ok(Ok(panel))
}

fn name(panel: &SweepPanel) -> String {
    format!("{} nodes", panel.nodes)
}

fn series(panel: &SweepPanel, numbers: &[f64]) -> SweepSeries {
    let column = |of: fn(&IterationRow) -> Option<f64>| {
        let value = |row: &SweepRow| of(&row.iteration).filter(|_| row.status != "diverged");
        panel.rows.iter().map(value).collect()
    };
    SweepSeries {
        name: name(panel),
        theta: numbers.to_vec(),
        eta_nndd: column(|it| it.eta_nndd),
        eta_dis: column(|it| it.eta_dis),
        e_cre: column(|it| it.e_cre),
    }
}

/// Says where the iteration's error is smallest.
fn best(key: &str, panel: &SweepPanel) -> String {
    let known = panel.rows.iter().filter_map(|row| Some((row.iteration.eta_nndd?, &row.value)));
    match known.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((eta, value)) => format!("{}: smallest eta_nndd {eta:.3e} at {key} = {value}\n", name(panel)),
        None => format!("{}: no value\n", name(panel)),
    }
}
