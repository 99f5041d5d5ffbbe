//! Examples of solids in `tests/cases/solid`, held against closed forms.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;

/// `E / (1 - nu^2)` of the material of all of them, Pa.
const MODULUS: f64 = 1000.0 / 0.91;

/// Solves an example and returns its report.json, which must have a valid certificate.
fn solved(case: &str, set: &[&str]) -> Value {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/solid").join(format!("{case}.toml"));
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.args(["solve", "--quiet", "--set", "output.vtu=false", "--out"]).arg(folder.path()).arg(file);
    command.args(set.iter().flat_map(|value| ["--set", value]));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{case}: {}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(folder.path().join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["certificate"]["valid"], true, "{case}");
    report
}

fn number(report: &Value, pointer: &str) -> f64 {
    report.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number at {pointer}"))
}

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found / expected - 1.0).abs() <= relative, "{found} is not within {relative} of {expected}");
}

/// Radius of contact and largest pressure of Hertz, of ellipses that are nearly circles (Johnson 1985, section 4.2).
///
/// * `curvatures`: relative ones along both axes, 1/m.
fn hertz(force: f64, curvatures: [f64; 2], modulus: f64) -> [f64; 2] {
    let radius = (0.75 * force / (modulus * (curvatures[0] * curvatures[1]).sqrt())).cbrt();
    [radius, 1.5 * force / (PI * radius * radius)]
}

/// Holds a pair against its closed form: the area lies in the interval of the report, and the largest pressure of a node, which no bound is
/// known for, is that of the closed form up to a tolerance.
fn holds(report: &Value, pair: usize, area: f64, [pressure, tolerance]: [f64; 2]) {
    let of_pair = |key: &str| number(report, &format!("/contact/{pair}/{key}"));
    let [certain, possible] = ["area/certain", "area/possible"].map(of_pair);
    assert!(certain <= area && area <= possible, "{area} is not in [{certain}, {possible}]");
    assert!(possible < 1.4 * certain, "{certain} {possible}");
    near(of_pair("max_pressure"), pressure, tolerance);
}

/// The exact contact force, which balances the load, lies in its certified interval.
fn force_is_certified(report: &Value, force: f64) {
    let bounds = report.pointer("/certificate/bounds/contact_force").unwrap();
    let [low, high] = [0, 1].map(|k: usize| bounds[k].as_f64().unwrap());
    assert!(low <= force && force <= high, "{force} is not in [{low}, {high}]");
}

#[test]
fn a_sphere_on_a_block_is_hertz() {
    let report = solved("sphere_on_block", &[]);
    let [radius, pressure] = hertz(2.0, [1.0; 2], 0.5 * MODULUS);
    holds(&report, 0, 0.25 * PI * radius * radius, [pressure, 0.15]);
    near(number(&report, "/contact/0/contact_force"), 0.5, 0.01);
}

#[test]
fn a_cylinder_on_a_plane_is_hertz() {
    let report = solved("cylinder_on_plane", &[]);
    let half_width = 2.0 * (10.0 / (PI * MODULUS)).sqrt();
    holds(&report, 0, 0.2 * half_width, [20.0 / (PI * half_width), 0.1]);
    near(number(&report, "/contact/0/contact_force"), 1.0, 1e-9);
}

#[test]
fn a_ball_between_rings_is_hertz() {
    let report = solved("ball_in_rings", &[]);
    for (pair, curvature) in [2.0 + 0.5, 2.0 - 1.0 / 3.0].into_iter().enumerate() {
        let [radius, pressure] = hertz(2.0, [curvature, 2.0], MODULUS);
        holds(&report, pair, 0.25 * PI * radius * radius, [pressure, 0.15]);
        near(number(&report, &format!("/contact/{pair}/contact_force")), 0.5, 1e-3);
    }
}

#[test]
fn a_head_in_a_cup_is_nearly_hertz() {
    let report = solved("cup", &[]);
    let [radius, pressure] = hertz(4.0, [1.0 - 1.0 / 1.1; 2], MODULUS);
    holds(&report, 0, 0.25 * PI * radius * radius, [pressure, 0.15]);
}

#[test]
fn contact_of_plates_recedes() {
    let [once, twice] = [-10.0, -20.0]
        .map(|load: f64| solved("two_plates", &[&format!("body.0.traction.0.vector=[0.0, 0.0, {load:?}]")]));
    for pair in 0..2 {
        let of = |report: &Value, key: &str| number(report, &format!("/contact/{pair}/{key}"));
        for key in ["area/certain", "area/possible"] {
            near(of(&twice, key), of(&once, key), 1e-9);
        }
        for key in ["max_pressure", "contact_force"] {
            near(of(&twice, key), 2.0 * of(&once, key), 1e-6);
        }
        near(of(&once, "contact_force"), 1.6, 1e-9);
        assert!(of(&once, "area/possible") < 0.2 * of(&once, "area/total"));
    }
    near(number(&twice, "/certificate/relative"), number(&once, "/certificate/relative"), 1e-6);
}

#[test]
fn three_pads_press_alike() {
    let report = solved("clamp", &[]);
    let force = |pair: usize| number(&report, &format!("/contact/{pair}/contact_force"));
    let resultant = |axis: usize| {
        (0..3).map(|pair| number(&report, &format!("/contact/{pair}/resultant/{axis}"))).sum::<f64>()
    };
    assert!((1..3).all(|pair| (force(pair) / force(0) - 1.0).abs() < 1e-6));
    assert!((0..2).all(|axis| resultant(axis).abs() < 1e-9 * force(0)));
}

#[test]
fn a_bracket_stands_on_a_part_of_its_foot() {
    let report = solved("bracket", &[]);
    near(number(&report, "/contact/0/contact_force"), 10.0, 1e-9);
    force_is_certified(&report, 10.0);
    assert!(number(&report, "/contact/0/area/possible") < 0.5 * number(&report, "/contact/0/area/total"));
    assert!(number(&report, "/certificate/relative") <= 0.3);
}

#[test]
fn a_tilted_patch_is_exact() {
    let report = solved("tilted", &[]);
    near(number(&report, "/contact/0/max_pressure"), 10.0, 1e-9);
    near(number(&report, "/contact/0/area/certain"), 2.0, 1e-9);
    force_is_certified(&report, 20.0);
    // The square of the energy norm is p^2 V / E of each block.
    for (body, young) in [2000.0, 1000.0].into_iter().enumerate() {
        near(number(&report, &format!("/results/energy_norm_squared/{body}")), 100.0 * 2.0 / young, 1e-9);
    }
    assert!(number(&report, "/certificate/relative") < 1e-9);
}
