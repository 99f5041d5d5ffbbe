//! Uniform against adaptive meshes: rates, nodes needed for a certified error, cost of a run over its last step's.

use crate::figure::{Line, log_log};
use crate::page::{head, row, verdict, write};
use certified_contact::{
    AdaptSettings, CertifiedSolution, Imposed, Observer, Phase, Settings, Silent, Step, solve,
    solve_adaptively,
};
use fem_core::interface::ContactProblem;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;
use tests::blocks::Blocks;
use tests::{finer, hertz, paper};

/// The phases of a step, in the order of [`Watch::steps`].
const PHASES: [(Phase, &str); 5] = [
    (Phase::Refinement, "refinement"),
    (Phase::Assembly, "assembly"),
    (Phase::Factorisation, "factorisation"),
    (Phase::Iterations, "iterations"),
    (Phase::Estimate, "estimate"),
];
/// Runs of which the one of the median time is shown.
const RUNS: usize = 3;

/// Wall times of an adaptive run, by mesh and phase.
struct Watch {
    switched: Instant,
    phase: Phase,
    /// Of the present step, s.
    present: [f64; PHASES.len()],
    /// Of the steps before.
    steps: Vec<[f64; PHASES.len()]>,
}

impl Watch {
    fn new() -> Self {
        Self { switched: Instant::now(), phase: Phase::Assembly, present: [0.0; 5], steps: vec![] }
    }

    fn switch(&mut self, phase: Phase) {
        for (seconds, _) in self.present.iter_mut().zip(PHASES).filter(|(_, (p, _))| *p == self.phase) {
            *seconds += self.switched.elapsed().as_secs_f64();
        }
        (self.switched, self.phase) = (Instant::now(), phase);
    }
}

impl Observer for Watch {
    fn phase(&mut self, phase: Phase) {
        self.switch(phase);
    }

    fn step(&mut self, _step: &Step, _solution: &CertifiedSolution) {
        self.switch(self.phase);
        self.steps.push(std::mem::take(&mut self.present));
    }
}

/// One mesh of a study.
struct Point {
    nodes: usize,
    relative: f64,
}

/// An adaptive run with its times.
struct Run {
    target: f64,
    points: Vec<Point>,
    iterations: Vec<usize>,
    /// Of each step by phase, refining included, s.
    phases: Vec<[f64; PHASES.len()]>,
    met: bool,
}

impl Run {
    fn of(problem: ContactProblem, target: f64) -> Result<(Self, CertifiedSolution), Box<dyn Error>> {
        let mut watch = Watch::new();
        let answer =
            solve_adaptively(problem, &Settings::default(), &AdaptSettings::new(target), &mut watch)?;
        let point = |s: &Step| Point { nodes: s.nodes, relative: s.relative.unwrap_or(f64::NAN) };
        let met = answer.solution.is_certified() && answer.solution.relative().is_some_and(|r| r <= target);
        let iterations = answer.history.iter().map(|s| s.iterations).collect();
        let points = answer.history.iter().map(point).collect();
        Ok((Self { target, points, iterations, phases: watch.steps, met }, answer.solution))
    }

    /// The run of the median time of a few.
    fn median(problem: &ContactProblem, target: f64) -> Result<(Self, CertifiedSolution), Box<dyn Error>> {
        let runs = (0..RUNS).map(|_| Self::of(problem.clone(), target));
        let mut runs = runs.collect::<Result<Vec<_>, _>>()?;
        runs.sort_by(|(a, _), (b, _)| a.whole().total_cmp(&b.whole()));
        Ok(runs.swap_remove(RUNS / 2))
    }

    /// Of each step, s.
    fn seconds(&self) -> Vec<f64> {
        self.phases.iter().map(|step| step.iter().sum()).collect()
    }

    /// Of all steps, s.
    fn whole(&self) -> f64 {
        self.seconds().iter().sum()
    }

    fn nodes(&self) -> usize {
        self.points.last().map_or(0, |p| p.nodes)
    }

    /// Computes the ratio of the whole run's time to the last step's, which includes the refining of its mesh.
    fn cost(&self) -> f64 {
        self.whole() / self.seconds().last().copied().unwrap_or(f64::NAN)
    }

    /// Computes the ratios of the numbers of nodes from each mesh to the next one.
    fn growth(&self) -> Vec<f64> {
        self.points.windows(2).map(|w| w[1].nodes as f64 / w[0].nodes as f64).collect()
    }
}

/// The observed rate `r` of `e ~ N^(-r)` between two meshes.
fn rate(a: &Point, b: &Point) -> f64 {
    (a.relative / b.relative).ln() / (b.nodes as f64 / a.nodes as f64).ln()
}

