//! How sharp the bound is on hard problems, by steps of relaxation.

use crate::page::{head, row};
use certified_contact::{Criterion, Settings, Silent, solve};
use cre_estimator::Relaxation;
use fem_core::assembly::external_forces;
use fem_core::geometry::dot;
use fem_core::norm::energy_norm_squared;
use std::error::Error;
use std::fmt::Write as _;
use tests::quadratic::extrapolated;
use tests::run::{certify_with, condense_both, displacements, newton};
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
        let bodies = condense_both(&problem);
        let iterate = newton(&problem, &bodies)?;
        let touching = format!("{} of {}", iterate.contact_nodes(), iterate.lambda.len());
        let u = displacements(&bodies, &iterate);
        let (mut norm, mut potential) = (0.0, 0.0);
        for (body, u) in problem.bodies.iter().zip(&u) {
            let a = energy_norm_squared(body, u);
            norm += a;
            potential += 0.5 * a - external_forces(body).iter().zip(u).map(|(f, u)| dot(*f, *u)).sum::<f64>();
        }
        let error = (2.0 * (potential - limit)).sqrt();
        let mut settings = Settings::default();
        settings.criterion = Criterion::EtaNndd { tolerance: 1e-8 };
        let default = solve(problem.clone(), &settings, &mut Silent)?.estimate.map_or(f64::NAN, |e| e.e_cre);
        let mut cells = vec![
            sharp.name(),
            format!("{angle:.1}"),
            format!("{:.3}", error / norm.sqrt()),
            format!("{:.3}", default / error),
        ];
        for steps in STEPS {
            let e = certify_with(&problem, &bodies, &iterate, Relaxation::Steps(steps))?;
            cells.push(format!("{:.3}", e.e_cre / error));
        }
        for gain in GAINS {
            let relaxation = Relaxation::Tolerance { gain, max_steps: 100 };
            let e = certify_with(&problem, &bodies, &iterate, relaxation)?;
            let [a, b] = [0, 1].map(|b: usize| e.pair.relaxation[b].steps);
            cells.push(format!("{:.3} ({a}, {b})", e.e_cre / error));
        }
        let cells: Vec<&dyn std::fmt::Display> = cells.iter().map(|c| c as &dyn std::fmt::Display).collect();
        let _ = writeln!(text, "{}", row(&cells));
        let shown: Vec<String> = energies.iter().map(|e| format!("{e:.8e}")).collect();
        let _ = writeln!(
            references,
            "- {}: touching {touching}, J = {}, limit {limit:.8e}; J(v) {potential:.8e}",
            sharp.name(),
            shown.join(", ")
        );
    }
    Ok(format!("## Sharpness by steps of relaxation\n\n{text}\n{references}"))
}
