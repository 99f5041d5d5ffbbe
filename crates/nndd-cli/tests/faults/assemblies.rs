//! Faults of assemblies: pairs, obstacles, stamps, rigid sides, discs.

use super::*;
use case_io::Case;
use case_io::diagnostic::Diagnostic;

/// A case, what is replaced in it, by what, and words of the message.
type Fault = (&'static str, &'static str, &'static str, &'static [&'static str]);

const TOP: &str = "surfaces = [\"top\"]\n";
const BOTTOM: &str = "surfaces = [\"bottom\"]\n";
const STAMP: &str = "force = [0.0, -0.8]";
const ABOUT: &str = "about = [1.1, 2.0]\n";
const DISC: &str = "radius = 5.0, cells = 32";

const PAIRS: &[Fault] = &[
    ("press", TOP, "surfaces = [\"top\"]\nfriction = 0.3\n", &["`contact.1.friction`", "a table"]),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = {}\n",
        &["`contact.1.friction.law` is missing", "law = \"tresca\""],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"stick\" }\n",
        &["`contact.1.friction.law` is \"stick\"", "\"tresca\""],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"coulomb\" }\n",
        &["`contact.1.friction.mu` is missing", "mu = 0.3"],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"coulomb\", mu = -0.3 }\n",
        &["`contact.1.friction.mu` is -0.3", "a number >= 0"],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"coulomb\", mu = nan }\n",
        &["`contact.1.friction.mu` is "],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"tresca\" }\n",
        &["`contact.1.friction.limit` is missing", "limit = 4.0"],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"tresca\", limit = -1.0 }\n",
        &["`contact.1.friction.limit` is negative", "a number >= 0"],
    ),
    (
        "press",
        TOP,
        "surfaces = [\"top\"]\nfriction = { law = \"tresca\", limit = \"x - 1\" }\n",
        &["the friction limit at", "a finite number >= 0"],
    ),
    (
        "press",
        "bodies = [\"block\"]\nsurfaces = [\"top\"]",
        "bodies = \"block\"\nsurfaces = [\"top\"]",
        &["an array of strings"],
    ),
    (
        "press",
        "[\"block\"]\nsurfaces = [\"top\"]",
        "[\"blok\"]\nsurfaces = [\"top\"]",
        &["which is no body", "did you mean \"block\""],
    ),
    (
        "press",
        "[\"block\"]\nsurfaces = [\"top\"]",
        "[]\nsurfaces = [\"top\"]",
        &["has 0 entries", "one body: the other partner is the obstacle"],
    ),
    (
        "press",
        "[\"block\"]\nsurfaces = [\"top\"]",
        "[\"block\", \"block\"]\nsurfaces = [\"top\"]",
        &["has 2 entries"],
    ),
    ("press", TOP, "surfaces = []\n", &["`contact.1.surfaces` has 0 entries"]),
    ("press", TOP, "surfaces = [\"top\", \"left\"]\n", &["`contact.1.surfaces` has 2 entries"]),
    ("press", TOP, "surfaces = 3\n", &["an array of strings"]),
    ("press", TOP, "", &["`contact.1.surfaces` is missing"]),
    ("press", TOP, "surfaces = [\"topp\"]\n", &["no edge group \"topp\"", "did you mean \"top\""]),
    (
        "press",
        TOP,
        "surfaces = [\"right\"]\n",
        &["no edge on this side that faces the obstacle", "to 60 degrees"],
    ),
    ("press", "name = \"stamp\"", "name = \"Table\"", &["cannot name this pair"]),
    ("press", TOP, "surfaces = [\"top\"]\nnormal = [0.0, 1.0]\n", &["no meaning against an obstacle"]),
    ("press", TOP, "surfaces = [\"top\"]\nimposed = \"first\"\n", &["no meaning against an obstacle"]),
    (
        "press",
        BOTTOM,
        "surfaces = [\"bottom\"]\ngap = -0.1\ninterference = true\n",
        &["`contact.0.interference` keeps"],
    ),
    ("assembly", "bodies = [\"roller\", \"base\"]\n", "", &["`contact.0.bodies` is missing"]),
    ("assembly", "[\"roller\", \"base\"]", "[\"roller\", \"roller\"]", &["a body cannot touch itself"]),
    (
        "assembly",
        "[\"roller\", \"plate\"]\nsurfaces = [\"rim\", \"bottom\"]",
        "[\"base\", \"roller\"]\nsurfaces = [\"top\", \"rim\"]",
        &["this is the pair \"roller-base\" again"],
    ),
    ("assembly", "[\"rim\", \"top\"]", "[\"top\", \"rim\"]", &["swap the two names"]),
];

const OBSTACLES: &[Fault] = &[
    ("press", "kind = \"plane\"", "kind = \"line\"", &["\"plane\" or \"circle\""]),
    ("press", "kind = \"plane\", ", "", &["`contact.0.obstacle.kind` is missing"]),
    ("press", ", normal = [0.0, 1.0]", "", &["`contact.0.obstacle.normal` is missing"]),
    ("press", "normal = [0.0, 1.0]", "normal = [0.0, 0.0]", &["has no direction"]),
    (
        "press",
        "normal = [0.0, 1.0]",
        "normal = [0.0, -1.0]",
        &["faces the obstacle", "turn the obstacle round"],
    ),
    ("press", "point = [0.0, 0.0]", "point = [0.0, inf]", &["`contact.0.obstacle.point.1` is inf"]),
    (
        "press",
        "point = [0.0, 0.0]",
        "point = [0.0, 0.5]",
        &["overlaps the obstacle: deepest by 5.000e-1", ".toml:22:"],
    ),
    (
        "press",
        "centre = [0.0, 7.0]",
        "centre = [0.0, 6.0]",
        &["overlaps the obstacle: deepest by 1.000e0 at (0, 2)"],
    ),
    ("press", "radius = 5.0", "radius = -5.0", &["a number > 0"]),
    ("press", "radius = 5.0", "radius = nan", &["`contact.1.obstacle.radius` is NaN"]),
    ("press", "radius = 5.0", "radius = 5.0, side = \"left\"", &["\"outside\" or \"inside\""]),
    ("press", "radius = 5.0", "radius = 5.0, side = \"inside\"", &["faces the obstacle"]),
    (
        "press",
        "obstacle = { kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }",
        "obstacle = \"plane\"",
        &["expected a table"],
    ),
    ("press", "point = [0.0, 0.0], normal", "point = [0.0, 0.0], size = 3, normal", &["unknown key `size`"]),
    // A given gap does not hide where the obstacle is.
    (
        "press",
        "point = [0.0, 0.0], normal = [0.0, 1.0] }",
        "point = [0.0, 0.5], normal = [0.0, 1.0] }\ngap = 0.0",
        &["overlaps the obstacle by 5.000e-1", "within 5 % of an edge"],
    ),
    (
        "press",
        "point = [0.0, 0.0], normal = [0.0, 1.0] }",
        "point = [0.0, -1.0], normal = [0.0, 1.0] }\ngap = 0.0",
        &["is apart from the obstacle by 1.000e0"],
    ),
    ("press", "ux = 0.0\n", "fixed = true\n", &["a support holds along the normal of the obstacle"]),
    ("press", BOTTOM, "surfaces = [\"bottom\"]\nmotion = [0.0]\n", &["`contact.0.motion` has 1 entries"]),
    ("press", BOTTOM, "surfaces = [\"bottom\"]\nmotion = [nan, 0.0]\n", &["`contact.0.motion.0` is NaN"]),
    ("press", TOP, "surfaces = [\"top\"]\nmotion = [0.0, -0.1]\n", &["exclude each other"]),
    (
        "assembly",
        "[\"roller\", \"base\"]",
        "[\"roller\", \"base\"]\nmotion = [0.0, 0.1]",
        &["this pair has no obstacle"],
    ),
];

const STAMPS: &[Fault] = &[
    ("press", STAMP, "force = [0.0, nan]", &["`contact.1.obstacle.force.1` is NaN"]),
    ("press", STAMP, "force = [0.0, -inf]", &["`contact.1.obstacle.force.1` is -inf"]),
    ("press", STAMP, "force = -0.8", &["an array of two numbers"]),
    (
        "press",
        STAMP,
        "force = [0.2, -0.8]",
        &["`contact.1.obstacle.ux` is imposed, and a load acts along it"],
    ),
    ("press", STAMP, "force = [0.0, -0.8], moment = 0.1", &["`contact.1.obstacle.rotation` is imposed"]),
    ("press", STAMP, "uy = -0.1, force = [0.0, -0.8]", &["`contact.1.obstacle.uy` is imposed"]),
    ("press", STAMP, "forces = [0.0, -0.8]", &["did you mean `force`?"]),
    (
        "press",
        STAMP,
        "force = [0.0, -0.8], about = \"centre\"",
        &["`contact.1.obstacle.about` is the string"],
    ),
];

const RIGID: &[Fault] = &[
    ("plate", "ux    = 0.0\n", "ux = 0.0\nuz = 0.0\n", &["unknown key `uz` in `body.0.rigid.0`"]),
    ("plate", "ux    = 0.0\n", "ux = \"x\"\n", &["expected a number"]),
    ("plate", "ux    = 0.0\n", "ux = nan\n", &["`body.0.rigid.0.ux` is NaN"]),
    ("plate", "on    = \"top\"\n", "", &["`body.0.rigid.0.on` is missing"]),
    ("plate", "on    = \"top\"\n", "on = \"topp\"\n", &["no edge group \"topp\"", "did you mean \"top\""]),
    (
        "plate",
        "on    = \"top\"\n",
        "on = \"bottom\"\n",
        &["also has an imposed displacement", "contact edges that are free"],
    ),
    ("plate", "on    = \"top\"\n", "on = \"left\"\npart = { y = [3.0, 4.0] }\n", &["lies in the given part"]),
    ("plate", "[[body.rigid]]\n", "[body.rigid]\n", &["an array of tables"]),
    ("plate", "force = [0.0, -20.0]", "force = [0.0, inf]", &["`body.0.rigid.0.force.1` is inf"]),
    ("plate", "force = [0.0, -20.0]", "force = [nan, -20.0]", &["`body.0.rigid.0.force.0` is NaN"]),
    (
        "plate",
        "force = [0.0, -20.0]",
        "force = [3.0, -20.0]",
        &["`body.0.rigid.0.ux` is imposed, and a load acts along it"],
    ),
    (
        "plate",
        "force = [0.0, -20.0]",
        "force = [0.0, -20.0]\nmoment = inf",
        &["`body.0.rigid.0.moment` is inf"],
    ),
    ("plate", ABOUT, "about = [1.1]\n", &["`body.0.rigid.0.about` has 1 entries"]),
    (
        "plate",
        ABOUT,
        "about = [1.1, 2.0]\n[[body.rigid]]\non = \"left\"\n",
        &["rigid side condition 2", "at (0, 2)", "no common node"],
    ),
    (
        "plate",
        ABOUT,
        "about = [1.1, 2.0]\n[[body.rigid]]\non = \"top\"\n",
        &["rigid side condition 2 has another condition"],
    ),
    (
        "plate",
        ABOUT,
        "about = [1.1, 2.0]\n[[body.displacement]]\non = \"top\"\nuy = 0.0\n",
        &["rigid side condition 1 has another condition"],
    ),
    (
        "plate",
        ABOUT,
        "about = [1.1, 2.0]\n[[body.traction]]\non = \"top\"\npressure = 1.0\n",
        &["traction condition 1 loads the edge"],
    ),
    // The corner is in both sides; the message has both values as they were written.
    (
        "plate",
        ABOUT,
        "about = [1.1, 2.0]\n[[body.displacement]]\non = \"left\"\nux = 0.1\n",
        &["on the node at (0, 2): [0.1, 0.0]"],
    ),
];

const DISCS: &[Fault] = &[
    ("assembly", DISC, "radius = 0.0, cells = 32", &["a number > 0"]),
    ("assembly", DISC, "radius = inf, cells = 32", &["`body.1.generator.radius` is inf"]),
    (
        "assembly",
        DISC,
        "radius = 5.0, cells = [32, 32]",
        &["a whole number", "write one number, without brackets"],
    ),
    ("assembly", DISC, "radius = 5.0, cells = 0", &["a whole number, at least 1"]),
    ("assembly", DISC, "radius = 5.0", &["write `cells = 8`"]),
    ("assembly", DISC, "radius = 5.0, cells = 32, start = nan", &["`body.1.generator.start` is NaN"]),
    ("assembly", DISC, "radius = 5.0, cells = 32, angles = [0, 90]", &["unknown key `angles`"]),
    ("assembly", "centre = [0.0, 5.0]", "centre = [0.0, 4.0]", &["the bodies overlap"]),
];

fn text(case: &str) -> String {
    std::fs::read_to_string(cases().join(case).with_extension("toml")).unwrap()
}

/// Writes a case with another text in one place, and solves it.
fn changed(here: &Path, case: &str, from: &str, to: &str) -> (Option<i32>, String) {
    let whole = text(case);
    assert!(whole.contains(from), "{from:?} is not in {case}");
    let file = here.join("case.toml");
    std::fs::write(&file, whole.replacen(from, to, 1)).unwrap();
    let output = solve(&file, &here.join("out"), &[]);
    (output.status.code(), said(&output))
}

#[test]
fn every_fault_of_an_assembly_has_its_place_and_a_fix() {
    let temp = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for (case, from, to, words) in [PAIRS, OBSTACLES, STAMPS, RIGID, DISCS].concat() {
        let (code, text) = changed(temp.path(), case, from, to);
        let first = text.lines().find(|line| line.starts_with("error")).unwrap_or_default();
        let placed = first.contains("case.toml:") && !first.contains("case.toml: ");
        let whole = placed && first.contains("; expected ") && first.contains("; help: ");
        let missing = words.iter().find(|word| !text.contains(**word));
        if code != Some(3) || !whole || missing.is_some() {
            wrong.push(format!("{case}: {to:?}: {code:?}, {missing:?} is missing in\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(!temp.path().join("out").exists());
}

#[test]
fn loads_that_nothing_resists_are_refused_with_the_motion() {
    let temp = tempfile::tempdir().unwrap();
    let up = "the obstacle of \"stamp\" is not held: it can move by (0, 1)";
    for (case, from, to, word) in [
        ("press", STAMP, "force = [0.0, 0.8]", up),
        (
            "press",
            "rotation = 0.0, force = [0.0, -0.8]",
            "force = [0.0, -0.8], moment = 0.5",
            "can rotate about (0, 7)",
        ),
        ("plate", "force = [0.0, -20.0]", "force = [0.0, 20.0]", "body \"block\" is not held"),
        ("plate", ABOUT, "about = [3.1, 2.0]\n", "body \"block\" is not held: it can rotate about (2, 2)"),
        (
            "assembly",
            "pressure = 40.0",
            "pressure = -40.0",
            "body \"plate\" is not held: it can move by (0, 1)",
        ),
    ] {
        let (code, text) = changed(temp.path(), case, from, to);
        assert_eq!(code, Some(4), "{to}: {text}");
        assert!(
            text.contains(word) && text.contains("\n  expected: ") && text.contains("\n  fix: "),
            "{text}"
        );
    }
}

#[test]
fn numbers_that_overflow_are_said_to_be_too_large() {
    let temp = tempfile::tempdir().unwrap();
    let (code, text) = changed(temp.path(), "press", STAMP, "force = [0.0, -1e300]");
    assert_eq!(code, Some(3), "{text}");
    assert!(text.contains("the loads are so large") && text.contains("\n  fix: check the units"), "{text}");
    let (code, text) = changed(temp.path(), "plate", ABOUT, "about = [1e300, 2.0]\n");
    assert_eq!(code, Some(3), "{text}");
    assert!(
        text.contains("not finite") && text.contains("the points about which rigid sides rotate"),
        "{text}"
    );
}

#[test]
fn a_gap_that_moves_an_obstacle_is_noted() {
    let temp = tempfile::tempdir().unwrap();
    let line = "point = [0.0, 0.0], normal = [0.0, 1.0] }";
    let moved = "point = [0.0, 0.004], normal = [0.0, 1.0] }\ngap = 0.001";
    let (code, text) = changed(temp.path(), "press", line, moved);
    assert_eq!(code, Some(0), "{text}");
    let notes = report(&temp.path().join("out")).notes.join("\n");
    assert!(
        notes.contains("contact.0.gap overrides the meshes") && notes.contains("by at most 0.00500"),
        "{notes}"
    );
}

#[test]
fn a_check_counts_rigid_sides_and_stamps() {
    let temp = tempfile::tempdir().unwrap();
    let check = |case: &str| said(&nndd(temp.path()).arg("check").arg(cases().join(case)).output().unwrap());
    let plate = check("plate.toml");
    assert!(plate.contains("supports        0 conditions on 0 nodes"), "{plate}");
    assert!(
        plate.contains("rigid           1 side\n") && plate.contains("held            1 body by"),
        "{plate}"
    );
    let press = check("press.toml");
    assert!(press.contains("held            1 body and 1 obstacle by contact only"), "{press}");
}

#[test]
fn an_exact_solution_has_no_theta_to_sweep() {
    let temp = tempfile::tempdir().unwrap();
    for case in ["press.toml", "paper.toml"] {
        let case = cases().join(case);
        let mut command = nndd(temp.path());
        command
            .arg("sweep")
            .arg(case)
            .args(["--over", "solver.theta=0.4:0.6:0.1", "--out", "out"])
            .args(["--set", "solver.method=exact"]);
        let output = command.output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(
            text.contains("`solver.theta` has no effect") && text.contains("solver.method=nndd"),
            "{text}"
        );
        assert!(!temp.path().join("out").exists());
    }
}

/// Lists texts with one line left out or twice, and with one number replaced.
fn damaged(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let mut all = Vec::new();
    for k in 0..lines.len() {
        let with = |times: usize| {
            let (before, after) = (&lines[..k], &lines[k + 1..]);
            [before, &vec![lines[k]; times], after].concat().join("\n")
        };
        all.extend([with(0), with(2)]);
    }
    let numeral = |c: char| c.is_ascii_digit() || "-.".contains(c);
    let mut at = 0;
    while let Some(start) = text[at..].find(|c: char| c.is_ascii_digit() || c == '-').map(|k| at + k) {
        let end = text[start..].find(|c| !numeral(c)).map_or(text.len(), |k| start + k);
        for value in ["nan", "-inf", "-1", "0", "1e300", "-1e160", "1e-300", "\"x\"", "[]", "{}"] {
            all.push(format!("{}{value}{}", &text[..start], &text[end..]));
        }
        at = end;
    }
    all
}

#[test]
fn damaged_assemblies_are_refused_in_words_or_can_be_built() {
    let coarse = |case: &str, cells: &[[&str; 2]]| {
        let whole = text(case);
        let bare: Vec<&str> =
            whole.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).collect();
        cells.iter().fold(bare.join("\n"), |text, [from, to]| text.replace(from, to))
    };
    let all = [
        coarse("press", &[["[32, 16]", "[8, 4]"]]),
        coarse("plate", &[["[18, 9]", "[6, 3]"]]),
        coarse("assembly", &[["[64, 16]", "[16, 4]"], ["cells = 32", "cells = 4"]]),
    ];
    let cured = |found: &Diagnostic, text: &str| {
        assert!(found.expected.is_some() && found.help.is_some(), "{found}\n{text}");
    };
    let mut refused = 0;
    for text in all.iter().flat_map(|case| damaged(case)) {
        let built = Case::parse(&text, "case.toml", &[]).and_then(|case| Ok((case.build()?.0, case)));
        match built {
            Ok((problem, case)) => {
                if let Err(failure) = nndd_report::check::check(&case, &problem) {
                    failure.diagnostics.iter().for_each(|found| cured(found, &text));
                    let message = failure.message.unwrap_or_default();
                    let whole = message.contains("\n  expected: ") && message.contains("\n  fix: ");
                    assert!(whole || !failure.diagnostics.is_empty(), "{message}\n{text}");
                    assert!([3, 4, 8].contains(&failure.code), "{message}\n{text}");
                }
            }
            Err(error) => {
                assert!(!error.diagnostics.is_empty(), "{text}");
                error.diagnostics.iter().for_each(|found| cured(found, &text));
                refused += 1;
            }
        }
    }
    assert!(refused > 300, "{refused}");
}
