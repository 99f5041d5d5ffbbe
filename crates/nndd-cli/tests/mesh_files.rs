//! Mesh files at the command line: the same numbers from every source, and `nndd mesh`.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases")
}

fn nndd(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Solves an example case; returns its report and what was said.
fn solved(name: &str) -> (Report, String) {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    let case = cases().join(name);
    let output = nndd(&["solve", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = Report::from_json(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    (report, text(&output.stderr))
}

#[test]
fn files_of_the_papers_mesh_give_the_generators_numbers() {
    let (paper, _) = solved("paper.toml");
    assert!(matches!(&paper.notes[..], [note] if note.contains("grows without limit")), "{:?}", paper.notes);
    for name in ["gmsh.toml", "abaqus.toml"] {
        let (report, said) = solved(name);
        assert_eq!(report.iterations, paper.iterations, "{name}");
        assert_eq!(report.certificate, paper.certificate, "{name}");
        let mut results = report.results.clone();
        for reaction in results.reactions.iter_mut().flatten() {
            let side = reaction.on.split_once('.').unwrap();
            assert_eq!(side.0, reaction.body, "{name}");
            reaction.on = side.1.to_owned();
        }
        assert_eq!(results, paper.results, "{name}");
        assert_ne!(report.case_hash(), paper.case_hash());
        // The deck is one of quadrilaterals; a note on the console and in the report says so.
        let split = ["upper", "lower"].map(|body| {
            format!("162 quadrilaterals of region \"{body}\" were split into two triangles along the shorter diagonal")
        });
        let notes: &[String] = if name == "abaqus.toml" { &split } else { &[] };
        assert_eq!(report.notes, [&paper.notes[..], notes].concat(), "{name}");
        assert!(notes.iter().all(|note| said.contains(&format!("note: {note}"))), "{said}");
    }
}

#[test]
fn a_mesh_file_is_shown_to_people_and_programs() {
    let file = cases().join("meshes/gmsh-4.15.2.msh");
    let shown = nndd(&["mesh", file.to_str().unwrap()]);
    assert_eq!(shown.status.code(), Some(0));
    let said = text(&shown.stdout);
    for words in [
        "Gmsh MSH 4.1, text",
        "86 x 3-node triangle, 32 x 4-node quadrilateral",
        "bounding box    [0, 2] x [0, 2]",
        "smallest angle  42.451 degrees",
        "lower.sides",
        "area 2\n",
        "note: 32 quadrilaterals of the mesh were split",
    ] {
        assert!(said.contains(words), "{words} is not in\n{said}");
    }
    assert!(!said.contains("problem"), "{said}");
    let shown = nndd(&["mesh", file.to_str().unwrap(), "--format", "json"]);
    let object: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(object["nodes"], 101);
    assert_eq!(object["cells"]["3-node triangle"], 86);
    let groups = object["groups"].as_array().unwrap();
    let sides = groups.iter().find(|g| g["name"] == "lower.sides").unwrap();
    assert_eq!((&sides["dimension"], &sides["edges"]), (&1.into(), &8.into()));
    assert!((sides["length"].as_f64().unwrap() - 2.0).abs() < 1e-12);
}

#[test]
fn a_mesh_file_with_faults_is_shown_with_its_problems_or_refused() {
    let bad = |name: &str| {
        let path = cases().join("bad/meshes").join(name);
        let output = nndd(&["mesh", path.to_str().unwrap()]);
        (output.status.code(), text(&output.stdout) + &text(&output.stderr))
    };
    let expected = [
        ("only_edges.msh", 0, "problem: 4 edges and no 2D elements"),
        ("only_cells.msh", 0, "name the sides in the case file by their places, with [[body.side]]"),
        ("xz_plane.msh", 0, "x-z plane"),
        ("flat.msh", 0, "problem: 1 cell without an area, the first is element 6"),
        ("loose_part.msh", 0, "problem: region \"upper\" consists of 2 parts"),
        ("glued.msh", 0, "3 nodes in common"),
        ("three_cells.msh", 0, "shared by more than two cells"),
        ("cut.msh", 3, "cut.msh:15: the file ended inside $Nodes after 3 of 6 nodes"),
        ("html.msh", 3, "error[mesh::format]"),
        ("include.inp", 7, "error[mesh::unreadable]"),
        ("absent.msh", 7, "cannot be read"),
    ];
    for (name, code, words) in expected {
        let (found, said) = bad(name);
        assert_eq!(found, Some(code), "{name}: {said}");
        assert!(said.contains(words), "{name}: {words} is not in\n{said}");
    }
    let pipe = nndd(&["mesh", "/dev/zero"]);
    assert_eq!(pipe.status.code(), Some(if cfg!(unix) { 7 } else { 3 }));
    assert_eq!(nndd(&["mesh"]).status.code(), Some(2));
}
