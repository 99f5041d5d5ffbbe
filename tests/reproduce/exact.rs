//! Layered and slender bodies whose solution the mesh holds, measured in double-double arithmetic.

use crate::page::{head, median};
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use tests::random::Random;
use tests::stacks::{Measured, Stack, random_settings};

/// Runs of each decade of contrast and of each slenderness.
const RUNS: usize = 60;
const RATIOS: [f64; 5] = [10.0, 30.0, 100.0, 300.0, 1000.0];

/// A family and its members.
struct Family {
    name: String,
    found: Vec<Option<Measured>>,
}

fn family(
    name: String,
    seed: u64,
    runs: usize,
    stack: impl Fn(&mut Random) -> Stack + Sync,
) -> Result<Family, Box<dyn Error>> {
    let measure = |run: usize| {
        let mut random = Random::new(seed << 32 ^ run as u64);
        let stack = stack(&mut random);
        Measured::new(&stack, &random_settings(&mut random)).map_err(|e| e.to_string())
    };
    let found: Result<_, String> = (0..runs).into_par_iter().map(measure).collect();
    Ok(Family { name, found: found? })
}

/// Makes the section; the number of violations comes second.
pub(crate) fn section(quick: bool) -> Result<(String, usize), Box<dyn Error>> {
    let runs = if quick { RUNS / 10 } else { RUNS };
    let mut families = Vec::new();
    for decade in 0..=13 {
        let contrast = 10f64.powi(decade);
        families.push(family(format!("layers, contrast 1e{decade}"), decade as u64, runs, |random| {
            Stack::layered(contrast, random)
        })?);
    }
    for (k, ratio) in RATIOS.into_iter().enumerate() {
        families.push(family(format!("slender, L/t = {ratio}"), 100 + k as u64, runs, |random| {
            Stack::slender(ratio, random)
        })?);
    }
    let mut text = head(&[
        "family",
        "runs",
        "without certificate",
        "e_CRE violated",
        "eta_nndd",
        "energy norm",
        "potential energy",
        "contact force",
        "largest error/e_CRE",
        "median error/norm",
        "median e_CRE/error",
    ]) + "\n";
    let mut all = 0;
    for family in &families {
        let found: Vec<&Measured> = family.found.iter().flatten().collect();
        let violations = [0, 1, 2, 3, 4].map(|k: usize| found.iter().filter(|m| m.violations()[k]).count());
        all += violations.iter().sum::<usize>();
        let worst = found.iter().map(|m| m.error / m.e_cre).fold(0.0, f64::max);
        let mut relative: Vec<f64> = found.iter().map(|m| m.error / m.norm).collect();
        let mut effectivity: Vec<f64> = found.iter().map(|m| m.e_cre / m.error).collect();
        let mut cells = vec![
            family.name.clone(),
            family.found.len().to_string(),
            (family.found.len() - found.len()).to_string(),
        ];
        cells.extend(violations.iter().map(usize::to_string));
        cells.extend([
            format!("{worst:.2e}"),
            format!("{:.1e}", median(&mut relative)),
            format!("{:.1e}", median(&mut effectivity)),
        ]);
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    Ok((text, all))
}
