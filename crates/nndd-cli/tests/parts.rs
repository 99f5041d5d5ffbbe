//! The parts of the bound must mean what they are called: cases on which an earlier version was wrong.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// Solves a case of `tests/parts` with settings; returns its report.
fn solved(case: &str, settings: &[&str]) -> Value {
    let temp = tempfile::tempdir().unwrap();
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/parts").join(case).with_extension("toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("solve").arg(path).args(["--quiet", "--out", "out"]).current_dir(temp.path());
    settings.iter().for_each(|setting| {
        command.args(["--set", setting]);
    });
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{case}: {}", String::from_utf8_lossy(&output.stderr));
    let report = std::fs::read(temp.path().join("out/report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    parts_add_up(case, &report);
    report
}

fn certificate(report: &Value, key: &str) -> f64 {
    report["certificate"][key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

fn part(report: &Value, key: &str) -> f64 {
    report["certificate"]["parts"][key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

/// The squares of all parts but round-off make the bound without round-off; the iteration has at most η_NNDD.
fn parts_add_up(case: &str, report: &Value) {
    assert_eq!(report["certificate"]["valid"], true, "{case}");
    let (e, round_off) = (certificate(report, "e_cre"), part(report, "round_off"));
    let sum: f64 = ["mesh", "iteration", "contact", "lift", "gap_data", "friction"]
        .map(|key| {
            assert!(part(report, key) >= 0.0, "{case}: {key}");
            part(report, key).powi(2)
        })
        .iter()
        .sum();
    let whole = (e - round_off).powi(2);
    // The difference of two numbers that are nearly equal has their rounding.
    assert!((sum - whole).abs() <= 1e-12 * whole + 8.0 * f64::EPSILON * e * e, "{case}: {sum:e} {whole:e}");
    assert!(part(report, "iteration") <= certificate(report, "eta_nndd"), "{case}");
    assert_eq!(
        report["certificate"]["split"]["discretisation"].as_f64(),
        Some(part(report, "mesh")),
        "{case}"
    );
}

fn notes(report: &Value) -> String {
    report["notes"].as_array().unwrap().iter().filter_map(Value::as_str).collect::<Vec<_>>().join("\n")
}

#[test]
fn stiff_layers_on_soft_ones_have_the_digits_of_double_precision() {
    // The solution is linear in each layer: three soft ones of height 1 and one that is rigid to 8 and 13 digits.
    for (case, contrast, digits) in [("layers_1e8", 1e8, 1e-12), ("layers_1e13_24x16", 1e13, 1e-11)] {
        let report = solved(case, &[]);
        let exact = 1e-3 * 2.0 / (3.0 + 1.0 / contrast);
        let force = report["results"]["contact_force"].as_f64().unwrap();
        assert!((force / exact - 1.0).abs() < digits, "{case}: {force:e} {exact:e}");
        let interval = report["certificate"]["bounds"]["contact_force"].as_array().unwrap();
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
        assert!(low <= exact && exact <= high, "{case}: {interval:?}");
    }
}

#[test]
fn round_off_of_the_iteration_is_in_eta_nndd() {
    // A cell that is 3000 times as stiff as the others: the operators alone say 1.6e-14, the answer was off by 3e-12.
    let report = solved("contrast_1043", &[]);
    assert!(certificate(&report, "eta_nndd") > 1e-13);
    let forces = &report["iterations"][0]["contact_forces"];
    let [first, second] = [0, 1].map(|k| forces[k].as_f64().unwrap());
    assert!((first - second).abs() <= 1e-11 * second, "{first} {second}");
}

#[test]
fn eta_dis_bounds_the_frozen_problem_near_incompressibility() {
    // The error of the frozen problem is at least 7.37e-3 (a finer admissible field).
    assert!(certificate(&solved("etadis_incomp_3049", &[]), "eta_dis") >= 7.37e-3);
}

#[test]
fn what_the_contact_law_leaves_between_the_nodes_is_not_the_iterations() {
    let report = solved("gap_interpolated", &[]);
    assert!(part(&report, "contact") > 5.0 * part(&report, "mesh"));
    assert!(part(&report, "iteration") < 0.01 * part(&report, "contact"));
    let notes = notes(&report);
    assert!(notes.contains("contact law") && !notes.contains("more iterations would"), "{notes}");
    let newton = solved("newton_exact", &[]);
    assert!(part(&newton, "iteration") < 1e-10 * certificate(&newton, "e_cre"));
    assert!(part(&newton, "contact") > 0.1 * certificate(&newton, "e_cre"));
}

#[test]
fn the_lift_goes_to_the_body_where_it_costs_less() {
    let [first, second] = ["first", "second"].map(|body| {
        let imposed = format!("solver.imposed=\"{body}\"");
        let report = solved("lift_bent_1028", &[&imposed]);
        assert!(part(&report, "lift") < part(&report, "mesh"), "{body}: {}", report["certificate"]);
        certificate(&report, "relative")
    });
    assert!(first < 0.6 && second < 0.6, "{first} {second}");
    let report = solved("lift_bent_1028", &[]);
    assert!(part(&report, "iteration") < 1e-3 * part(&report, "lift"));
}

#[test]
fn the_default_relaxation_reaches_what_many_steps_reach() {
    for case in ["sharp_incomp_1069", "sharp_ortho_1174", "sharp_oblique_1092"] {
        let by_default = solved(case, &[]);
        // Hundreds of steps lower the first one by a further half.
        let relaxed = solved(case, &["estimator.relaxation=30"]);
        let [found, best] = [&by_default, &relaxed].map(|report| certificate(report, "e_cre"));
        println!("{case}: {found:.4e}, after 30 steps {best:.4e}");
        assert!(found <= 1.1 * best, "{case}: {found:e} against {best:e}");
        if case == "sharp_incomp_1069" {
            assert!(notes(&by_default).contains("nearly incompressible"), "{}", notes(&by_default));
        }
    }
}
