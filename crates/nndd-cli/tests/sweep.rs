//! `nndd sweep`: its table, its directory, and what ends it early.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn paper() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/paper.toml")
}

fn command(name: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg(name).arg(paper()).arg("--out").arg(out).args(more).current_dir(out.parent().unwrap());
    command
}

fn sweep(out: &Path, over: &str, more: &[&str]) -> Output {
    command("sweep", out, &[&["--over", over], more].concat()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Every file below a directory with its bytes.
fn contents(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path))
        } else {
            found.push((path.clone(), std::fs::read(path).unwrap()))
        }
    }
    found.sort();
    found
}

/// A column of a table of numbers and words without commas.
fn column(out: &Path, table: &str, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(out.join(table)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let at = lines.next().unwrap().iter().position(|head| head == name).unwrap();
    lines.map(|cells| cells[at].clone()).collect()
}

#[test]
fn a_sweep_finds_the_papers_theta() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let output = sweep(&out, "solver.theta=0.1:0.9:0.1", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(["0.4", "0.5"].iter().any(|t| said.contains(&format!("at solver.theta = {t}\n"))), "{said}");
    assert_eq!(std::fs::read_to_string(out.join("sweep.csv")).unwrap().lines().count(), 10);
    assert!(out.join("figures/sweep.svg").exists());
}

#[test]
fn a_sweep_never_switches_to_newton() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let more = ["--set", "solver.method=auto", "--iterations", "2"];
    let output = sweep(&out, "solver.theta=[\"auto\", 0.4]", &more);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(column(&out, "sweep.csv", "status"), ["completed", "completed"]);
    assert_eq!(column(&out, "sweep.csv", "iteration"), ["2", "2"]);
}

#[test]
fn a_result_of_a_solve_is_kept_from_harm() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("keep");
    assert_eq!(command("solve", &out, &["--quiet"]).output().unwrap().status.code(), Some(0));
    let before = contents(&out);
    let range = "solver.theta=[0.3, 0.4]";
    let refused = sweep(&out, range, &[]);
    assert_eq!(refused.status.code(), Some(7));
    assert!(text(&refused.stderr).contains("--force"), "{}", text(&refused.stderr));
    assert!(contents(&out) == before);
    assert_eq!(sweep(&out, range, &["--force"]).status.code(), Some(0));
    assert!(!out.join("report.json").exists() && out.join("sweep.json").exists());
    // Nor does a solve replace a sweep.
    let before = contents(&out);
    assert_eq!(command("solve", &out, &["--quiet"]).output().unwrap().status.code(), Some(7));
    assert!(contents(&out) == before);
}

#[test]
fn the_same_sweep_replaces_itself_and_another_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let panel = ["--panel", "solver.weights=stiffness"];
    let range = "solver.theta=[0.3, 0.4]";
    assert_eq!(sweep(&out, range, &panel).status.code(), Some(0));
    assert!(out.join("sweep-2.csv").exists());
    let before = std::fs::read(out.join("sweep.csv")).unwrap();
    assert_eq!(sweep(&out, range, &panel).status.code(), Some(0));
    assert!(std::fs::read(out.join("sweep.csv")).unwrap() == before);
    for (over, more) in
        [("solver.theta=[0.3, 0.5]", &panel[..]), (range, &[]), (range, &["--iterations", "2"])]
    {
        let refused = sweep(&out, over, more);
        assert_eq!(refused.status.code(), Some(7), "{over} {more:?}");
    }
    // The second table belongs to a panel that is gone.
    assert_eq!(sweep(&out, range, &["--force"]).status.code(), Some(0));
    assert!(!out.join("sweep-2.csv").exists());
    assert!(std::fs::read(out.join("sweep.csv")).unwrap() == before);
}

#[test]
fn what_a_sweep_sets_itself_may_be_swept() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let output = sweep(&out, "solver.max_iterations=[1, 2, 3]", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(column(&out, "sweep.csv", "solver.max_iterations"), ["1", "2", "3"]);
    assert_eq!(column(&out, "sweep.csv", "iteration"), ["1", "2", "3"]);
    let eta = column(&out, "sweep.csv", "eta_nndd");
    assert!(eta[0] != eta[1] && eta[1] != eta[2], "{eta:?}");
    // The columns are below their heads, however long the key is.
    let said = text(&output.stdout);
    let rows: Vec<&str> = said.lines().skip_while(|line| !line.contains("eta_nndd")).take(4).collect();
    let end = rows[0].find("eta_nndd").unwrap() + "eta_nndd".len();
    for row in &rows[1..] {
        assert!(row[..end].ends_with(|c: char| c.is_ascii_digit()) && row[end..].starts_with(' '), "{said}");
    }
}

#[test]
fn one_iteration_is_the_least() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let refused = sweep(&out, "solver.theta=0.4", &["--iterations", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("at least 1"), "{}", text(&refused.stderr));
    assert_eq!(sweep(&out, "solver.theta=0.4", &["--iterations", "1"]).status.code(), Some(0));
    assert_eq!(column(&out, "sweep.csv", "iteration"), ["1"]);
}

/// Sweeps θ of a case of `tests/cases/true_numbers`.
fn sweep_of(name: &str, out: &Path, more: &[&str]) -> Output {
    let case = paper().with_file_name("true_numbers").join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("sweep").arg(case).args(["--over", "solver.theta=0.3:0.5:0.1", "--out"]).arg(out);
    command.args(more).output().unwrap()
}

