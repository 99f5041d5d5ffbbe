//! The best linear solver on the uniform mesh with the error of an adaptive run.

use crate::bench::peers::minimum_degree;
use crate::workspace::{Outcome, Workspace};
use std::fmt::Write as _;

/// Targets, as `adaptivity.csv` writes them, and the problems with the names of the page.
const TARGETS: [&str; 2] = ["0.02", "0.005"];
const PROBLEMS: [(&str, &str); 2] = [("paper", "the paper's problem"), ("hertz", "Hertz")];

/// No mesh has more nodes.
const LARGEST: f64 = 1e9;

/// One mesh of `adaptivity.csv`.
struct Mesh<'a> {
    problem: &'a str,
    /// Empty for a uniform mesh.
    target: &'a str,
    nodes: f64,
    relative: f64,
    seconds: f64,
}

fn meshes(csv: &str) -> Vec<Mesh<'_>> {
    let mesh = |line| {
        let cells: Vec<&str> = str::split(line, ',').collect();
        let number = |k: usize| cells.get(k)?.parse().ok();
        let seconds = number(7).unwrap_or(0.0);
        Some(Mesh {
            problem: cells[0],
            target: cells.get(2)?,
            nodes: number(4)?,
            relative: number(5)?,
            seconds,
        })
    };
    csv.lines().filter_map(mesh).collect()
}

/// Nodes of a uniform mesh with a certified error, by the rate of the two finest ones.
fn uniform_nodes(meshes: &[Mesh<'_>], problem: &str, relative: f64) -> Option<f64> {
    let uniform: Vec<&Mesh<'_>> =
        meshes.iter().filter(|m| m.problem == problem && m.target.is_empty()).collect();
    let [.., a, b] = uniform.as_slice() else { return None };
    let rate = (a.relative / b.relative).ln() / (b.nodes / a.nodes).ln();
    let nodes = b.nodes * (b.relative / relative).powf(1.0 / rate);
    (rate > 0.0 && nodes < LARGEST).then_some(nodes)
}

/// Writes the section of the page.
pub(super) fn section(workspace: &Workspace, csv: &str) -> Outcome<String> {
    let meshes = meshes(csv);
    let (mut rows, mut cells) = (vec![], vec![]);
    for (problem, name) in PROBLEMS {
        for target in TARGETS {
            let of_run = |m: &&Mesh<'_>| m.problem == problem && m.target == target;
            let Some(last) = meshes.iter().rfind(of_run) else { continue };
            let Some(nodes) = uniform_nodes(&meshes, problem, last.relative) else { continue };
            let seconds: f64 = meshes.iter().filter(of_run).map(|m| m.seconds).sum();
            // Two blocks of 2n by n cells have about 4n² nodes.
            let n = (nodes / 4.0).sqrt().round().max(1.0) as usize;
            rows.push((name, target, last, seconds, nodes));
            cells.push([2 * n, n]);
        }
    }
    let mut text = include_str!("peers.md").to_owned();
    let found = match minimum_degree(workspace, &cells) {
        Ok(found) => found,
        Err(error) => return Ok(format!("{text}\nNot measured: {error}\n")),
    };
    for (((name, target, last, ours, nodes), [nx, ny]), (theirs, memory)) in rows.iter().zip(cells).zip(found)
    {
        let _ = writeln!(
            text,
            "| {name} | {target} | {:.5} | {} | {ours:.2} | {nodes:.0} | {nx}x{ny} | {theirs:.2} | {:.2} | {:.2} |",
            last.relative,
            last.nodes,
            memory / 1e9,
            ours / theirs
        );
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_extrapolated_by_the_rate_of_the_finest_meshes() {
        let csv = "problem,kind,target,step,nodes,relative,iterations,seconds\nhertz,uniform,,,50,9e-1,,\n\
                   hertz,uniform,,,100,4e-1,,\nhertz,uniform,,,400,2e-1,,\nhertz,adaptive,0.02,1,90,1e-1,3,0.5\n";
        let meshes = meshes(csv);
        assert_eq!((meshes.len(), meshes[3].target, meshes[3].seconds), (4, "0.02", 0.5));
        assert!(uniform_nodes(&meshes, "hertz", 0.1).is_some_and(|n| (n - 1600.0).abs() < 1e-6));
        assert_eq!(uniform_nodes(&meshes, "paper", 0.1), None);
    }
}
