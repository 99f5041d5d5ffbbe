//! The page and the tables of an ordinary run.

use super::criterion::Estimate;
use super::machine::{Machine, provenance};
use super::numbers::{exponent, quoted, spread, time};
use super::process::{PHASES, Process};
use crate::workspace::{Outcome, Workspace};
use std::fmt::Write as _;

/// The page's text on all that these numbers do not show.
const NOT_MEASURED: &str = include_str!("not_measured.md");
/// Phases whose growth is fitted.
const GROWING: [&str; 5] = ["assembly", "factorisation", "iterations", "estimate", "total"];
/// Meshes with fewer unknowns say nothing of growth: starting threads and writing files take as long.
const SMALL: f64 = 5e3;

/// The page that says what was measured, where and how.
pub(super) fn readme(
    workspace: &Workspace,
    command: &str,
    machine: &Machine,
    estimates: &[Estimate],
    processes: &[Process],
) -> Outcome<String> {
    let mut text = format!("# Benchmarks of {} on {}\n\n", super::today(), machine.slug());
    text.push_str(&provenance(workspace, machine, command, &[])?);
    let _ = write!(text, "\n## Summary\n\n{}", summary(estimates, processes));
    let _ = write!(text, "\n## Growth\n\n{}", growth(processes));
    let _ = write!(text, "\n## Noise\n\n{}", noise(estimates, processes));
    let _ = write!(text, "\n## Not measured\n\n{NOT_MEASURED}");
    if processes.iter().any(|p| p.memory.is_empty()) {
        text.push_str("- peak memory: GNU time was not there.\n");
    }
    text.push_str(
        "\nRaw numbers: `criterion.csv` (nanoseconds), `whole-process.csv` (seconds, kibibytes), \
         `phases.csv` (seconds).\n",
    );
    Ok(text)
}

/// Exponents of growth with the number of unknowns, and the parts of a solution against each other.
fn growth(processes: &[Process]) -> String {
    let sized = || processes.iter().filter_map(|p| Some((p.unknowns.filter(|n| *n >= SMALL)?, p)));
    let fitted = |value: &dyn Fn(&Process) -> Option<f64>| {
        let points: Vec<[f64; 2]> = sized().filter_map(|(n, p)| Some([n, value(p)?])).collect();
        exponent(&points).map_or("-".to_owned(), |e| format!("{e:.2}"))
    };
    let mut exponents: Vec<String> = GROWING.map(|phase| fitted(&|p| p.phase(phase))).to_vec();
    exponents.push(fitted(&|p| spread(&p.memory).map(|[median, ..]| median)));
    let mut text = format!(
        "Exponents of growth with the number of unknowns, least squares in logarithms over the meshes with more than \
         {SMALL} unknowns:\n\n| {} | peak memory |\n|{}\n| {} |\n",
        GROWING.join(" | "),
        "---|".repeat(GROWING.len() + 1),
        exponents.join(" | ")
    );
    text.push_str(
        "\n`solve` is assembly, factorisation and iterations.\n\n\
         | case | unknowns | solve, s | of it factorisation | estimate / solve | µs per unknown, both |\n\
         |---|---|---|---|---|---|\n",
    );
    for p in processes {
        let Some(unknowns) = p.unknowns else { continue };
        let phases = ["assembly", "factorisation", "iterations", "estimate"].map(|name| p.phase(name));
        let [Some(assembly), Some(factorisation), Some(iterations), Some(estimate)] = phases else {
            continue;
        };
        let solve = assembly + factorisation + iterations;
        let _ = writeln!(
            text,
            "| {} | {unknowns} | {solve:.4} | {:.0} % | {:.2} | {:.2} |",
            p.case,
            100.0 * factorisation / solve,
            estimate / solve,
            1e6 * (solve + estimate) / unknowns
        );
    }
    text
}

/// The two tables of results.
pub(super) fn summary(estimates: &[Estimate], processes: &[Process]) -> String {
    let mut text = String::from(
        "| whole process | median | smallest | largest | peak memory |\n|---|---|---|---|---|\n",
    );
    for p in processes {
        let [median, least, most] =
            spread(&p.seconds).map_or(["-"; 3].map(str::to_owned), |s| s.map(|t| time(t * 1e9)));
        let memory =
            spread(&p.memory).map_or("not measured".to_owned(), |m| format!("{:.1} MiB", m[0] / 1024.0));
        let _ = writeln!(text, "| {} | {median} | {least} | {most} | {memory} |", p.case);
    }
    let _ = writeln!(
        text,
        "\n| phases, median s | {} |\n|---{}|",
        PHASES.join(" | "),
        "|---".repeat(PHASES.len())
    );
    for p in processes {
        let times: Vec<String> = p.phases.iter().map(|t| format!("{t:.4}")).collect();
        let _ = writeln!(text, "| {} | {} |", p.case, times.join(" | "));
    }
    if estimates.is_empty() {
        text.push_str("\nNo crate has a criterion suite.\n");
        return text;
    }
    text.push_str("\n| criterion | median | confidence interval |\n|---|---|---|\n");
    for e in estimates {
        let name = e.name.replace('|', "\\|");
        let _ = writeln!(
            text,
            "| {name} | {} | {} to {} ({:.0} %) |",
            time(e.median),
            time(e.lower),
            time(e.upper),
            100.0 * e.level
        );
    }
    text
}

