//! What each step of relaxation gains, against the best of the space; and what a tolerance reaches.

use crate::effectivity::{Case, enclosure};
use crate::page::{head, row, verdict};
use cre_estimator::Relaxation;
use std::error::Error;
use std::fmt::Write as _;
use tests::effectivity::{Which, course};
use tests::paper;
use tests::run::{certify_with, condense_both, newton};

/// Steps until the rest is round-off of the single precision the stars are kept in.
const BEST: Relaxation = Relaxation::Tolerance { gain: 1e-6, max_steps: 400 };

/// Makes the section: figures by step, then by tolerance.
pub(crate) fn section(quick: bool) -> Result<String, Box<dyn Error>> {
    Ok(format!("{}\n{}", steps(quick)?, tolerances(quick)?))
}

/// `‖τ − σ̂‖` of each body after 0, 1, 2, 3, 8 steps and at the end, at the converged iteration.
fn steps(quick: bool) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## Steps of relaxation\n\n`‖τ − σ̂‖` of each body at the converged iteration; the best is where a step gains \
         less than 1e-6. Targets of two steps over the best: 1.10 where the solution is smooth, 1.25 in the body \
         with the strong singularity (half open, upper).\n\n",
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
    ];
    text += &(head(&names) + "\n");
    let mut cases = vec![
        (Case::signorini(1.0, 0.0, 8)?, [1.1, 1.1]),
        (Case::signorini(1.0, 0.0, 16)?, [1.1, 1.1]),
        (Case::signorini(0.05, 0.0, 16)?, [1.1, 1.1]),
        (Case::paper(paper::COARSE)?, [1.1, 1.1]),
        (Case::paper([36, 18])?, [1.1, 1.1]),
        (Case::half_open(1.0, 18)?, [1.25, 1.1]),
        (Case::half_open(1.0, 36)?, [1.25, 1.1]),
    ];
    if !quick {
        cases.push((Case::signorini(1.0, 0.0, 32)?, [1.1, 1.1]));
        cases.push((Case::half_open(1.0, 80)?, [1.25, 1.1]));
    }
    for (case, targets) in cases {
        let problem = &case.problem;
        let nodes: usize = problem.bodies.iter().map(|b| b.mesh().points().len()).sum();
        let bodies = condense_both(problem);
        let pair = certify_with(problem, &bodies, &newton(problem, &bodies)?, BEST)?.pair;
        for (b, report) in pair.relaxation.iter().enumerate() {
            let history = &report.energy_history;
            let at = |k: usize| history.get(k).or(history.last()).copied().unwrap_or(f64::NAN).sqrt();
            let best = at(usize::MAX);
            let [eet, one, two, three, eight, last] =
                [0, 1, 2, 3, 8, usize::MAX].map(|k| format!("{:.4}", at(k)));
            let ratio = at(2) / best;
            let cells: [&dyn std::fmt::Display; 13] = [
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
            ];
            let _ = writeln!(text, "{}", row(&cells));
        }
    }
    Ok(text)
}

/// Effectivity and steps for tolerances, at the iteration where the default criterion stops.
fn tolerances(quick: bool) -> Result<String, Box<dyn Error>> {
    const GAINS: [f64; 7] = [0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005];
    let mut relaxations = GAINS.map(|gain| Relaxation::Tolerance { gain, max_steps: 100 }).to_vec();
    relaxations.push(BEST);
    let mut text = String::from(
        "## Tolerances of relaxation\n\nEffectivity where the default criterion stops, and in brackets the steps made \
         in both bodies together; relaxation ends when a step lowers `‖τ − σ̂‖` by less than the fraction at the head of \
         the column.\n\n",
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
