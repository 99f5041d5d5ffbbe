//! `cargo xtask bench --solids`: contact and certificate of two boxes of tetrahedra beside PARDISO and beside our own factorisation.

use super::machine::{Machine, provenance};
use super::numbers::spread_of;
use super::peers::{LinearAnswer, Pardiso, THREADS, ratio, verdict};
use super::process;
use crate::workspace::{Outcome, Workspace, load_average, output, stream};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

/// Cells along each edge of a box: 1, 20 and 50 thousand nodes.
const CELLS: [usize; 3] = [10, 26, 36];
/// Coarsest boxes of the targets, and those of the target of the certificate.
const COARSEST: usize = 26;
const FINEST: usize = 36;
/// Largest solve over PARDISO's, certificate over our own factorisation, peak memory over PARDISO's.
const SOLVE: f64 = 0.7;
const CERTIFICATE: f64 = 0.7;
const MEMORY: f64 = 1.2;
/// Rounds after the discarded one.
const ROUNDS: usize = 3;
/// No round begins if the page would take longer, seconds.
const LIMIT: f64 = 720.0;
/// The benchmark of the phases; a plain program.
const SUITE: &str = "relaxation";
/// Settings of every run, and of the certificate that is compared.
const SETTINGS: [&str; 2] = ["estimator.every=0", "output.vtu=false"];
const STEPS: &str = "estimator.relaxation=2";
const PAGE: &str = include_str!("solids.md");
/// PARDISO's orders.
const ORDERS: [&str; 2] = ["METIS", "minimum degree"];
const HEADER: &str = "nodes_per_body,round,what,value,unit";

/// What the benchmark of the phases prints, in its order.
const PHASES: [&str; 5] = ["factorisation", "face tractions", "without steps", "step", "distance"];

/// A run of this program.
#[derive(Clone, Copy)]
struct Own {
    /// Seconds: assembly, factorisation and iterations; everything for the certificate; the process.
    solve: f64,
    certificate: f64,
    whole: f64,
    /// Peak of the process, bytes.
    memory: Option<f64>,
}

/// One round on boxes of one size.
struct Round {
    own: Own,
    /// By the place of the order; `None` if it is not run again.
    pardiso: [Option<LinearAnswer>; 2],
    /// Microseconds per node of each of [`PHASES`].
    phases: [f64; 5],
}

/// Everything measured on boxes of one size.
struct Size {
    cells: usize,
    rounds: Vec<Round>,
    /// With the default steps of relaxation, seconds.
    default: f64,
}

/// The case: a box on another one.
fn case(cells: usize) -> String {
    let mut text = "schema = 1\n[model]\nhypothesis = \"solid\"\n".to_owned();
    let bodies = [
        (
            "upper",
            2000,
            1,
            "top",
            "ux = 0.0\nuy = 0.0\nuz = -0.01\n[[body.traction]]\non = \"right\"\nvector = [0.0, 0.0, 10.0]",
        ),
        ("lower", 1000, 0, "bottom", "fixed = true"),
    ];
    for (name, young, ..) in bodies {
        let _ = writeln!(text, "[materials.{name}]\nyoung = {young}.0\npoisson = 0.3");
    }
    for (name, _, height, side, held) in bodies {
        let _ = writeln!(
            text,
            "[[body]]\nname = \"{name}\"\nmaterial = \"{name}\"\ngenerator = {{ kind = \"box\", origin = [0.0, 0.0, {height}.0], \
             size = [1.0, 1.0, 1.0], cells = [{cells}, {cells}, {cells}] }}\n[[body.displacement]]\non = \"{side}\"\n{held}"
        );
    }
    text + "[[contact]]\nbodies = [\"upper\", \"lower\"]\nsurfaces = [\"bottom\", \"top\"]\n"
}

/// Runs all programs on boxes of one size.
struct Runner<'a> {
    workspace: &'a Workspace,
    pardiso: &'a Pardiso<'a>,
    cells: usize,
    case: PathBuf,
    matrix: PathBuf,
}

impl<'a> Runner<'a> {
    /// Writes what the programs read.
    fn new(workspace: &'a Workspace, pardiso: &'a Pardiso<'a>, cells: usize) -> Outcome<Self> {
        let folder = workspace.target.join("peers").join(format!("boxes-{cells}"));
        let (file, matrix) = (folder.join("boxes.toml"), folder.join("stiffness.npz"));
        workspace.write(&file, &case(cells))?;
        pardiso.prepare_boxes(cells, &matrix)?;
        Ok(Self { workspace, pardiso, cells, case: file, matrix })
    }

