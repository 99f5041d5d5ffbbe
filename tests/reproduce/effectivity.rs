//! The bound over the true error: every problem, mesh and iteration, and the targets.

use crate::page::{head, median, row, verdict, write};
use crate::relaxation;
use fem_core::interface::ContactProblem;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use tests::blocks::Blocks;
use tests::columns::Columns;
use tests::effectivity::{CONTRASTS, Course, RELAXATIONS, Truth, Which, course};
use tests::{heavy, paper, signorini};

const TWO_STEPS: usize = 1;
const TOLERANCE: usize = 2;
/// How many times more exact the finer solution is if the exact one is not known.
const OVERKILL: f64 = 10.0;
/// The same on the smaller meshes of the problems with targets.
const SHARP_OVERKILL: f64 = 20.0;

type Made = Result<ContactProblem, Box<dyn Error>>;

/// One problem on one mesh.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) contrast: f64,
    pub(crate) problem: ContactProblem,
    pub(crate) truth: Truth<'static>,
}

impl Case {
    fn new(
        name: &'static str,
        contrast: f64,
        problem: Made,
        truth: Truth<'static>,
    ) -> Result<Self, Box<dyn Error>> {
        Ok(Self { name, contrast, problem: problem?, truth })
    }

    /// Reference problem 2, Signorini's with exact solution, on `2n × n` cells per body.
    pub(crate) fn signorini(contrast: f64, k: f64, n: usize) -> Result<Self, Box<dyn Error>> {
        let poisson = if contrast == 0.05 { [0.2, 0.4] } else { [0.3, 0.3] };
        let materials = [(contrast, poisson[0]), (1.0, poisson[1])];
        let name = if k == 0.0 { "Signorini, exact" } else { "Signorini with bending, exact" };
        Self::new(
            name,
            contrast,
            signorini::problem(materials, k, [2 * n, n]),
            Truth::signorini(materials, k),
        )
    }

    fn columns(contrast: f64, n: usize) -> Result<Self, Box<dyn Error>> {
        let columns = Columns::contrast(contrast);
        Self::new("heavy columns, exact", contrast, columns.problem(n), Truth::columns(columns))
    }

    pub(crate) fn paper(cells: [usize; 2]) -> Result<Self, Box<dyn Error>> {
        let factor = if cells[0] <= 36 { SHARP_OVERKILL } else { OVERKILL };
        Self::new("the paper's", 2.0, paper::problem(cells), Truth::Overkill(factor))
    }

    fn blocks(contrast: f64, cells: usize) -> Result<Self, Box<dyn Error>> {
        let problem = Blocks::contrast(contrast).cells(cells).problem();
        Self::new("the paper's loads", contrast, problem, Truth::Overkill(OVERKILL))
    }

    pub(crate) fn half_open(contrast: f64, cells: usize) -> Result<Self, Box<dyn Error>> {
        let problem = Blocks::half_open(contrast).cells(cells).problem();
        let factor = if cells <= 36 && contrast == 1.0 { SHARP_OVERKILL } else { OVERKILL };
        Self::new("half open, singular", contrast, problem, Truth::Overkill(factor))
    }

    fn heavy(n: usize) -> Result<Self, Box<dyn Error>> {
        Self::new("heavy blocks on a slope", 1.8, heavy::problem(0.3, n), Truth::Overkill(OVERKILL))
    }
}

/// Every problem on every mesh.
fn cases(quick: bool) -> Result<Vec<Case>, Box<dyn Error>> {
    let mut all = Vec::new();
    for &c in &CONTRASTS {
        let sizes: &[usize] = match (quick, c == 1.0 || c == 0.05) {
            (true, true) => &[8, 16, 32],
            (true, false) => &[8, 16],
            (false, true) => &[8, 16, 32, 64],
            (false, false) => &[8, 16, 32],
        };
        for &n in sizes {
            all.push(Case::signorini(c, 0.0, n)?);
        }
        all.push(Case::signorini(c, 0.7, 16)?);
        for n in [4, 8, 16] {
            all.push(Case::columns(c, n)?);
        }
        let cells: &[usize] = if quick { &[18] } else { &[18, 36] };
        for &n in cells {
            all.push(Case::blocks(c, n)?);
        }
        for &n in if c == 1.0 { &[18, 36, 80][..] } else { cells } {
            all.push(Case::half_open(c, n)?);
        }
    }
    for cells in [paper::COARSE, [36, 18], paper::FINE] {
        all.push(Case::paper(cells)?);
    }
    for n in [8, 16] {
        all.push(Case::heavy(n)?);
    }
    Ok(all)
}

