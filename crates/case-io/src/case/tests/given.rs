//! Meshes and data that a program gives in memory.

use super::*;
use crate::case_file::{At, Node, NodeValue, Table};
use crate::expression::NodalFunction;
use fem_core::geometry::Vector;
use mesh_io::{MeshArrays, MeshFile};

/// A body with conditions of every kind, two others, and a pair.
const CONDITIONS: &str = r#"schema = 1
[materials.m]
young = 1.0
poisson = 0.0
[[body]]
name = "c"
material = "m"
generator = { kind = "block", origin = [0, 1], size = [2, 1], cells = [4, 1] }
side = [{ name = "corner", point = [2.0, 2.0] }]
displacement = [{ on = "corner", ux = 0.0 }, { on = "left", normal = 0.0 }]
traction = [{ on = "top", vector = [0.0, 0.0] }, { on = "right", pressure = 0.0 }]
[[body]]
name = "b"
material = "m"
generator = { kind = "block", size = [2, 1], cells = [4, 1] }
displacement = [{ on = "bottom", ux = 0.0, uy = 0.0 }]
[[contact]]
bodies = ["c", "b"]
surfaces = ["bottom", "top"]
gap = 0.0
friction = { law = "tresca", limit = 0.0 }
"#;

/// Gives the keys of a text as a program does, with another value for one of them.
fn given(text: &str, key: &str, value: NodeValue) -> Result<Case, CaseError> {
    let document = case_file::parse(text, "case.toml", &[]).unwrap();
    let mut root = in_memory_table(document.root, "");
    let mut value = Some(value);
    replace(&mut root, key, &mut value);
    assert!(value.is_none(), "{key}");
    let mut case = AnyCase::of_table(root, "problem", &[], false)?.into_plane()?;
    case.give_mesh("<mesh 1>", square(1.0));
    case.read_mesh_files("no/such/folder".as_ref())?;
    Ok(case)
}

fn in_memory_table(table: Table, path: &str) -> Table {
    let mut made = Table::default();
    for entry in table.entries {
        let path = if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
        made.put(entry.key, in_memory_node(entry.node, &path));
    }
    made
}

fn in_memory_node(node: Node, path: &str) -> Node {
    let at = match &node.value {
        NodeValue::String(text) => At::of_key(path, &format!("\"{text}\"")),
        _ => At::of_key(path, ""),
    };
    let value = match node.value {
        NodeValue::Table(table) => NodeValue::Table(in_memory_table(table, path)),
        NodeValue::Array(items) => {
            let items = items.into_iter().enumerate();
            NodeValue::Array(items.map(|(k, item)| in_memory_node(item, &format!("{path}.{k}"))).collect())
        }
        other => other,
    };
    Node { value, at }
}

fn replace(table: &mut Table, key: &str, value: &mut Option<NodeValue>) {
    for entry in &mut table.entries {
        replace_node(&mut entry.node, key, value);
    }
}

/// Replaces the value whose place is a key.
fn replace_node(node: &mut Node, key: &str, value: &mut Option<NodeValue>) {
    if node.at.place().file() == key {
        node.value = value.take().unwrap();
        return;
    }
    match &mut node.value {
        NodeValue::Table(table) => replace(table, key, value),
        NodeValue::Array(items) => items.iter_mut().for_each(|item| replace_node(item, key, value)),
        _ => {}
    }
}

fn numbers(values: impl IntoIterator<Item = f64>) -> NodeValue {
    let number = |value| Node { value: NodeValue::Float(value), at: At::of_key("", "") };
    NodeValue::Array(values.into_iter().map(number).collect())
}

fn sum(factor: f64) -> NodeValue {
    NodeValue::Function(NodalFunction::new(move |points| {
        Some(points.iter().map(|p| factor * (1.0 + p.x + p.y)).collect())
    }))
}

