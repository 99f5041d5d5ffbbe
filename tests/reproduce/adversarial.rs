//! The matrix of promises: random problems with every feature, and whether what was printed of them is true.

use crate::counts::{Counts, name, said};
use crate::page::{head, write};
use crate::{exact, sharpness, solids};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use tests::matrix::{FEATURES, Problem, Promise, Trial};

/// Problems of the whole study, and of a quick one.
const PROBLEMS: [u64; 2] = [20_000, 1_000];
/// Problems between two lines about the progress, after which the tables are written.
const CHUNK: u64 = 500;
/// The table of an interrupted study, or of one that found violations.
const PARTIAL: &str = "partial.md";
/// A finer field measures an error if each body has this many cells.
const FINE: usize = 200;

/// The title above the rows of solid bodies.
const SOLIDS: &str = "## Solids\n\n";

/// Effectivities above this are counted by the part of the bound that is largest.
const LARGE: f64 = 2.0;
/// Features that make bounds large: extreme materials and cells, bent lines, runs that end early.
const EXTREME: [&str; 13] = [
    "nearly incompressible",
    "contrast of moduli",
    "orthotropic material",
    "given stiffness",
    "slivers",
    "far from the origin",
    "bent contact line",
    "early stop",
    "fixed relaxation",
    "theta",
    "no coarse space",
    "corner of two pairs",
    "exact solution is linear",
];

/// Counts of one feature or of all problems.
#[derive(Default)]
struct TableRow {
    problems: usize,
    without: usize,
    counts: Counts,
    /// By the largest part of the bound: how many effectivities are above [`LARGE`].
    large: BTreeMap<&'static str, usize>,
}

impl TableRow {
    fn add(&mut self, trial: &Trial) {
        self.problems += 1;
        self.without += usize::from(trial.measured.is_none() && trial.code != 0);
        let measured = trial.measured.filter(|of| trial.cells[1] >= FINE && of.above_rounding);
        let effectivity = measured.map(|found| found.bound / found.distance);
        self.counts.add(&trial.verdicts, effectivity);
        if let Some((found, _)) = measured.zip(effectivity).filter(|(_, effectivity)| *effectivity > LARGE) {
            *self.large.entry(found.largest).or_default() += 1;
        }
    }

    fn line(&mut self, name: &str) -> String {
        let mut cells = vec![name.to_owned(), self.problems.to_string(), self.without.to_string()];
        cells.extend(self.counts.columns(Promise::ALL.into_iter().map(|(promise, _)| promise)));
        let large: Vec<String> = self.large.iter().map(|(part, count)| format!("{part} {count}")).collect();
        cells.push(large.join(", "));
        format!("| {} |\n", cells.join(" | "))
    }
}

/// The sums over all trials so far.
#[derive(Default)]
struct Found {
    rows: BTreeMap<&'static str, TableRow>,
    all: TableRow,
    /// Problems without an [`EXTREME`] feature.
    ordinary: TableRow,
    runs: usize,
    violations: String,
    count: usize,
    csv: String,
}

impl Found {
    fn add(&mut self, trial: &Trial) {
        self.runs += trial.runs;
        self.all.add(trial);
        if !EXTREME.iter().any(|feature| trial.features.contains(feature)) {
            self.ordinary.add(trial);
        }
        for feature in &trial.features {
            self.rows.entry(feature).or_default().add(trial);
        }
        let [cells, _] = trial.cells;
        let bits: String =
            FEATURES.iter().map(|f| if trial.features.contains(f) { '1' } else { '0' }).collect();
        let digits: Vec<String> = bits
            .as_bytes()
            .chunks(4)
            .map(|four| four.iter().fold(0, |n, b| 2 * n + u32::from(b - b'0')))
            .map(|n| format!("{n:x}"))
            .collect();
        let measured = trial.measured.filter(|found| found.above_rounding);
        let effectivity =
            measured.map_or_else(String::new, |found| format!("{:.2}", found.bound / found.distance));
        let violated = trial.violations().count();
        let _ = writeln!(
            self.csv,
            "{},{cells},{},{},{violated},{effectivity},{}",
            trial.number,
            trial.code,
            trial.verdicts.len(),
            digits.concat()
        );
        for verdict in trial.violations() {
            self.count += 1;
            let (name, said) = (name(verdict.promise), said(verdict));
            let features: Vec<&str> = trial.features.iter().copied().collect();
            let _ =
                writeln!(self.violations, "{},{name},\"{said}\",\"{}\"", trial.number, features.join("; "));
        }
    }

