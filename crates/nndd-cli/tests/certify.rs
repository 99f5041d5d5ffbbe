//! `nndd certify`: displacements of other codes.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn nndd(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(directory).output().unwrap()
}

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(name)
}

/// Solves a case, and returns its report.
fn solved(name: &str, directory: &Path) -> Report {
    let output = nndd(&["solve", case(name).to_str().unwrap(), "--out", "out", "--force"], directory);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    Report::from_json(&std::fs::read_to_string(directory.join("out/report.json")).unwrap()).unwrap()
}

/// Certifies files for a case; returns the status and the numbers.
fn certified(name: &str, files: &[&str], directory: &Path) -> (i32, serde_json::Value, String) {
    let path = case(name);
    let mut arguments = vec!["certify", path.to_str().unwrap(), "--format", "json", "--displacement"];
    arguments.extend(files);
    let output = nndd(&arguments, directory);
    let numbers = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code().unwrap(), numbers, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_field_of_its_own_has_about_the_bound_of_its_run() {
    let temp = tempfile::tempdir().unwrap();
    for (name, files) in [
        ("paper.toml", ["out/upper.vtu", "out/lower.vtu"]),
        // The meshes of the run have more nodes than the meshes of the case.
        ("nonmatching.toml", ["out/upper.vtu", "out/lower.vtu"]),
        ("plate.toml", ["out/block.vtu", "out/base.vtu"]),
    ] {
        let report = solved(name, temp.path());
        let (status, numbers, said) = certified(name, &files, temp.path());
        assert_eq!(status, 0, "{name}: {said}");
        let (own, found) =
            (report.certificate.as_ref().unwrap().e_cre.unwrap(), numbers["bound"].as_f64().unwrap());
        assert!((found / own - 1.0).abs() < 0.02, "{name}: {found} {own}");
    }
}

#[test]
fn people_read_four_digits() {
    let temp = tempfile::tempdir().unwrap();
    solved("paper.toml", temp.path());
    let path = case("paper.toml");
    let files = ["out/upper.vtu", "out/lower.vtu"];
    let output =
        nndd(&["certify", path.to_str().unwrap(), "--displacement", files[0], files[1]], temp.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count();
    assert!(said.starts_with("certified error <= 18.") && said.contains(" of 1.0"), "{said}");
    assert!(said.split_whitespace().all(|word| digits(word) <= 5), "{said}");
}

#[test]
fn poor_fields_have_large_bounds_and_wrong_ones_none() {
    let temp = tempfile::tempdir().unwrap();
    solved("paper.toml", temp.path());
    let (_, good, _) = certified("paper.toml", &["out/upper.vtu", "out/lower.vtu"], temp.path());
    // A table of a few digits, which penetrates a little.
    let (nodes, h) = (19, 1.0 / 9.0);
    let table = |body: usize, sink: f64| {
        let y0 = [1.0, 0.0][body];
        let mut text = "x,y,ux,uy\n".to_owned();
        for j in 0..10 {
            for i in 0..nodes {
                let (x, y) = (f64::from(i) * h, y0 + f64::from(j) * h);
                let uy = [-0.02, -0.01 * y + sink][body];
                text += &format!("{x:.7},{y:.7},0.0,{:.4}\n", if j == 0 && body == 1 { 0.0 } else { uy });
            }
        }
        text
    };
    for (name, sink) in [("sound.csv", -0.01), ("deep.csv", 0.01)] {
        std::fs::write(temp.path().join(name), table(1, sink)).unwrap();
    }
    std::fs::write(temp.path().join("upper.csv"), table(0, 0.0)).unwrap();
    let (status, poor, said) = certified("paper.toml", &["upper.csv", "sound.csv"], temp.path());
    assert_eq!(status, 0, "{said}");
    assert!(poor["bound"].as_f64().unwrap() > 2.0 * good["bound"].as_f64().unwrap(), "{poor}");
    let (status, deep, said) = certified("paper.toml", &["upper.csv", "deep.csv"], temp.path());
    assert_eq!(status, 0, "{said}");
    assert!(deep["penetration"].as_f64().unwrap() > 0.0 && deep["change"].as_f64().unwrap() > 0.0, "{deep}");
    // Twice the imposed displacement violates the support.
    let wrong = table(0, 0.0).replace("-0.0200", "-0.0400");
    std::fs::write(temp.path().join("wrong.csv"), wrong).unwrap();
    let (status, numbers, _) = certified("paper.toml", &["wrong.csv", "sound.csv"], temp.path());
    assert_eq!((status, &numbers["valid"]), (6, &serde_json::Value::Bool(false)), "{numbers}");
    assert!(numbers["bound"].is_null() && numbers["failed_checks"]["imposed_displacement"].is_number());
    let missed = &numbers["missed_support"];
    assert_eq!(
        (missed["body"].as_str(), missed["point"][1].as_f64()),
        (Some("upper"), Some(2.0)),
        "{missed}"
    );
    assert!((missed["distance"].as_f64().unwrap() - 0.02).abs() < 1e-12, "{missed}");
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    solved("paper.toml", temp.path());
    let refused = |files: &[&str], code: i32, words: &str| {
        let (status, _, said) = certified("paper.toml", files, temp.path());
        assert_eq!(status, code, "{files:?}: {said}");
        assert!(said.contains(words) && said.contains("expected"), "{files:?}: {said}");
    };
    refused(&["out/lower.vtu", "out/upper.vtu"], 3, "has a node at");
    refused(&["out/lower.vtu"], 2, "1 files of displacements");
    refused(&["out/none.vtu", "out/lower.vtu"], 7, "cannot be read");
    refused(&["out/report.json", "out/lower.vtu"], 3, "not an unstructured grid");
    std::fs::write(temp.path().join("bad.csv"), "x,y,ux\n0,0,0\n").unwrap();
    refused(&["bad.csv", "out/lower.vtu"], 3, "line 1: there is no column uy");
    std::fs::write(temp.path().join("nan.csv"), "x,y,ux,uy\n0,0,0,nan\n").unwrap();
    refused(&["nan.csv", "out/lower.vtu"], 3, "\"nan\" is not a finite number");
}

/// Certifies files beside a case of `tests/cases/true_numbers`; returns the status, the numbers and what is said on stderr.
fn true_numbers(name: &str, files: &[&str]) -> (i32, serde_json::Value, String) {
    let path = case("true_numbers").join(name);
    let folder = path.parent().unwrap();
    let files: Vec<PathBuf> = files.iter().map(|file| folder.join(file)).collect();
    let files: Vec<&str> = files.iter().map(|file| file.to_str().unwrap()).collect();
    certified(&format!("true_numbers/{name}"), &files, folder)
}

#[test]
fn the_bound_is_for_the_field_of_the_file_though_meshes_do_not_match() {
    let (status, found, said) = true_numbers("certify-snap/case.toml", &["u.csv", "l.csv"]);
    assert_eq!(status, 0, "{said}");
    // The exact solution is linear: the field of the files is 1.592 away.
    let [bound, change] = ["bound", "change"].map(|key| found[key].as_f64().unwrap());
    assert!(bound >= 1.592 && change > 0.1, "{found}");
}

#[test]
fn points_between_the_nodes_are_compared_with_the_differences_in_a_cell() {
    let (status, _, said) = true_numbers("certify-midpoints/case.toml", &["u.csv", "l.csv"]);
    assert!(status == 3 && said.contains("is not that of a linear field"), "{status} {said}");
}

#[test]
fn the_last_factors_of_load_steps_count() {
    let temp = tempfile::tempdir().unwrap();
    let files = ["out/u.vtu", "out/l.vtu"];
    let full = solved("true_numbers/certify-steps/full.toml", temp.path());
    let (status, of_full, said) = certified("true_numbers/certify-steps/case.toml", &files, temp.path());
    assert_eq!(status, 0, "{said}");
    // The last factor is 0.01: the field of the full load is wrong by about its own size.
    let own = full.certificate.as_ref().unwrap().e_cre.unwrap();
    assert!(of_full["bound"].as_f64().unwrap() > 1.5 * own, "{of_full} {own}");
    let in_steps = solved("true_numbers/certify-steps/case.toml", temp.path());
    let (_, found, said) = certified("true_numbers/certify-steps/case.toml", &files, temp.path());
    let own = in_steps.certificate.as_ref().unwrap().e_cre.unwrap();
    assert!((found["bound"].as_f64().unwrap() / own - 1.0).abs() < 0.02, "{found} {own} {said}");
}

#[test]
fn far_points_pipes_devices_and_free_obstacles_are_refused_at_once() {
    let temp = tempfile::tempdir().unwrap();
    let snap = "true_numbers/certify-snap";
    let [upper, lower] = ["u.csv", "l.csv"].map(|name| case(snap).join(name));
    let far = std::fs::read_to_string(&upper).unwrap().trim_end().to_owned() + "\n1e300,0,0,0\n";
    std::fs::write(temp.path().join("far.csv"), &far).unwrap();
    let refused = |name: &str, file: &str, code: i32, words: &str| {
        let (status, _, said) = certified(name, &[file, lower.to_str().unwrap()], temp.path());
        assert!(status == code && said.contains(words), "{file}: {status} {said}");
    };
    let snap = format!("{snap}/case.toml");
    let line = format!("line {}: the point (1e300, 0) is far from all bodies", far.lines().count());
    refused(&snap, "far.csv", 3, &line);
    refused(&snap, ".", 7, "it is a directory");
    if cfg!(unix) {
        refused(&snap, "/dev/zero", 7, "it is not a regular file");
        let made = Command::new("mkfifo").arg(temp.path().join("pipe.csv")).status().unwrap();
        assert!(made.success());
        refused(&snap, "pipe.csv", 7, "it is not a regular file");
    }
    let path = case("press.toml");
    let arguments = ["certify", path.to_str().unwrap(), "--displacement", "far.csv"];
    let output = nndd(&arguments, temp.path());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(3) && said.contains("is free to move"), "{said}");
}

#[test]
fn a_directory_gets_the_report_the_page_and_the_map_of_the_error() {
    let temp = tempfile::tempdir().unwrap();
    let folder = case("true_numbers/certify-snap");
    let [path, upper, lower] =
        ["case.toml", "u.csv", "l.csv"].map(|name| folder.join(name).to_str().unwrap().to_owned());
    let run = |displacement: [&str; 2], more: &[&str]| {
        let all = ["certify", &path, "--displacement", displacement[0], displacement[1], "--out", "out"];
        nndd(&[&all[..], more].concat(), temp.path())
    };
    let output = run([&upper, &lower], &["--threads", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(temp.path().join("out").join(name)).unwrap();
    let report: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!((&report["schema"], &report["status"]["code"]), (&1.into(), &0.into()), "{report}");
    assert!(
        report["certificate"]["bound"].as_f64().unwrap() >= 1.592 && report["certificate"]["valid"] == true
    );
    assert_eq!((&report["bodies"][0]["name"], report["bodies"].as_array().unwrap().len()), (&"u".into(), 2));
    let page = read("report.html");
    assert!(
        page.contains("<svg") && page.contains("Error density") && page.contains("certified error"),
        "{page}"
    );
    for body in ["u.vtu", "l.vtu"] {
        let bytes = std::fs::read(temp.path().join("out").join(body)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("Name=\"error_density\""), "{body}");
    }
    // The same again replaces it; another field needs --force.
    assert_eq!(run([&upper, &lower], &[]).status.code(), Some(0));
    std::fs::copy(&upper, temp.path().join("other.csv")).unwrap();
    assert_eq!(run(["other.csv", &lower], &[]).status.code(), Some(7));
    assert_eq!(run(["other.csv", &lower], &["--force"]).status.code(), Some(0));
}
