//! The factorisation of `fem-core` beside the sparse Cholesky of faer, on the same matrices.

use super::machine::{Machine, provenance};
use super::numbers::{spread_of, time};
use crate::workspace::{Outcome, Workspace, load_average, output, stream};
use std::fmt::Write as _;

/// The benchmark that measures; a plain program, no suite of criterion.
pub(super) const SUITE: &str = "factor";
const OURS: &str = "this project";
const PAGE: &str = include_str!("factor.md");
const HEADER: &str = "cells,unknowns,method,threads,symbolic_s,numeric_s,solve_s,values";

/// One factorisation.
struct Round {
    cells: String,
    unknowns: usize,
    method: String,
    threads: usize,
    /// Of order and analysis, of the factorisation, of one solve.
    seconds: [f64; 3],
    /// Values that the factor stores.
    stored: usize,
}

/// Measures, and writes page and table.
pub(super) fn run(workspace: &Workspace, command: &str, runs: u32) -> Outcome<()> {
    let load = load_average();
    // faer's threads are a feature that no other build asks for.
    let bench = ["bench", "--package", "tests", "--bench", SUITE, "--features", "faer/rayon"];
    if stream(workspace.cargo(&bench).arg("--no-run"))? != Some(0) {
        return Err(format!("the benchmark {SUITE} does not build"));
    }
    println!("measuring {} rounds", runs + 1);
    let csv = output(workspace.cargo(&bench).arg("--").arg(runs.to_string()))?;
    let rounds = csv.lines().map(parse).collect::<Outcome<Vec<Round>>>()?;
    let machine = Machine::look();
    let more = [("rounds", format!("{runs} after a discarded one")), ("load in the minute before", load)];
    let table = provenance(workspace, &machine, command, &more)?;
    let text = page(&rounds);
    let title = format!("# Factorisation beside faer's, {} on {}", super::today(), machine.slug());
    let files =
        [("factor.md", format!("{title}\n\n{table}\n{text}")), ("factor.csv", format!("{HEADER}\n{csv}"))];
    super::write_all(workspace, &machine, &files)?;
    print!("\n{text}");
    Ok(())
}

fn parse(line: &str) -> Outcome<Round> {
    let fault = || format!("{SUITE}: found `{line}`, expected {HEADER}");
    let fields: [&str; 8] = line.split(',').collect::<Vec<_>>().try_into().map_err(|_| fault())?;
    let whole = |field: &str| field.parse::<usize>().map_err(|_| fault());
    let [cells, unknowns, method, threads, times @ .., stored] = fields;
    let mut seconds = [0.0; 3];
    for (value, field) in seconds.iter_mut().zip(times) {
        *value = field.parse().map_err(|_| fault())?;
    }
    Ok(Round {
        cells: cells.to_owned(),
        unknowns: whole(unknowns)?,
        method: method.to_owned(),
        threads: whole(threads)?,
        seconds,
        stored: whole(stored)?,
    })
}

fn total(round: &Round) -> f64 {
    round.seconds.iter().sum()
}

fn page(rounds: &[Round]) -> String {
    let mut rows = String::new();
    let mut groups: Vec<Vec<&Round>> = vec![];
    for round in rounds {
        let same = |g: &&mut Vec<&Round>| {
            (&g[0].cells, &g[0].method, g[0].threads) == (&round.cells, &round.method, round.threads)
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(round),
            None => groups.push(vec![round]),
        }
    }
    let spread = |group: &[&Round], of: &dyn Fn(&Round) -> f64| {
        spread_of(group.iter().map(|r| of(r)).collect()).unwrap_or([f64::NAN; 3])
    };
    for group in &groups {
        let Round { cells, unknowns, method, threads, stored, .. } = group[0];
        let [symbolic, numeric, solve] = [0, 1, 2].map(|k| time(1e9 * spread(group, &|r| r.seconds[k])[0]));
        let [sum, least, most] = spread(group, &total);
        let ours = groups
            .iter()
            .find(|g| (&g[0].cells, g[0].method.as_str(), g[0].threads) == (cells, OURS, *threads));
        let ratio = ours.map_or("-".to_owned(), |g| format!("{:.2}", sum / spread(g, &total)[0]));
        let _ = writeln!(
            rows,
            "| {cells} | {unknowns} | {method} | {threads} | {symbolic} | {numeric} | {solve} | {} | {} to {} | {stored} | {ratio} |",
            time(1e9 * sum),
            time(1e9 * least),
            time(1e9 * most),
        );
    }
    PAGE.replace("{rows}", &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_medians_and_ratios() {
        let lines = [
            "80x36,5832,this project,1,0.001,0.004,0.001,300",
            "80x36,5832,faer simplicial,1,0.003,0.008,0.001,200",
            "80x36,5832,this project,1,0.001,0.008,0.001,300",
            "80x36,5832,faer simplicial,2,0.003,0.008,0.001,200",
        ];
        let rounds: Vec<Round> = lines.iter().map(|l| parse(l).unwrap()).collect();
        let text = page(&rounds);
        let ours = "| 80x36 | 5832 | this project | 1 | 1.00 ms | 6.00 ms | 1.00 ms | 8.00 ms | 6.00 ms to 10.00 ms | 300 | 1.00 |";
        assert!(text.contains(ours), "{text}");
        assert!(text.contains("| 12.00 ms to 12.00 ms | 200 | 1.50 |\n"), "{text}");
        assert!(text.contains("| faer simplicial | 2 |") && text.contains("| 200 | - |\n"), "{text}");
    }

    #[test]
    fn lines_of_another_form_are_refused() {
        for line in ["", "80x36,5832,this project,1,0.001,0.004,300", "a,b,c,d,e,f,g,h", "a,1,c,1,1,1,1,1,1"]
        {
            assert!(parse(line).is_err(), "{line}");
        }
    }
}