#[test]
fn a_sweep_prints_no_bound_that_is_not_valid() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let output = sweep_of("sweep-invalid.toml", &out, &[]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(6), "{said}");
    assert!(said.contains("no value; the certificate of 3 of 3 runs is not valid"), "{said}");
    assert_eq!(column(&out, "sweep.csv", "valid"), ["false"; 3]);
    for bound in ["e_cre", "eta_dis"] {
        assert_eq!(column(&out, "sweep.csv", bound), [""; 3]);
    }
    let record = std::fs::read_to_string(out.join("sweep.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    let rows = record["panels"][0]["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["valid"] == false && row["iteration"]["e_cre"].is_null()), "{record}");
    let svg = std::fs::read_to_string(out.join("figures/sweep.svg")).unwrap();
    assert!(svg.contains("no data") && svg.contains("3 of 3 left out"), "{svg}");
    let output = sweep(&out, "solver.theta=0.3:0.5:0.1", &["--force"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    assert_eq!(column(&out, "sweep.csv", "valid"), ["true"; 3]);
    assert!(column(&out, "sweep.csv", "e_cre").iter().all(|e| e.parse::<f64>().unwrap() > 0.0));
}

#[test]
fn a_sweep_uses_the_last_factors_of_load_steps() {
    let temp = tempfile::tempdir().unwrap();
    let e_cre = |name: &str, more: &[&str]| {
        let out = temp.path().join(format!("{}{}", name.replace('/', "-"), more.len()));
        let output = sweep_of(name, &out, more);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        column(&out, "sweep.csv", "e_cre")
    };
    let in_steps = e_cre("certify-steps/case.toml", &[]);
    assert_eq!(in_steps, e_cre("certify-steps/full.toml", &["--set", "body.0.traction.0.vector=[0.0, 0.3]"]));
    assert_ne!(in_steps, e_cre("certify-steps/full.toml", &[]));
}

#[test]
fn a_run_without_value_is_a_dash_and_a_sweep_of_such_runs_is_not_converged() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("none");
    let output = sweep(&out, "solver.theta=[1e200]", &[]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(5), "{said}");
    assert!(said.contains("diverged: no run of this sweep has an eta_nndd"), "{said}");
    assert!(!said.contains("NaN") && !said.contains("inf"), "{said}");
    assert_eq!(column(&out, "sweep.csv", "eta_nndd"), [""]);
    let output = sweep(&temp.path().join("some"), "solver.theta=[0.4, 1e200]", &[]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains("NaN") && said.contains("smallest eta_nndd"), "{said}");
}

#[test]
fn an_impossible_value_is_refused_before_the_first_run_and_called_by_its_option() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let output = sweep(&out, "solver.theta=[0.3, -1]", &[]);
    let complaint = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{complaint}");
    assert!(complaint.contains("--over solver.theta=-1") && !complaint.contains("--set"), "{complaint}");
    assert!(output.stdout.is_empty() && !out.exists(), "{}", text(&output.stdout));
    // An error that only shows when the problem is built keeps the rows before it.
    let output = sweep(&out, "body.0.generator.origin=[[0.0, 1.0], [0.0, 0.5]]", &[]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert_eq!(column(&out, "sweep.csv", "iteration").len(), 1);
    let out = temp.path().join("panel");
    let output = sweep(&out, "solver.theta=[0.3]", &["--panel", "solver.weights=none"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("--panel solver.weights=none"), "{}", text(&output.stderr));
    // If nothing was run, nothing is written.
    let out = temp.path().join("nothing");
    assert_eq!(sweep(&out, "solver.theta=[-1, 0.3]", &[]).status.code(), Some(3));
    assert!(!out.join("sweep.json").exists());
}

#[test]
fn panels_of_one_size_have_names_of_their_own() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let output = sweep(&out, "solver.theta=[0.3, 0.4]", &["--panel", "solver.weights=stiffness"]);
    let said = text(&output.stdout);
    for name in ["\n380 nodes\n", "\n380 nodes (solver.weights=stiffness)\n"] {
        assert!(said.contains(name), "{said}");
    }
    assert_eq!(column(&out, "sweep-2.csv", "settings"), ["solver.weights=stiffness"; 2]);
    let figure = std::fs::read_to_string(out.join("figures/sweep.svg")).unwrap();
    assert!(
        figure.contains("380 nodes: smallest") && figure.contains("(solver.weights=stiffness): smallest")
    );
}

#[test]
fn a_range_that_is_none_is_a_wrong_command_line() {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    for over in ["solver.theta", "solver.theta=0.1:0.9", "solver.theta=1:0:0.1"] {
        let output = sweep(&out, over, &[]);
        assert_eq!(output.status.code(), Some(2), "{over}: {}", text(&output.stderr));
    }
    // A range of an unknown key is an error of the case.
    assert_eq!(sweep(&out, "solver.theata=0.1:0.9:0.1", &[]).status.code(), Some(3));
}

#[test]
fn verbose_says_what_was_chosen_for_each_value() {
    let temp = tempfile::tempdir().unwrap();
    let output = sweep(&temp.path().join("sweep"), "solver.theta=[0.3, 0.4]", &["-v"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout).matches("lambda is carried by").count(), 2);
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_keeps_its_rows() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("sweep");
    let mut command = command("sweep", &out, &["--over", "solver.theta=0.1:0.9:0.0001"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while lines.read_line(&mut line).unwrap() > 0 && !line.trim_start().starts_with("0.1002 ") {
        line.clear();
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let mut said = String::new();
    lines.read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
    let rows = column(&out, "sweep.csv", "status").len();
    assert!((3..8001).contains(&rows), "{rows}");
    assert!(said.contains(&format!("interrupted: by a signal after {rows} of 8001 runs")), "{said}");
    let record: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("sweep.json")).unwrap()).unwrap();
    assert_eq!(record["run"]["interrupted"], true);
    assert!(out.join("figures/sweep.svg").exists());
}