    fn own(&self, steps: &[&str]) -> Outcome<Own> {
        let settings: Vec<String> = SETTINGS.iter().chain(steps).map(|s| (*s).to_owned()).collect();
        let name = format!("boxes of {} cells", self.cells);
        let (run, report) = process::solve_case(self.workspace, &self.case, &name, &settings, Some(THREADS))?;
        let phase = |key: &str| {
            report["timings"][key].as_f64().ok_or_else(|| format!("{name}: no timing {key} in report.json"))
        };
        Ok(Own {
            solve: phase("assembly")? + phase("factorisation")? + phase("iterations")?,
            certificate: phase("estimate")?,
            whole: run.seconds,
            memory: run.memory.map(|kib| kib * 1024.0),
        })
    }

    fn phases(&self) -> Outcome<[f64; 5]> {
        let arguments = ["1".to_owned(), self.cells.to_string(), "--threads".to_owned(), THREADS.to_string()];
        phases(&output(bench(self.workspace).arg("--").args(arguments))?)
    }

    fn round(&self, wanted: [bool; 2]) -> Outcome<Round> {
        let own = self.own(&[STEPS])?;
        let mut pardiso = [None, None];
        for (k, answer) in pardiso.iter_mut().enumerate().filter(|(k, _)| wanted[*k]) {
            *answer = Some(self.pardiso.solve(&self.matrix, k == 1)?);
        }
        Ok(Round { own, pardiso, phases: self.phases()? })
    }
}

/// The command of the benchmark of the phases.
fn bench(workspace: &Workspace) -> std::process::Command {
    workspace.cargo(&["bench", "--quiet", "--package", "tests", "--bench", SUITE])
}

/// Reads what the benchmark of the phases prints.
fn phases(csv: &str) -> Outcome<[f64; 5]> {
    let mut found = [0.0; 5];
    for (value, name) in found.iter_mut().zip(PHASES) {
        let number = |line: &str| match line.split(',').collect::<Vec<_>>()[..] {
            [_, what, number, _] if what == name => number.parse().ok(),
            _ => None,
        };
        *value = csv.lines().find_map(number).ok_or_else(|| format!("{SUITE}: no line of {name}"))?;
    }
    Ok(found)
}

/// Measures, and writes `solids.md` and `solids.csv`.
///
/// * `quick`: the smallest boxes alone.
pub(super) fn run(workspace: &Workspace, command: &str, quick: bool) -> Outcome<()> {
    let load = load_average();
    if stream(bench(workspace).arg("--no-run"))? != Some(0) {
        return Err(format!("the benchmark {SUITE} does not build"));
    }
    let pardiso = Pardiso::new(workspace)?;
    let start = Instant::now();
    let mut sizes = vec![];
    for &cells in if quick { &CELLS[..1] } else { &CELLS[..] } {
        let runner = Runner::new(workspace, &pardiso, cells)?;
        sizes.push(on_boxes(&runner, &start)?);
    }
    let machine = Machine::look();
    let more = [
        ("threads", format!("{THREADS} for every program")),
        ("Python", pardiso.versions()),
        ("load in the minute before", load),
    ];
    let table = provenance(workspace, &machine, command, &more)?;
    let title = format!("# Solids beside PARDISO, {} on {}", super::today(), machine.slug());
    let tables = tables(&sizes);
    let page = format!("{title}\n\n{table}\n{tables}{PAGE}");
    super::write_all(workspace, &machine, &[("solids.md", page), ("solids.csv", csv(&sizes))])?;
    print!("\n{tables}");
    Ok(())
}

/// Runs the rounds on boxes of one size, as many as there is time for but at least one.
fn on_boxes(runner: &Runner<'_>, start: &Instant) -> Outcome<Size> {
    println!("boxes of {} cells along an edge", runner.cells);
    let default = runner.own(&[])?.certificate;
    let first = runner.round([true; 2])?;
    let seconds = first.pardiso.each_ref().map(|a| a.as_ref().map_or(f64::NAN, |a| a.seconds));
    let wanted = [seconds[0] <= 2.0 * seconds[1], seconds[1] <= 2.0 * seconds[0]];
    let mut rounds: Vec<Round> = vec![];
    let mut longest = 0.0f64;
    for k in 1..=ROUNDS {
        let began = start.elapsed().as_secs_f64();
        if began + longest > LIMIT && !rounds.is_empty() {
            println!("no time for round {k}");
            break;
        }
        println!("round {k} of {ROUNDS}");
        rounds.push(runner.round(wanted)?);
        longest = longest.max(start.elapsed().as_secs_f64() - began);
    }
    Ok(Size { cells: runner.cells, rounds, default })
}

