//! Cases whose surfaces do not match, as a user runs them: the note, the result, matching cases untouched.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::Path;
use std::process::{Command, Output};

fn nndd(command: &str, case: &str, more: &[&str], directory: &Path) -> Output {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(case);
    let mut arguments = vec![command, path.to_str().unwrap()];
    arguments.extend(more);
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(directory).output().unwrap()
}

#[test]
fn the_note_is_said_by_check_and_solve_and_written_down() {
    let temp = tempfile::tempdir().unwrap();
    let note = "the contact surfaces do not match and were refined in common: \"upper\"";
    let checked = nndd("check", "nonmatching.toml", &[], temp.path());
    let said = String::from_utf8_lossy(&checked.stderr).into_owned();
    assert_eq!(checked.status.code(), Some(0), "{said}");
    assert!(said.contains(&format!("note: {note}")), "{said}");
    let solved = nndd("solve", "nonmatching.toml", &["--out", "out"], temp.path());
    let said = String::from_utf8_lossy(&solved.stderr).into_owned();
    assert_eq!(solved.status.code(), Some(0), "{said}");
    assert!(said.contains(&format!("note: {note}")), "{said}");
    let text = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
    let report = Report::from_json(&text).unwrap();
    assert!(report.certificate.as_ref().unwrap().valid);
    let of_surfaces: Vec<&String> = report.notes.iter().filter(|text| text.starts_with(note)).collect();
    assert!(of_surfaces.len() == 1 && of_surfaces[0].contains("is free"), "{:?}", report.notes);
    assert!((report.contact[0].line.as_ref().unwrap().length - 1.5).abs() < 1e-12);
    // A sweep has the same mesh, and a matching case no note.
    let swept = nndd("sweep", "nonmatching.toml", &["--over", "solver.theta=0.4:0.5:0.1"], temp.path());
    assert_eq!(swept.status.code(), Some(0), "{}", String::from_utf8_lossy(&swept.stderr));
    let matching = nndd("check", "paper.toml", &[], temp.path());
    assert!(!String::from_utf8_lossy(&matching.stderr).contains("note:"));
}

#[test]
fn bent_lines_of_different_counts_are_solved_and_each_stretch_has_its_results() {
    let temp = tempfile::tempdir().unwrap();
    let changed = ["--out", "out", "--set", "body.0.generator.cells=[23, 10]"];
    let solved = nndd("solve", "rings.toml", &changed, temp.path());
    let said = String::from_utf8_lossy(&solved.stderr).into_owned();
    assert_eq!(solved.status.code(), Some(0), "{said}");
    assert!(said.contains("the gap is measured between smooth curves"), "{said}");
    let text = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
    let report = Report::from_json(&text).unwrap();
    assert!(report.certificate.as_ref().unwrap().valid);
    // Lame's pressure, as rings.toml says.
    let Some([stretch]) = report.results.lines.as_ref().unwrap().contact_stretches.as_deref() else {
        panic!("{text}")
    };
    let mean = stretch.contact_force / stretch.length;
    assert!((mean / 7.208947 - 1.0).abs() < 1e-3, "{mean}");
    assert!((stretch.max_edge_pressure / 7.208947 - 1.0).abs() < 0.05, "{stretch:?}");
    assert!(stretch.max_pressure >= stretch.max_edge_pressure, "{stretch:?}");
    assert_eq!(
        (stretch.pairs, stretch.length),
        (report.contact[0].pairs, report.contact[0].line.as_ref().unwrap().length)
    );
    assert!((stretch.contact_force / report.results.contact_force.unwrap() - 1.0).abs() < 1e-12);
}

#[test]
fn a_closed_line_in_contact_everywhere_is_in_contact_on_its_whole_length() {
    let temp = tempfile::tempdir().unwrap();
    let solved = nndd("solve", "rings_whole.toml", &["--out", "out"], temp.path());
    assert_eq!(solved.status.code(), Some(0), "{}", String::from_utf8_lossy(&solved.stderr));
    let text = std::fs::read_to_string(temp.path().join("out/report.json")).unwrap();
    let results = Report::from_json(&text).unwrap().results;
    let [stretch] = &results.lines.as_ref().unwrap().contact_stretches.as_ref().unwrap()[..] else {
        panic!("{text}")
    };
    let [[start, end]] = results.lines.as_ref().unwrap().contact_intervals.as_ref().unwrap()[..] else {
        panic!("{text}")
    };
    assert!(start == 0.0 && (end / stretch.length - 1.0).abs() < 1e-12, "{start} {end} {}", stretch.length);
    assert!((stretch.s[1] / stretch.length - 1.0).abs() < 1e-12, "{stretch:?}");
}

#[test]
fn a_corner_of_the_contact_line_gets_a_note() {
    let temp = tempfile::tempdir().unwrap();
    let cells = |n: &str| {
        let set = |b: usize| format!("body.{b}.generator.cells=[{n}, 2]");
        let checked = nndd("check", "rings.toml", &["--set", &set(0), "--set", &set(1)], temp.path());
        (checked.status.code(), String::from_utf8_lossy(&checked.stderr).into_owned())
    };
    let (code, said) = cells("2");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("the contact line turns by 45.0 degrees at (1.06"), "{said}");
    let (code, said) = cells("4");
    assert!(code == Some(0) && !said.contains("turns by"), "{said}");
}
