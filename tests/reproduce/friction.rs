//! Random problems with friction of Tresca, each bound against a finer mesh.

use crate::page::{head, median, write};
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use tests::distance::{Outcome, outcome};
use tests::friction::blocks;
use tests::tresca::{KINDS, trial};

/// Problems.
const COUNT: u64 = 560;
/// Every problem with this remainder is compared with a mesh of four times as many cells in each direction, not twice as many.
const FINEST: u64 = 9;

/// Formats the smallest, the middle and the largest effectivity.
fn spread(found: &[[f64; 2]]) -> String {
    let mut all: Vec<f64> = found.iter().filter(|[_, error]| *error > 0.0).map(|[b, e]| b / e).collect();
    let middle = median(&mut all);
    let ends = [all.first(), all.last()].map(|x| x.copied().unwrap_or(f64::NAN));
    format!("{:.3} / {middle:.3} / {:.3}", ends[0], ends[1])
}

/// Makes the tables; writes `friction.csv`; fails if a bound is below the distance.
pub(crate) fn page(folder: &Path, quick: bool) -> Result<(), Box<dyn Error>> {
    let count = if quick { COUNT / 10 } else { COUNT };
    let one = |number: u64| {
        let times = if number % 10 == FINEST { 2 } else { 1 };
        let found = trial(number, times).map_err(|e| format!("{number}: {e}"))?;
        Ok((number, times, found))
    };
    let found: Result<Vec<(u64, usize, Outcome)>, String> = (0..count).into_par_iter().map(one).collect();
    let found = found?;
    let mut table = head(&["kind", "problems", "certified", "violated", "not valid", "effectivity"]) + "\n";
    let mut csv = String::from("number,kind,refinements,bound,distance,reason\n");
    let mut violated = 0;
    for (k, kind) in KINDS.iter().enumerate() {
        let of_kind = found.iter().filter(|(number, ..)| *number as usize % KINDS.len() == k);
        let (mut certified, mut others, mut bad) = (Vec::new(), 0, 0);
        let name = kind.replace(',', "");
        for (number, times, outcome) in of_kind {
            let refinements = if *times == 2 { "4x" } else { "2x" };
            let _ = match outcome {
                Outcome::Certified { bound, error } => {
                    certified.push([*bound, *error]);
                    bad += usize::from(!(bound >= error));
                    writeln!(csv, "{number},{name},{refinements},{bound:e},{error:e},")
                }
                Outcome::NotValid { checks } => {
                    others += 1;
                    let checks: Vec<String> = checks.iter().map(|(c, v)| format!("{c} {v:.1e}")).collect();
                    writeln!(csv, "{number},{name},,,,{}", checks.join("; "))
                }
                Outcome::Refused(message) => {
                    others += 1;
                    writeln!(csv, "{number},{name},,,,{}", message.replace([',', '\n'], ";"))
                }
            };
        }
        violated += bad;
        let _ = writeln!(
            table,
            "| {kind} | {} | {} | {bad} | {others} | {} |",
            certified.len() + others,
            certified.len(),
            spread(&certified)
        );
    }
    let mut rows = head(&["limit s", "bound", "distance to the finer mesh", "effectivity"]) + "\n";
    for s in [1.0, 4.0, 8.0] {
        let problem = blocks([18, 9], fem_core::interface::Friction::tresca(s))?;
        if let Outcome::Certified { bound, error } = outcome(problem, 3)? {
            let _ = writeln!(rows, "| {s} | {bound:.6} | {error:.6} | {:.4} |", bound / error);
        }
    }
    write(folder, "friction.csv", &csv)?;
    println!("## Random problems: {count}\n\n{table}\n## The blocks of the tests\n\n{rows}");
    match violated {
        0 => Ok(()),
        all => Err(format!("{all} violations").into()),
    }
}
