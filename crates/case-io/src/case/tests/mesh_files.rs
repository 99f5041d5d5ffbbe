//! Bodies whose mesh is a file.

use super::*;
use crate::diagnostic::{CaseError, code};
use std::path::Path as FilePath;

/// Two squares on top of each other that share the nodes of the line between them.
const GLUED: &str = "*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n5, 1, 2\n6, 0, 2\n\
    *ELEMENT, TYPE=CPS4, ELSET=b\n1, 1, 2, 3, 4\n*ELEMENT, TYPE=CPS4, ELSET=a\n2, 4, 3, 5, 6\n\
    *ELSET, ELSET=both\na, b\n*SURFACE, NAME=bottom\nboth, S1\n*SURFACE, NAME=top\nboth, S3\n";

/// The minimal case with the mesh of each body replaced.
fn text(meshes: [&str; 2]) -> String {
    let text = minimal("");
    let mut meshes = meshes.into_iter();
    let lines = text.lines().map(|l| {
        if l.starts_with("generator") {
            format!("mesh = {}\n", meshes.next().unwrap())
        } else {
            format!("{l}\n")
        }
    });
    lines.collect()
}

fn load(folder: &FilePath, meshes: [&str; 2]) -> Result<Case, CaseError> {
    let mut case = Case::parse(&text(meshes), "c.toml", &[])?;
    case.read_mesh_files(folder)?;
    Ok(case)
}

fn folder(deck: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.inp"), deck).unwrap();
    folder
}

const A: &str = "{ file = 'm.inp', region = 'a' }";
const B: &str = "{ file = 'm.inp', region = 'b' }";
const APART: &str = "{ file = 'm.inp', region = 'b', duplicate_interface = true }";

#[test]
fn keys_have_defaults_and_checks() {
    let mut case = Case::parse(&text([A, APART]), "c.toml", &[]).unwrap();
    let file = |region: &str, duplicate_interface| MeshSource::File {
        file: "m.inp".into(),
        region: vec![region.into()],
        merge: false,
        duplicate_interface,
        connected_to: None,
    };
    assert_eq!([&case.bodies[0].mesh, &case.bodies[1].mesh], [&file("a", false), &file("b", true)]);
    assert_eq!(case.node_counts(), [0, 0]);
    assert!(case.build_bodies().unwrap_err().to_string().contains("has not been read"));
    case.read_mesh_files(folder(GLUED).path()).unwrap();
    assert_eq!(case.node_counts(), [4, 4]);
    let again = toml::to_string(&case.settings_json()["body"]).unwrap_or_default();
    assert!(!again.contains("generator"), "{again}");
    let fault = |mesh: &str| Case::parse(&text([mesh, B]), "c.toml", &[]).unwrap_err().to_string();
    assert!(fault("{ region = 'a' }").starts_with("c.toml:8:8: the key `body.0.mesh.file` is missing"));
    assert!(fault("{ file = 1 }").starts_with("c.toml:8:17: `body.0.mesh.file` is the integer 1"));
    assert!(fault("{ file = '' }").contains("`mesh.file` is empty"));
    assert!(fault("{ file = 'm', regoin = 'a' }").contains("did you mean `region`?"));
    let both = text(["{ file = 'm' }\ngenerator = { kind = 'block', size = [1, 1], cells = [2, 2] }", B]);
    assert!(
        Case::parse(&both, "c", &[]).unwrap_err().to_string().contains("either a `generator` or a `mesh`")
    );
    let neither = text(["{ file = 'm' }", B]).replace("mesh = { file = 'm' }\n", "");
    let told = Case::parse(&neither, "c.toml", &[]).unwrap_err().to_string();
    assert!(told.starts_with("c.toml:5:1: this body has no mesh: neither `generator` nor `mesh`"), "{told}");
}

#[test]
fn bodies_that_are_one_mesh_are_parted_only_when_asked() {
    let folder = folder(GLUED);
    let told = load(folder.path(), [A, B]).unwrap_err();
    assert_eq!(told.diagnostics.len(), 1);
    let told = told.to_string();
    assert!(told.contains("the bodies \"a\" and \"b\" share 2 nodes (node 3 at (1, 1))"), "{told}");
    assert!(told.contains("duplicate_interface = true"), "{told}");
    let case = load(folder.path(), [A, APART]).unwrap();
    assert!(case.mesh_notes().iter().any(|n| n.starts_with("2 nodes of m.inp belonging to both bodies")));
    assert_eq!(case.build().unwrap().0.node_pairs(), 2);
    // Parting does not help if the cells are the same.
    let told = load(folder.path(), [A, "{ file = 'm.inp', region = 'both', duplicate_interface = true }"]);
    assert!(told.unwrap_err().to_string().contains("element 2 belongs to both bodies"));
}

#[test]
fn the_contents_of_files_count_in_the_hash_and_their_place_does_not() {
    let (one, same, other) = (folder(GLUED), folder(GLUED), folder(&GLUED.replace("6, 0, 2", "6, 0, 2.5")));
    let hash = |folder: &tempfile::TempDir| load(folder.path(), [A, APART]).unwrap().hash();
    assert_eq!(hash(&one), hash(&same));
    assert_ne!(hash(&one), hash(&other));
    // An included file counts as well.
    let split = |nodes: &str| {
        let folder = folder(&GLUED.replacen("*NODE\n", "*INCLUDE, INPUT=more.inp\n*NODE\n", 1));
        std::fs::write(folder.path().join("more.inp"), nodes).unwrap();
        folder
    };
    assert_ne!(hash(&split("*NODE\n7, 5, 5\n")), hash(&split("*NODE\n7, 5, 6\n")));
}

