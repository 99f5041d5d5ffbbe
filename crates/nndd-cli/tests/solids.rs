//! Cases of solids, as a user runs them: from a generator and from a mesh file, with a wrong input as well.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use fem_core::mesh::TetMesh;
use fem_core::mesh::generate::cuboid;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/solid")
}

fn nndd(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nndd")).args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn report(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap()
}

fn solve(case: &Path, out: &Path, options: &[&str]) -> Value {
    let named =
        [&["solve", "--quiet", case.to_str().unwrap(), "--out", out.to_str().unwrap()], options].concat();
    let output = nndd(&named);
    assert!(output.status.success(), "{}", said(&output));
    report(out)
}

/// Writes bodies as one mesh of Gmsh; sides are called by their body.
fn gmsh(bodies: &[(&str, TetMesh)]) -> String {
    let (mut names, mut nodes, mut elements) = (String::new(), String::new(), Vec::new());
    let (mut group, mut first) = (0, 1);
    for (body, mesh) in bodies {
        group += 1;
        let _ = writeln!(names, "3 {group} \"{body}\"");
        let numbered = |n: &fem_core::mesh::id::NodeId| (n.index() + first).to_string();
        for cell in mesh.cells() {
            let corners: Vec<String> = cell.iter().map(numbered).collect();
            elements.push(format!("4 2 {group} 1 {}", corners.join(" ")));
        }
        for (side, faces) in mesh.groups() {
            group += 1;
            let _ = writeln!(names, "2 {group} \"{body}_{side}\"");
            for face in faces {
                let corners: Vec<String> = mesh.topology().facets()[*face].iter().map(numbered).collect();
                elements.push(format!("2 2 {group} 1 {}", corners.join(" ")));
            }
        }
        for (k, p) in mesh.points().iter().enumerate() {
            let _ = writeln!(nodes, "{} {} {} {}", k + first, p[0], p[1], p[2]);
        }
        first += mesh.points().len();
    }
    let elements: Vec<String> =
        elements.iter().enumerate().map(|(k, element)| format!("{} {element}", k + 1)).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{group}\n{names}$EndPhysicalNames\n$Nodes\n{}\n{nodes}$EndNodes\n\
         $Elements\n{}\n{}\n$EndElements\n",
        first - 1,
        elements.len(),
        elements.join("\n")
    )
}

#[test]
fn a_mesh_file_gives_the_same_solution_as_the_generator() {
    let temp = tempfile::tempdir().unwrap();
    let generated = solve(&cases().join("half_open.toml"), &temp.path().join("generated"), &[]);
    let block = |z: f64| cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
    std::fs::write(temp.path().join("blocks.msh"), gmsh(&[("upper", block(1.0)), ("lower", block(0.0))]))
        .unwrap();
    let mut text = std::fs::read_to_string(cases().join("half_open.toml")).unwrap();
    // The cells tell that the bodies are solid.
    text = text.replace("[model]\nhypothesis = \"solid\"\n", "");
    for body in ["upper", "lower"] {
        let (from, rest) = text.split_once("generator = ").unwrap();
        let rest = rest.split_once('\n').unwrap().1;
        let (own, other) = rest.split_at(rest.find("\n[[body]]").or(rest.find("\n[contact]")).unwrap());
        let own = own.replace("on = \"", &format!("on = \"{body}_"));
        text = format!("{from}mesh = {{ file = \"blocks.msh\", region = \"{body}\" }}\n{own}{other}");
    }
    let text = text.replace("[\"bottom\", \"top\"]", "[\"upper_bottom\", \"lower_top\"]");
    let case = temp.path().join("file.toml");
    std::fs::write(&case, text).unwrap();
    let found = solve(&case, &temp.path().join("file"), &[]);
    for key in ["contact", "certificate", "iterations"] {
        let numbers = |report: &Value| report[key].to_string();
        let (a, b) = (numbers(&found), numbers(&generated));
        assert_eq!(a, b, "{key}");
    }
    assert_eq!(found["results"]["balance"], generated["results"]["balance"]);
    let mesh = nndd(&["mesh", temp.path().join("blocks.msh").to_str().unwrap()]);
    let listed = String::from_utf8_lossy(&mesh.stdout).into_owned();
    for words in
        ["192 x 4-node tetrahedron", "volumes   volume 2", "[0, 2] x [0, 1] x [0, 2]", "45.000 degrees"]
    {
        assert!(listed.contains(words), "{listed}");
    }
}