    fn tables(&mut self) -> String {
        let mut names = vec!["feature", "problems", "not certified"];
        names.extend(Promise::ALL.map(|(_, name)| name));
        names.extend(["e_cre/error", "measured", "above 2, by largest part"]);
        let mut text = format!(
            "{} problems, {} runs of solver or certificate, {} verdicts, {} violated.\n\n{}\n",
            self.all.problems,
            self.runs,
            self.all.counts.verdicts(),
            self.count,
            head(&names)
        );
        text += &self.all.line("**all**");
        text += &self.ordinary.line("**ordinary**");
        for feature in FEATURES {
            text += &self.rows.entry(feature).or_default().line(feature);
        }
        text
    }

    fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        let head = "problem,promise,numbers,features\n".to_owned();
        write(folder, "violations.csv", &(head + &self.violations))?;
        let head = "problem,cells,status,verdicts,violated,effectivity,features\n".to_owned();
        write(folder, "runs.csv", &(head + &self.csv))
    }
}

/// Prints the part about solids alone, with what is violated.
pub(crate) fn solids(
    folder: &Path,
    quick: bool,
    problems: Option<u64>,
    family: Option<&'static str>,
) -> Result<(), Box<dyn Error>> {
    println!("{SOLIDS}{}", solids::section(folder, quick, problems, family)?.0);
    Ok(())
}

/// Runs one problem and prints its case file and its verdicts.
pub(crate) fn one(number: u64, folder: &Path) -> Result<(), Box<dyn Error>> {
    let problem = Problem::new(number)?;
    problem.write(folder)?;
    let trial = Trial::new(number)?;
    println!("{}\n{:?}\n{:?} cells", problem.text, trial.features, trial.cells);
    println!("status {}: {}", trial.code, trial.reason);
    for verdict in &trial.verdicts {
        let word = if verdict.holds { "kept" } else { "VIOLATED" };
        println!("{word}: {:?} {}", verdict.promise, verdict.said);
    }
    println!("case.toml and other.toml are in {}", folder.display());
    if trial.violations().next().is_some() { Err("violated".into()) } else { Ok(()) }
}

/// Makes the table, after each part of the problems; writes `runs.csv` and `violations.csv`; fails if anything is violated.
///
/// * `problems`: how many, if not the number of the study.
pub(crate) fn page(folder: &Path, quick: bool, problems: Option<u64>) -> Result<(), Box<dyn Error>> {
    let all = problems.unwrap_or(PROBLEMS[usize::from(quick)]);
    let mut found = Found::default();
    for from in (0..all).step_by(CHUNK as usize) {
        let one = |number: u64| Trial::new(number).map_err(|e| format!("problem {number}: {e}"));
        let trials: Result<Vec<Trial>, String> =
            (from..all.min(from + CHUNK)).into_par_iter().map(one).collect();
        trials?.iter().for_each(|trial| found.add(trial));
        found.write(folder)?;
        write(folder, PARTIAL, &found.tables())?;
    }
    let (layers, more) = exact::section(quick)?;
    let (assemblies, violated) = solids::section(folder, quick, problems, None)?;
    println!("{}\n## Exact solutions\n\n{layers}\n{}", found.tables(), sharpness::section(quick)?);
    println!("\n{SOLIDS}{assemblies}");
    match found.count + more + violated {
        0 => Ok(std::fs::remove_file(folder.join(PARTIAL))?),
        count => Err(format!("{count} violations").into()),
    }
}
