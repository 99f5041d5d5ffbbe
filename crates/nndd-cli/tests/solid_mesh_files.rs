//! `nndd mesh` of volumes: what it lists can be put into a case file as it is.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::process::{Command, Output};

/// A cube of one hexahedron, twice: the second one a little above the first one.
fn deck(above: f64) -> String {
    format!(
        "*PART, NAME=cube\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n\
         *ELEMENT, TYPE=C3D8R\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SURFACE, NAME=bottom\n1, S1\n*SURFACE, NAME=top\n1, S2\n*END PART\n\
         *ASSEMBLY, NAME=a\n*INSTANCE, NAME=low, PART=cube\n*END INSTANCE\n*INSTANCE, NAME=high, PART=cube\n0, 0, {}\n*END INSTANCE\n\
         *END ASSEMBLY\n",
        1.0 + above
    )
}

const CASE: &str = "schema = 1\n[materials.m]\nyoung = 1000.0\npoisson = 0.3\n\
    [[body]]\nname = \"low\"\nmaterial = \"m\"\nmesh = { file = \"two.inp\", region = \"low\" }\n\
    [[body.displacement]]\non = \"low.bottom\"\nfixed = true\n\
    [[body]]\nname = \"high\"\nmaterial = \"m\"\nmesh = { file = \"two.inp\", region = \"high\" }\n\
    [[body.displacement]]\non = \"high.top\"\nux = 0.0\nuy = 0.0\nuz = -0.1\n";

fn nndd(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn contacts_that_are_listed_make_a_case() {
    let temp = tempfile::tempdir().unwrap();
    for (above, apart) in [(0.0, false), (0.02, true)] {
        std::fs::write(temp.path().join("two.inp"), deck(above)).unwrap();
        let said = text(&nndd(temp.path(), &["mesh", "two.inp"]).stdout);
        for words in [
            "2 x 8-node hexahedron",
            "low low.top 2 1 (0, 0, 1)",
            "flattest cell height / longest edge = 0.333",
            "note: 2 hexahedra of the mesh were split into 12 tetrahedra",
        ] {
            // Columns are as wide as their names.
            let single = said.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(single.contains(words), "{words} is not in\n{said}");
        }
        let table = said.split_once("[[contact]]").unwrap().1.split("\n\n").next().unwrap();
        assert!(table.contains("surfaces = [\"low.top\",\"high.bottom\"]"), "{table}");
        assert_eq!(table.contains("gap      = \"geometric\"   # up to 0.02 apart"), apart, "{table}");
        std::fs::write(temp.path().join("case.toml"), format!("{CASE}[[contact]]{table}\n")).unwrap();
        let checked = nndd(temp.path(), &["check", "case.toml"]);
        assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stderr));
    }
    // Half an edge apart is too far.
    std::fs::write(temp.path().join("two.inp"), deck(0.5)).unwrap();
    let output = nndd(temp.path(), &["mesh", "two.inp", "--format", "json"]);
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["facing"].as_array().map(Vec::len), Some(0));
    assert_eq!(object["sides"].as_array().map(Vec::len), Some(4));
}
