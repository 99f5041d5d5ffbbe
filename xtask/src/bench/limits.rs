//! The least that a solve needs, by count and by the peaks of the machine, beside the times of its phases.

mod page;

use super::machine::{Machine, provenance};
use super::numbers::{exponent, spread_of};
use super::process;
use crate::workspace::{Outcome, Workspace, load_average, output, stream};
use serde::Deserialize;
use serde_json::Value;
use std::fmt::Write as _;

/// The benchmark that measures; a plain program, no suite of criterion.
const SUITE: &str = "limits";
const HEADER: &str = "cells,unknowns,threads,phase,seconds,smallest_s,largest_s,flops,bytes,limit_s";
/// Rounds of a phase that takes less than ten seconds.
const ROUNDS: usize = 3;
/// A phase that takes less than this part of the time at the largest size is not named.
const SHARE: f64 = 0.03;

/// The estimate in one call, and its parts that the benchmark calls alone.
const WHOLE: &str = "whole estimate";
const PARTS: [&str; 6] = ["Neumann problems", "EET", "star set-up", "star residual", "star sweeps", "checks"];
/// The name of the estimate in one call less these parts.
const REST: &str = "rest of the estimate";
/// Part of other phases, so no part of the sum.
const INSIDE: &str = "Johnson-Mercier";
/// Its bytes go to files, not to memory.
const FILES: &str = "files";

/// The peaks of the machine with some threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
struct Peak {
    threads: usize,
    /// Operations and bytes per second.
    flops: f64,
    bytes: f64,
    /// Bytes per second that one thread writes to a file.
    written: f64,
}

/// A line of the benchmark.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Line {
    Peak(Peak),
    Phase { phase: String, threads: usize, unknowns: f64, seconds: Vec<f64>, flops: f64, bytes: f64 },
    Run { threads: usize, iterations: usize, estimates: usize, seconds: Value },
}

/// A phase of one problem.
#[derive(Clone, Debug, PartialEq)]
struct Phase {
    name: String,
    cells: [usize; 2],
    threads: usize,
    unknowns: f64,
    /// Median, smallest and largest.
    seconds: [f64; 3],
    /// Zero: they are not counted.
    flops: f64,
    /// Likewise.
    bytes: f64,
}

/// A whole run with its files: iterations, and the times in its report.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    cells: [usize; 2],
    threads: usize,
    iterations: usize,
    /// Iterations that were estimated.
    estimates: usize,
    timings: Value,
}

/// The resource that limits a phase.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Resource {
    Multiplication,
    Memory,
    Files,
}

/// Everything that was measured.
#[derive(Debug, Default)]
struct Measured {
    peaks: Vec<Peak>,
    phases: Vec<Phase>,
    runs: Vec<Run>,
}

/// Measures, and writes page and table.
///
/// * `large`: 1280x640 cells per body as well.
pub(super) fn run(workspace: &Workspace, command: &str, large: bool) -> Outcome<()> {
    let load = load_average();
    let bench = ["bench", "--package", "tests", "--bench", SUITE];
    if stream(workspace.cargo(&bench).arg("--no-run"))? != Some(0) {
        return Err(format!("the benchmark {SUITE} does not build"));
    }
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    // The smallest mesh of the other benchmarks has no time to measure.
    let cells = &process::CELLS[1..if large { 5 } else { 4 }];
    let mut measured = Measured::default();
    for threads in if all == 1 { vec![1] } else { vec![1, 2] } {
        let ask = |arguments: &[String]| output(workspace.cargo(&bench).arg("--").args(arguments));
        // Before and after the phases: another program may be at work during one of them.
        let peaks = || ask(&["peaks".to_owned(), threads.to_string()]);
        measured.take([0; 2], &peaks()?)?;
        for &cells in cells {
            println!("measuring {}x{} cells per body, {threads} threads", cells[0], cells[1]);
            let mut arguments = vec!["phases".to_owned(), threads.to_string(), ROUNDS.to_string()];
            arguments.extend(process::settings(cells));
            arguments.push("output.vtu=true".to_owned());
            measured.take(cells, &ask(&arguments)?)?;
        }
        measured.take([0; 2], &peaks()?)?;
    }
    let machine = Machine::look();
    let more = [
        ("rounds", format!("{ROUNDS}, one if a phase takes more than 10 s")),
        ("largest cache", largest_cache()),
        ("load in the minute before", load),
    ];
    let table = provenance(workspace, &machine, command, &more)?;
    let text = page::page(&measured);
    let title = format!(
        "# Phases of a solve beside the limits of the machine, {} on {}",
        super::today(),
        machine.slug()
    );
    let files = [("limits.md", format!("{title}\n\n{table}\n{text}")), ("limits.csv", measured.csv())];
    super::write_all(workspace, &machine, &files)?;
    print!("\n{text}");
    Ok(())
}

