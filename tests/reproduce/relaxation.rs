//! The gain of each step of relaxation, against the best of the space, and the effect of a tolerance.

use crate::effectivity::{Case, enclosure};
use crate::page::{head, row, verdict};
use cre_estimator::Relaxation;
use std::error::Error;
use std::fmt::Write as _;
use tests::effectivity::{Which, course};
use tests::paper;
use tests::run::{certify_with, newton, prepare};

/// Steps until the rest is round-off of the single precision the stars are kept in.
const BEST: Relaxation = Relaxation::Tolerance { tolerance: 1e-6, max_steps: 400 };

/// Makes the section: figures by step, then by tolerance.
pub(crate) fn section(quick: bool) -> Result<String, Box<dyn Error>> {
    Ok(format!("{}\n{}\n{}", steps(quick)?, effectivities(quick)?, tolerances(quick)?))
}

/// `‖τ − σ̂‖` of each body after 0, 1, 2, 3, 8 steps and at the end, at the converged iteration.
fn steps(quick: bool) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## Steps of relaxation\n\n`‖τ − σ̂‖` of each body at the converged iteration; the best is where at most \
         1e-6 is expected to be left to gain, at most 400 steps. Targets of two steps over the best: 1.10 where the solution is smooth, 1.25 in the body with \
         the strong singularity (half open, upper). The last column: the same by another program, written independently of \
         this one, to the digits it printed (EET, one step, two; the best).\n\n",
    );
    let names = [
        "problem",
        "E1/E2",
        "nodes",
        "body",
        "EET",
        "1",
        "2",
        "3",
        "8",
        "best",
        "steps to it",
        "2 / best",
        "target",
        "another program",
    ];
    text += &(head(&names) + "\n");
    let mut cases = vec![
        (Case::signorini(1.0, 0.0, 8)?, [1.1, 1.1], ["", ""]),
        (Case::signorini(1.0, 0.0, 16)?, [1.1, 1.1], ["", ""]),
        (Case::signorini(0.05, 0.0, 16)?, [1.1, 1.1], ["", ""]),
        (
            Case::paper(paper::COARSE)?,
            [1.1, 1.1],
            ["0.498, 0.205, 0.189; 0.174", "0.174, 0.056, 0.053; 0.051"],
        ),
        (Case::paper([36, 18])?, [1.1, 1.1], ["", ""]),
        (
            Case::half_open(1.0, 18)?,
            [1.25, 1.1],
            ["0.695, 0.279, 0.249; 0.199", "0.1025, 0.0328, 0.0313; 0.0300"],
        ),
        (Case::half_open(1.0, 36)?, [1.25, 1.1], ["", ""]),
    ];
    if !quick {
        cases.push((Case::signorini(1.0, 0.0, 32)?, [1.1, 1.1], ["", ""]));
        cases.push((Case::half_open(1.0, 80)?, [1.25, 1.1], ["", ""]));
    }
    for (case, targets, other) in cases {
        let problem = &case.problem;
        let nodes: usize = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
        let prepared = prepare(problem);
        let pair = certify_with(&prepared, &newton(&prepared)?, BEST)?.pair;
        for (b, report) in pair.bodies.iter().map(|body| &body.relaxation).enumerate() {
            let history = &report.energy_history;
            let at = |k: usize| history.get(k).or(history.last()).copied().unwrap_or(f64::NAN).sqrt();
            let best = at(usize::MAX);
            let [eet, one, two, three, eight, last] =
                [0, 1, 2, 3, 8, usize::MAX].map(|k| format!("{:.4}", at(k)));
            let ratio = at(2) / best;
            let cells: [&dyn std::fmt::Display; 14] = [
                &case.name,
                &case.contrast,
                &nodes,
                &["upper", "lower"][b],
                &eet,
                &one,
                &two,
                &three,
                &eight,
                &last,
                &report.steps,
                &format!("{ratio:.3}"),
                &verdict(ratio, targets[b]),
                &other[b],
            ];
            let _ = writeln!(text, "{}", row(&cells));
        }
    }
    Ok(text)
}

