//! The messages of the program if the iteration does not converge, or has nothing to measure.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used)]

use case_io::report::Report;
use std::path::Path;
use std::process::Command;

/// Solves an example case with settings; returns its report, and what it said.
fn solved(case: &str, settings: &[&str]) -> (Report, String) {
    let temp = tempfile::tempdir().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(case);
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.current_dir(temp.path()).args(["solve", path.to_str().unwrap(), "--out", "out"]);
    settings.iter().for_each(|setting| {
        command.args(["--set", setting]);
    });
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let report = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
    let report = Report::from_json(&report).unwrap();
    assert_eq!(output.status.code(), Some(i32::from(report.status.code)), "{said}");
    (report, said)
}

fn word(report: &Report) -> (&str, u8) {
    (report.status.word.as_str(), report.status.code)
}

/// The bad case whose tolerance lies below round-off has the default method.
const DEFAULT: &str = "bad/case_below_round_off.toml";

#[test]
fn the_default_method_begins_with_the_papers_and_names_its_newton_steps() {
    let (report, said) = solved(DEFAULT, &["solver.stop.tolerance=1e-8"]);
    assert_eq!(word(&report), ("converged", 0));
    assert_eq!(report.status.reason, "eta_nndd <= 1e-8 eta_nndd(1)");
    let steps: Vec<Option<usize>> = report.iterations.iter().map(|row| row.step).collect();
    assert!(steps[..2] == [None; 2] && steps[2..].iter().all(Option::is_some), "{steps:?}");
    assert!(said.contains("\n   3         - "), "{said}");
    // What belongs to the paper's iteration asks for it.
    for explicit in ["solver.method=nndd", "solver.theta=0.5", "solver.stop.criterion=iterations"] {
        let (report, _) = solved(DEFAULT, &["solver.max_iterations=3", explicit]);
        let iterations = explicit.ends_with("iterations");
        assert_eq!(word(&report), if iterations { ("completed", 0) } else { ("max_iterations", 5) });
        assert!(report.iterations.iter().all(|row| row.step.is_none() && row.theta.is_some()), "{explicit}");
    }
}

#[test]
fn settings_of_the_papers_iteration_choose_it_on_small_assemblies_too() {
    for given in ["theta=0.5", "weights=half", "acceleration=aitken"] {
        let (report, said) = solved("stack.toml", &[&format!("solver.{given}")]);
        assert_eq!(word(&report), ("converged", 0));
        let theta = report.iterations[0].theta.unwrap();
        assert!(report.iterations.len() > 2 && (theta == 0.5) == (given == "theta=0.5"), "{given} {theta}");
        assert!(!said.contains("it ignores"), "{said}");
    }
    // Without them, and with friction whose limit is part of the solution, they are not used.
    let (report, _) = solved("stack.toml", &[]);
    assert!(report.iterations.len() == 1 && report.iterations[0].theta.is_none());
    let (report, _) = solved("coulomb.toml", &["solver.weights=half"]);
    assert!(report.notes.iter().any(|note| note.contains("it ignores `weights`")), "{:?}", report.notes);
}

#[test]
fn a_number_of_iterations_is_completed_even_if_they_stall() {
    let iterations = ["solver.stop.criterion=iterations", "solver.max_iterations=400"];
    let (report, _) = solved(DEFAULT, &iterations);
    assert_eq!(word(&report), ("completed", 0));
    assert!(report.iterations.len() < 400 && report.status.reason.contains("at its round-off floor"));
    // So small a θ changes nothing: no progress far from round-off.
    let (report, _) =
        solved("paper.toml", &[&iterations[..], &["solver.theta=1e-12", "estimator.every=0"]].concat());
    assert_eq!(word(&report), ("completed", 0));
    assert!(report.iterations.len() < 400 && report.status.reason.contains("no longer falling"));
}

#[test]
fn a_theta_that_is_too_small_is_told_the_best_one() {
    let (report, _) = solved("paper.toml", &["solver.theta=1e-300"]);
    assert_eq!(word(&report), ("max_iterations", 5));
    let reason = &report.status.reason;
    assert!(
        reason.contains("theta = 1e-300 is too small: in full contact theta is best near 0.4"),
        "{reason}"
    );
    assert!(!reason.contains("raise"), "{reason}");
}

#[test]
fn a_divergence_with_an_automatic_theta_is_told_what_else_to_set() {
    let settings = [
        "solver.theta=auto",
        "solver.acceleration=anderson",
        "solver.stop.criterion=eta_nndd",
        "materials.stiff.young=1e-3",
        "body.0.traction.0.vector=[0.0,0.3]",
        "estimator.every=0",
        "solver.max_iterations=200",
    ];
    let (report, _) = solved("paper.toml", &settings);
    assert_eq!(word(&report), ("diverged", 5));
    let reason = &report.status.reason;
    // The moduli differ by a million, and so does θ from one.
    assert!(reason.contains("between 0 and 3.43e-6 and is best near 2.14e-6"), "{reason}");
    let advice = "; use weights = \"stiffness\", imposed = \"auto\", or method = \"newton\"";
    assert!(reason.ends_with(advice), "{reason}");
    // Its advice helps, and so does Newton's method.
    for advice in [
        &["solver.weights=stiffness", "solver.imposed=auto"][..],
        &["solver.method=newton"],
        &["solver.method=newton-nn"],
    ] {
        let (report, _) = solved("paper.toml", &[&settings[..], advice].concat());
        assert_eq!(word(&report), ("converged", 0), "{advice:?}: {}", report.status.reason);
    }
}

