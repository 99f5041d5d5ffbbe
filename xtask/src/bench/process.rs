//! Runs the program as a whole process: wall time, peak memory, and the phases it reports itself.

use super::numbers::spread_of;
use crate::workspace::{Outcome, Workspace, read};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

/// The case timed as a whole process, as it is and on finer meshes with the program's default settings.
const CASE: &str = "tests/cases/paper.toml";
/// Cells per body of the finer meshes; the last one only when asked for.
pub(super) const CELLS: [[usize; 2]; 5] = [[18, 9], [80, 36], [320, 160], [640, 320], [1280, 640]];
/// Settings that undo the paper's, so that the defaults are timed.
const DEFAULTS: [&str; 9] = [
    "solver.method=auto",
    "solver.imposed=auto",
    "solver.theta=auto",
    "solver.weights=stiffness",
    "solver.acceleration=anderson",
    "solver.stop.ratio=0.01",
    "solver.stop.force_balance=1e-3",
    "estimator.every=0",
    "output.vtu=false",
];
/// The parts of a run's time, as report.json names them.
pub(super) const PHASES: [&str; 7] =
    ["mesh", "assembly", "factorisation", "iterations", "estimate", "write", "total"];
/// GNU time, which reports the peak memory of a process.
const TIME: &str = "/usr/bin/time";

/// Repeated runs of the program on one case.
#[derive(Debug, PartialEq)]
pub(super) struct Process {
    pub(super) case: String,
    /// Free unknowns of both bodies; only of cases that belong to one family of meshes.
    pub(super) unknowns: Option<f64>,
    /// Wall times in seconds, ascending.
    pub(super) seconds: Vec<f64>,
    /// Peak memory in kibibytes, ascending; empty if it could not be measured.
    pub(super) memory: Vec<f64>,
    /// Median seconds of each of [`PHASES`].
    pub(super) phases: Vec<f64>,
}

impl Process {
    /// The median seconds of one of [`PHASES`].
    pub(super) fn phase(&self, name: &str) -> Option<f64> {
        let at = PHASES.iter().position(|p| *p == name)?;
        self.phases.get(at).copied()
    }
}

/// One run of a process.
pub(super) struct Run {
    /// Wall time in seconds.
    pub(super) seconds: f64,
    /// Peak memory in kibibytes; `None` without GNU time.
    pub(super) memory: Option<f64>,
    /// Processor time of it and its children in seconds; `None` without GNU time.
    pub(super) processor: Option<f64>,
    /// Its standard output.
    pub(super) said: String,
}

/// Runs a program and measures its time and its memory.
///
/// * `name`: for messages.
/// * `prepare`: adds arguments, environment and folder to the command.
pub(super) fn run(name: &str, program: &Path, prepare: impl Fn(&mut Command)) -> Outcome<Run> {
    // Not every program of this name is GNU's; then it is not measured.
    let timed = Path::new(TIME).exists();
    let mut command = Command::new(if timed { Path::new(TIME) } else { program });
    if timed {
        command.arg("-v").arg(program);
    }
    prepare(&mut command);
    let start = Instant::now();
    let done: Output = command.stdin(Stdio::null()).output().map_err(|e| format!("{name}: {e}"))?;
    let seconds = start.elapsed().as_secs_f64();
    let errors = String::from_utf8_lossy(&done.stderr);
    if done.status.success() {
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        Ok(Run { seconds, memory: peak_memory(&errors), processor: processor_time(&errors), said })
    } else {
        // GNU time adds its own text, which begins with this line.
        let own = errors.split("Command exited with").next().unwrap_or_default();
        Err(format!("{name}: {}: {}", done.status, own.trim()))
    }
}

/// Settings for the paper's problem on some mesh with the program's defaults.
pub(super) fn settings([nx, ny]: [usize; 2]) -> Vec<String> {
    let cells = (0..2).map(|body| format!("body.{body}.generator.cells=[{nx},{ny}]"));
    cells.chain(DEFAULTS.iter().map(|s| (*s).to_owned())).collect()
}

/// Solves [`CASE`] with some settings, see [`solve_case`].
pub(super) fn solve(
    workspace: &Workspace,
    name: &str,
    settings: &[String],
    threads: Option<usize>,
) -> Outcome<(Run, Value)> {
    solve_case(workspace, Path::new(CASE), name, settings, threads)
}

