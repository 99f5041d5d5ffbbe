//! `cargo xtask bench --peers`: what a user would pick instead, on the same meshes and at the same time.
//!
//! Every round runs this program and then each peer once, so that a machine that drifts drifts for all. The page is
//! written before a disagreement makes the task fail.

mod environment;
mod page;
mod roster;
mod targets;

use super::process::{self, CELLS};
use super::{Arguments, criterion, machine::Machine, write_all};
use crate::python::last_line;
use crate::workspace::{Outcome, Workspace};
pub(super) use roster::{Answer as LinearAnswer, Pardiso};
use roster::{Answer, Peer, Runner};
use serde_json::Value;
pub(super) use targets::ratio;
pub(crate) use targets::verdict;

/// Threads of every program.
pub(super) const THREADS: usize = 2;
/// A peer whose first run took longer is not run again, seconds.
const SLOW: f64 = 60.0;
/// Largest relative difference to a peer that solves the same discrete problem.
const AGREEMENT: f64 = 1e-6;
/// Settings of the run whose answer is compared with the peers' answers: converged far below [`AGREEMENT`].
const CONVERGED: [&str; 2] = ["solver.stop.criterion=\"eta_nndd\"", "solver.stop.tolerance=1e-8"];
/// Criterion's name of one iteration with 1281 pairs.
const ITERATION: &str = "nndd/one iteration/1281";

/// One run of this program.
#[derive(Clone, Debug)]
struct Own {
    /// From the mesh in memory to recovered displacements, by the default criterion.
    solve: f64,
    /// The same, converged as far as [`CONVERGED`] says.
    converged: f64,
    /// The same with everything for the certificate.
    certified: f64,
    /// Wall time of the process.
    whole: f64,
    /// Peak memory of the process, bytes.
    memory: Option<f64>,
}

/// The runs of a peer on one mesh.
struct Series {
    peer: Peer,
    /// The rounds that count, in the order of the program's own; one run only if that took long.
    answers: Vec<Answer>,
    /// Relative differences to this program's answer: energies of both bodies, contact force.
    differences: Option<[f64; 3]>,
}

/// Everything measured on one mesh.
struct OnMesh {
    cells: [usize; 2],
    unknowns: f64,
    own: Vec<Own>,
    series: Vec<Series>,
}

/// Measures, writes `peers.md` and `peers.csv`, and fails if an exact peer disagrees.
pub(super) fn run(workspace: &Workspace, arguments: &Arguments) -> Outcome<()> {
    let environment = environment::make(workspace);
    let (peers, mut skipped) = roster::muster(&environment);
    for line in &skipped {
        println!("skipped {line}");
    }
    let mut more = vec![ITERATION.trim_start_matches("nndd/")];
    if arguments.quick {
        more.push("--quick");
    }
    let iteration = criterion::measure(workspace, &["nndd"], &more)?;
    let iteration = iteration.into_iter().find(|e| e.name == ITERATION);

    let meshes = if arguments.large { CELLS.len() } else { CELLS.len() - 1 };
    let wanted = CELLS[..meshes].iter().filter(|c| arguments.up_to.is_none_or(|n| c[0] <= n));
    let mut found = vec![];
    for cells in wanted {
        let runner = Runner { workspace, environment: &environment, cells: *cells };
        found.push(on_mesh(&runner, &peers, arguments.runs as usize, &mut skipped)?);
    }
    let machine = Machine::look();
    let measured = page::Measured {
        command: arguments.command(),
        runs: arguments.runs as usize,
        meshes: &found,
        iteration: iteration.as_ref(),
        skipped: &skipped,
    };
    let page = page::page(workspace, &environment, &machine, &measured)?;
    write_all(workspace, &machine, &[("peers.md", page), ("peers.csv", page::csv(&found))])?;
    print!("\n{}", targets::table(&found, iteration.as_ref()));
    let wrong = disagreements(&found);
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}

/// Measures PARDISO, ordered by minimum degree, on two blocks of each of these cells: the median seconds, and the memory in bytes.
pub(crate) fn minimum_degree(workspace: &Workspace, cells: &[[usize; 2]]) -> Outcome<Vec<(f64, f64)>> {
    let environment = environment::make(workspace);
    let (peers, skipped) = roster::muster(&environment);
    let peer = peers.iter().find(|p| p.task == roster::Task::Linear("pardiso-minimum-degree"));
    let peer = peer.ok_or_else(|| skipped.join("; "))?;
    let median = |cells: &[usize; 2]| {
        let runner = Runner { workspace, environment: &environment, cells: *cells };
        runner.prepare(std::slice::from_ref(peer))?;
        let mut answers = (0..3).map(|_| runner.run(peer)).collect::<Outcome<Vec<_>>>()?;
        answers.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        Ok((answers[1].seconds, answers[1].memory.unwrap_or(f64::NAN)))
    };
    cells.iter().map(median).collect()
}

