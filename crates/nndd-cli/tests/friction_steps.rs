//! Load steps that leave pairs with friction without load.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/true_numbers").join(name)
}

/// Solves a case, which ends with status 0, and returns its report.
fn solve(name: &str, settings: &[String], folder: &Path) -> Report {
    let out = folder.join("out");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("solve").arg(case(name)).arg("--out").arg(&out).args(["--force", "--quiet"]);
    for setting in settings {
        command.args(["--set", setting]);
    }
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{settings:?}: {said}");
    Report::from_json(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

/// Solves a case with other factors of the press.
fn with_factors(name: &str, factors: &[f64], more: &[&str], folder: &Path) -> Report {
    let steps: Vec<String> = factors.iter().map(|f| format!("{{ factors = {{ press = {f:?} }} }}")).collect();
    let mut settings = vec![format!("step=[{}]", steps.join(", "))];
    settings.extend(more.iter().map(|setting| (*setting).to_owned()));
    let report = solve(name, &settings, folder);
    assert_eq!(report.steps.len(), factors.len());
    report
}

#[test]
fn steps_that_leave_a_friction_pair_without_load_are_certified() {
    let temp = tempfile::tempdir().unwrap();
    for name in ["friction-unload.toml", "friction-lift-stack.toml"] {
        let report = solve(name, &[], temp.path());
        assert!(report.steps.iter().all(|step| step.certificate.as_ref().unwrap().valid), "{name}");
        let [loaded, unloaded] = [0, 1].map(|k: usize| report.steps[k].results.clone());
        assert!(loaded.contact_force.unwrap() > 1.0 && unloaded.contact_force == Some(0.0));
        assert!(unloaded.energy_norm_squared.unwrap().iter().all(|a| *a < 1e-25), "{name}");
        // Nodes that stick leave no slip of round-off, whose friction would be all of the bound.
        assert!(report.steps[1].certificate.as_ref().unwrap().e_cre.unwrap() < 1e-12);
    }
}

#[test]
fn loads_are_taken_off_turned_and_put_back_with_any_law() {
    let temp = tempfile::tempdir().unwrap();
    let laws = ["{ law = \"tresca\", limit = 4.0 }", "{ law = \"tresca\", limit = 0.05 }"];
    for law in laws {
        let law = format!("contact.1.friction={law}");
        for factors in [&[1.0, 0.0, 1.0][..], &[0.5, 1.0, -0.3, 0.0, 0.2], &[1.0, 1e-9, 1e-13, 0.0]] {
            let report = with_factors("friction-lift-stack.toml", factors, &[&law], temp.path());
            let valid = |certificate: Option<&case_io::report::Certificate>| certificate.unwrap().valid;
            assert!(report.steps.iter().all(|step| valid(step.certificate.as_ref())), "{law} {factors:?}");
        }
    }
    // No load is left to compare the friction limit of Coulomb with.
    let law = "contact.1.friction={ law = \"coulomb\", mu = 0.3 }";
    let report = with_factors("friction-lift-stack.toml", &[1.0, -0.3, 1.0], &[law], temp.path());
    assert!(report.steps.iter().all(|step| step.coulomb.as_ref().unwrap().e_b.is_some()));
}

#[test]
fn the_iteration_stops_if_everything_falls_to_zero() {
    let temp = tempfile::tempdir().unwrap();
    let more = [
        "solver={ method = \"nndd\" }",
        "body.0.rigid.0.force=[0.5, -10.0]",
        "body.0.traction=[{ name = \"side\", on = \"right\", vector = [-0.6, 0.0] }]",
    ];
    for factors in [&[1.0, 0.0][..], &[1.0, 0.0, 0.5]] {
        let report = with_factors("friction-unload.toml", factors, &more, temp.path());
        assert!(report.steps.iter().all(|step| step.certificate.as_ref().unwrap().valid), "{factors:?}");
        assert!(report.steps[1].results.energy_norm_squared.as_ref().unwrap().iter().all(|a| *a < 1e-25));
    }
}

#[test]
fn friction_on_both_sides_of_a_corner_is_solved() {
    let temp = tempfile::tempdir().unwrap();
    let cells = |x: usize, y: usize| format!("body.0.generator.cells=[{x}, {y}]");
    for (x, y) in [(2, 1), (1, 1), (3, 2), (4, 4)] {
        for limit in [1e-5, 3e-4, 1e-2] {
            let limit = format!("contact.1.friction={{ law = \"tresca\", limit = {limit:?} }}");
            let settings = [cells(x, y), limit, "materials.m0.poisson=0.3".to_owned()];
            let report = solve("stall-corner-151.toml", &settings, temp.path());
            assert!(report.certificate.unwrap().valid, "{settings:?}");
        }
    }
    assert!(solve("stall-corner-151.toml", &[], temp.path()).certificate.unwrap().valid);
    // A support and a plane impose the slip at the end of one line.
    let limits = ["0.0", "1e-5", "7e-4", "7e-3", "1.0"];
    for limit in limits.map(|s| format!("contact.6.friction={{ law = \"tresca\", limit = {s} }}")) {
        assert!(solve("stall-gridtresca-7.toml", &[limit], temp.path()).certificate.unwrap().valid);
    }
}

#[test]
fn a_floating_body_whose_nodes_are_all_in_contact_has_springs_against_every_motion() {
    let temp = tempfile::tempdir().unwrap();
    assert!(solve("held-tresca7.toml", &[], temp.path()).certificate.unwrap().valid);
    // Nearly incompressible or not.
    let settings = ["materials.m1.poisson=0.3".to_owned(), "materials.m5.poisson=0.3".to_owned()];
    assert!(solve("held-tresca7.toml", &settings, temp.path()).certificate.unwrap().valid);
}
