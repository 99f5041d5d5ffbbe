//! Geometry of contact sides from case files: arcs that continue straight sides, pins that may spin, sides that end apart.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::Path;
use std::process::Command;

/// Solves a case with settings, and returns its report and what was said.
///
/// * `name`: of a file in `tests/cases`, or an absolute path.
fn solved(name: &str, settings: &[&str]) -> (Report, String) {
    let here = tempfile::tempdir().unwrap();
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(name);
    let mut program = Command::new(env!("CARGO_BIN_EXE_nndd"));
    program.current_dir(here.path()).arg("solve").arg(case).args(["--out", "out"]);
    settings.iter().for_each(|setting| {
        program.args(["--set", setting]);
    });
    let output = program.output().unwrap();
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let report = std::fs::read_to_string(here.path().join("out/report.json"));
    let report = report.unwrap_or_else(|_| panic!("no report: {said}"));
    (Report::from_json(&report).unwrap(), said)
}

/// The largest mean pressure of an edge.
fn peak(report: &Report) -> f64 {
    report.results.max_edge_pressure.unwrap()
}

#[test]
fn the_pressure_at_rounded_edges_is_that_of_the_arcs() {
    let (report, said) = solved("true_numbers/rounded-punch/rp.toml", &[]);
    assert_eq!(report.status.word, "converged", "{said}");
    // Ciavarella 1998.
    assert!((peak(&report) / 829.487 - 1.0).abs() < 0.03, "{}", peak(&report));
    let (report, said) = solved("true_numbers/dovetail/dove2.toml", &[]);
    assert_eq!(report.status.word, "converged", "{said}");
    // The kink of the first mesh made 3285 of it.
    assert!(peak(&report) < 2000.0, "{}", peak(&report));
    assert!(!said.contains("too short"), "{said}");
}

#[test]
fn a_side_that_ends_at_the_tangent_point_is_called_too_short() {
    let (_, said) = solved("true_numbers/dovetail/dove.toml", &["adapt.target_relative_error=0.1"]);
    assert!(said.contains("is a contact side too short?"), "{said}");
    // A stamp that ends at corners is as long as it should be.
    let (_, said) = solved("punch_corner.toml", &[]);
    assert!(!said.contains("too short"), "{said}");
}

#[test]
fn sides_may_end_at_any_offset() {
    for offset in ["1e-9", "1e-5", "0.0005", "0.003", "0.0049", "0.02"] {
        let origin = format!("body.0.generator.origin=[{offset}, 1.0]");
        let (report, said) = solved("true_numbers/ends-offset.toml", &[&origin]);
        assert_eq!(report.status.word, "converged", "{offset}: {said}");
        assert!(report.certificate.unwrap().valid, "{offset}");
    }
}

#[test]
fn a_pin_that_may_spin_is_certified_on_finer_meshes() {
    let target = "adapt.target_relative_error=0.04";
    for name in ["true_numbers/pin-free/lug2.toml", "true_numbers/pin-free/pin_arc.toml"] {
        let (report, said) = solved(name, &[target]);
        assert_eq!(report.status.word, "converged", "{name}: {said}");
        let bounds: Vec<f64> = report.adaptive.iter().filter_map(|step| step.relative).collect();
        assert!(bounds.windows(2).all(|w| w[1] < w[0]), "{name}: {bounds:?}");
        let left_out = &report.certificate.unwrap().projected_load;
        assert_eq!(!left_out.is_empty(), said.contains("for the load without"), "{name}: {said}");
        assert!(left_out.iter().all(|of| of.share < 1e-3), "{name}: {left_out:?}");
        assert!(!said.contains("no load drives it,"), "{name}: {said}");
        assert_eq!(!left_out.is_empty(), said.contains("free motion along declared arcs"), "{name}: {said}");
    }
}

#[test]
fn a_torque_that_the_polygon_does_not_explain_is_not_left_out() {
    let here = tempfile::tempdir().unwrap();
    let turned = here.path().join("turned.toml");
    std::fs::write(&turned, TORQUE).unwrap();
    let of_file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/true_numbers/pin-free/pin_arc.toml");
    let pulled = (of_file, "body.1.traction.0.vector=[60.0, 6.0]", "eye", "170");
    let twisted = (turned, "body.1.traction.0.vector=[\"-0.75*y\", \"0.75*x\"]", "pin", "30.1");
    for (command, (case, torque, body, load)) in
        ["solve", "check"].into_iter().flat_map(|command| [&pulled, &twisted].map(|of| (command, of)))
    {
        let mut program = Command::new(env!("CARGO_BIN_EXE_nndd"));
        program.current_dir(here.path()).arg(command).arg(case).args(["--set", torque]);
        let output = program.output().unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert_eq!(output.status.code(), Some(4), "{said}");
        assert!(said.contains(&format!("can rotate about (0, 0) (load {load} in that direction")), "{said}");
        assert!(!said.contains("no load drives it"), "{said}");
        let free = format!(
            "free motion along declared arcs: body \"{body}\" can rotate about (0, 0), with a load {load} along it"
        );
        assert!(command == "solve" || said.contains(&free), "{said}");
    }
}

