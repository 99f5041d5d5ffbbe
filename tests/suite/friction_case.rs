//! Friction from a case file.

use case_io::Case;
use certified_contact::nndd::{CoulombSettings, CoulombStatus};
use certified_contact::{Settings, Silent, SolveError, solve, solve_coulomb};
use cre_estimator::Relaxation;

#[test]
fn the_case_with_friction_has_the_figures_of_an_independent_code() {
    let text = include_str!("../cases/tresca.toml");
    let problem = Case::parse(text, "tresca.toml", &[]).unwrap().build().unwrap().0;
    let answer = solve(problem, &Settings::default(), &mut Silent).unwrap();
    assert!(answer.is_certified());
    let results = answer.results.unwrap();
    for (found, expected) in results.energy_norm_squared.iter().zip([0.666934838661, 0.367422533138]) {
        assert!((found - expected).abs() < 1e-9 * expected, "{found}");
    }
    let contact = &results.contacts[0];
    assert!((contact.contact_force / 26.4209920856 - 1.0).abs() < 1e-9);
    let friction = contact.friction.as_ref().unwrap();
    assert!((friction.max_slip / 5.618746904e-3 - 1.0).abs() < 1e-9, "{friction:?}");
    assert_eq!((friction.stick_intervals.len(), friction.slip_intervals.len()), (1, 1));
}

#[test]
fn a_limit_that_is_not_linear_is_noted() {
    let text = include_str!("../cases/tresca.toml").replace("limit = 4.0", "limit = \"4 + x^2\"");
    let case = Case::parse(&text, "tresca.toml", &[]).unwrap();
    let problem = case.build().unwrap().0;
    let notes = case.data_notes(&problem);
    assert!(notes.iter().any(|note| note.starts_with("contact.friction.limit = \"4 + x^2\"")), "{notes:?}");
    let linear = text.replace("4 + x^2", "4 + x");
    let case = Case::parse(&linear, "tresca.toml", &[]).unwrap();
    let problem = case.build().unwrap().0;
    assert!(case.data_notes(&problem).is_empty());
}

#[test]
fn the_cases_with_coulomb_friction_have_the_figures_of_an_independent_code() {
    let text = include_str!("../cases/coulomb.toml");
    let mut settings = CoulombSettings::default();
    (settings.tolerance, settings.max_steps) = (1e-13, 80);
    let best = Relaxation::Tolerance { tolerance: 1e-12, max_steps: 400 };
    for (mu, energies, e_b) in [
        ("0.3", [0.698430686688, 0.354783326205], 0.182607249418),
        ("0.6", [0.682882125647, 0.364235756451], 0.182720275607),
    ] {
        let given = [("contact.friction.mu".to_owned(), mu.to_owned())];
        let problem = Case::parse(text, "coulomb.toml", &given).unwrap().build().unwrap().0;
        let found = solve_coulomb(problem, &settings, best, &mut Silent).unwrap();
        assert_eq!(found.solution.status, CoulombStatus::Converged);
        for (found, expected) in found.results.energy_norm_squared.iter().zip(energies) {
            assert!((found - expected).abs() < 1e-11 * expected, "{found}");
        }
        assert!((found.residual().unwrap() / e_b - 1.0).abs() < 1e-9, "{:?}", found.residual());
        // Nothing of it is a certificate.
        assert!(found.estimate().certificate().is_none());
    }
    let slope = include_str!("../cases/slope.toml");
    let problem = Case::parse(slope, "slope.toml", &[]).unwrap().build().unwrap().0;
    let found =
        solve_coulomb(problem, &CoulombSettings::default(), Relaxation::Steps(2), &mut Silent).unwrap();
    assert!(found.solution.status == CoulombStatus::Converged && found.residual().is_some());
    let steep = [("body.0.body_force".to_owned(), "[6.0, -10.0]".to_owned())];
    let problem = Case::parse(slope, "slope.toml", &steep).unwrap().build().unwrap().0;
    let refused = solve_coulomb(problem, &CoulombSettings::default(), Relaxation::NONE, &mut Silent);
    assert!(matches!(refused, Err(SolveError::OutsideCones { motion }) if motion.load > 0.0));
}

#[test]
fn what_does_not_support_friction_yet_is_refused_in_the_case_file() {
    let refused = |text: &str, words: &str| {
        let error = Case::parse(text, "tresca.toml", &[]).unwrap_err();
        let found = &error.diagnostics[0];
        assert!(found.message.contains(words) && found.message.contains("upper-lower"), "{}", found.message);
        assert!(found.place.is_some() && found.expected.is_some(), "{found:?}");
    };
    let text = include_str!("../cases/coulomb.toml");
    for (more, words) in [
        ("[solver]\nmethod = \"nndd\"\n", "does not support Coulomb friction"),
        ("[solver]\ntheta = 0.5\n", "does not support Coulomb friction"),
        ("[adapt]\ntarget_relative_error = 0.05\n", "no certificate exists"),
    ] {
        refused(&format!("{text}{more}"), words);
    }
}
