//! `cargo xtask bench --assemblies`: stacks of blocks and pairs with the friction of Tresca, by the exact method and by the iteration, beside
//! one linear solve of PARDISO with the stiffnesses of as many blocks.

use super::machine::{Machine, provenance};
use super::numbers::spread_of;
use super::peers::{Pardiso, THREADS};
use super::process;
use crate::workspace::{Outcome, Workspace};
use serde_json::Value;
use std::fmt::Write as _;

/// Bodies of the stacks.
const BODIES: [usize; 5] = [2, 4, 8, 16, 32];
/// Rows of all pairs together, about.
const ROWS: [usize; 4] = [100, 500, 2000, 5000];
/// A block has at least this many cells along its sides, and at most the other number from the lower to the upper one.
const CELLS: [usize; 2] = [8, 20];
/// The methods that are timed.
const METHODS: [&str; 2] = ["exact", "nndd"];
/// Settings of every run.
const SETTINGS: [&str; 2] = ["estimator.every=0", "output.vtu=false"];

/// A stack of blocks.
#[derive(Clone, Copy)]
struct Stack {
    bodies: usize,
    cells: [usize; 2],
    friction: bool,
}

/// One run of a method.
#[derive(Clone, Copy)]
struct Timed {
    /// Assembly, factorisation and iterations, and with everything for the certificate.
    solve: f64,
    certified: f64,
    whole: f64,
    /// Passes of the iteration, or active sets tried.
    steps: f64,
}

impl Stack {
    /// The stack with about this many rows; `None` if its blocks would be too coarse.
    fn new(bodies: usize, rows: usize, friction: bool) -> Option<Self> {
        let of_pair = rows / (bodies - 1) / if friction { 2 } else { 1 };
        let along = of_pair.saturating_sub(1) / 2 * 2;
        (along >= CELLS[0]).then(|| Self { bodies, cells: [along, (along / 2).min(CELLS[1])], friction })
    }

    fn rows(self) -> usize {
        (self.bodies - 1) * (self.cells[0] + 1) * if self.friction { 2 } else { 1 }
    }

    /// The case: blocks of 2 m x 1 m, or two strips with square cells. The lowest is clamped, the uppermost pressed down, guided on its left
    /// and pulled up on its right, the others float. With friction the uppermost is pushed aside, and its limit grows along the line, so that
    /// a part slips.
    fn case(self) -> String {
        let [nx, ny] = self.cells;
        let height = if self.bodies == 2 { 2.0 * ny as f64 / nx as f64 } else { 1.0 };
        let pressed = 0.02 * height;
        let mut text = "schema = 1\n".to_owned();
        for (name, young) in [("soft", 1000), ("middle", 1500), ("stiff", 2000)] {
            let _ = writeln!(text, "[materials.{name}]\nyoung = {young}.0\npoisson = 0.3");
        }
        for body in 0..self.bodies {
            let [lowest, uppermost] = [body == 0, body + 1 == self.bodies];
            let material = if lowest {
                "soft"
            } else if uppermost {
                "stiff"
            } else {
                "middle"
            };
            let _ = writeln!(
                text,
                "[[body]]\nname = \"{body}\"\nmaterial = \"{material}\"\ngenerator = {{ kind = \"block\", \
                 origin = [0.0, {:?}], size = [2.0, {height:?}], cells = [{nx}, {ny}] }}",
                body as f64 * height
            );
            if lowest {
                text.push_str("[[body.displacement]]\non = \"bottom\"\nfixed = true\n");
            } else if uppermost {
                let guide = match self.friction {
                    true => format!("ux = {pressed:?}"),
                    false => "[[body.displacement]]\non = \"left\"\nux = 0.0".to_owned(),
                };
                let _ = writeln!(text, "[[body.displacement]]\non = \"top\"\nuy = -{pressed:?}\n{guide}");
                text.push_str("[[body.traction]]\non = \"right\"\nvector = [0.0, 30.0]\n");
            }
        }
        for body in 1..self.bodies {
            let _ = writeln!(
                text,
                "[[contact]]\nbodies = [\"{body}\", \"{}\"]\nsurfaces = [\"bottom\", \"top\"]",
                body - 1
            );
            if self.friction {
                text.push_str("friction = { law = \"tresca\", limit = \"2 + 4*x\" }\n");
            }
        }
        text
    }
}

