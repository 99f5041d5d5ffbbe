//! The page and the table of a run with peers.

use super::super::criterion::Estimate;
use super::super::machine::{Machine, provenance};
use super::super::numbers::{quoted, spread_of};
use super::environment::program;
use super::targets::{self, paired, ratio};
use super::{AGREEMENT, OnMesh, SLOW, THREADS};
use crate::python::Environment;
use crate::workspace::{Outcome, Workspace};
use std::fmt::Write as _;
use std::process::Command;

/// The page's text on the measured quantities and how they are measured.
const HOW: &str = include_str!("how.md");

/// The page's text on all that the numbers do not show.
const NOT_MEASURED: &str = include_str!("not_measured.md");

/// Spreads up to this many per cent are not named one by one.
const QUIET: f64 = 10.0;

/// The results of a run with peers.
pub(super) struct Measured<'a> {
    pub(super) command: String,
    pub(super) runs: usize,
    pub(super) meshes: &'a [OnMesh],
    pub(super) iteration: Option<&'a Estimate>,
    pub(super) skipped: &'a [String],
}

/// The page that says what was compared and what came of it.
pub(super) fn page(
    workspace: &Workspace,
    environment: &Environment,
    machine: &Machine,
    measured: &Measured<'_>,
) -> Outcome<String> {
    let Measured { command, runs, meshes, iteration, skipped } = measured;
    let rows = [
        ("threads", format!("{THREADS} for every program")),
        ("Python", environment.versions()),
        ("CalculiX", calculix_version()),
        ("BLAS of CHOLMOD", blas(meshes)),
    ];
    let mut text =
        format!("# This program and its peers, {} on {}\n\n", super::super::today(), machine.slug());
    text.push_str(&provenance(workspace, machine, command, &rows)?);
    let _ = write!(text, "\n## Targets\n\n{}", targets::table(meshes, *iteration));
    let _ = write!(text, "\n## Times and memory\n\n{}", times(meshes));
    let _ = write!(text, "\n## Ratios\n\n{}", ratios(meshes));
    let _ = write!(text, "\n## Agreement\n\n{}", agreement(meshes));
    text.push_str("\n## Skipped\n\n");
    for line in skipped.iter() {
        let _ = writeln!(text, "- {}", line.replace('\n', " "));
    }
    if skipped.is_empty() {
        text.push_str("Nothing, but for sizes beyond what a peer is asked for: the tables name what ran.\n");
    }
    let _ = write!(text, "\n## How\n\n{HOW}");
    let _ = writeln!(
        text,
        "- {runs} runs each after one that is thrown away; a peer whose first run took more than {SLOW} s has that run \
         only. The tables give the number."
    );
    let _ = write!(text, "\n## Noise\n\n{}", noise(meshes));
    let _ = write!(text, "\n## Not measured\n\n{NOT_MEASURED}\nRaw numbers: `peers.csv`.\n");
    Ok(text)
}

fn calculix_version() -> String {
    let Some(ccx) = program("ccx") else { return "not there".to_owned() };
    // It leaves with a status of its own here.
    let said = Command::new(ccx).arg("-v").output().map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
    said.unwrap_or_default().trim().to_owned()
}

fn blas(meshes: &[OnMesh]) -> String {
    let series = meshes.iter().flat_map(|m| &m.series).filter(|s| s.peer.name.contains("CHOLMOD"));
    let mut named: Vec<String> = series
        .filter_map(|s| Some((s.peer.name, s.answers.first()?.details["blas"].as_str()?)))
        .map(|(name, library)| format!("{name}: {library}"))
        .collect();
    named.sort();
    named.dedup();
    if named.is_empty() { "unknown".to_owned() } else { named.join("; ") }
}

/// A row of the table of times, as text and as numbers.
struct TableRow {
    mesh: String,
    unknowns: f64,
    program: String,
    seconds: Vec<f64>,
    whole: Vec<f64>,
    memory: Vec<f64>,
    own: Option<f64>,
}

fn rows(meshes: &[OnMesh]) -> Vec<TableRow> {
    let mut rows = vec![];
    for m in meshes {
        let mesh = format!("{}x{}", m.cells[0], m.cells[1]);
        let whole: Vec<f64> = m.own.iter().map(|o| o.whole).collect();
        let memory: Vec<f64> = m.own.iter().filter_map(|o| o.memory).collect();
        for (program, seconds) in [
            ("this program, solve to 1e-8", m.own.iter().map(|o| o.converged).collect()),
            ("this program, solve", m.own.iter().map(|o| o.solve).collect()),
            ("this program, with certificate", m.own.iter().map(|o| o.certified).collect()),
        ] {
            rows.push(TableRow {
                mesh: mesh.clone(),
                unknowns: m.unknowns,
                program: program.to_owned(),
                seconds,
                // Process time and memory belong to the run by the default criterion.
                whole: if program.ends_with("1e-8") { vec![] } else { whole.clone() },
                memory: if program.ends_with("1e-8") { vec![] } else { memory.clone() },
                own: None,
            });
        }
        rows.extend(m.series.iter().map(|s| TableRow {
            mesh: mesh.clone(),
            unknowns: m.unknowns,
            program: s.peer.name.to_owned(),
            seconds: s.answers.iter().map(|a| a.seconds).collect(),
            whole: s.answers.iter().map(|a| a.whole).collect(),
            memory: s.answers.iter().filter_map(|a| a.memory).collect(),
            own: s.answers.first().and_then(|a| a.details["own_bytes"].as_f64()),
        }));
    }
    rows
}