/// How far repeated measurements lie apart.
fn noise(estimates: &[Estimate], processes: &[Process]) -> String {
    let mut text = String::new();
    for p in processes {
        if let Some([median, least, most]) = spread(&p.seconds) {
            let percent = 100.0 * (most - least) / median;
            let _ = writeln!(
                text,
                "- `{}`: {} to {} over {} runs, {percent:.1} % of the median. Smaller differences say nothing.",
                p.case,
                time(least * 1e9),
                time(most * 1e9),
                p.seconds.len()
            );
        }
    }
    let widest = estimates.iter().max_by(|a, b| a.width().total_cmp(&b.width()));
    if let Some(e) = widest {
        let _ = writeln!(
            text,
            "- criterion: the widest confidence interval is {:.1} % of its median ({}).",
            100.0 * e.width(),
            e.name
        );
    }
    text
}

pub(super) fn criterion_csv(estimates: &[Estimate]) -> String {
    let mut text = String::from("benchmark,median_ns,lower_ns,upper_ns,confidence_level\n");
    for e in estimates {
        let _ = writeln!(text, "{},{},{},{},{}", quoted(&e.name), e.median, e.lower, e.upper, e.level);
    }
    text
}

pub(super) fn process_csv(processes: &[Process]) -> String {
    let mut text = String::from("case,quantity,unit,median,smallest,largest,runs\n");
    for p in processes {
        for (quantity, unit, values) in [("wall time", "s", &p.seconds), ("peak memory", "KiB", &p.memory)] {
            if let Some([median, least, most]) = spread(values) {
                let _ = writeln!(
                    text,
                    "{},{quantity},{unit},{median},{least},{most},{}",
                    quoted(&p.case),
                    values.len()
                );
            }
        }
    }
    text
}

/// The phases of every case, median seconds.
pub(super) fn phases_csv(processes: &[Process]) -> String {
    let mut text = format!("case,{}\n", PHASES.map(|phase| format!("{phase} [s]")).join(","));
    for p in processes {
        let times: Vec<String> = p.phases.iter().map(|t| format!("{t:.6}")).collect();
        let _ = writeln!(text, "{},{}", quoted(&p.case), times.join(","));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate() -> Estimate {
        let name = "condense/body, fine".to_owned();
        Estimate { name, median: 1200.25, lower: 1150.5, upper: 1250.0, level: 0.95 }
    }

    #[test]
    fn tables_hold_every_result() {
        let processes = [Process {
            case: "paper.toml".into(),
            unknowns: None,
            seconds: vec![0.1, 0.12, 0.2],
            memory: vec![],
            phases: vec![],
        }];
        let text = summary(&[estimate()], &processes);
        assert!(text.contains("| 120.00 ms | 100.00 ms | 200.00 ms | not measured |"), "{text}");
        assert!(text.contains("| condense/body, fine | 1.20 µs | 1.15 µs to 1.25 µs (95 %) |"), "{text}");
        assert!(criterion_csv(&[estimate()]).ends_with("\"condense/body, fine\",1200.25,1150.5,1250,0.95\n"));
        assert_eq!(process_csv(&processes).lines().count(), 2);
        assert!(noise(&[estimate()], &processes).contains("83.3 %"));
        assert!(summary(&[], &processes).contains("No crate has a criterion suite"));
    }

    #[test]
    fn growth_is_fitted_over_the_finer_meshes() {
        let process = |unknowns: f64, seconds: f64| Process {
            case: format!("{unknowns}"),
            unknowns: Some(unknowns),
            seconds: vec![seconds],
            memory: vec![],
            phases: vec![seconds; PHASES.len()],
        };
        let text = growth(&[process(600.0, 9.0), process(1e4, 1.0), process(1e5, 10.0)]);
        assert!(text.contains("| 1.00 | 1.00 | 1.00 | 1.00 | 1.00 | - |"), "{text}");
        assert!(text.contains("| 10000 | 10000 | 3.0000 | 33 % | 0.33 | 400.00 |"), "{text}");
    }
}