/// Measures everything; prints the page, writes `effectivity.csv`; fails if a bound is below the error.
pub(crate) fn page(folder: &Path, quick: bool) -> Result<(), Box<dyn Error>> {
    let measured: Vec<(Case, Course)> = cases(quick)?
        .into_iter()
        .map(|case| Ok((course(case.problem.clone(), &case.truth, &RELAXATIONS, Which::Every)?, case)))
        .map(|pair: Result<_, Box<dyn Error>>| pair.map(|(course, case)| (case, course)))
        .collect::<Result<_, _>>()?;
    println!(
        "## Targets\n\nAt the iteration at which the default criterion stops.\n\n{}",
        targets(&measured)
    );
    println!(
        "## Every iteration\n\nLeast / middle / largest of all iterations and meshes.\n\n{}",
        distribution(&measured)
    );
    println!("## Every problem and mesh\n\n{}", meshes(&measured));
    println!("{}", relaxation::section(quick)?);
    write(folder, "effectivity.csv", &csv(&measured))?;
    let (count, below) = count_below(&measured, 0);
    if below > 0 { Err(format!("{below} of {count} bounds are below the true error").into()) } else { Ok(()) }
}

/// Counts the valid bounds, and those that are below one end of the enclosure of the error: below the lower end a bound
/// fails; between the ends the finer solution is not exact enough to tell.
fn count_below(measured: &[(Case, Course)], end: usize) -> (usize, usize) {
    let samples = measured.iter().flat_map(|(_, course)| &course.samples);
    let pairs = samples.flat_map(|s| s.bounds.iter().flatten().map(|bound| (*bound, s.error[end])));
    // Also if one is NaN.
    pairs.fold((0, 0), |(n, below), (bound, error)| (n + 1, below + usize::from(!(bound >= error))))
}

/// The enclosure of the effectivity at the iteration at which the default criterion stops.
fn at_stop(course: &Course, relaxation: usize) -> [f64; 2] {
    course.stop().and_then(|s| s.effectivity(relaxation)).unwrap_or([f64::NAN; 2])
}

fn targets(measured: &[(Case, Course)]) -> String {
    let named = |name: &'static str, contrasts: &'static [f64], least: usize| {
        move |c: &Case, k: &Course| c.name == name && contrasts.contains(&c.contrast) && k.nodes >= least
    };
    type Chosen = Box<dyn Fn(&Case, &Course) -> bool>;
    let rows: [(&str, Chosen, usize, f64); 5] = [
        (
            "Signorini, contrasts 1 and 1/20, from 1,100 nodes, two steps",
            Box::new(named("Signorini, exact", &[1.0, 0.05], 1100)),
            TWO_STEPS,
            1.05,
        ),
        (
            "the same, tolerance-driven",
            Box::new(named("Signorini, exact", &[1.0, 0.05], 1100)),
            TOLERANCE,
            1.02,
        ),
        (
            "the paper's problem, 380 to 5,994 nodes, two steps",
            Box::new(named("the paper's", &[2.0], 0)),
            TWO_STEPS,
            1.2,
        ),
        (
            "half open (singular), contrast 1, two steps",
            Box::new(named("half open, singular", &[1.0], 0)),
            TWO_STEPS,
            1.5,
        ),
        ("the same, tolerance-driven", Box::new(named("half open, singular", &[1.0], 0)), TOLERANCE, 1.3),
    ];
    let mut text = head(&["effectivity of", "target", "largest found", "verdict"]) + "\n";
    for (what, chosen, relaxation, target) in rows {
        let found: Vec<f64> =
            measured.iter().filter(|(c, k)| chosen(c, k)).map(|(_, k)| at_stop(k, relaxation)[1]).collect();
        let worst = found.iter().fold(f64::NEG_INFINITY, |m, x| if x.is_nan() { *x } else { m.max(*x) });
        let _ = writeln!(text, "{}", row(&[&what, &target, &format!("{worst:.3}"), &verdict(worst, target)]));
    }
    for (what, end) in
        [("certainly below the error", 0), ("too near to tell, since the error is only enclosed", 1)]
    {
        let (count, below) = count_below(measured, end);
        let word = if below == 0 { "met" } else { "missed" };
        let what = format!("every bound: {what}");
        let _ = writeln!(text, "{}", row(&[&what, &"none", &format!("{below} of {count}"), &word]));
    }
    text
}