/// Measures, and writes `scaling.md`, then `assemblies.md`, which needs other programs.
pub(super) fn run(workspace: &Workspace, command: &str, runs: usize) -> Outcome<()> {
    let scaling = super::scaling::table(workspace, runs)?;
    let machine = Machine::look();
    let table = provenance(workspace, &machine, command, &[("rounds", runs.to_string())])?;
    let title = format!("# Scaling of assemblies, {} on {}", super::today(), machine.slug());
    super::write_all(workspace, &machine, &[("scaling.md", format!("{title}\n\n{table}{scaling}"))])?;
    print!("\n{scaling}");
    let pardiso = Pardiso::new(workspace)?;
    let stacks = BODIES.iter().flat_map(|b| ROWS.iter().filter_map(|rows| Stack::new(*b, *rows, false)));
    let pairs = ROWS.iter().filter_map(|rows| Stack::new(2, *rows, true));
    let mut text = heading("Stacks without friction");
    for stack in stacks.chain(pairs) {
        if stack.friction && !text.contains("Tresca") {
            text.push_str(&heading("Pairs with the friction of Tresca"));
        }
        text.push_str(&line(workspace, &pardiso, stack, runs)?);
    }
    let title = format!("# Assemblies and friction, {} on {}", super::today(), machine.slug());
    let page = format!(
        "{title}\n\n{table}\nMedians of interleaved runs, {THREADS} threads, seconds. A stack of blocks of 2 m x 1 m, or two strips \
         with square cells; the lowest is clamped, the uppermost held, the others float. *Solve* is assembly, factorisation and iterations; *certified* has the certificate and \
         the results with it, *whole* the process with its files. PARDISO: analysis, factorisation and one linear solve with the \
         stiffnesses of as many blocks with as many cells, all of them held, as one block-diagonal matrix, in the better of its two orders. *Sets*: active \
         sets that the exact method tried; *passes*: of the iteration, to 1 % of the mesh error.\n{text}"
    );
    super::write_all(workspace, &machine, &[("assemblies.md", page)])?;
    print!("\n{text}");
    Ok(())
}

fn heading(title: &str) -> String {
    format!(
        "\n## {title}\n\n\
         | bodies | cells of each | rows | PARDISO | exact: sets | solve | / PARDISO | certified | whole \
         | iteration: passes | solve | / PARDISO | certified | whole |\n{}\n",
        "|---".repeat(14) + "|"
    )
}

/// Measures one stack, and writes its line of the table.
fn line(workspace: &Workspace, pardiso: &Pardiso<'_>, stack: Stack, runs: usize) -> Outcome<String> {
    let Stack { bodies, cells: [nx, ny], .. } = stack;
    let name = format!("{bodies} bodies, {} rows", stack.rows());
    println!("{name}");
    let case = workspace.target.join("assembly.toml");
    workspace.write(&case, &stack.case())?;
    pardiso.prepare(stack.cells, bodies)?;
    let mut own = [vec![], vec![]];
    let mut others = [vec![], vec![]];
    for _ in 0..runs {
        for (method, found) in METHODS.iter().zip(&mut own) {
            let mut settings = vec![format!("solver.method=\"{method}\"")];
            settings.extend(SETTINGS.map(str::to_owned));
            let (run, report) = process::solve_case(workspace, &case, &name, &settings, Some(THREADS))?;
            found.push(timed(method, &report, run.seconds).ok_or_else(|| format!("{name}: no timings"))?);
        }
        let seconds = pardiso.run(stack.cells)?;
        others.iter_mut().zip(seconds).for_each(|(all, s)| all.push(s));
    }
    let middle = |values: Vec<f64>| spread_of(values).map_or(f64::NAN, |[median, ..]| median);
    let reference = others.map(middle).into_iter().fold(f64::NAN, f64::min);
    let mut text = format!("| {bodies} | {nx}x{ny} | {} | {reference:.3} |", stack.rows());
    for found in own {
        let of = |take: fn(&Timed) -> f64| middle(found.iter().map(take).collect());
        let solve = of(|t| t.solve);
        let _ = write!(
            text,
            " {} | {solve:.3} | {:.2} | {:.3} | {:.3} |",
            of(|t| t.steps),
            solve / reference,
            of(|t| t.certified),
            of(|t| t.whole)
        );
    }
    Ok(text + "\n")
}

/// Reads a report.
fn timed(method: &str, report: &Value, whole: f64) -> Option<Timed> {
    let phase = |key: &str| report["timings"][key].as_f64();
    let solve = phase("assembly")? + phase("factorisation")? + phase("iterations")?;
    let iterations = report["iterations"].as_array()?;
    let steps = match method {
        "exact" => iterations.first()?["qp_iterations"].as_f64()?,
        _ => iterations.len() as f64,
    };
    Some(Timed { solve, certified: solve + phase("estimate")?, whole, steps })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacks_have_about_the_rows_that_are_asked_for() {
        for bodies in BODIES {
            for stack in ROWS.into_iter().filter_map(|rows| Stack::new(bodies, rows, false)) {
                assert!(ROWS.iter().any(|rows| rows.abs_diff(stack.rows()) < 2 * bodies), "{}", stack.rows());
                assert_eq!(stack.case().matches("[[body]]").count(), bodies);
                assert_eq!(stack.case().matches("[[contact]]").count(), bodies - 1);
            }
        }
        assert!(Stack::new(32, 100, false).is_none());
        assert!(
            Stack::new(2, 5000, true).is_some_and(|pair| pair.rows() == 4998 && pair.cells == [2498, 20])
        );
    }
}