/// A problem, its uniform meshes, and its targets with the most nodes allowed.
struct Study {
    name: &'static str,
    file: &'static str,
    meshes: Vec<ContactProblem>,
    targets: Vec<(f64, Option<usize>)>,
    /// The slope drawn beside the uniform meshes, and what is known of their rate.
    uniform: (f64, &'static str),
}

fn studies(quick: bool) -> Result<Vec<Study>, Box<dyn Error>> {
    let sizes: &[usize] = if quick { &[18, 36, 72] } else { &[18, 36, 72, 144] };
    // The same polygons on every mesh.
    let mut discs = vec![hertz::problem(1.5, 15, 0.4)?];
    for _ in 2..sizes.len() {
        discs.push(finer::halve(&discs[discs.len() - 1])?.problem);
    }
    let of = |problem: &dyn Fn(usize) -> Result<ContactProblem, Box<dyn Error>>| {
        sizes.iter().map(|&n| problem(n)).collect::<Result<Vec<_>, _>>()
    };
    let mut targets = vec![(0.05, None), (0.02, Some(40_000)), (0.01, Some(150_000))];
    if !quick {
        targets.push((0.005, None));
    }
    Ok(vec![
        Study {
            name: "The paper's problem",
            file: "paper",
            meshes: of(&|n| paper::problem([n, n / 2]))?,
            targets: targets.clone(),
            uniform: (0.5, "below 0.5, since the corners are weakly singular"),
        },
        Study {
            name: "Hertz: two half discs, `nndd new hertz`",
            file: "hertz",
            meshes: discs,
            targets: targets.iter().map(|(target, _)| (*target, None)).collect(),
            uniform: (0.5, "about 0.5; the ends of the flats are weakly singular"),
        },
        Study {
            name: "Half open: a strong singularity where the pressed part of the top ends",
            file: "half-open",
            meshes: of(&|n| Blocks::half_open(1.0).cells(n).problem())?,
            targets,
            uniform: (0.25, "0.25 in the limit"),
        },
    ])
}

/// Runs everything; prints the page, writes `adaptivity.csv` and one figure per problem.
pub(crate) fn page(folder: &Path, quick: bool) -> Result<(), Box<dyn Error>> {
    let mut csv = "problem,kind,target,step,nodes,relative,iterations,seconds\n".to_owned();
    for study in studies(quick)? {
        let uniform: Vec<Point> =
            study.meshes.iter().map(|p| uniform_point(p.clone())).collect::<Result<_, _>>()?;
        for p in &uniform {
            let _ = writeln!(csv, "{},uniform,,,{},{:.6e},,", study.file, p.nodes, p.relative);
        }
        let first = &study.meshes[0];
        let mut runs = Vec::new();
        let mut last_alone = Vec::new();
        for &(target, _) in &study.targets {
            let (run, solution) = Run::median(first, target)?;
            last_alone.push(alone(solution)?);
            for (k, p) in run.points.iter().enumerate() {
                let _ = writeln!(
                    csv,
                    "{},adaptive,{target},{},{},{:.6e},{},{:.4}",
                    study.file,
                    k + 1,
                    p.nodes,
                    p.relative,
                    run.iterations[k],
                    run.seconds()[k]
                );
            }
            runs.push(run);
        }
        println!("## {}\n", study.name);
        println!("{}", needed(&study, &runs, &last_alone));
        println!("{}", shares(&runs));
        println!("{}", rates(&study, &uniform, &runs));
        println!(
            "![Certified error against nodes]({}.svg)\n\nThin lines: the slope -1/2 through the last adaptive mesh, -{} through the last uniform one.\n",
            study.file, study.uniform.0
        );
        let lines = figure_lines(&uniform, &runs, study.uniform.0);
        let svg = log_log(study.name, ["nodes of both bodies", "certified relative error"], &lines)?;
        write(folder, &format!("{}.svg", study.file), &svg)?;
    }
    write(folder, "adaptivity.csv", &csv)
}

fn uniform_point(problem: ContactProblem) -> Result<Point, Box<dyn Error>> {
    let solution = solve(problem, &Settings::default(), &mut Silent)?;
    let relative =
        solution.relative().filter(|_| solution.is_certified()).ok_or("a uniform mesh is not certified")?;
    Ok(Point { nodes: solution.problem.bodies.iter().map(|b| b.mesh().points().len()).sum(), relative })
}

/// Solves and certifies the last mesh of a run once more, from λ = 0 and knowing nothing, s.
fn alone(solution: CertifiedSolution) -> Result<f64, Box<dyn Error>> {
    let problem = solution.problem;
    let mut settings = Settings::default();
    settings.imposed = Imposed::First;
    let started = Instant::now();
    let again = solve(problem, &settings, &mut Silent)?;
    let seconds = started.elapsed().as_secs_f64();
    if again.is_certified() { Ok(seconds) } else { Err("the last mesh alone is not certified".into()) }
}

fn needed(study: &Study, runs: &[Run], alone: &[f64]) -> String {
    let names = [
        "target",
        "certified",
        "nodes",
        "allowed",
        "verdict",
        "steps",
        "growth per step",
        "whole run, s",
        "/ last step",
        "/ last mesh alone",
        "whole run ≤ 2 last steps",
    ];
    let mut text = head(&names) + "\n";
    for ((run, (_, allowed)), alone) in runs.iter().zip(&study.targets).zip(alone) {
        let verdict_of_nodes = match (run.met, allowed) {
            (false, _) => "missed: target not reached".into(),
            (true, None) => "met".into(),
            (true, Some(allowed)) => verdict(run.nodes() as f64, *allowed as f64),
        };
        let growth = run.growth();
        let range = [
            growth.iter().copied().fold(f64::INFINITY, f64::min),
            growth.iter().copied().fold(0.0, f64::max),
        ];
        let certified = run.points.last().map_or(f64::NAN, |p| p.relative);
        let whole = run.whole();
        let _ = writeln!(
            text,
            "{}",
            row(&[
                &run.target,
                &format!("{certified:.5}"),
                &run.nodes(),
                &allowed.map_or("-".to_owned(), |n| n.to_string()),
                &verdict_of_nodes,
                &run.points.len(),
                &format!("{:.2} to {:.2}", range[0], range[1]),
                &format!("{whole:.2}"),
                &format!("{:.2}", run.cost()),
                &format!("{:.2}", whole / alone),
                &verdict(run.cost(), 2.0),
            ])
        );
    }
    text
}

/// Makes the table of the shares of the runs' time: the last mesh, and all earlier ones together.
fn shares(runs: &[Run]) -> String {
    let mut names = vec!["% of the whole run: target", "meshes"];
    names.extend(PHASES.map(|(_, name)| name));
    let mut text = head(&names) + "\n";
    for run in runs {
        let Some((last, earlier)) = run.phases.split_last() else { continue };
        for (which, steps) in [("earlier", earlier), ("last", std::slice::from_ref(last))] {
            let share = |k: usize| 100.0 * steps.iter().map(|step| step[k]).sum::<f64>() / run.whole();
            let shares: Vec<String> = (0..PHASES.len()).map(|k| format!("{:.1}", share(k))).collect();
            let mut cells: Vec<&dyn std::fmt::Display> = vec![&run.target, &which];
            cells.extend(shares.iter().map(|s| s as &dyn std::fmt::Display));
            let _ = writeln!(text, "{}", row(&cells));
        }
    }
    text
}

fn rates(study: &Study, uniform: &[Point], runs: &[Run]) -> String {
    let mut text = head(&["uniform: nodes", "certified relative error", "rate in N"]) + "\n";
    for (k, p) in uniform.iter().enumerate() {
        let r = if k == 0 { "-".into() } else { format!("{:.3}", rate(&uniform[k - 1], p)) };
        let _ = writeln!(text, "{}", row(&[&p.nodes, &format!("{:.5}", p.relative), &r]));
    }
    let Some(longest) = runs.last() else { return text };
    text += "\n";
    text += &(head(&["adaptive: nodes", "certified relative error", "rate in N", "iterations", "s"]) + "\n");
    for (k, p) in longest.points.iter().enumerate() {
        let r = if k == 0 { "-".into() } else { format!("{:.3}", rate(&longest.points[k - 1], p)) };
        let cells: [&dyn std::fmt::Display; 5] = [
            &p.nodes,
            &format!("{:.5}", p.relative),
            &r,
            &longest.iterations[k],
            &format!("{:.3}", longest.seconds()[k]),
        ];
        let _ = writeln!(text, "{}", row(&cells));
    }
    // From about 1500 nodes on: before, the singularities are still being cut out.
    let late: Vec<&Point> = longest.points.iter().filter(|p| p.nodes > 1500).collect();
    if let (Some(a), Some(b), [.., c, d]) = (late.first(), late.last(), uniform) {
        let adaptive = rate(a, b);
        let _ = writeln!(
            text,
            "\nRate of the adaptive meshes from {} nodes on: {adaptive:.3} (the best of linear triangles is 0.5: {}); of \
             the two finest uniform meshes: {:.3} (expected: {}).",
            a.nodes,
            verdict(0.5, adaptive / 0.95),
            rate(c, d),
            study.uniform.1
        );
    }
    text
}

fn figure_lines(uniform: &[Point], runs: &[Run], uniform_rate: f64) -> Vec<(Line, f64)> {
    let points = |p: &[Point]| p.iter().map(|p| (p.nodes as f64, p.relative)).collect();
    let mut lines = vec![(Line { name: "uniform".into(), points: points(uniform) }, -uniform_rate)];
    if let Some(run) = runs.last() {
        let name = format!("adaptive, target {}", run.target);
        lines.push((Line { name, points: points(&run.points) }, -0.5));
    }
    lines
}
