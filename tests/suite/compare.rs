//! Comparing two runs: their rows, and the problems of which they are.

use case_io::case::AnyCase;
use nndd_report::compare::{Comparison, Problems, Row, Values, compare, summary, table};
use nndd_report::{Host, ReportSpace, RunDirectory, Stopwatch, files, run};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

struct Quiet;

impl Host for Quiet {
    fn elapsed(&self) -> f64 {
        0.0
    }
}

fn write<S: ReportSpace>(case: &case_io::Case<S>, out: &Path) {
    let mut watch = Stopwatch::start(0.0);
    let built = run::build(case, &Quiet).unwrap();
    let mut place = RunDirectory::open(case, out, false).unwrap();
    let solved = run::solve(case, built, &mut place, &mut watch, &mut Quiet).unwrap();
    files::write(case, &solved, place, serde_json::Map::new(), &mut watch, &Quiet).unwrap();
}

/// Solves a case of `tests/cases` with settings; returns its folder below another.
fn solved(temp: &TempDir, name: &str, case: &str, settings: &[&str]) -> PathBuf {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(case).with_extension("toml");
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let out = temp.path().join(name);
    match run::read_case(&file, &run::overrides(&settings).unwrap()).unwrap() {
        AnyCase::Plane(case) => write(&case, &out),
        AnyCase::Solid(case) => write(&case, &out),
    }
    out
}

fn row<'a>(found: &'a Comparison, of: &str, name: &str) -> &'a Row {
    found.rows.iter().find(|row| row.of == of && row.name == name).unwrap_or_else(|| panic!("{of} {name}"))
}

