//! The rows of the matrix of promises for solid bodies: random assemblies by families.

use crate::counts::{Counts, name, said};
use crate::page::{head, write};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use tests::random_solids::{FAMILIES, PROMISES, Problem, Trial};

/// Problems of the whole study, and of a quick one.
const PROBLEMS: [u64; 2] = [4_000, 400];
/// Problems between two writings of the tables.
const CHUNK: u64 = 170;

/// Counts of one family or of all problems.
#[derive(Default)]
struct TableRow {
    problems: usize,
    runs: usize,
    without: usize,
    fields: usize,
    counts: Counts,
}

impl TableRow {
    fn add(&mut self, trial: &Trial) {
        self.problems += 1;
        self.runs += trial.runs;
        self.without += usize::from(trial.refused.is_some());
        self.fields += trial.fields;
        self.counts.add(&trial.verdicts, trial.effectivity);
    }

    fn line(&mut self, name: &str) -> String {
        let mut cells = vec![name.to_owned()];
        cells.extend([self.problems, self.runs, self.without, self.fields].map(|n| n.to_string()));
        cells.extend(self.counts.columns(PROMISES.into_iter()));
        format!("| {} |\n", cells.join(" | "))
    }
}

/// The sums over all trials so far.
#[derive(Default)]
struct Found {
    rows: BTreeMap<&'static str, TableRow>,
    all: TableRow,
    violations: String,
    count: usize,
    csv: String,
}

impl Found {
    fn add(&mut self, trial: &Trial) {
        self.all.add(trial);
        self.rows.entry(trial.family).or_default().add(trial);
        let violated = trial.violations().count();
        let effectivity = trial.effectivity.map_or_else(String::new, |e| format!("{e:.2}"));
        let certified = trial.refused.as_deref().unwrap_or("certified").replace([',', '"', '\n'], " ");
        let _ = writeln!(
            self.csv,
            "{},{},{},{},{},{certified},{},{violated},{effectivity}",
            trial.number,
            trial.family,
            trial.nodes,
            trial.pairs,
            trial.runs,
            trial.verdicts.len(),
        );
        for verdict in trial.violations() {
            self.count += 1;
            let (name, said) = (name(verdict.promise), said(verdict));
            let _ = writeln!(self.violations, "{},{},{name},\"{said}\"", trial.number, trial.family);
        }
    }

    fn table(&mut self) -> String {
        let mut names = vec!["family", "problems", "runs", "not certified", "given fields"];
        names.extend(PROMISES.map(name));
        names.extend(["e_cre/error", "measured"]);
        let mut text = format!(
            "{} problems, {} runs, {} verdicts, {} violated.\n\n{}\n",
            self.all.problems,
            self.all.runs,
            self.all.counts.verdicts(),
            self.count,
            head(&names)
        );
        text += &self.all.line("**all**");
        for family in FAMILIES {
            text += &self.rows.entry(family).or_default().line(family);
        }
        text
    }

    fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        let head = "problem,family,promise,numbers\n".to_owned();
        write(folder, "solids-violations.csv", &(head + &self.violations))?;
        let head = "problem,family,nodes,pairs,runs,first run,verdicts,violated,effectivity\n".to_owned();
        write(folder, "solids-runs.csv", &(head + &self.csv))
    }
}

/// Runs one problem and prints its assembly and its verdicts.
pub(crate) fn one(number: u64) -> Result<(), Box<dyn Error>> {
    let problem = Problem::new(number)?;
    println!("{problem:#?}");
    let trial = Trial::of(&problem);
    println!("{}: {} nodes, {} pairs; {}", trial.family, trial.nodes, trial.pairs, trial.ended);
    println!("not certified: {:?}, effectivity {:?}", trial.refused, trial.effectivity);
    for verdict in &trial.verdicts {
        let word = if verdict.holds { "kept" } else { "VIOLATED" };
        println!("{word}: {:?} {}", verdict.promise, verdict.said);
    }
    if trial.violations().next().is_some() { Err("violated".into()) } else { Ok(()) }
}

/// Makes the table and writes `solids-runs.csv` and `solids-violations.csv`; returns the section and the number of violations.
///
/// * `problems`: how many, if not the number of the study.
pub(crate) fn section(
    folder: &Path,
    quick: bool,
    problems: Option<u64>,
) -> Result<(String, usize), Box<dyn Error>> {
    let all = problems.unwrap_or(PROBLEMS[usize::from(quick)]);
    let mut found = Found::default();
    for from in (0..all).step_by(CHUNK as usize) {
        let one = |number: u64| Trial::new(number).map_err(|e| format!("solid problem {number}: {e}"));
        let trials: Result<Vec<Trial>, String> =
            (from..all.min(from + CHUNK)).into_par_iter().map(one).collect();
        trials?.iter().for_each(|trial| found.add(trial));
        found.write(folder)?;
    }
    Ok((found.table(), found.count))
}