/// Makes the table of the effectivity after 0, 1, 2, 3, 8 steps and at the end, beside the figures of another program.
fn effectivities(quick: bool) -> Result<String, Box<dyn Error>> {
    let mut relaxations = [0, 1, 2, 3, 8].map(Relaxation::Steps).to_vec();
    relaxations.push(BEST);
    let mut text = String::from(
        "## Effectivity by steps\n\nOn the exact Signorini problem, where the default criterion stops. The last column: the \
         same by another program, written independently of this one, at the converged iteration (EET, 1, 2, 3 steps; the best).\n\n",
    );
    text += &head(&["E1/E2", "nodes", "EET", "1", "2", "3", "8", "best", "another program"]);
    text += "\n";
    let mut cases = vec![
        (1.0, 8, "4.18, 1.133, 1.067, 1.046; 1.009"),
        (1.0, 16, "4.26, 1.104, 1.046, 1.032; 1.004"),
        (1.0, 32, "4.29, 1.082, 1.028, 1.020"),
        (0.05, 16, "3.59, 1.086, 1.043, 1.030; 1.005"),
    ];
    if !quick {
        cases.push((0.05, 32, ""));
    }
    for (contrast, n, other) in cases {
        let case = Case::signorini(contrast, 0.0, n)?;
        let found = course(case.problem, &case.truth, &relaxations, Which::Stop)?;
        let stop = found.stop().ok_or("the default criterion did not stop")?;
        let mut cells = vec![contrast.to_string(), found.nodes.to_string()];
        cells.extend((0..relaxations.len()).map(|k| enclosure(stop.effectivity(k).unwrap_or([f64::NAN; 2]))));
        let _ = writeln!(text, "| {} | {other} |", cells.join(" | "));
    }
    Ok(text)
}

/// Effectivity and steps for tolerances, at the iteration at which the default criterion stops.
fn tolerances(quick: bool) -> Result<String, Box<dyn Error>> {
    const GAINS: [f64; 7] = [0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005];
    let mut relaxations =
        GAINS.map(|gain| Relaxation::Tolerance { tolerance: gain, max_steps: 100 }).to_vec();
    relaxations.push(BEST);
    let mut text = String::from(
        "## Tolerances of relaxation\n\nEffectivity where the default criterion stops, and in brackets the steps made \
         in both bodies together; relaxation ends if all further steps can be expected to gain less than the fraction at \
         the head of the column, at most after 100 steps.\n\n",
    );
    let mut names = vec!["problem".to_owned(), "E1/E2".to_owned(), "nodes".to_owned()];
    names.extend(GAINS.iter().map(f64::to_string));
    names.push("best".to_owned());
    text += &(head(&names.iter().map(String::as_str).collect::<Vec<_>>()) + "\n");
    let mut cases = vec![
        Case::signorini(1.0, 0.0, 16)?,
        Case::signorini(0.05, 0.0, 16)?,
        Case::signorini(1.0, 0.0, 32)?,
        Case::signorini(0.05, 0.0, 32)?,
        Case::paper(paper::COARSE)?,
        Case::half_open(1.0, 18)?,
        Case::half_open(1.0, 36)?,
    ];
    if !quick {
        cases.push(Case::paper(paper::FINE)?);
        cases.push(Case::half_open(1.0, 80)?);
    }
    for case in cases {
        let found = course(case.problem.clone(), &case.truth, &relaxations, Which::Stop)?;
        let stop = found.stop().ok_or("the default criterion did not stop")?;
        let mut cells = vec![case.name.to_owned(), case.contrast.to_string(), found.nodes.to_string()];
        for k in 0..relaxations.len() {
            let effectivity = stop.effectivity(k).unwrap_or([f64::NAN; 2]);
            cells.push(format!("{} ({})", enclosure(effectivity), stop.steps[k]));
        }
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    Ok(text)
}
