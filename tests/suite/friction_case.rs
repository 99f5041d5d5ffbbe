//! Friction from a case file.

use case_io::Case;
use certified_contact::{Settings, Silent, solve};

#[test]
fn the_case_with_friction_has_the_figures_of_an_independent_code() {
    let text = include_str!("../cases/tresca.toml");
    let problem = Case::parse(text, "tresca.toml", &[]).unwrap().build_problem().unwrap();
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
    let mut case = Case::parse(&text, "tresca.toml", &[]).unwrap();
    let problem = case.build_problem().unwrap();
    let notes = case.data_notes(&problem);
    assert!(notes.iter().any(|note| note.starts_with("contact.friction.limit = \"4 + x^2\"")), "{notes:?}");
    let linear = text.replace("4 + x^2", "4 + x");
    let mut case = Case::parse(&linear, "tresca.toml", &[]).unwrap();
    let problem = case.build_problem().unwrap();
    assert!(case.data_notes(&problem).is_empty());
}

#[test]
fn what_does_not_support_friction_yet_is_refused_in_the_case_file() {
    let text = include_str!("../cases/tresca.toml");
    let refused = |text: &str, words: &str| {
        let error = Case::parse(text, "tresca.toml", &[]).unwrap_err();
        let found = &error.diagnostics[0];
        assert!(found.message.contains(words) && found.message.contains("upper-lower"), "{}", found.message);
        assert!(found.place.is_some() && found.expected.is_some(), "{found:?}");
    };
    refused(
        &format!("{text}[adapt]\ntarget_relative_error = 0.05\n"),
        "adaptive runs do not support friction",
    );
    refused(&format!("{text}[solver]\npath = \"literal\"\n"), "\"literal\" does not support friction");
}