/// Checks that the table has no number that is not finite, no wide line, and the sentence.
fn printed(found: &Comparison, sentence: &str) -> String {
    let text = table(found);
    assert!(text.contains(sentence), "{text}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    assert!(text.lines().skip(2).all(|line| line.chars().count() <= 110), "{text}");
    text
}

#[test]
fn a_run_compared_with_itself_has_zero_differences() {
    let temp = tempfile::tempdir().unwrap();
    for case in ["paper", "tresca", "solid/stack", "foundation", "flange"] {
        let out = solved(&temp, case, case, &[]);
        let found = compare([&out, &out]).unwrap();
        assert_eq!((found.problems, found.settings.len()), (Problems::Same, 0), "{case}");
        printed(&found, "their intervals meet, as they must");
        for row in &found.rows {
            match &row.values {
                Values::Words([a, b]) => assert_eq!(a, b),
                Values::Numbers([Some(_), Some(_)]) | Values::Bounds([Some(_), Some(_)]) => {
                    assert_eq!((row.difference(), row.percent()), (Some(0.0), Some(0.0)), "{row:?}");
                }
                Values::Numbers(values) | Values::Bounds(values) => assert_eq!(*values, [None; 2], "{row:?}"),
                Values::Intervals(values) => assert_eq!(row.meet(), values[0].map(|_| true), "{row:?}"),
            }
        }
    }
}

#[test]
fn two_meshes_of_blocks_are_one_problem_whose_intervals_meet() {
    let temp = tempfile::tempdir().unwrap();
    let finer = |cells: &str, bodies: usize| -> Vec<String> {
        (0..bodies).map(|body| format!("body.{body}.generator.cells={cells}")).collect()
    };
    for (case, settings) in [("tresca", finer("[36,18]", 2)), ("solid/stack", finer("[6,3,3]", 3))] {
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let a = solved(&temp, &format!("{case}-a"), case, &[]);
        let b = solved(&temp, &format!("{case}-b"), case, &settings);
        let found = compare([&a, &b]).unwrap();
        assert_eq!((found.problems, found.settings.len()), (Problems::Same, settings.len()), "{case}");
        let text = printed(&found, "their intervals meet, as they must");
        let norm = row(&found, "", "bounds of energy norm");
        assert_eq!(norm.meet(), Some(true), "{norm:?}");
        assert_ne!(row(&found, "", "energy norm").difference(), Some(0.0));
        // Of a bound no number is printed that is below it.
        let Values::Bounds([Some(bound), _]) = row(&found, "", "bound e_CRE").values else {
            panic!("{found:?}")
        };
        let line = text.lines().find(|line| line.starts_with("bound e_CRE ")).unwrap();
        assert!(line.split_whitespace().nth(2).unwrap().parse::<f64>().unwrap() >= bound, "{line} {bound}");
    }
}

#[test]
fn an_interval_that_is_false_is_named() {
    let temp = tempfile::tempdir().unwrap();
    let [a, b] = ["a", "b"].map(|name| solved(&temp, name, "patch", &[]));
    let path = b.join("report.json");
    let mut report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    report["certificate"]["bounds"]["energy_norm"] = serde_json::json!([1e3, 1e3]);
    std::fs::write(&path, report.to_string()).unwrap();
    let found = compare([&a, &b]).unwrap();
    let text = printed(&found, "of two intervals that do not meet, one is false");
    assert!(text.contains("do not meet\n"), "{text}");
    let object = summary(&found);
    let rows = object["rows"].as_array().unwrap();
    let norm = rows.iter().find(|row| row["name"] == "bounds of energy norm").unwrap();
    assert_eq!((&norm["meet"], &norm["b"][0]), (&false.into(), &1e3.into()));
}

#[test]
fn other_loads_are_other_problems_and_curves_follow_their_mesh() {
    let temp = tempfile::tempdir().unwrap();
    let a = solved(&temp, "a", "tresca", &[]);
    let b = solved(&temp, "b", "tresca", &["body.0.displacement.0.uy=-0.03"]);
    let found = compare([&a, &b]).unwrap();
    assert_eq!(found.problems, Problems::Other);
    assert_eq!(found.settings, ["body.0.displacement.0.uy was -0.02 and is -0.03"]);
    printed(&found, "intervals are of different problems and need not meet");
    let b = solved(&temp, "method", "tresca", &["solver.qp=\"active-set\"", "estimator.relaxation=3"]);
    assert_eq!(compare([&a, &b]).unwrap().problems, Problems::Same);
    // Data that are not linear are other data on a finer mesh.
    let curved = "body.0.displacement.0.uy=\"-0.02 - 0.001*x^2\"";
    let cells = ["body.0.generator.cells=[36,18]", "body.1.generator.cells=[36,18]"];
    let a = solved(&temp, "curved", "tresca", &[curved]);
    let b = solved(&temp, "curved-finer", "tresca", &[curved, cells[0], cells[1]]);
    assert_eq!(compare([&a, &b]).unwrap().problems, Problems::OtherMeshes);
    // The polygon of a ring is another body on a finer mesh.
    let a = solved(&temp, "rings", "rings", &[]);
    let b = solved(
        &temp,
        "finer",
        "rings",
        &["body.0.generator.cells=[48,12]", "body.1.generator.cells=[48,12]"],
    );
    assert_eq!(compare([&a, &b]).unwrap().problems, Problems::OtherMeshes);
    assert_eq!(compare([&a, &a]).unwrap().problems, Problems::Same);
}

#[test]
fn without_a_bound_there_are_residuals_or_dashes() {
    let temp = tempfile::tempdir().unwrap();
    let a = solved(&temp, "a", "coulomb", &[]);
    let b = solved(&temp, "b", "coulomb", &["contact.friction.mu=0.1"]);
    let found = compare([&a, &b]).unwrap();
    assert!(row(&found, "", "residual e_b").difference().is_some());
    assert_eq!(row(&found, "", "bounds of energy norm").values, Values::Intervals([None; 2]));
    assert!(!printed(&found, "residual e_b, relative").contains("intervals"));
    // A run that ended before it had a result.
    let path = b.join("report.json");
    let mut report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    for (_, value) in report["results"].as_object_mut().unwrap() {
        *value = serde_json::Value::Null;
    }
    report["coulomb"] = serde_json::Value::Null;
    std::fs::write(&path, report.to_string()).unwrap();
    let found = compare([&a, &b]).unwrap();
    let Values::Numbers([Some(_), None]) = row(&found, "", "energy norm").values else { panic!("{found:?}") };
    printed(&found, "-");
}