/// Formats the smallest, the middle and the largest effectivity of some samples.
fn spread(courses: &[&Course], relaxation: usize) -> String {
    let all: Vec<[f64; 2]> =
        courses.iter().flat_map(|c| &c.samples).filter_map(|s| s.effectivity(relaxation)).collect();
    let least = all.iter().map(|e| e[0]).fold(f64::INFINITY, f64::min);
    let most = all.iter().map(|e| e[1]).fold(0.0, f64::max);
    let mut middle: Vec<f64> = all.iter().map(|e| 0.5 * (e[0] + e[1])).collect();
    format!("{least:.3} / {:.3} / {most:.3}", median(&mut middle))
}

fn distribution(measured: &[(Case, Course)]) -> String {
    let mut text = head(&[
        "problem",
        "E1/E2",
        "meshes",
        "iterations",
        "EET alone",
        "two steps",
        "tolerance 1e-4",
        "refused",
    ]) + "\n";
    let mut groups: Vec<(&str, f64)> = measured.iter().map(|(c, _)| (c.name, c.contrast)).collect();
    groups.sort_by(|a, b| a.0.cmp(b.0).then(a.1.total_cmp(&b.1)));
    groups.dedup();
    for (name, contrast) in groups {
        let of: Vec<&Course> = measured
            .iter()
            .filter(|(c, _)| c.name == name && c.contrast == contrast)
            .map(|(_, k)| k)
            .collect();
        let samples = || of.iter().flat_map(|c| &c.samples);
        let refused: usize = samples().map(|s| s.bounds.iter().filter(|b| b.is_none()).count()).sum();
        let [eet, two, tolerance] = [0, 1, 2].map(|k| spread(&of, k));
        let cells: [&dyn std::fmt::Display; 8] =
            [&name, &contrast, &of.len(), &samples().count(), &eet, &two, &tolerance, &refused];
        let _ = writeln!(text, "{}", row(&cells));
    }
    text
}

/// Formats an enclosure: one number if both ends agree in the digits shown.
pub(crate) fn enclosure(range: [f64; 2]) -> String {
    let [a, b] = range.map(|x| format!("{x:.3}"));
    if a == b { a } else { format!("{a} to {b}") }
}

fn meshes(measured: &[(Case, Course)]) -> String {
    let names = [
        "problem",
        "E1/E2",
        "nodes",
        "stops at",
        "EET alone",
        "two steps",
        "tolerance 1e-4",
        "steps",
        "reference",
    ];
    let mut text = head(&names) + "\n";
    for (case, course) in measured {
        let [eet, two, tolerance] = [0, 1, 2].map(|k| enclosure(at_stop(course, k)));
        let stop = course.stop();
        let iteration = stop.map_or("-".into(), |s| s.iteration.to_string());
        let steps = stop.map_or("-".into(), |s| s.steps[TOLERANCE].to_string());
        let reference = course.overkill.map_or("exact".into(), |(nodes, relative)| {
            format!("{nodes} nodes, certified {:.2} %", 100.0 * relative)
        });
        let cells: [&dyn std::fmt::Display; 9] = [
            &case.name,
            &case.contrast,
            &course.nodes,
            &iteration,
            &eet,
            &two,
            &tolerance,
            &steps,
            &reference,
        ];
        let _ = writeln!(text, "{}", row(&cells));
    }
    text
}

fn csv(measured: &[(Case, Course)]) -> String {
    let mut text = "problem,contrast,nodes,iteration,stops,error_low,error_high,e_cre_eet,e_cre_two_steps,e_cre_tolerance\n".to_owned();
    for (case, course) in measured {
        for s in &course.samples {
            let bounds: Vec<String> =
                s.bounds.iter().map(|b| b.map_or(String::new(), |b| format!("{b:.9e}"))).collect();
            let _ = writeln!(
                text,
                "\"{}\",{},{},{},{},{:.9e},{:.9e},{}",
                case.name,
                case.contrast,
                course.nodes,
                s.iteration,
                s.stops,
                s.error[0],
                s.error[1],
                bounds.join(",")
            );
        }
    }
    text
}