impl Size {
    fn nodes(&self) -> usize {
        (self.cells + 1).pow(3)
    }

    fn spread(&self, of: impl Fn(&Round) -> Option<f64>) -> Option<[f64; 3]> {
        spread_of(self.rounds.iter().filter_map(of).collect())
    }

    /// Our microseconds per node of a phase as seconds of both boxes.
    fn seconds(&self, round: &Round, phase: usize) -> f64 {
        1e-6 * round.phases[phase] * (2 * self.nodes()) as f64
    }

    /// The order in which PARDISO is faster.
    fn better(&self) -> usize {
        let median = |k: usize| {
            self.spread(|r| Some(r.pardiso[k].as_ref()?.seconds)).map_or(f64::INFINITY, |[m, ..]| m)
        };
        usize::from(median(1) < median(0))
    }

    fn paired(&self, both: impl Fn(&Round) -> Option<[f64; 2]>) -> Option<[f64; 3]> {
        ratio(&self.rounds.iter().filter_map(both).collect::<Vec<_>>())
    }
}

/// The targets, the times, and the phases of the certificate.
fn tables(sizes: &[Size]) -> String {
    let mut text = String::from(
        "## Targets\n\n| target | nodes of a body | found | of single rounds | verdict |\n|---|---|---|---|---|\n",
    );
    for size in sizes.iter().filter(|s| s.cells >= COARSEST) {
        let order = size.better();
        let mut line = |what: &str, found: Option<[f64; 3]>, limit: f64| {
            let said = found.map_or("- | - | not measured".to_owned(), |[middle, least, most]| {
                format!("{middle:.2} | {least:.2} to {most:.2} | {}", verdict(middle, limit, true))
            });
            let _ = writeln!(text, "| {what} <= {limit} | {} | {said} |", size.nodes());
        };
        let pardiso = |r: &Round, of: fn(&LinearAnswer) -> Option<f64>| of(r.pardiso[order].as_ref()?);
        let solve = size.paired(|r| Some([r.own.solve, pardiso(r, |a| Some(a.seconds))?]));
        line(&format!("solve / PARDISO ({})", ORDERS[order]), solve, SOLVE);
        if size.cells >= FINEST {
            let own = size.paired(|r| Some([r.own.certificate, size.seconds(r, 0)]));
            line("certificate / our factorisation", own, CERTIFICATE);
        }
        let whole = size.paired(|r| Some([r.own.memory?, pardiso(r, |a| a.process_memory)?]));
        line("peak memory / that of PARDISO's process", whole, MEMORY);
        let alone = size.paired(|r| Some([r.own.memory?, pardiso(r, |a| a.memory)?]));
        line("peak memory / PARDISO's less Python's", alone, MEMORY);
    }
    if sizes.iter().all(|s| s.cells < COARSEST) {
        text.push_str("| of larger boxes | - | - | - | not measured |\n");
    }
    text + &times(sizes) + &of_phases(sizes)
}