fn square(shift: f64) -> MeshFile {
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let arrays = MeshArrays {
        points: points.map(|[x, y]| [x, y + shift, 0.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        sides: vec![("bottom".into(), vec![[0, 1]]), ("top".into(), vec![[2, 3]])],
        ..MeshArrays::default()
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

const KEYS: [&str; 7] = [
    "body.0.displacement.1.normal",
    "body.0.traction.0.vector.0",
    "body.0.traction.0.vector.1",
    "body.0.traction.1.pressure",
    "body.1.displacement.0.uy",
    "contact.0.gap",
    "contact.0.friction.limit",
];

#[test]
fn data_at_nodes_replace_numbers_everywhere() {
    let plain = Case::parse(CONDITIONS, "case.toml", &[]).unwrap().hash();
    for key in KEYS {
        let case = given(CONDITIONS, key, sum(0.001)).unwrap();
        let other = case.hash();
        assert_ne!(other, plain, "{key}");
        assert!(case.settings_json().to_string().contains("{\"nodal\":\""), "{key}");
        let twice = given(CONDITIONS, key, sum(0.002)).unwrap().hash();
        assert!(twice != other && twice != plain, "{key}");
        // The same values in an array.
        let body = if key.starts_with("body.1") { 1 } else { 0 };
        let mesh = case.mesh_of(body).unwrap();
        let values = mesh.points().iter().map(|p| 0.001 * (1.0 + p.x + p.y));
        assert_eq!(given(CONDITIONS, key, numbers(values)).unwrap().hash(), other, "{key}");
        let problem = case.build().unwrap().0;
        assert!(case.data_notes(&problem).is_empty(), "{key}: {:?}", case.data_notes(&problem));
    }
}

#[test]
fn rows_of_pairs_are_a_vector_at_nodes() {
    let mesh = Case::parse(CONDITIONS, "case.toml", &[]).unwrap().mesh_of(0).unwrap();
    let row = |p: &Vector| Node { value: numbers([p.x, p.y]), at: At::of_key("", "") };
    let rows = NodeValue::Array(mesh.points().iter().map(row).collect());
    let key = "body.0.traction.0.vector";
    let case = given(CONDITIONS, key, rows).unwrap();
    let Load::Vector([x, y]) = &case.bodies[0].tractions[0].load else { panic!("no vector") };
    let at = |value: &Value| value.scalar::<Plane>().at(Vector::new(1.5, 2.0));
    assert_eq!([at(x), at(y)], [1.5, 2.0]);
}

#[test]
fn data_that_make_no_sense_are_refused_at_their_key() {
    let said = |key: &str, value: NodeValue| {
        let error = given(CONDITIONS, key, value).unwrap_err();
        let place = error.diagnostics[0].place.as_ref().unwrap().to_string();
        assert!(place.starts_with(key.trim_end_matches(".0")), "{place}");
        error.to_string()
    };
    let all = [
        (KEYS[0], numbers([1.0; 9]), "an array of 9 values, and the mesh of body \"c\" has 10 nodes"),
        (KEYS[0], NodeValue::Array(vec![]), "an array of 0 values"),
        (KEYS[3], NodeValue::Boolean(true), "is the boolean true"),
        (KEYS[5], NodeValue::Function(NodalFunction::new(|_| None)), "the function gives no values"),
        (KEYS[5], NodeValue::Function(NodalFunction::new(|_| Some(vec![0.0]))), "gives no values"),
        ("body.0.displacement.0.ux", sum(1.0), "`body.0.displacement.0.ux` takes no values at nodes"),
        ("body.0.traction.0.vector", sum(1.0), "`body.0.traction.0.vector` is a function"),
        ("body.0.side.0.point.0", sum(1.0), "is a function; expected a number"),
        ("schema", sum(1.0), "`schema` is a function"),
    ];
    for (key, value, words) in all {
        let said = said(key, value);
        assert!(said.contains(words), "{said}");
    }
    let texts = ["a", "b"].map(|text| Node { value: NodeValue::String(text.into()), at: At::of_key("", "") });
    let said = said(KEYS[3], NodeValue::Array(texts.to_vec()));
    assert!(said.contains("is an array of 2 entries, and entry 0 is the string \"a\""), "{said}");
    let with = CONDITIONS.to_owned() + "[solver]\nlambda = 0.0\n";
    let said = given(&with, "solver.lambda", sum(1.0)).unwrap_err().to_string();
    assert!(said.contains("`solver.lambda` takes no values at nodes"), "{said}");
    // A text of a case file has no values at nodes.
    let text = CONDITIONS.replace("pressure = 0.0", "pressure = [0.0, 1.0]");
    let said = Case::parse(&text, "case.toml", &[]).unwrap_err().to_string();
    assert!(said.contains("is an array; expected a number"), "{said}");
}

#[test]
fn data_on_a_side_that_does_not_exist_leave_the_fault_to_the_body() {
    let text = CONDITIONS.replace("on = \"right\"", "on = \"rigth\"");
    let case = given(&text, KEYS[3], sum(1.0)).unwrap();
    assert!(case.build_bodies().unwrap_err().to_string().contains("there is no edge group \"rigth\""));
}

#[test]
fn a_generator_alone_makes_its_mesh() {
    let mut keys = Table::default();
    let kind = NodeValue::String("block".into());
    keys.put("kind".into(), Node { value: kind, at: At::of_key("generator.kind", "") });
    keys.put("size".into(), Node { value: numbers([2.0, 1.0]), at: At::of_key("generator.size", "") });
    let said = mesh_of_generator(&keys).unwrap_err();
    assert!(said.to_string().starts_with("generator: the key `generator.cells` is missing"), "{said}");
    let whole = |n| Node { value: NodeValue::Integer(n), at: At::of_key("generator.cells", "") };
    let cells = NodeValue::Array(vec![whole(3), whole(2)]);
    keys.put("cells".into(), Node { value: cells, at: At::of_key("generator.cells", "") });
    assert_eq!(mesh_of_generator(&keys).unwrap().cells().len(), 12);
}
