//! The stress of the estimator on a tetrahedron, judged by FIAT's Johnson-Mercier element.

use crate::bench::peers::verdict;
use crate::python::{Environment, Group};
use crate::workspace::{Outcome, Workspace, output};
use serde::Deserialize;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// The group of FIAT, and its name in messages.
const FIAT: &str = "FIAT";
const GROUPS: [Group; 1] = [Group {
    name: FIAT,
    tools: &[],
    packages: &[["firedrake-fiat", "2026.10.0"], ["numpy", "2.4.6"], ["scipy", "1.17.1"]],
    hint: "it needs Python 3.10 or newer and the package index",
}];

/// Dimensions of the element, and of its part without divergence.
const DIMENSIONS: [usize; 2] = [42, 30];
/// Largest distance from FIAT's space, relative.
const SAME: f64 = 1e-12;
/// Largest sine of an angle between the spaces without divergence, and error of moments: they round in flat cells.
const ROUNDED: f64 = 1e-11;
/// Largest relative difference to the least energy.
const ENERGY: f64 = 1e-10;

/// What the script says of one cell.
#[derive(Deserialize)]
struct Cell {
    dimension: usize,
    rank: usize,
    asymmetry: f64,
    bend: f64,
    residual: f64,
    dimensions: [usize; 2],
    apart: f64,
    moments: f64,
    missed: f64,
    free: usize,
    sum: f64,
    energy: f64,
    below: [f64; 2],
}

/// A target: its name, the largest figure, and the figure of a cell.
type Limit = (&'static str, f64, fn(&Cell) -> f64);

/// Lets FIAT judge the file of cells in a folder, and returns the tables of the page; a reason if FIAT is not here.
pub(super) fn judge(workspace: &Workspace, folder: &Path) -> Outcome<Result<String, String>> {
    let environment = Environment::make(workspace.target.join("fiat-venv"), &GROUPS);
    if let Some((name, reason)) = environment.missing.first() {
        return Ok(Err(format!("{name}: {reason}")));
    }
    let script = workspace.root.join("xtask").join("peers").join("fiat_element.py");
    let said =
        output(Command::new(environment.python()).arg("-B").arg(script).arg(folder.join("cells.json")))?;
    let cells: Vec<Cell> = serde_json::from_str(said.trim()).map_err(|e| format!("fiat_element.py: {e}"))?;
    Ok(Ok(format!("{}\nPython: {}.\n", page(&cells), environment.versions())))
}

/// The targets with the largest figures of all cells, then a line for each cell.
fn page(cells: &[Cell]) -> String {
    let largest = |of: fn(&Cell) -> f64| cells.iter().map(of).fold(0.0, larger);
    let mut text = "| target | found | verdict |\n|---|---|---|\n".to_owned();
    let whole = cells.iter().all(|c| [c.dimension, c.rank] == [DIMENSIONS[0]; 2]);
    let still = cells.iter().all(|c| c.dimensions == [DIMENSIONS[1]; 2]);
    let unique = cells.iter().all(|c| c.free == 0);
    let said = |holds: bool| if holds { "met" } else { "**missed**" };
    for (what, holds) in [
        (format!("FIAT's element has {} functions, and they are independent", DIMENSIONS[0]), whole),
        (format!("both spaces without divergence have {} dimensions", DIMENSIONS[1]), still),
        ("moments and balance leave nothing free in FIAT's space".to_owned(), unique),
    ] {
        let _ = writeln!(text, "| {what} | {} cells | {} |", cells.len(), said(holds));
    }
    let limits: [Limit; 7] = [
        ("FIAT's functions are symmetric", SAME, |c| c.asymmetry),
        ("FIAT's functions are linear in each part", SAME, |c| c.bend),
        ("the stress lies in FIAT's space", SAME, |c| c.residual),
        ("the spaces without divergence are the same", ROUNDED, |c| c.apart),
        ("the stress has the given moments", ROUNDED, |c| larger(c.moments, c.missed)),
        ("its energy is that of its values", ENERGY, |c| c.sum),
        ("its energy is the least in FIAT's space with these moments in balance", ENERGY, |c| c.energy),
    ];
    for (what, limit, of) in limits {
        let found = largest(of);
        let _ =
            writeln!(text, "| {what}: at most {limit:e} | {found:.1e} | {} |", verdict(found, limit, true));
    }
    text.push_str(
        "\n| cell | distance from FIAT's space | between the spaces | moments | energy | least energy without balance, over ours |\n\
         |---|---|---|---|---|---|\n",
    );
    for (k, c) in cells.iter().enumerate() {
        let _ = writeln!(
            text,
            "| {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.3} to {:.3} |",
            k + 1,
            c.residual,
            c.apart,
            larger(c.moments, c.missed),
            c.energy,
            c.below[0],
            c.below[1]
        );
    }
    text
}

/// The larger one of two numbers; NaN if one of them is.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(residual: f64, free: usize) -> Cell {
        Cell {
            dimension: 42,
            rank: 42,
            asymmetry: 0.0,
            bend: 1e-15,
            residual,
            dimensions: [30, 30],
            apart: 1e-14,
            moments: 1e-15,
            missed: 1e-16,
            free,
            sum: 1e-15,
            energy: 1e-13,
            below: [0.9, 0.99],
        }
    }

    #[test]
    fn misses_are_printed_as_misses() {
        let text = page(&[cell(1e-14, 0), cell(2e-14, 0)]);
        assert!(!text.contains("missed") && text.contains("| 2.0e-14 | met |"), "{text}");
        let text = page(&[cell(2e-12, 0), cell(1e-14, 1)]);
        assert!(text.contains("missed by 100 %") && text.contains("| 2 cells | **missed** |"), "{text}");
        assert!(page(&[cell(f64::NAN, 0)]).contains("| NaN | missed by"));
    }
}
