//! Meshes and data that a program gives in memory.

use super::*;
use mesh_io::{MeshArrays, MeshFile};

/// The minimal case with conditions of every kind; each number is one that data replace.
const CONDITIONS: &str = r#"gap = 0.0
friction = { law = "tresca", limit = 0.0 }
[[body]]
name = "c"
material = "m"
generator = { kind = "block", origin = [3.0, 0.0], size = [2, 1], cells = [4, 1] }
[[body.side]]
name = "corner"
point = [5.0, 1.0]
[[body.displacement]]
on = "corner"
ux = 0.0
[[body.displacement]]
on = "bottom"
uy = 0.0
[[body.displacement]]
on = "left"
normal = 0.0
[[body.traction]]
on = "top"
vector = [0.0, 0.0]
[[body.traction]]
on = "right"
pressure = 0.0
"#;

fn with_conditions() -> Case {
    let text = minimal(CONDITIONS).replace("[contact]\n", "[[contact]]\nbodies = [\"a\", \"b\"]\n");
    parse(&text)
}

fn square(shift: f64) -> MeshFile {
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let arrays = MeshArrays {
        points: points.map(|[x, y]| [x, y + shift, 0.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        sides: vec![("bottom".into(), vec![[0, 1]]), ("top".into(), vec![[2, 3]])],
        regions: vec![],
    };
    MeshFile::of_arrays("square", &arrays).unwrap()
}

/// The minimal case whose first body has a mesh in memory.
fn in_memory(shift: f64) -> Case {
    let generator = "generator = { kind = \"block\", origin = [0.0, 1.0], size = [1, 1], cells = [2, 2] }";
    let mut case = parse(&minimal("").replace(generator, "mesh = { file = \"<mesh 1>\" }"));
    case.give_mesh("<mesh 1>", square(9.0));
    // The last of a name counts.
    case.give_mesh("<mesh 1>", square(shift));
    case.read_mesh_files("no/such/folder".as_ref()).unwrap();
    case
}

#[test]
fn a_mesh_in_memory_is_read_instead_of_a_file() {
    let case = in_memory(1.0);
    assert_eq!((case.node_numbers(0), case.node_numbers(1)), (Some(&[0, 1, 2, 3][..]), None));
    assert_eq!(case.mesh_of(0).unwrap().points()[2].y, 2.0);
    let [first, second] = [in_memory(1.0), in_memory(1.5)];
    assert!(case.hash() == first.hash() && case.hash() != second.hash());
    // A name without a given mesh is the name of a file.
    let mut other = parse(&minimal("").replacen(
        "generator = { kind = \"block\", origin = [0.0, 1.0], size = [1, 1], cells = [2, 2] }",
        "mesh = { file = \"<mesh 2>\" }",
        1,
    ));
    other.give_mesh("<mesh 1>", square(1.0));
    let said = other.read_mesh_files("".as_ref()).unwrap_err().to_string();
    assert!(said.contains("<mesh 2>: cannot be read"), "{said}");
}

#[test]
fn data_at_nodes_replace_numbers_everywhere() {
    let keys = [
        "body.2.displacement.1.uy",
        "body.2.displacement.2.normal",
        "body.2.traction.0.vector.0",
        "body.2.traction.0.vector.1",
        "body.2.traction.1.pressure",
        "contact.0.gap",
        "contact.0.friction.limit",
    ];
    let plain = with_conditions().hash();
    for key in keys {
        let mut case = with_conditions();
        let nodes = case.data_nodes(key).unwrap();
        let values: Vec<f64> = nodes.points.iter().map(|p| 0.001 * (1.0 + p.x + p.y)).collect();
        case.set_data(key, &nodes, &values).unwrap();
        let other = case.hash();
        assert_ne!(other, plain, "{key}");
        assert!(case.settings_json().to_string().contains("{\"nodal\":\""), "{key}");
        case.set_data(key, &nodes, &values.iter().map(|v| 2.0 * v).collect::<Vec<_>>()).unwrap();
        assert!(case.hash() != other && case.hash() != plain, "{key}");
        let problem = case.build_problem().unwrap();
        assert!(case.data_notes(&problem).is_empty(), "{key}: {:?}", case.data_notes(&problem));
    }
}

#[test]
fn nodes_of_data_are_those_of_the_side() {
    let mut case = with_conditions();
    let nodes = case.data_nodes("body.2.traction.0.vector.0").unwrap();
    let mesh = case.mesh_of(2).unwrap();
    assert_eq!((nodes.body, nodes.points.len()), (2, 5));
    for (number, point) in nodes.numbers.iter().zip(&nodes.points) {
        assert_eq!((mesh.points()[*number as usize], point.y), (*point, 1.0));
    }
    // A single node, a list that is not there, and a key of another kind take no data.
    for key in [
        "body.2.displacement.0.ux",
        "body.2.displacement.9.uy",
        "solver.theta",
        "body.2.rigid.0.ux",
        "contact.1.gap",
    ] {
        let said = case.data_nodes(key).unwrap_err().to_string();
        assert!(said.contains(&format!("`{key}` takes no values at nodes")), "{said}");
    }
    let said = case.set_data("body.2.traction.0.pressure", &nodes, &[0.0; 5]).unwrap_err().to_string();
    assert!(said.contains("takes no values at nodes"), "{said}");
    let said = case.set_data("body.2.traction.0.vector.0", &nodes, &[0.0; 4]).unwrap_err().to_string();
    assert!(said.contains("has 4 values for 5 nodes"), "{said}");
}

#[test]
fn data_on_a_side_that_does_not_exist_leave_the_fault_to_the_body() {
    let mut case = parse(
        &minimal(CONDITIONS)
            .replace("[contact]\n", "[[contact]]\nbodies = [\"a\", \"b\"]\n")
            .replace("on = \"right\"", "on = \"rigth\""),
    );
    let nodes = case.data_nodes("body.2.traction.1.pressure").unwrap();
    assert!(nodes.points.is_empty());
    case.set_data("body.2.traction.1.pressure", &nodes, &[]).unwrap();
    assert!(case.build_bodies().unwrap_err().to_string().contains("there is no edge group \"rigth\""));
}
