//! Expressions, materials and thickness, from the case file to the report.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases").join(name)
}

/// Solves a case and returns what was said, and the report.
fn solve(name: &str, settings: &[&str], folder: &Path) -> (String, Report) {
    let out = folder.join("out");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_nndd"));
    command.arg("solve").arg(case(name)).arg("--out").arg(&out).arg("--force");
    for setting in settings {
        command.args(["--set", setting]);
    }
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    (said, Report::from_json(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap())
}

/// The note on interpolated data; the strains of these examples, whose modulus is 1, are worth others.
fn interpolated(report: &Report) -> Vec<&String> {
    report.notes.iter().filter(|note| note.contains("the bound is for interpolated data")).collect()
}

#[test]
fn the_report_says_that_the_bound_is_for_interpolated_data() {
    let temp = tempfile::tempdir().unwrap();
    let (said, report) = solve("expressions.toml", &[], temp.path());
    assert!(report.certificate.as_ref().unwrap().valid);
    let force = report.results.contact_force.unwrap();
    assert!((force - 2.0 / 3.0).abs() < 5e-3, "{force}");
    // The worst of them, and how many others.
    let [note] = interpolated(&report)[..] else { panic!("{:#?}", report.notes) };
    assert!(note.contains("traction y") && note.contains("11 other data"), "{note}");
    for note in &report.notes {
        assert!(said.contains(note.as_str()), "{said}");
    }
    assert_eq!(report.case["body"][0]["traction"][1]["on"], "right");
    // The note of an adaptive run is for its last mesh, whose data are nearer to the expressions.
    let adaptive = [
        "adapt={target_relative_error=0.03}",
        "body.0.generator.cells=[8,4]",
        "body.1.generator.cells=[8,4]",
    ];
    let (_, finer) = solve("expressions.toml", &adaptive, temp.path());
    assert!(finer.adaptive.len() > 1);
    let mean = |note: &String| -> f64 {
        let text = note.rsplit_once('(').unwrap().1;
        text.split(' ').next().unwrap().parse().unwrap()
    };
    let (coarse, _) = {
        let settings = ["adapt={target_relative_error=0.5}", adaptive[1], adaptive[2]];
        let (_, report) = solve("expressions.toml", &settings, temp.path());
        assert_eq!(report.adaptive.len(), 1);
        (interpolated(&report).into_iter().map(mean).fold(0.0, f64::max), report)
    };
    let fine = interpolated(&finer).into_iter().map(mean).fold(0.0, f64::max);
    assert!(fine < coarse, "{fine} {coarse}");
}

#[test]
fn an_adaptive_run_speaks_of_the_data_of_its_last_mesh_alone() {
    let temp = tempfile::tempdir().unwrap();
    let (said, report) = solve("kirsch.toml", &["adapt.target_relative_error=0.05"], temp.path());
    assert!(report.adaptive.len() > 1);
    let notes: Vec<&str> = said.lines().filter(|line| line.contains("interpolated data")).collect();
    assert_eq!(notes.len(), interpolated(&report).len(), "{said}");
    assert!(interpolated(&report).iter().all(|note| said.contains(note.as_str())), "{said}");
}

#[test]
fn notes_are_worth_reading_and_the_important_ones_come_first() {
    let temp = tempfile::tempdir().unwrap();
    // A motion of 1e-7 to make the field admissible is nothing beside displacements of 0.03.
    let (_, rings) = solve("rings.toml", &[], temp.path());
    assert!(rings.notes.iter().all(|note| !note.contains("were moved by")), "{:#?}", rings.notes);
    let (_, roller) = solve("roller_half.toml", &["adapt.target_relative_error=0.06"], temp.path());
    let place = |words: &str| roller.notes.iter().position(|note| note.contains(words)).unwrap();
    assert!(place("declare the curve") < place("the contact line bends"), "{:#?}", roller.notes);
}

#[test]
fn materials_of_every_kind_are_certified_without_notes() {
    let temp = tempfile::tempdir().unwrap();
    let (_, report) = solve("materials.toml", &[], temp.path());
    assert!(report.certificate.as_ref().unwrap().valid);
    assert_eq!(report.notes, [] as [&str; 0]);
    assert!(report.results.max_von_mises.unwrap() > 0.0);
    // All results are per unit thickness.
    let (_, thin) = solve("materials.toml", &["model.thickness=1.0"], temp.path());
    assert_eq!((thin.results, thin.certificate), (report.results.clone(), report.certificate));
    let page = |thickness: &str| {
        let _ = solve("materials.toml", &[thickness], temp.path());
        std::fs::read_to_string(temp.path().join("out/report.html")).unwrap()
    };
    assert_ne!(page("model.thickness=1.0"), page("model.thickness=18.0"));
}

#[test]
fn the_equivalent_stress_is_null_where_it_is_not_known() {
    let temp = tempfile::tempdir().unwrap();
    let (_, report) = solve("materials.toml", &["model.hypothesis='plane_strain'"], temp.path());
    assert!(report.certificate.as_ref().unwrap().valid);
    assert_eq!(report.results.max_von_mises, None);
    assert!(
        report.notes[0].contains("material \"laminate\": a plane stiffness in plane strain"),
        "{:?}",
        report.notes
    );
    let vtu = |name: &str| {
        String::from_utf8_lossy(&std::fs::read(temp.path().join("out").join(name)).unwrap()).into_owned()
    };
    assert!(!vtu("block.vtu").contains("von_mises") && vtu("sheet.vtu").contains("von_mises"));
}
