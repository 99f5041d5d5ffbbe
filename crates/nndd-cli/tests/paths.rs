//! Results along lines and circles, and limits of materials.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Two blocks under a pressure of 6: the stress is uniform.
const BLOCKS: &str = r#"
schema = 1
[model]
hypothesis = "plane_stress"
[materials.soft]
young = 1000.0
poisson = 0.25
limit = 8.0
[materials.hard]
young = 2000.0
poisson = 0.25
limit = 4.0
[[body]]
name = "lower"
material = "soft"
generator = { kind = "block", origin = [0.0, 0.0], size = [2.0, 1.0], cells = [7, 4] }
[[body.displacement]]
on = "bottom"
uy = 0.0
[[body.displacement]]
on = "left"
ux = 0.0
[[body]]
name = "upper"
material = "hard"
generator = { kind = "block", origin = [0.0, 1.0], size = [2.0, 1.0], cells = [7, 4] }
[[body.displacement]]
on = "left"
ux = 0.0
[[body.traction]]
on = "top"
pressure = 6.0
[contact]
surfaces = ["top", "bottom"]
gap = 0.0
"#;

const PATHS: &str = r#"
[[output.path]]
name = "down"
from = [0.3, 2.5]
to = [0.3, 0.0]
points = 11
[[output.path]]
name = "a ring"
circle = { centre = [1.0, 1.0], radius = 0.5 }
points = 8
"#;

/// A name too long for a file.
const LONG: &str = "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\"";

/// A cube under a pressure of 3 on a plane.
const CUBE: &str = r#"
schema = 1
contact = []
[model]
hypothesis = "solid"
[materials.m]
young = 100.0
poisson = 0.0
[[body]]
name = "cube"
material = "m"
generator = { kind = "box", origin = [0.0, 0.0, 0.0], size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
[[body.displacement]]
on = "bottom"
uz = 0.0
[[body.displacement]]
on = "left"
ux = 0.0
[[body.displacement]]
on = "front"
uy = 0.0
[[body.traction]]
on = "top"
pressure = 3.0
[[output.path]]
name = "arc"
circle = { centre = [0.0, 0.5, 0.5], radius = 0.4, angles = [0.0, 90.0], axis = [0.0, 2.0, 0.0] }
points = 3
"#;

fn solve(text: &str, folder: &Path) -> Output {
    let file = folder.join("case.toml");
    std::fs::write(&file, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_nndd"));
    command
        .args(["solve", "--quiet", "--set", "output.vtu=false", "--out"])
        .arg(folder.join("out"))
        .arg(file);
    command.output().unwrap()
}

/// Reads a table: its columns, and its rows as texts.
fn table(file: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

fn number(text: &str) -> f64 {
    text.parse().unwrap()
}

fn assert_near(found: &str, expected: f64, what: &str) {
    assert!((number(found) - expected).abs() < 1e-9, "{what}: {found} instead of {expected}");
}

#[test]
fn a_uniform_stress_is_written_along_lines_and_circles() {
    let folder = tempfile::tempdir().unwrap();
    let done = solve(&format!("{BLOCKS}{PATHS}"), folder.path());
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let out = folder.path().join("out");
    let (columns, rows) = table(&out.join("path-down.csv"));
    let expected = "s,x,y,body,ux,uy,stress_xx,stress_yy,stress_zz,stress_xy,von_mises,principal_smallest,principal_largest";
    assert_eq!(columns.join(","), expected);
    // Two points are above the bodies, and both bodies are at one of the others.
    assert_eq!(rows.len(), 12);
    assert!(rows[..2].iter().all(|row| row[3..].iter().all(String::is_empty)), "{rows:?}");
    let names: Vec<&str> = rows[2..].iter().map(|row| row[3].as_str()).collect();
    assert_eq!(names[..6], ["upper", "upper", "upper", "upper", "lower", "upper"]);
    assert!(names[6..].iter().all(|name| *name == "lower"));
    for row in &rows[2..] {
        let y = number(&row[2]);
        let (young, uy) = match row[3].as_str() {
            "lower" => (1000.0, -6e-3 * y),
            _ => (2000.0, -6e-3 - 3e-3 * (y - 1.0)),
        };
        assert_near(&row[0], 2.5 - y, "s");
        for (place, expected) in
            [0.25 * 6.0 / young * 0.3, uy, 0.0, -6.0, 0.0, 0.0, 6.0, -6.0, 0.0].into_iter().enumerate()
        {
            assert_near(&row[4 + place], expected, &columns[4 + place]);
        }
    }
    let (_, ring) = table(&out.join("path-a_ring.csv"));
    assert_near(&ring.last().unwrap()[0], std::f64::consts::PI, "length");
    assert!(ring.iter().all(|row| (number(&row[1]) - 1.0).hypot(number(&row[2]) - 1.0) > 0.5 - 1e-12));
    ring.iter().for_each(|row| assert_near(&row[7], -6.0, "stress_yy"));
    assert!(out.join("figures/path-a_ring.svg").is_file() && out.join("figures/path-down.svg").is_file());
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().contains("path-a_ring.csv"));
}

#[test]
fn a_point_just_outside_has_the_values_of_the_cell_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    // The cells are a quarter high: a tenth of that is beside them.
    let path = |name: &str, y: f64| {
        format!("[[output.path]]\nname = \"{name}\"\nfrom = [0.1, {y}]\nto = [1.9, {y}]\npoints = 7\n")
    };
    let done = solve(&format!("{BLOCKS}{}{}", path("beside", -0.024), path("away", -0.026)), folder.path());
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let (_, beside) = table(&folder.path().join("out/path-beside.csv"));
    for row in &beside {
        assert_eq!(row[3], "lower");
        assert_near(&row[5], 6e-3 * 0.024, "uy");
        assert_near(&row[7], -6.0, "stress_yy");
    }
    let (_, away) = table(&folder.path().join("out/path-away.csv"));
    assert!(away.len() == 7 && away.iter().all(|row| row[3].is_empty()), "{away:?}");
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("7 of 7 points are outside of all bodies"));
}