fn times(meshes: &[OnMesh]) -> String {
    let mut text = String::from(
        "| cells per body | unknowns | program | s, median | smallest to largest | whole process, s | memory, MiB | runs |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let mib = |bytes: f64| format!("{:.0}", bytes / (1024.0 * 1024.0));
    for row in rows(meshes) {
        let runs = row.seconds.len();
        let Some([median, least, most]) = spread_of(row.seconds) else { continue };
        let whole = spread_of(row.whole).map_or("-".to_owned(), |[m, ..]| format!("{m:.3}"));
        let memory = spread_of(row.memory).map_or("-".to_owned(), |[m, ..]| mib(m));
        let own = row.own.map(|bytes| format!(" (own {})", mib(bytes))).unwrap_or_default();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {median:.4} | {least:.4} to {most:.4} | {whole} | {memory}{own} | {runs} |",
            row.mesh, row.unknowns, row.program
        );
    }
    text
}

fn ratios(meshes: &[OnMesh]) -> String {
    let mut text = String::from(
        "How many times longer a peer takes, against the solve and against the solve with its certificate (CalculiX: \
         its whole process against ours).\n\n\
         | cells per body | peer | / solve | of single rounds | / with certificate | of single rounds |\n\
         |---|---|---|---|---|---|\n",
    );
    for m in meshes {
        for s in &m.series {
            let by_process = s.peer.solves_contact() && !s.peer.is_exact();
            let solve =
                paired(m, s, |o| Some(if by_process { o.whole } else { o.solve }), |a| Some(a.seconds));
            let certified =
                paired(m, s, |o| Some(if by_process { o.whole } else { o.certified }), |a| Some(a.seconds));
            let shown = |pairs: &[[f64; 2]]| {
                let turned: Vec<[f64; 2]> = pairs.iter().map(|[own, peer]| [*peer, *own]).collect();
                ratio(&turned).map_or("- | -".to_owned(), |[r, a, b]| format!("{r:.2} | {a:.2} to {b:.2}"))
            };
            let first = if by_process { "- | -".to_owned() } else { shown(&solve) };
            let _ = writeln!(
                text,
                "| {}x{} | {} | {first} | {} |",
                m.cells[0],
                m.cells[1],
                s.peer.name,
                shown(&certified)
            );
        }
    }
    text
}

fn agreement(meshes: &[OnMesh]) -> String {
    let mut text = format!(
        "Relative differences of the energies a(u,u) and of the contact force to this program's, converged to \
         eta_nndd <= 1e-8 of its first value. The active set solves the same discrete problem and must agree to \
         {AGREEMENT:e}; CalculiX's penalty lets the bodies overlap, and its displacements have seven digits.\n\n\
         | cells per body | peer | energy, upper | energy, lower | contact force | required |\n|---|---|---|---|---|---|\n"
    );
    for m in meshes {
        for s in m.series.iter().filter(|s| s.peer.solves_contact()) {
            let shown = match s.differences {
                Some(d) => d.map(|x| format!("{x:.1e}")).join(" | "),
                None => "- | - | -".to_owned(),
            };
            let required =
                if s.peer.is_exact() { format!("{AGREEMENT:e}") } else { "stated only".to_owned() };
            let _ =
                writeln!(text, "| {}x{} | {} | {shown} | {required} |", m.cells[0], m.cells[1], s.peer.name);
        }
    }
    text
}

/// The spreads that are large enough to be named.
fn noise(meshes: &[OnMesh]) -> String {
    let mut text = String::new();
    for row in rows(meshes) {
        let runs = row.seconds.len();
        let Some([median, least, most]) = spread_of(row.seconds) else { continue };
        let percent = 100.0 * (most - least) / median;
        if percent > QUIET {
            let _ = writeln!(text, "- {}, {}: {percent:.0} % over {runs} runs.", row.mesh, row.program);
        }
    }
    format!(
        "Largest less smallest time over the median, if it is more than {QUIET} %. Smaller differences between \
         programs say nothing.\n\n{}",
        if text.is_empty() { "- nowhere.\n" } else { &text }
    )
}

/// Medians, smallest and largest values of everything.
pub(super) fn csv(meshes: &[OnMesh]) -> String {
    let mut text = String::from("cells,unknowns,program,quantity,unit,median,smallest,largest,runs\n");
    for row in rows(meshes) {
        let own = row.own.into_iter().collect();
        for (quantity, unit, values) in [
            ("time", "s", row.seconds),
            ("whole process", "s", row.whole),
            ("memory", "B", row.memory),
            ("memory by its own count", "B", own),
        ] {
            let runs = values.len();
            if let Some([median, least, most]) = spread_of(values) {
                let _ = writeln!(
                    text,
                    "{},{},{},{quantity},{unit},{median},{least},{most},{runs}",
                    row.mesh,
                    row.unknowns,
                    quoted(&row.program)
                );
            }
        }
    }
    text
}
