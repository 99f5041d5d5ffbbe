//! `nndd compare`: its exit status, and what it prints.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the command; returns its exit status and what it printed.
fn nndd(arguments: &[&str], folder: &Path) -> (i32, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Solves a case of `tests/cases` into a folder.
fn solve(case: &str, out: &str, folder: &Path) {
    let case: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(case);
    let (code, _, said) = nndd(&["solve", case.to_str().unwrap(), "--quiet", "--out", out], folder);
    assert_eq!(code, 0, "{said}");
}

#[test]
fn two_runs_are_compared() {
    let temp = tempfile::tempdir().unwrap();
    solve("patch.toml", "a", temp.path());
    let (code, said, _) = nndd(&["compare", "a", "a"], temp.path());
    assert_eq!(code, 0);
    for part in ["A  a\n", "e_CRE", "body \"upper\"", "contact force", "meet", "one problem"] {
        assert!(said.contains(part), "{part}\n{said}");
    }
    let (code, said, _) = nndd(&["compare", "a", "a", "--format", "json"], temp.path());
    let object: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((code, said.lines().count(), &object["problems"]), (0, 1, &"same".into()));
    let nodes = object["rows"].as_array().unwrap().iter().find(|row| row["name"] == "nodes").unwrap();
    assert_eq!((&nodes["a"], &nodes["difference"]), (&45.0.into(), &0.0.into()));
}

#[test]
fn other_bodies_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    for (case, out) in [("patch.toml", "plane"), ("foundation.toml", "beam"), ("solid/stack.toml", "solid")] {
        solve(case, out, temp.path());
    }
    for other in ["beam", "solid"] {
        let (code, said, why) = nndd(&["compare", "plane", other], temp.path());
        assert_eq!((code, said.as_str()), (3, ""), "{why}");
        assert!(why.contains("the bodies differ") && why.contains("\n  fix: "), "{why}");
    }
}

#[test]
fn a_folder_without_a_report_cannot_be_read() {
    let temp = tempfile::tempdir().unwrap();
    solve("patch.toml", "a", temp.path());
    let report = std::fs::read_to_string(temp.path().join("a/report.json")).unwrap();
    let next = report.replacen("\"schema\": 1", "\"schema\": 2", 1);
    let files = [
        ("cut", &report[..report.len() / 2]),
        ("list", "[]"),
        ("other", "{\"schema\": 1}"),
        ("huge", "1e999"),
        ("next", next.as_str()),
    ];
    for (name, text) in files {
        std::fs::create_dir(temp.path().join(name)).unwrap();
        std::fs::write(temp.path().join(name).join("report.json"), text).unwrap();
    }
    std::fs::create_dir(temp.path().join("empty")).unwrap();
    for other in ["cut", "list", "other", "huge", "next", "empty", "missing", "a/report.json"] {
        for pair in [["a", other], [other, "a"]] {
            let (code, said, why) = nndd(&["compare", pair[0], pair[1]], temp.path());
            assert_eq!((code, said.as_str()), (7, ""), "{other}: {why}");
            assert!(why.contains("cannot read") && why.contains("\n  expected: "), "{why}");
        }
    }
    let (_, said, _) = nndd(&["compare", "a", "empty", "--format", "json"], temp.path());
    let object: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((&object["event"], &object["code"]), (&"failed".into(), &7.into()));
    assert_eq!(nndd(&["compare", "a"], temp.path()).0, 2);
}