#[test]
fn a_limit_with_which_nothing_is_compared_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let text = BLOCKS.replacen("plane_stress", "plane_strain", 1).replacen(
        "young = 2000.0\npoisson = 0.25",
        "stiffness = [[2000.0, 0.0, 0.0], [0.0, 2000.0, 0.0], [0.0, 0.0, 1000.0]]",
        1,
    );
    let done = solve(&text, folder.path());
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let said = std::fs::read_to_string(folder.path().join("out/report.json")).unwrap().replace("\\\"", "\"");
    assert!(said.contains("material \"hard\": nothing is compared with its limit 4"), "{said}");
    assert!(said.contains("material \"soft\": the largest recovered von Mises stress is"), "{said}");
}

#[test]
fn limits_are_compared_with_the_largest_stress() {
    let folder = tempfile::tempdir().unwrap();
    let done = solve(BLOCKS, folder.path());
    let said = String::from_utf8_lossy(&done.stderr);
    let text = std::fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let limits = report["results"]["stress_limits"].as_array().unwrap();
    for (found, (material, share)) in limits.iter().zip([("soft", 0.75), ("hard", 1.5)]) {
        assert_eq!(found["material"], material);
        assert!((found["share"].as_f64().unwrap() - share).abs() < 1e-9, "{found}");
    }
    let notes = report["notes"].to_string();
    assert!(
        notes.contains("1.50 of its limit 4, above it") && notes.contains("0.750 of its limit 8, in"),
        "{notes}\n{said}"
    );
}

#[test]
fn an_arc_in_space_turns_around_its_axis() {
    let folder = tempfile::tempdir().unwrap();
    let done = solve(CUBE, folder.path());
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let (columns, rows) = table(&folder.path().join("out/path-arc.csv"));
    let place = |name: &str| columns.iter().position(|column| column == name).unwrap();
    // From the x axis around y: by 90 degrees to −z.
    for (row, [x, z]) in
        rows.iter().zip([[0.4, 0.5], [0.4 * 0.5f64.sqrt(), 0.5 - 0.4 * 0.5f64.sqrt()], [0.0, 0.1]])
    {
        assert_near(&row[place("x")], x, "x");
        assert_near(&row[place("z")], z, "z");
        assert_near(&row[place("uz")], -0.03 * z, "uz");
        assert_near(&row[place("stress_zz")], -3.0, "stress_zz");
        assert_near(&row[place("stress_xz")], 0.0, "stress_xz");
        assert_near(&row[place("principal_smallest")], -3.0, "principal_smallest");
    }
}

#[test]
fn wrong_paths_are_refused_with_their_place() {
    for (from, to, said) in [
        ("to = [0.3, 0.0]", "to = [0.3, 2.5]", "the line from `from` to `to` has the length 0"),
        ("to = [0.3, 0.0]", "to = [1e300, 0.0]", "the line from `from` to `to` has the length"),
        ("to = [0.3, 0.0]\n", "", "`output.path.0.to` is missing"),
        ("points = 11", "points = 1", "`output.path.0.points` is 1"),
        ("points = 11", "points = 1000000", "at most 100000"),
        ("\"a ring\"", "\"Down\"", "\"Down\" cannot name this path"),
        ("\"a ring\"", "\" \"", "cannot name this path"),
        ("\"a ring\"", LONG, "cannot name this path"),
        ("name = \"a ring\"\n", "", "`output.path.1.name` is missing"),
        ("radius = 0.5", "radius = 0.0", "a number > 0"),
        ("radius = 0.5", "radius = 0.5, axis = [0, 0, 1]", "axis"),
        ("radius = 0.5", "radius = 1e300", "a number > 0"),
        ("radius = 0.5", "radius = 0.5, angles = [30, 30]", "an arc of 0 degrees"),
        ("radius = 0.5", "radius = 0.5, angles = [0, 1e300]", "at most 360 degrees apart"),
        ("points = 8", "to = [1.0, 1.0]", "both a circle and the ends of a line"),
        ("limit = 8.0", "limit = 0.0", "a stress > 0"),
    ] {
        let text = format!("{BLOCKS}{PATHS}").replacen(from, to, 1);
        let folder = tempfile::tempdir().unwrap();
        let done = solve(&text, folder.path());
        let error = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(3), "{to}: {error}");
        assert!(error.contains(said), "{to}: {error}");
    }
}
