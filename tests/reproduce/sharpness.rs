//! How sharp the bound is on hard problems, by steps of relaxation.

use crate::page::{head, row};
use certified_contact::{Criterion, Settings, Silent, solve};
use cre_estimator::Relaxation;
use std::error::Error;
use std::fmt::Write as _;
use tests::quadratic::extrapolated;
use tests::run::{certify_with, displacements, newton, prepare};
use tests::sharp::Sharp;

/// Makes the section: effectivities of the default relaxation, of fixed numbers of steps, and by tolerance.
pub(crate) fn section(quick: bool) -> Result<String, Box<dyn Error>> {
    const GAINS: [f64; 6] = [0.1, 0.05, 0.03, 0.02, 0.01, 0.005];
    const STEPS: [usize; 8] = [0, 2, 5, 10, 20, 30, 100, 300];
    let mut names = vec![
        "problem".to_owned(),
        "smallest angle".to_owned(),
        "error/norm".to_owned(),
        "default".to_owned(),
    ];
    names.extend(STEPS.map(|s| format!("{s} steps")));
    names.extend(GAINS.map(|g| format!("gain < {g} (steps)")));
    let mut text = head(&names.iter().map(String::as_str).collect::<Vec<_>>()) + "\n";
    let mut references = String::new();
    for sharp in Sharp::ALL {
        let problem = sharp.problem()?;
        let angle = problem.bodies.iter().map(|b| b.mesh().smallest_angle()).fold(180.0, f64::min);
        let (energies, limit) = extrapolated(&problem, if quick { 2 } else { 3 })?;
        let prepared = prepare(&problem);
        let iterate = newton(&prepared)?;
        let touching = format!("{} of {}", iterate.contact_nodes(), iterate.lambda.len());
        let u = displacements(&prepared, &iterate);
        let [norm, error] = sharp.norm_and_error(&problem, &u);
        if !quick && !((limit / sharp.reference() - 1.0).abs() < 1e-6) {
            return Err(format!("{}: {limit:e} against {:e}", sharp.name(), sharp.reference()).into());
        }
        let mut settings = Settings::default();
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-8 };
        let default = solve(problem.clone(), &settings, &mut Silent)?
            .estimate
            .map_or(f64::NAN, |e| e.unchecked().e_cre);
        let mut cells = vec![
            sharp.name(),
            format!("{angle:.1}"),
            format!("{:.3}", error / norm),
            format!("{:.3}", default / error),
        ];
        for steps in STEPS {
            let e = certify_with(&prepared, &iterate, Relaxation::Steps(steps))?;
            cells.push(format!("{:.3}", e.unchecked().e_cre / error));
        }
        for gain in GAINS {
            let relaxation = Relaxation::Tolerance { tolerance: gain, max_steps: 100 };
            let e = certify_with(&prepared, &iterate, relaxation)?;
            let [a, b] = [0, 1].map(|b: usize| e.pair.bodies[b].relaxation.steps);
            cells.push(format!("{:.3} ({a}, {b})", e.unchecked().e_cre / error));
        }
        let cells: Vec<&dyn std::fmt::Display> = cells.iter().map(|c| c as &dyn std::fmt::Display).collect();
        let _ = writeln!(text, "{}", row(&cells));
        let shown: Vec<String> = energies.iter().map(|e| format!("{e:.8e}")).collect();
        let _ = writeln!(
            references,
            "- {}: touching {touching}, J = {}, limit {limit:.8e}",
            sharp.name(),
            shown.join(", ")
        );
    }
    Ok(format!("## Sharpness by steps of relaxation\n\n{text}\n{references}"))
}