/// Solves a case with some settings, and returns the run and its report.json.
///
/// * `threads`: `None` for the program's default.
pub(super) fn solve_case(
    workspace: &Workspace,
    case: &Path,
    name: &str,
    settings: &[String],
    threads: Option<usize>,
) -> Outcome<(Run, Value)> {
    let out: PathBuf = workspace.target.join("bench");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", workspace.shown(&out)))?;
    let done = run(name, &workspace.nndd(), |command| {
        command
            .current_dir(&workspace.root)
            .arg("solve")
            .arg(case)
            .args(settings.iter().flat_map(|setting| ["--set", setting]))
            .arg("--out")
            .arg(&out)
            .args(["--force", "--quiet"])
            .args(threads.iter().flat_map(|n| ["--threads".to_owned(), n.to_string()]));
    })?;
    let report = serde_json::from_str(&read(&out.join("report.json"))?)
        .map_err(|e| format!("report.json of {name}: {e}"))?;
    Ok((done, report))
}

/// The free unknowns of both bodies in a report.
pub(super) fn unknowns(report: &Value) -> Option<f64> {
    report["bodies"].as_array()?.iter().map(|body| body["unknowns"].as_f64()).sum()
}

/// The cases of whole processes: what they are called, and the mesh with the default settings if not the file's own.
fn cases(large: bool) -> Vec<(String, Option<[usize; 2]>)> {
    let meshes = if large { CELLS.len() } else { CELLS.len() - 1 };
    let finer =
        CELLS[..meshes].iter().map(|c| (format!("{}x{} cells per body, defaults", c[0], c[1]), Some(*c)));
    std::iter::once(("paper.toml".to_owned(), None)).chain(finer).collect()
}

/// Times the program on every case: once discarded, then `runs` times.
pub(super) fn time_all(workspace: &Workspace, large: bool, runs: usize) -> Outcome<Vec<Process>> {
    cases(large).iter().map(|(name, cells)| time_process(workspace, name, *cells, runs)).collect()
}

fn time_process(
    workspace: &Workspace,
    case: &str,
    cells: Option<[usize; 2]>,
    runs: usize,
) -> Outcome<Process> {
    println!("timing {case}");
    let settings = cells.map(settings).unwrap_or_default();
    let (_, first) = solve(workspace, case, &settings, None)?;
    let (mut seconds, mut memory) = (vec![], vec![]);
    let mut phases = vec![vec![]; PHASES.len()];
    for _ in 0..runs {
        let (run, report) = solve(workspace, case, &settings, None)?;
        seconds.push(run.seconds);
        memory.extend(run.memory);
        for (times, phase) in phases.iter_mut().zip(PHASES) {
            times.extend(report["timings"][phase].as_f64());
        }
    }
    seconds.sort_by(f64::total_cmp);
    memory.sort_by(f64::total_cmp);
    let middle = |times: Vec<f64>| spread_of(times).map_or(f64::NAN, |[median, ..]| median);
    Ok(Process {
        case: case.to_owned(),
        unknowns: cells.and_then(|_| unknowns(&first)),
        seconds,
        memory,
        phases: phases.into_iter().map(middle).collect(),
    })
}

/// The peak memory in kibibytes in what GNU time says.
fn peak_memory(said: &str) -> Option<f64> {
    figure(said, "Maximum resident set size")
}

/// User and system time in seconds in what GNU time says.
fn processor_time(said: &str) -> Option<f64> {
    Some(figure(said, "User time")? + figure(said, "System time")?)
}

/// A number in what GNU time says, by the beginning of its line.
fn figure(said: &str, beginning: &str) -> Option<f64> {
    let line = said.lines().find(|l| l.trim().starts_with(beginning))?;
    line.rsplit(':').next()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_memory_is_read_from_gnu_time() {
        let said = "\tElapsed (wall clock) time (h:mm:ss or m:ss): 0:00.10\n\tMaximum resident set size (kbytes): 20480\n";
        assert_eq!(peak_memory(said), Some(20480.0));
        assert_eq!(peak_memory("usage: time"), None);
        let said = "\tUser time (seconds): 1.25\n\tSystem time (seconds): 0.50\n";
        assert_eq!(processor_time(said), Some(1.75));
    }

    #[test]
    fn unknowns_of_both_bodies_are_added() {
        let report = serde_json::json!({ "bodies": [{ "unknowns": 10 }, { "unknowns": 12 }] });
        assert_eq!(unknowns(&report), Some(22.0));
        assert_eq!(unknowns(&serde_json::json!({ "bodies": [{}] })), None);
        assert_eq!(unknowns(&serde_json::json!({})), None);
    }

    #[test]
    fn the_largest_mesh_is_for_who_asks() {
        assert_eq!((cases(false).len(), cases(true).len()), (CELLS.len(), CELLS.len() + 1));
        assert!(settings([4, 2]).contains(&"body.1.generator.cells=[4,2]".to_owned()));
    }
}