#[test]
fn bodies_that_hold_no_strain_energy_get_a_word_and_no_percentage() {
    let settings = [
        "body.0.displacement.1.uy=0.5",
        "body.0.traction.0.vector=[0.0,0.0]",
        "solver.stop.criterion=estimator",
    ];
    let (report, said) = solved(DEFAULT, &settings);
    assert_eq!(word(&report), ("converged", 0), "{}", report.status.reason);
    assert!(
        report.certificate.as_ref().unwrap().valid && report.certificate.as_ref().unwrap().relative.is_none()
    );
    assert!(
        said.contains("the bodies hold no strain energy") && !said.contains(" % of the energy norm"),
        "{said}"
    );
    let (report, said) = solved(DEFAULT, &[&settings[..], &["adapt.target_relative_error=0.02"]].concat());
    assert_eq!(word(&report), ("converged", 0), "{}", report.status.reason);
    assert_eq!(report.adaptive.len(), 1);
    assert!(report.status.reason.contains("a relative target has no meaning here"), "{said}");
}

#[test]
fn a_bound_that_is_all_round_off_says_so() {
    let (report, said) = solved("true_numbers/far-displacement.toml", &[]);
    let found = report.certificate.as_ref().unwrap();
    let (bound, round_off) = (found.e_cre.unwrap(), found.parts.round_off.unwrap());
    let norm = report.results.energy_norm_squared.as_ref().unwrap().iter().sum::<f64>().sqrt();
    assert!(
        found.valid && norm > 0.0 && round_off > 0.5 * bound && bound > norm,
        "{bound} {round_off} {norm}"
    );
    assert!(!said.contains("no strain energy") && said.contains("the bound is round-off"), "{said}");
    assert_eq!(found.relative, Some(bound / norm));
    let note = report.notes.iter().find(|note| note.starts_with("the bound is round-off"));
    assert!(note.is_some_and(|note| note.contains("100 % of the bound")), "{:?}", report.notes);
    // No mesh makes such a bound small: the run says so, and does not call it met.
    let (report, said) = solved(
        "true_numbers/far-displacement.toml",
        &["adapt.target_relative_error=0.1", "adapt.max_steps=2"],
    );
    assert!(report.status.code != 0 && !said.contains("no strain energy"), "{said}");
    // The rows of a sweep tell the allowance, and the sentence about them counts the bounds that it makes up.
    let temp = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/true_numbers/far-displacement.toml");
    command.current_dir(temp.path()).arg("sweep").arg(case);
    command.args(["--over", "estimator.relaxation=[1,3]", "--iterations", "1", "--out", "out"]);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("; the bound of 2 of 2 runs is round-off"), "{said}");
    let table = std::fs::read_to_string(temp.path().join("out/sweep.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = |name: &str| head.iter().position(|of| *of == name).unwrap();
    let [bound, allowance] = [column("e_cre"), column("round_off")];
    for row in rows {
        let [bound, allowance] = [bound, allowance].map(|k| row[k].parse::<f64>().unwrap());
        assert!(allowance > 0.5 * bound && allowance <= bound, "{allowance} {bound}");
    }
}

#[test]
fn a_motion_that_pairs_resist_by_rounding_alone_is_free() {
    // The loads along it were balanced by forces of 1e16 times their size: slides of 1e13 m, and a bound that was all round-off.
    let of = |steps: &str| {
        let (report, _) =
            solved("true_numbers/absurd-allowance.toml", &[&format!("solver.max_iterations={steps}")]);
        let found = report.certificate.unwrap();
        assert!(found.valid && found.parts.round_off.unwrap() < 1e-6 * found.e_cre.unwrap());
        report.iterations.last().unwrap().contact_force.unwrap()
    };
    let (near, nearer) = (of("20"), of("40"));
    assert!(near > 0.01 && (near - nearer).abs() < 0.02 * near, "{near} {nearer}");
}

#[test]
fn both_contact_forces_and_the_balance_of_each_body_are_reported() {
    let (report, said) = solved("paper.toml", &[]);
    assert!(said.contains("force_1     force_2"), "{said}");
    let first = &report.iterations[0];
    // From λ = 0 the upper body alone is pressed.
    assert!(first.contact_forces[0].unwrap() > 10.0 && first.contact_forces[1] == Some(0.0));
    let last = report.iterations.last().unwrap();
    assert_eq!(last.contact_forces[1], last.contact_force);
    let balance = report.results.balance.unwrap();
    assert_eq!(balance.len(), 2);
    // The traction alone, 30 N/m, has a moment of 30 N about the centroid, so a missing term shows.
    assert!(balance.iter().flatten().all(|sum| sum.abs() < 1e-10), "{balance:?}");
}
