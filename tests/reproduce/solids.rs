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

/// The rows of both files.
#[derive(Default)]
struct Tables {
    violations: String,
    csv: String,
}

impl Tables {
    fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        let head = "problem,kind,family,promise,numbers\n".to_owned();
        write(folder, "solids-violations.csv", &(head + &self.violations))?;
        let head =
            "problem,kind,family,nodes,pairs,runs,first run,verdicts,violated,effectivity\n".to_owned();
        write(folder, "solids-runs.csv", &(head + &self.csv))
    }
}

/// The sums over all trials of one kind so far.
#[derive(Default)]
struct Found {
    rows: BTreeMap<&'static str, TableRow>,
    all: TableRow,
    count: usize,
}

impl Found {
    fn add(&mut self, kind: &str, trial: &Trial, tables: &mut Tables) {
        let kind = kind.split(',').next().unwrap_or_default();
        self.all.add(trial);
        self.rows.entry(trial.family).or_default().add(trial);
        let violated = trial.violations().count();
        let effectivity = trial.effectivity.map_or_else(String::new, |e| format!("{e:.2}"));
        let certified = trial.refused.as_deref().unwrap_or("certified").replace([',', '"', '\n'], " ");
        let _ = writeln!(
            tables.csv,
            "{},{kind},{},{},{},{},{certified},{},{violated},{effectivity}",
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
            let _ = writeln!(tables.violations, "{},{kind},{},{name},\"{said}\"", trial.number, trial.family);
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
            if let Some(row) = self.rows.get_mut(family) {
                text += &row.line(family);
            }
        }
        text
    }
}

/// Draws a problem, of a family if one is named.
fn drawn(number: u64, family: Option<&'static str>) -> Result<Problem, Box<dyn Error>> {
    match family {
        Some(family) => Problem::of_family(number, family),
        None => Problem::new(number),
    }
}

/// Runs one problem in all ways, and prints its assembly and its verdicts.
pub(crate) fn one(number: u64, family: Option<&'static str>) -> Result<(), Box<dyn Error>> {
    let problem = drawn(number, family)?;
    println!("{problem:#?}");
    let mut violated = false;
    for (kind, judge, _) in KINDS {
        let trial = judge(&problem);
        println!("{kind}: {}: {} nodes, {} pairs; {}", trial.family, trial.nodes, trial.pairs, trial.ended);
        println!("not certified: {:?}, effectivity {:?}", trial.refused, trial.effectivity);
        for verdict in &trial.verdicts {
            let word = if verdict.holds { "kept" } else { "VIOLATED" };
            println!("{word}: {:?} {}", verdict.promise, verdict.said);
        }
        violated |= trial.violations().next().is_some();
    }
    if violated { Err("violated".into()) } else { Ok(()) }
}

/// What is done with a problem: its name, how it is judged, and one of how many problems.
type Kind = (&'static str, fn(&Problem) -> Trial, u64);

/// All kinds of trials.
const KINDS: [Kind; 3] = [
    ("On given meshes", Trial::of, 1),
    ("On the meshes of adaptive runs", Trial::adaptive, 4),
    ("Surfaces that do not match, laid over each other, on the meshes of adaptive runs", Trial::overlaid, 4),
];

/// Makes the tables and writes `solids-runs.csv` and `solids-violations.csv`; returns the section and the number of violations.
///
/// * `problems`: how many on given meshes, if not the number of the study; `family`: the only one, if any.
pub(crate) fn section(
    folder: &Path,
    quick: bool,
    problems: Option<u64>,
    family: Option<&'static str>,
) -> Result<(String, usize), Box<dyn Error>> {
    let all = problems.unwrap_or(PROBLEMS[usize::from(quick)]);
    let (mut text, mut count, mut tables) = (String::new(), 0, Tables::default());
    for (kind, judge, share) in KINDS {
        let mut found = Found::default();
        let all = all / share;
        for from in (0..all).step_by(CHUNK as usize) {
            let one = |number: u64| {
                let problem = drawn(number, family);
                problem.map(|problem| judge(&problem)).map_err(|e| format!("solid problem {number}: {e}"))
            };
            let trials: Result<Vec<Trial>, String> =
                (from..all.min(from + CHUNK)).into_par_iter().map(one).collect();
            trials?.iter().for_each(|trial| found.add(kind, trial, &mut tables));
            tables.write(folder)?;
        }
        text += &format!("{kind}: {}\n", found.table());
        count += found.count;
    }
    Ok((text, count))
}
