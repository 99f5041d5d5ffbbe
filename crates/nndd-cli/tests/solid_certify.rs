//! `nndd certify`: displacements of other codes on tetrahedra.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn nndd(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(directory).output().unwrap()
}

fn case(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/solid").join(name);
    path.to_str().unwrap().to_owned()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Certifies files for a case; returns the status and the numbers.
fn certified(case: &str, files: &[&str], more: &[&str], directory: &Path) -> (i32, Value, String) {
    let start = ["certify", case, "--format", "json", "--displacement"];
    let output = nndd(&[&start[..], files, more].concat(), directory);
    let numbers = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code().unwrap(), numbers, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_field_of_its_own_has_the_bound_of_its_run() {
    let temp = tempfile::tempdir().unwrap();
    for (name, files) in [
        ("half_open.toml", &["out/upper.vtu", "out/lower.vtu"][..]),
        ("weight.toml", &["out/cube.vtu"]),
        ("stack.toml", &["out/bottom.vtu", "out/middle.vtu", "out/top.vtu"]),
    ] {
        let solve =
            ["solve", &case(name), "--quiet", "--out", "out", "--force", "--set", "solver.method=exact"];
        let output = nndd(&solve, temp.path());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let report = read(&temp.path().join("out/report.json"));
        let names: Vec<&str> =
            report["bodies"].as_array().unwrap().iter().map(|body| body["name"].as_str().unwrap()).collect();
        let in_order: Vec<String> = names.iter().map(|name| format!("out/{name}.vtu")).collect();
        assert_eq!(in_order.len(), files.len());
        let in_order: Vec<&str> = in_order.iter().map(String::as_str).collect();
        let (status, numbers, said) = certified(&case(name), &in_order, &[], temp.path());
        assert_eq!(status, 0, "{name}: {said}");
        let (own, found) =
            (report["certificate"]["e_cre"].as_f64().unwrap(), numbers["bound"].as_f64().unwrap());
        assert!((found / own - 1.0).abs() < 1e-9, "{name}: {found} {own} {numbers}");
        // The number of threads does not matter.
        let (_, again, _) = certified(&case(name), &in_order, &["--threads", "1"], temp.path());
        assert_eq!(again, numbers, "{name}");
    }
}

/// A table of a field at the nodes of a box of cells, in shuffled columns.
fn table(low_z: f64, cells: [u32; 3], size: [f64; 3], field: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = "uz,ux,node,z,y,x,uy\n".to_owned();
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let at = [i, j, k];
                let mut x = [0, 1, 2].map(|c| size[c] * f64::from(at[c]) / f64::from(cells[c]));
                x[2] += low_z;
                let u = field(x);
                let _ = writeln!(text, "{:e},{:e},7,{},{},{},{:e}", u[2], u[0], x[2], x[1], x[0], u[1]);
            }
        }
    }
    text
}