/// The size of the last level of the cache as Linux states it.
fn largest_cache() -> String {
    let of_level = |k: usize| format!("/sys/devices/system/cpu/cpu0/cache/index{k}/size");
    let mut sizes = (0..8).filter_map(|k| std::fs::read_to_string(of_level(k)).ok());
    sizes.next_back().map_or("unknown".to_owned(), |size| size.trim().to_owned())
}

impl Measured {
    /// Takes what the benchmark printed of one mesh, or of the machine.
    fn take(&mut self, cells: [usize; 2], lines: &str) -> Outcome<()> {
        for line in lines.lines() {
            self.take_line(cells, line)
                .ok_or_else(|| format!("{SUITE}: found `{line}`, expected one of its objects"))?;
        }
        self.take_parts();
        Ok(())
    }

    /// Takes the measured parts from the estimates in one call.
    fn take_parts(&mut self) {
        while let Some(at) = self.phases.iter().position(|phase| phase.name == WHOLE) {
            let mut whole = self.phases.remove(at);
            let parts = PARTS.iter().filter_map(|name| self.phase(name, whole.cells, whole.threads));
            let parts: f64 = parts.map(|part| part.seconds[0]).sum();
            whole.seconds = whole.seconds.map(|seconds| seconds - parts);
            whole.name = REST.to_owned();
            self.phases.push(whole);
        }
    }

    fn take_line(&mut self, cells: [usize; 2], line: &str) -> Option<()> {
        match serde_json::from_str(line).ok()? {
            Line::Peak(found) => match self.peaks.iter_mut().find(|peak| peak.threads == found.threads) {
                Some(peak) => {
                    peak.flops = peak.flops.max(found.flops);
                    peak.bytes = peak.bytes.max(found.bytes);
                    peak.written = peak.written.max(found.written);
                }
                None => self.peaks.push(found),
            },
            Line::Phase { phase: name, threads, unknowns, seconds, flops, bytes } => {
                let seconds = spread_of(seconds)?;
                self.phases.push(Phase { name, cells, threads, unknowns, seconds, flops, bytes });
            }
            Line::Run { threads, iterations, estimates, seconds: timings } => {
                self.runs.push(Run { cells, threads, iterations, estimates, timings });
            }
        }
        Some(())
    }

    /// The numbers of threads, ascending.
    fn threads(&self) -> Vec<usize> {
        self.peaks.iter().map(|peak| peak.threads).collect()
    }

    /// The meshes, the coarsest first, with their unknowns.
    fn meshes(&self) -> Vec<([usize; 2], f64)> {
        let mut meshes: Vec<([usize; 2], f64)> = self.phases.iter().map(|p| (p.cells, p.unknowns)).collect();
        meshes.sort_by(|a, b| a.1.total_cmp(&b.1));
        meshes.dedup();
        meshes
    }