/// Median seconds and memory.
fn times(sizes: &[Size]) -> String {
    let mut text = String::from(
        "\n## Times and memory\n\nMedians, seconds and GB.\n\n\
         | nodes of a body | rounds | solve | certificate | with default steps | whole process | memory | PARDISO, METIS | memory \
         | PARDISO, minimum degree | memory | our factorisation | certificate / PARDISO |\n",
    );
    let _ = writeln!(text, "|{}", "---|".repeat(13));
    for size in sizes {
        let number =
            |found: Option<[f64; 3]>| found.map_or("-".to_owned(), |[middle, ..]| format!("{middle:.3}"));
        let own = |of: fn(&Own) -> f64| number(size.spread(|r| Some(of(&r.own))));
        let gb = |bytes: Option<f64>| bytes.map(|b| 1e-9 * b);
        let mut cells = vec![size.nodes().to_string(), size.rounds.len().to_string()];
        cells.extend([
            own(|o| o.solve),
            own(|o| o.certificate),
            format!("{:.3}", size.default),
            own(|o| o.whole),
        ]);
        cells.push(number(size.spread(|r| gb(r.own.memory))));
        for k in 0..2 {
            cells.push(number(size.spread(|r| Some(r.pardiso[k].as_ref()?.seconds))));
            cells.push(number(size.spread(|r| gb(r.pardiso[k].as_ref()?.process_memory))));
        }
        cells.push(number(size.spread(|r| Some(size.seconds(r, 0)))));
        let order = size.better();
        let over = size.paired(|r| Some([r.own.certificate, r.pardiso[order].as_ref()?.seconds]));
        cells.push(over.map_or("-".to_owned(), |[middle, ..]| format!("{middle:.2}")));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// The phases of the certificate, and their ratio to the factorisation.
fn of_phases(sizes: &[Size]) -> String {
    let mut text = String::from(
        "\n## Phases of the certificate\n\nMedian microseconds per node, wall time, and in brackets over our factorisation.\n\n\
         | nodes of a body | our factorisation | face tractions (EET) | set-up of edge stars | a step | distance |\n|---|---|---|---|---|---|\n",
    );
    for size in sizes {
        let mut line = format!("| {} |", size.nodes());
        for k in 0..PHASES.len() {
            let middle = size.spread(|r| Some(r.phases[k])).map_or(f64::NAN, |[m, ..]| m);
            let over = size.paired(|r| Some([r.phases[k], r.phases[0]])).map_or(f64::NAN, |[m, ..]| m);
            let _ = match k {
                0 => write!(line, " {middle:.1} |"),
                _ => write!(line, " {middle:.1} ({over:.2}) |"),
            };
        }
        let _ = writeln!(text, "{line}");
    }
    text
}

fn csv(sizes: &[Size]) -> String {
    let mut text = format!("{HEADER}\n");
    for size in sizes {
        for (k, round) in size.rounds.iter().enumerate() {
            let mut line = |what: &str, value: Option<f64>, unit: &str| {
                if let Some(value) = value {
                    let _ = writeln!(text, "{},{},{what},{value},{unit}", size.nodes(), k + 1);
                }
            };
            line("solve", Some(round.own.solve), "s");
            line("certificate", Some(round.own.certificate), "s");
            line("whole process", Some(round.own.whole), "s");
            line("peak memory", round.own.memory, "bytes");
            for (order, answer) in ORDERS.iter().zip(&round.pardiso) {
                let of = |take: fn(&LinearAnswer) -> Option<f64>| answer.as_ref().and_then(take);
                line(&format!("PARDISO {order}"), of(|a| Some(a.seconds)), "s");
                line(&format!("PARDISO {order} process memory"), of(|a| a.process_memory), "bytes");
                line(&format!("PARDISO {order} memory"), of(|a| a.memory), "bytes");
            }
            for (name, value) in PHASES.iter().zip(round.phases) {
                line(name, Some(value), "us/node");
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(cells: usize, certificate: f64) -> Size {
        let own = Own { solve: 1.0, certificate, whole: 3.0, memory: None };
        let round = || Round { own, pardiso: [None, None], phases: [10.0, 1.0, 4.0, 2.0, 0.5] };
        Size { cells, rounds: vec![round(), round()], default: 9.0 }
    }

    #[test]
    fn phases_are_read_in_their_order() {
        let csv = "nodes,what,microseconds_per_node,over_factorisation\n8,factorisation,9.0,1\n8,face tractions,2.0,0.2\n\
                   8,without steps,3.0,0.3\n8,step,1.0,0.1\n8,distance,0.5,0.1\n";
        assert_eq!(phases(csv), Ok([9.0, 2.0, 3.0, 1.0, 0.5]));
        assert!(phases("8,factorisation,9.0,1\n").is_err());
    }

    #[test]
    fn misses_are_printed_as_misses() {
        // The factorisation of both boxes takes 1.01 s.
        let text = tables(&[size(36, 2.0)]);
        assert!(
            text.contains(
                "| certificate / our factorisation <= 0.7 | 50653 | 1.97 | 1.97 to 1.97 | missed by 182 % |"
            ),
            "{text}"
        );
        assert!(text.contains("| solve / PARDISO (METIS) <= 0.7 | 50653 | - | - | not measured |"), "{text}");
        assert!(
            text.contains("| 50653 | 10.0 | 1.0 (0.10) | 4.0 (0.40) | 2.0 (0.20) | 0.5 (0.05) |"),
            "{text}"
        );
        assert!(tables(&[size(10, 2.0)]).contains("| of larger boxes | - | - | - | not measured |"));
        assert_eq!(csv(&[size(10, 2.0)]).lines().count(), 1 + 2 * (3 + PHASES.len()));
    }

    #[test]
    fn cases_have_two_boxes_and_a_contact() {
        let text = case(26);
        assert_eq!((text.matches("[[body]]").count(), text.matches("cells = [26, 26, 26]").count()), (2, 2));
        assert!(text.parse::<toml::Table>().is_ok());
    }
}