/// Two blocks pressed together by a uniform pressure: the exact solution is linear.
const PRESSED: &str = "schema = 1
[model]
hypothesis = \"solid\"
[materials.m]
young = 1000.0
poisson = 0.25
[[body]]
name = \"upper\"
material = \"m\"
generator = { kind = \"box\", origin = [0.0, 0.0, 1.0], size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }
[[body.displacement]]
on = \"left\"
ux = 0.0
[[body.displacement]]
on = \"front\"
uy = 0.0
[[body.traction]]
on = \"top\"
pressure = 10.0
[[body]]
name = \"lower\"
material = \"m\"
generator = { kind = \"box\", size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }
[[body.displacement]]
on = \"left\"
ux = 0.0
[[body.displacement]]
on = \"front\"
uy = 0.0
[[body.displacement]]
on = \"bottom\"
uz = 0.0
[contact]
surfaces = [\"bottom\", \"top\"]
";

/// The exact displacements of [`PRESSED`].
fn exact(x: [f64; 3]) -> [f64; 3] {
    [0.0025 * x[0], 0.0025 * x[1], -0.01 * x[2]]
}

/// The exact displacements with an error that vanishes at all supports, of energy `E ε² V` for the strain `ε` along x.
fn wrong(x: [f64; 3]) -> [f64; 3] {
    let [u, v, w] = exact(x);
    [u + 0.001 * x[0], v, w]
}

const CELLS: [u32; 3] = [4, 2, 2];
const SIZE: [f64; 3] = [2.0, 1.0, 1.0];

/// Writes the case and the tables of both bodies.
fn written(folder: &Path, field: fn([f64; 3]) -> [f64; 3]) {
    std::fs::write(folder.join("case.toml"), PRESSED).unwrap();
    for (name, low) in [("u.csv", 1.0), ("l.csv", 0.0)] {
        std::fs::write(folder.join(name), table(low, CELLS, SIZE, field)).unwrap();
    }
}

#[test]
fn the_bound_of_a_wrong_field_holds_and_is_near_its_error() {
    let temp = tempfile::tempdir().unwrap();
    written(temp.path(), exact);
    let (status, numbers, said) = certified("case.toml", &["u.csv", "l.csv"], &[], temp.path());
    let norm = numbers["energy_norm"].as_f64().unwrap();
    assert!(status == 0 && numbers["bound"].as_f64().unwrap() < 1e-9 * norm, "{numbers} {said}");
    written(temp.path(), wrong);
    let (status, numbers, said) = certified("case.toml", &["u.csv", "l.csv"], &[], temp.path());
    assert_eq!(status, 0, "{said}");
    // The strain is 0.001 along x; λ + 2μ = 1200, and both blocks have a volume of 2.
    let error = (1200.0f64 * 1e-6 * 4.0).sqrt();
    let bound = numbers["bound"].as_f64().unwrap();
    assert!(bound >= error && bound < 1.2 * error, "{bound} {error}");
    // Blocks that penetrate are parted, and the change counts.
    let deep = table(0.0, CELLS, SIZE, |x| {
        let [u, v, w] = exact(x);
        [u, v, w + 1e-4 * x[2]]
    });
    std::fs::write(temp.path().join("deep.csv"), deep).unwrap();
    written(temp.path(), exact);
    let (status, numbers, said) = certified("case.toml", &["u.csv", "deep.csv"], &[], temp.path());
    assert_eq!(status, 0, "{said}");
    let [penetration, change] = ["penetration", "change"].map(|key| numbers[key].as_f64().unwrap());
    assert!((penetration - 1e-4).abs() < 1e-12 && change > 0.0, "{numbers}");
    // A support that is missed leaves no bound.
    let moved = table(0.0, CELLS, SIZE, |x| {
        let [u, v, w] = exact(x);
        [u + 0.01, v, w]
    });
    std::fs::write(temp.path().join("moved.csv"), moved).unwrap();
    let (status, numbers, _) = certified("case.toml", &["u.csv", "moved.csv"], &[], temp.path());
    assert_eq!((status, &numbers["valid"], &numbers["bound"]), (6, &Value::Bool(false), &Value::Null));
    assert_eq!(numbers["missed_support"]["point"].as_array().unwrap().len(), 3, "{numbers}");
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    written(temp.path(), wrong);
    let lower = std::fs::read_to_string(temp.path().join("l.csv")).unwrap();
    let refused = |name: &str, text: &str, code: i32, words: &str| {
        std::fs::write(temp.path().join(name), text).unwrap();
        let (status, _, said) = certified("case.toml", &["u.csv", name], &[], temp.path());
        assert!(status == code && said.contains(words) && said.contains("expected"), "{status} {said}");
    };
    let line = |u: [f64; 3], x: [f64; 3]| {
        format!("{:e},{:e},7,{:e},{:e},{:e},{:e}\n", u[2], u[0], x[2], x[1], x[0], u[1])
    };
    let middle = [0.25, 0.25, 0.25];
    let [u, v, w] = wrong(middle);
    refused(
        "quadratic.csv",
        &(lower.clone() + &line([u + 1e-5, v, w], middle)),
        3,
        "is not that of a linear field",
    );
    // A motion of the body hides no other field.
    let far = line([0.0; 3], [0.0, 0.0, 1e3]);
    refused("far.csv", &(lower.clone() + &far), 3, "the point (0, 0, 1000) is far from all bodies");
    let short: String = lower.lines().take(20).map(|line| format!("{line}\n")).collect();
    refused("short.csv", &short, 3, "has a node at (");
    refused("plane.csv", "x,y,ux,uy\n0,0,0,0\n", 3, "there is no column z");
    refused("two.csv", &lower.replacen("uz,", "vz,", 1), 3, "there is no column uz");
    refused("nan.csv", &(lower.clone() + "0,0,7,0,0,0,nan\n"), 3, "\"nan\" is not a finite number");
    let moved = lower.replacen(",7,0,0,0.5,", ",7,0.01,0,0.5,", 1);
    assert_ne!(moved, lower);
    refused("moved.csv", &moved, 3, "has a node at (");
    let (status, _, said) = certified("case.toml", &["u.csv"], &[], temp.path());
    assert!(status == 2 && said.contains("1 files of displacements"), "{said}");
    // A point between the nodes with the value of the field there is welcome, and so are other orders.
    let more = lower.clone() + &line([u, v, w], middle);
    std::fs::write(temp.path().join("more.csv"), more).unwrap();
    let mut lines: Vec<&str> = lower.lines().collect();
    lines[1..].reverse();
    std::fs::write(temp.path().join("back.csv"), lines.join("\n")).unwrap();
    let bound = |file: &str| {
        let (status, numbers, said) = certified("case.toml", &["u.csv", file], &[], temp.path());
        assert_eq!(status, 0, "{file}: {said}");
        numbers["bound"].as_f64().unwrap()
    };
    let own = bound("l.csv");
    assert!(bound("back.csv") == own && (bound("more.csv") / own - 1.0).abs() < 1e-9);
    // An obstacle that is free to move.
    let stamp = "[[contact]]\nbodies = [\"upper\"]\nsurfaces = [\"top\"]\nobstacle = { kind = \"plane\", point = [0.0, 0.0, 2.0], \
                 normal = [0.0, 0.0, -1.0], force = [0.0, 0.0, -20.0] }\n";
    let text = PRESSED.replace("[contact]\n", "[[contact]]\nbodies = [\"upper\", \"lower\"]\n") + stamp;
    let text = text.replace("[[body.traction]]\non = \"top\"\npressure = 10.0\n", "");
    std::fs::write(temp.path().join("stamp.toml"), text).unwrap();
    let (status, _, said) = certified("stamp.toml", &["u.csv", "l.csv"], &[], temp.path());
    assert!(
        status == 3 && said.contains("is free to move") && said.contains("ux, uy, uz and rotation"),
        "{said}"
    );
}

#[test]
fn a_directory_gets_the_report_the_page_with_tables_and_the_densities() {
    let temp = tempfile::tempdir().unwrap();
    written(temp.path(), wrong);
    let run = |more: &[&str]| {
        let all = ["certify", "case.toml", "--displacement", "u.csv", "l.csv", "--out", "out"];
        nndd(&[&all[..], more].concat(), temp.path())
    };
    let output = run(&["--threads", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let out = temp.path().join("out");
    let report = read(&out.join("report.json"));
    assert_eq!((&report["status"]["code"], &report["bodies"][0]["tetrahedra"]), (&0.into(), &96.into()));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for words in ["certified error", "Where the error is", "Solids have no map", "<td>upper</td>"] {
        assert!(page.contains(words), "{words}: {page}");
    }
    assert!(!page.contains("<svg") && !out.join("figures").exists());
    for body in ["upper.vtu", "lower.vtu"] {
        let bytes = std::fs::read(out.join(body)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("Name=\"error_density\""), "{body}");
    }
    // The same again replaces it; another field needs --force.
    assert_eq!(run(&[]).status.code(), Some(0));
    let other = ["certify", "case.toml", "--displacement", "u.csv", "other.csv", "--out", "out"];
    std::fs::copy(temp.path().join("l.csv"), temp.path().join("other.csv")).unwrap();
    assert_eq!(nndd(&other, temp.path()).status.code(), Some(7));
    assert_eq!(nndd(&[&other[..], &["--force"]].concat(), temp.path()).status.code(), Some(0));
}