#[test]
fn the_files_of_solids_have_three_coordinates() {
    let temp = tempfile::tempdir().unwrap();
    let found = solve(&cases().join("stack.toml"), temp.path(), &[]);
    let table = std::fs::read_to_string(temp.path().join("contact.csv")).unwrap();
    assert!(
        table.starts_with("pair,x,y,z,gap,opening,pressure,active\nmiddle-bottom,0.0,0.0,1.0,"),
        "{table}"
    );
    let pair = &found["contact"][1];
    let (area, patches) = (&pair["area"], pair["patches"].as_array().unwrap());
    let [certain, possible, total] = ["certain", "possible", "total"].map(|key| area[key].as_f64().unwrap());
    assert!(certain < possible && possible <= total && total == 2.0, "{area}");
    let sum: f64 = patches.iter().map(|patch| patch["force"][2].as_f64().unwrap()).sum();
    assert!((sum - pair["resultant"][2].as_f64().unwrap()).abs() < 1e-12 * sum, "{pair}");
    assert!(pair.get("length").is_none() && found["results"].get("contact_intervals").is_none());
    assert_eq!(found["bodies"][0]["tetrahedra"], 96);
    let page = std::fs::read_to_string(temp.path().join("report.html")).unwrap();
    for words in ["<td>reaction z of top on top</td>", "∫ p dA", "area in contact of top-middle, at least"]
    {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("thickness"));
    for file in ["bottom.vtu", "contact-top-middle.vtu"] {
        assert!(found["status"]["code"] == 0 && temp.path().join(file).exists(), "{file}");
    }
}

#[test]
fn a_sweep_and_a_check_take_solids() {
    let temp = tempfile::tempdir().unwrap();
    let case = cases().join("half_open.toml");
    let case = case.to_str().unwrap();
    let out = temp.path().join("sweep");
    let over = ["--over", "solver.theta=[0.5, 0.9]", "--out", out.to_str().unwrap()];
    let swept = nndd(&[&["sweep", case], &over[..]].concat());
    assert!(swept.status.success(), "{}", said(&swept));
    assert_eq!(std::fs::read_to_string(out.join("sweep.csv")).unwrap().lines().count(), 3);
    let checked = nndd(&["check", case]);
    let text = String::from_utf8_lossy(&checked.stdout).into_owned();
    for words in ["face groups     back (16 faces)", "pairs           15, area 2", "96 tetrahedra"] {
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn a_check_lists_the_sides_that_face_each_other() {
    let temp = tempfile::tempdir().unwrap();
    let stack = std::fs::read_to_string(cases().join("stack.toml")).unwrap();
    let checked = |text: &str, more: &[&str]| {
        let case = temp.path().join("case.toml");
        std::fs::write(&case, text).unwrap();
        let output = nndd(&[&["check", case.to_str().unwrap()], more].concat());
        assert!(output.status.success(), "{}", said(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(!checked(&stack, &[]).contains("in no contact"));
    let found: Value = serde_json::from_str(&checked(&stack, &["--format", "json"])).unwrap();
    let names = found["contact"].as_array().unwrap().iter().map(|contact| contact["name"].clone());
    let contacts = found["facing"].as_array().unwrap().iter().map(|facing| facing["contact"].clone());
    assert_eq!(names.collect::<Vec<_>>(), contacts.collect::<Vec<_>>());
    assert_eq!(found["facing"][0]["surfaces"], serde_json::json!(["top", "bottom"]));
    // The middle block is clamped, and the contact below it is forgotten.
    let clamped = stack.replacen(
        "[[body.traction]]\non = \"back\"\nvector = [0.0, 0.0, 10.0]",
        "[[body.displacement]]\non = \"back\"\nfixed = true",
        1,
    );
    let forgotten = clamped.replacen(
        "[[contact]]\nbodies = [\"middle\", \"bottom\"]\nsurfaces = [\"bottom\", \"top\"]\n",
        "",
        1,
    );
    assert!(clamped != stack && forgotten != clamped);
    let text = checked(&forgotten, &[]);
    assert!(
        text.contains("in no contact     \"top\" of \"bottom\" faces \"bottom\" of \"middle\""),
        "{text}"
    );
}

#[test]
fn wrong_cases_of_solids_are_refused_with_advice() {
    let temp = tempfile::tempdir().unwrap();
    let half_open = std::fs::read_to_string(cases().join("half_open.toml")).unwrap();
    let refused = |text: &str, code: i32, words: &str| {
        let case = temp.path().join("case.toml");
        std::fs::write(&case, text).unwrap();
        let output = nndd(&["check", case.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        assert!(said(&output).contains(words), "{}", said(&output));
    };
    refused(&half_open.replace("\"solid\"", "\"plane_strain\""), 3, "belongs to the plane");
    refused(&half_open.replacen("kind = \"box\"", "kind = \"block\"", 1), 3, "a case has bodies of one kind");
    // Nothing holds the upper block against the load.
    let free = half_open.replace("part = { x = [0.0, 1.0] }\nuz = -0.02", "ux = 0.0");
    refused(&free, 4, "body \"upper\" is not held");
    let plane = "*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n*ELEMENT, TYPE=CPS3, ELSET=lower\n1, 1, 2, 3\n";
    std::fs::write(temp.path().join("plane.inp"), plane).unwrap();
    let generator = "generator = { kind = \"box\", size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }";
    refused(&half_open.replace(generator, "mesh = { file = \"plane.inp\" }"), 3, "no volumes");
}