/// Runs this program and the peers on one mesh, round after round.
fn on_mesh(runner: &Runner<'_>, peers: &[Peer], runs: usize, skipped: &mut Vec<String>) -> Outcome<OnMesh> {
    let [nx, ny] = runner.cells;
    let name = format!("{nx}x{ny} cells per body");
    let settings = process::settings(runner.cells);
    let mut taking: Vec<Peer> = peers.iter().filter(|p| p.takes(runner.cells)).copied().collect();
    if let Err(error) = runner.prepare(&taking) {
        skipped.push(format!("all peers at {name}: {}", last_line(&error)));
        taking.clear();
    }
    println!("{name}: this program and {} peers", taking.len());
    let mut converged = settings.clone();
    converged.extend(CONVERGED.map(str::to_owned));
    let timer = Timer { workspace: runner.workspace, name: &name, settings, converged };
    // The first round is discarded, but for peers so slow that it is their only one.
    let (_, reference) = timer.run()?;
    let mut series = vec![];
    for peer in taking {
        match runner.run(&peer) {
            Ok(answer) => {
                println!("{}: {:.2} s, process {:.2} s", peer.name, answer.seconds, answer.whole);
                let differences = differences(&reference, &answer.details);
                let answers = if answer.whole > SLOW { vec![answer] } else { vec![] };
                series.push(Series { peer, answers, differences });
            }
            Err(error) => skip(skipped, &peer, &name, &error),
        }
    }
    let mut again: Vec<bool> = series.iter().map(|s| s.answers.is_empty()).collect();
    let mut own = vec![];
    for round in 1..=runs {
        println!("{name}: round {round} of {runs}");
        own.push(timer.run()?.0);
        for (s, again) in series.iter_mut().zip(&mut again).filter(|(_, again)| **again) {
            match runner.run(&s.peer) {
                Ok(answer) => s.answers.push(answer),
                Err(error) => {
                    skip(skipped, &s.peer, &name, &error);
                    *again = false;
                }
            }
        }
    }
    let unknowns = process::unknowns(&reference).unwrap_or(f64::NAN);
    Ok(OnMesh { cells: runner.cells, unknowns, own, series })
}

/// Notes that a peer does not run.
fn skip(skipped: &mut Vec<String>, peer: &Peer, mesh: &str, error: &str) {
    let line = format!("{} at {mesh}: {}", peer.name, last_line(error));
    println!("skipped {line}");
    skipped.push(line);
}

/// Runs this program on one mesh.
struct Timer<'a> {
    workspace: &'a Workspace,
    name: &'a str,
    settings: Vec<String>,
    converged: Vec<String>,
}

impl Timer<'_> {
    /// Runs it by its default criterion and converged, and returns the latter's report as well.
    fn run(&self) -> Outcome<(Own, Value)> {
        let (run, report) = process::solve(self.workspace, self.name, &self.settings, Some(THREADS))?;
        let solve = self.solve_time(&report)?;
        let certified = solve + self.phase(&report, "estimate")?;
        let (_, reference) = process::solve(self.workspace, self.name, &self.converged, Some(THREADS))?;
        let converged = self.solve_time(&reference)?;
        let memory = run.memory.map(|kib| kib * 1024.0);
        Ok((Own { solve, converged, certified, whole: run.seconds, memory }, reference))
    }

    fn solve_time(&self, report: &Value) -> Outcome<f64> {
        let phases = ["assembly", "factorisation", "iterations"];
        phases.into_iter().map(|key| self.phase(report, key)).sum()
    }

    fn phase(&self, report: &Value, key: &str) -> Outcome<f64> {
        let found = report["timings"][key].as_f64();
        found.ok_or_else(|| format!("{}: no timing {key} in report.json", self.name))
    }
}

/// Computes the relative differences of a peer's energies and contact force to report.json; `None` if the peer has no values.
fn differences(report: &Value, details: &Value) -> Option<[f64; 3]> {
    let results = &report["results"];
    let pairs = [
        (&details["energies"][0], &results["energy_norm_squared"][0]),
        (&details["energies"][1], &results["energy_norm_squared"][1]),
        (&details["contact_force"], &results["contact_force"]),
    ];
    let mut found = [0.0; 3];
    for (difference, (theirs, ours)) in found.iter_mut().zip(pairs) {
        let (theirs, ours) = (theirs.as_f64()?, ours.as_f64()?);
        *difference = (theirs - ours).abs() / ours.abs();
    }
    Some(found)
}

/// Exact peers that disagree, or whose answer cannot be compared.
fn disagreements(meshes: &[OnMesh]) -> Vec<String> {
    let exact = meshes.iter().flat_map(|m| m.series.iter().map(move |s| (m.cells, s)));
    exact
        .filter(|(_, s)| s.peer.is_exact())
        // NaN never meets the limit.
        .filter(|(_, s)| !s.differences.is_some_and(|d| d.iter().all(|x| *x <= AGREEMENT)))
        .map(|([nx, ny], s)| {
            format!("{} disagrees at {nx}x{ny}: {:?}, expected {AGREEMENT}", s.peer.name, s.differences)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn differences_are_relative() {
        let report = json!({ "results": { "energy_norm_squared": [2.0, 4.0], "contact_force": 10.0 } });
        let details = json!({ "energies": [2.0, 4.4], "contact_force": 9.0 });
        let found = differences(&report, &details).unwrap();
        assert!(found[0] == 0.0 && (found[1] - 0.1).abs() < 1e-12 && (found[2] - 0.1).abs() < 1e-12);
        assert_eq!(differences(&report, &json!({ "seconds": 1.0 })), None);
    }
}
