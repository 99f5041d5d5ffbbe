//! Loads next to the edge of what the contact sides can balance, on both sides of it.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Solves a case; returns the exit code and what was printed.
fn solved(directory: &Path, case: &str) -> (i32, String) {
    let file = directory.join("case.toml");
    std::fs::write(&file, case).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("solve").arg(file).args(["--quiet", "--force", "--out"]).arg(directory.join("out"));
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// A block of 4 by 4 cells, or a cube, of width 1, on a plane. A load of 1 acts `beyond` of the width outside of its lower side.
fn pushed_over(solid: bool, beyond: f64) -> String {
    let (hypothesis, cells) = if solid {
        ("solid", "box\", cells = [2, 2, 2]")
    } else {
        ("plane_stress", "block\", cells = [4, 4]")
    };
    let components =
        |x: &str, y: &str| if solid { format!("[{x}, 0.0, {y}]") } else { format!("[{x}, {y}]") };
    let vector = components("0.0", &format!("\"-(1 + {:?} * (x - 0.5))\"", 12.0 * (0.5 + beyond)));
    format!(
        "schema = 1\n[model]\nhypothesis = \"{hypothesis}\"\n[materials.m]\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = \"cube\"\n\
         material = \"m\"\ngenerator = {{ kind = \"{cells}, origin = {}, size = {} }}\n[[body.traction]]\non = \"top\"\nvector = {vector}\n\
         [contact]\nsurfaces = [\"bottom\"]\nobstacle = {{ kind = \"plane\", point = {}, normal = {} }}\n",
        components("0.0", "0.0"),
        if solid { "[1.0, 1.0, 1.0]" } else { "[1.0, 1.0]" },
        components("0.0", "0.0"),
        components("0.0", "1.0"),
    )
}

#[test]
fn the_load_that_nothing_resists_is_right_to_its_digits() {
    let temp = tempfile::tempdir().unwrap();
    for solid in [false, true] {
        for beyond in [1e-3, 1e-5, 1e-7, 3e-8, 2e-8, 1e-8, 5e-9, 2e-9, 1e-9, 3e-10, 1e-10, 1e-11] {
            let (code, text) = solved(temp.path(), &pushed_over(solid, beyond));
            assert_eq!(code, 4, "{solid} {beyond:e}: {text}");
            let load = text.split_once("(load ").and_then(|(_, rest)| rest.split_once(' ')).unwrap().0;
            // About the edge and half the height: the largest arm is that of the corner above.
            let wanted = beyond * 0.8f64.sqrt();
            let found: f64 = load.parse().unwrap();
            assert!((found / wanted - 1.0).abs() < 0.01, "{solid} {beyond:e}: {found:e} is not {wanted:e}");
        }
    }
}

#[test]
fn a_box_whose_load_is_nearly_between_two_of_three_spheres_is_solved() {
    let temp = tempfile::tempdir().unwrap();
    let sphere = |[x, y]: [f64; 2]| {
        format!(
            "[[contact]]\nsurfaces = [\"bottom\"]\ngap = \"geometric\"\n\
             obstacle = {{ kind = \"sphere\", centre = [{x:?}, {y:?}, -2.0], radius = 2.0, side = \"outside\" }}\n"
        )
    };
    for inside in [1e-5, 1e-6, 1e-7] {
        let case = format!(
            "schema = 1\n[model]\nhypothesis = \"solid\"\n[materials.m]\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = \"box\"\n\
             material = \"m\"\ngenerator = {{ kind = \"box\", cells = [4, 4, 4], origin = [0.0, 0.0, 0.0], size = [1.0, 1.0, 1.0] }}\n\
             [[body.traction]]\non = \"top\"\nvector = [0.0, 0.0, \"-(1 + {:?} * (x - 0.5))\"]\n{}",
            12.0 * (inside - 0.25),
            [[0.25, 0.25], [0.25, 0.75], [0.75, 0.5]].map(sphere).concat(),
        );
        let (code, text) = solved(temp.path(), &case);
        assert_eq!(code, 0, "{inside:e}: {text}");
        let report = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
        let report: Value = serde_json::from_str(&report).unwrap();
        for (k, share) in [0.5 - inside, 0.5 - inside, 2.0 * inside].into_iter().enumerate() {
            let force = report["contact"][k]["contact_force"].as_f64().unwrap();
            assert!((force - share).abs() < 1e-12, "{inside:e}: {force:e} is not {share:e}");
        }
    }
}

#[test]
fn a_small_torque_on_a_pin_is_rounding_or_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    let mut codes = Vec::new();
    for k in 0..16 {
        let torque = 10f64.powf(-13.0 + 0.5 * f64::from(k));
        let ring = |name: &str, radii: &str, more: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmaterial = \"m\"\ngenerator = {{ kind = \"ring\", radii = {radii}, cells = [48, 4] }}\n\
                 [[body.curve]]\non = [\"inner\", \"outer\"]\nkind = \"arc\"\n{more}"
            )
        };
        let twisted = format!(
            "[[body.traction]]\non = \"inner\"\nvector = [\"{torque:?} * -y\", \"{torque:?} * x\"]\n\
             [[body.traction]]\non = \"inner\"\nvector = [-3.0, 1.0]\n"
        );
        let held = "[[body.displacement]]\non = \"outer\"\nfixed = true\n";
        let case = format!(
            "schema = 1\n[model]\nhypothesis = \"plane_stress\"\n[materials.m]\nyoung = 210e3\npoisson = 0.3\n{}{}\
             [contact]\nbodies = [\"lug\", \"pin\"]\nsurfaces = [\"inner\", \"outer\"]\ngap = \"geometric\"\n",
            ring("lug", "[10.02, 20.0]", held),
            ring("pin", "[4.0, 10.0]", &twisted),
        );
        let (code, text) = solved(temp.path(), &case);
        assert!(code == 0 || code == 4, "{torque:e}: {code} {text}");
        codes.push(code);
    }
    // From one torque on it is refused.
    assert!(codes.is_sorted() && codes.contains(&0) && codes.contains(&4), "{codes:?}");
}