    /// The names of the phases, in the order of a run: the benchmark writes files first.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = vec![];
        for phase in &self.phases {
            if !names.contains(&phase.name.as_str()) {
                names.push(&phase.name);
            }
        }
        names.sort_by_key(|name| *name == FILES);
        names
    }

    fn phase(&self, name: &str, cells: [usize; 2], threads: usize) -> Option<&Phase> {
        self.phases.iter().find(|p| (p.name.as_str(), p.cells, p.threads) == (name, cells, threads))
    }

    /// Seconds that a phase needs at least, and what limits it; `None` if nothing of it is counted.
    fn limit(&self, phase: &Phase) -> Option<(f64, Resource)> {
        let peak = self.peaks.iter().find(|peak| peak.threads == phase.threads)?;
        let [flops, bytes] = [phase.flops / peak.flops, phase.bytes / peak.bytes];
        let found = match phase.name.as_str() {
            FILES => (phase.bytes / peak.written, Resource::Files),
            _ if flops > bytes => (flops, Resource::Multiplication),
            _ => (bytes, Resource::Memory),
        };
        Some(found).filter(|(seconds, _)| *seconds > 0.0)
    }

    /// The part of its time that a phase needs at least.
    fn fraction(&self, phase: &Phase) -> Option<f64> {
        Some(self.limit(phase)?.0 / phase.seconds[0])
    }

    /// The exponent of a phase's growth between the smallest and the largest mesh.
    fn growth(&self, name: &str, threads: usize) -> Option<f64> {
        let meshes = self.meshes();
        let at = |(cells, unknowns): ([usize; 2], f64)| {
            Some([unknowns, self.phase(name, cells, threads)?.seconds[0]])
        };
        exponent(&[at(*meshes.first()?)?, at(*meshes.last()?)?])
    }

    /// The phases of a mesh, without what is part of others.
    fn of_mesh(&self, cells: [usize; 2], threads: usize) -> impl Iterator<Item = &Phase> {
        let of_mesh = move |p: &&Phase| (p.cells, p.threads) == (cells, threads) && p.name != INSIDE;
        self.phases.iter().filter(of_mesh)
    }

    /// The median seconds of all phases of a mesh.
    fn total(&self, cells: [usize; 2], threads: usize) -> f64 {
        self.of_mesh(cells, threads).map(|p| p.seconds[0]).sum()
    }

    /// The phases of the largest mesh with the smallest fractions, the smallest first, and these.
    fn farthest(&self, threads: usize) -> Vec<(&Phase, f64)> {
        let Some(&(cells, _)) = self.meshes().last() else { return vec![] };
        let least = SHARE * self.total(cells, threads);
        let long = self.of_mesh(cells, threads).filter(|p| p.seconds[0] >= least);
        let mut found: Vec<(&Phase, f64)> = long.filter_map(|p| Some((p, self.fraction(p)?))).collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found.truncate(3);
        found
    }

    fn csv(&self) -> String {
        let mut text = format!("{HEADER}\n");
        for phase in &self.phases {
            let Phase {
                name,
                cells: [a, b],
                threads,
                unknowns,
                seconds: [median, least, most],
                flops,
                bytes,
            } = phase;
            let limit = self.limit(phase).map_or(String::new(), |(limit, _)| limit.to_string());
            let _ = writeln!(
                text,
                "{a}x{b},{unknowns},{threads},{name},{median},{least},{most},{flops},{bytes},{limit}"
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn measured() -> Measured {
        let mut measured = Measured::default();
        measured
            .take([0; 2], r#"{"kind":"peak","threads":1,"flops":1e9,"bytes":1e8,"written":1e7}"#)
            .unwrap();
        measured
            .take([0; 2], r#"{"kind":"peak","threads":1,"flops":1e10,"bytes":1e7,"written":1e8}"#)
            .unwrap();
        for (cells, scale) in [([4, 2], 1.0), ([8, 4], 4.0)] {
            let phases = [
                (FILES, 0.5, 0.0, 1e7),
                ("factorisation", 2.0, 1e10, 1e7),
                (WHOLE, 0.25, 0.0, 0.0),
                (INSIDE, 4.0, 1.0, 0.0),
                ("EET", 0.01, 0.0, 1e3),
            ];
            let mut lines = vec![
                r#"{"kind":"run","threads":1,"iterations":7,"estimates":2,"seconds":{"mesh":1.5,"total":2.5}}"#.to_owned(),
            ];
            for (name, seconds, flops, bytes) in phases {
                let line = serde_json::json!({ "kind": "phase", "threads": 1, "unknowns": 10.0 * scale,
                    "phase": name, "seconds": [scale * seconds, 9.0 * scale * seconds, 0.0],
                    "flops": scale * flops, "bytes": scale * bytes });
                lines.push(line.to_string());
            }
            measured.take(cells, &lines.join("\n")).unwrap();
        }
        measured
    }

    #[test]
    fn a_phase_has_the_limit_that_takes_longest() {
        let measured = measured();
        let phase = measured.phase("factorisation", [4, 2], 1).unwrap();
        assert_eq!(phase.seconds, [2.0, 0.0, 18.0]);
        // The better of two peaks of each kind.
        assert_eq!(measured.limit(phase), Some((1.0, Resource::Multiplication)));
        assert_eq!(measured.fraction(phase), Some(0.5));
        assert_eq!(measured.limit(measured.phase("files", [4, 2], 1).unwrap()), Some((0.1, Resource::Files)));
        assert!(measured.growth("EET", 1).is_some_and(|p| (p - 1.0).abs() < 1e-12));
        assert_eq!(measured.names(), ["factorisation", INSIDE, "EET", REST, FILES]);
    }

    #[test]
    fn phases_without_weight_are_not_named() {
        let measured = measured();
        let names: Vec<&str> = measured.farthest(1).iter().map(|(phase, _)| phase.name.as_str()).collect();
        assert_eq!(names, [FILES, "factorisation"]);
        assert_eq!(measured.csv().lines().count(), 11);
    }

    #[test]
    fn the_rest_of_an_estimate_is_what_its_parts_leave() {
        let measured = measured();
        let rest = measured.phase(REST, [8, 4], 1).unwrap();
        assert!((rest.seconds[0] - 0.96).abs() < 1e-12);
        assert_eq!((measured.phase(WHOLE, [8, 4], 1), measured.fraction(rest)), (None, None));
        assert!((measured.total([4, 2], 1) - 2.75).abs() < 1e-12);
    }

    #[test]
    fn lines_of_another_form_are_refused() {
        for line in ["x", "{}", r#"{"kind":"peak","threads":1}"#, r#"{"kind":"other","threads":1}"#] {
            assert!(Measured::default().take([4, 2], line).is_err(), "{line}");
        }
    }
}