#[test]
fn faults_of_both_files_come_together_at_their_keys() {
    let folder = folder(GLUED);
    let error =
        load(folder.path(), ["{ file = 'absent.msh' }", "{ file = 'm.inp', region = 'c' }"]).unwrap_err();
    let told: Vec<(&str, String)> =
        error.diagnostics.iter().map(|d| (d.code, d.place.as_ref().unwrap().to_string())).collect();
    assert_eq!(told, [(code::UNREADABLE, "c.toml:8:17".into()), ("mesh::region", "c.toml:12:35".into())]);
    assert!(
        error.to_string().contains("there is no region \"c\"; expected \"b\", \"a\", \"both\""),
        "{error}"
    );
}

#[test]
fn cracks_and_slivers_are_warned_of() {
    let cracked = "*NODE\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n5, 1, 0\n6, 1, 1\n7, 2, 0\n8, 2, 1\n9, 3, 0.0001\n\
        *ELEMENT, TYPE=CPS4, ELSET=a\n1, 1, 2, 3, 4\n2, 5, 7, 8, 6\n*ELEMENT, TYPE=CPS3, ELSET=a\n3, 7, 9, 8\n\
        *SURFACE, NAME=bottom\na, S1\n"
        .replace("9, 3, 0.0001", "9, 2.0001, 0.5");
    let folder = folder(&cracked);
    let other = folder.path().join("b.inp");
    std::fs::write(&other, GLUED).unwrap();
    let load = |mesh: &str| load(folder.path(), [mesh, "{ file = 'b.inp', region = 'b' }"]).unwrap();
    let warnings: Vec<String> = load(A).warnings().iter().map(ToString::to_string).collect();
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("2 nodes of region \"a\" coincide with others (nodes 2 and 5 at (1, 0))")),
        "{warnings:?}"
    );
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("1 triangle of region \"a\" with an angle below 0.1 degrees (elements 3)")),
        "{warnings:?}"
    );
    let merged = load("{ file = 'm.inp', region = 'a', merge = true }");
    assert!(
        merged
            .mesh_notes()
            .contains(&"2 nodes of region \"a\" joined with the node at the same place".to_owned()),
        "{:?}",
        merged.mesh_notes()
    );
    assert_eq!(merged.build_mesh(0).unwrap().topology().pieces().1, 1);
    assert_eq!(load(A).build_mesh(0).unwrap().topology().pieces().1, 2);
}

#[test]
fn a_side_of_the_other_body_is_said_to_be_one() {
    let deck = GLUED
        .replace("NAME=bottom\nboth, S1", "NAME=b.low\nb, S1")
        .replace("NAME=top\nboth, S3", "NAME=a.high\na, S3");
    let (folder, a) = (folder(&deck), [A, APART]);
    let with = |changed: &dyn Fn(String) -> String| {
        let mut case = Case::parse(&changed(text(a)), "c.toml", &[]).unwrap();
        case.read_mesh_files(folder.path()).unwrap();
        case
    };
    let held = |text: String| {
        text.replacen(
            "[[body]]\nname = \"b\"",
            "[[body.displacement]]\non = \"b.low\"\nux = 0\n[[body]]\nname = \"b\"",
            1,
        )
    };
    let said = with(&held).build_bodies().unwrap_err().to_string();
    assert!(said.ends_with("help: \"b.low\" is a side of body \"b\": name a side of \"a\" here"), "{said}");
    let surfaces = |names: &'static str| {
        let case = with(&move |text: String| text.replace("[\"bottom\", \"top\"]", names));
        case.build().unwrap_err().to_string()
    };
    let said = surfaces("[\"b.low\", \"b.low\"]");
    assert!(said.ends_with("help: \"b.low\" is a side of body \"b\": name a side of \"a\" here"), "{said}");
    let said = surfaces("[\"b.low\", \"a.high\"]");
    assert!(said.contains("help: swap the two names"), "{said}");
    let said = surfaces("[\"a.hihg\", \"b.low\"]");
    assert!(said.ends_with("help: did you mean \"a.high\"?"), "{said}");
}

#[test]
fn a_side_of_a_generated_body_with_the_name_of_its_body_is_told_apart() {
    let of = |on: &str| {
        let condition = format!("[[body.displacement]]\non = \"{on}\"\nux = 0\n[[body]]\nname = \"b\"");
        let case = minimal("").replacen("[[body]]\nname = \"b\"", &condition, 1);
        Case::parse(&case, "c.toml", &[]).unwrap().build_bodies().unwrap_err().to_string()
    };
    assert!(
        of("b.bottom").ends_with("help: \"bottom\" is a side of body \"b\": name a side of \"a\" here"),
        "{}",
        of("b.bottom")
    );
    assert!(
        of("a.bottom").ends_with("help: write the name of the side alone: \"bottom\""),
        "{}",
        of("a.bottom")
    );
    assert!(of("botom").ends_with("help: did you mean \"bottom\"?"), "{}", of("botom"));
}