/// Says that a load is left out only as long as the polygon explains it.
#[test]
fn a_load_that_the_next_polygon_does_not_explain_is_called_so() {
    let here = tempfile::tempdir().unwrap();
    std::fs::write(here.path().join("torque.toml"), TORQUE).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_nndd"))
        .current_dir(here.path())
        .args(["solve", "torque.toml", "--out", "out", "--set", "body.1.generator.cells=[40, 4]"])
        .output()
        .unwrap();
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert_eq!(output.status.code(), Some(6), "{said}");
    assert!(said.contains("for the load without"), "{said}");
    assert!(said.contains("is more than the error of the polygon of the next mesh"), "{said}");
    assert!(!said.contains("no load drives it"), "{said}");
}

#[test]
fn a_load_that_only_the_error_of_normals_balances_is_said_and_is_in_the_balance() {
    let here = tempfile::tempdir().unwrap();
    let case = here.path().join("disc.toml");
    std::fs::write(&case, DISC).unwrap();
    let (report, said) = solved(case.to_str().unwrap(), &[]);
    let (_, after) =
        said.split_once("free motion but for the error of normals: body \"disc\" can rotate").unwrap();
    let (_, load) = after.split_once("with a load ").unwrap();
    let load: f64 = load.split_once(' ').unwrap().0.parse().unwrap();
    assert!(report.certificate.unwrap().valid, "{said}");
    // Forces along it balance only up to the error of the normals.
    let left = &report.results.balance.unwrap()[0];
    assert!(left[..2].iter().all(|force| force.abs() < 1e-9), "{left:?}");
    assert!(load > 1e-6 && left[2].abs() > 1e-6 && left[2].abs() < 1e-2, "{left:?} and {load:e}: {said}");
}

/// A disc in a ring whose curves are not declared: the polygon of its second mesh hardly resists a rotation.
const DISC: &str = r#"
schema = 1
[materials.soft]
young = 1000.0
poisson = 0.3
[adapt]
target_relative_error = 0.07
max_steps = 2

[[body]]
name = "disc"
material = "soft"
generator = { kind = "disc", centre = [0.0, 0.0], radius = 1.0, cells = 3, start = 186.75581079503957 }
body_force = [-0.14890353530274578, 0.9772719032921581]

[[body]]
name = "ring"
material = "soft"
generator = { kind = "ring", centre = [0.0, 0.0], radii = [1.011090791426044, 2.0], angles = [0.0, 360.0], cells = [18, 1] }
[[body.displacement]]
on = "outer"
fixed = true

[[contact]]
bodies = ["disc", "ring"]
surfaces = ["rim", "inner"]
gap = "geometric"
"#;

/// A pin in an eye, loaded by its weight and a small torque in its bore. It is turned by 2 of the 7.5 degrees between two nodes: the normals of its
/// polygon differ from those of the arc by 2 degrees in both directions, and have hardly a moment.
const TORQUE: &str = r#"
schema = 1
[materials.steel]
young = 210e3
poisson = 0.3

[[body]]
name = "eye"
material = "steel"
generator = { kind = "ring", radii = [10.02, 20.0], cells = [48, 8] }
[[body.displacement]]
on = "outer"
fixed = true
[[body.curve]]
on = ["inner", "outer"]
kind = "arc"

[[body]]
name = "pin"
material = "steel"
generator = { kind = "ring", radii = [4.0, 10.0], angles = [2.0, 362.0], cells = [48, 4] }
body_force = [-3.0, 1.0]
[[body.traction]]
on = "inner"
vector = ["-0.001 * y", "0.001 * x"]
[[body.curve]]
on = "outer"
kind = "arc"

[[contact]]
bodies = ["eye", "pin"]
surfaces = ["inner", "outer"]
gap = "geometric"

[adapt]
target_relative_error = 0.05
"#;
