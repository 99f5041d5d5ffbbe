//! Keywords, sets, surfaces and what is refused, in small.

use super::parse_text;
use crate::mesh_file::{MeshFile, RegionOptions};
use fem_core::mesh::TriMesh;

const DECK: &str = "** two squares\n*Heading\nanything, at all\n*NODE, NSET=all\n1, 0, 0\n2, 1., 0\n3, 2, 0.D0\n4, , 1\n\
    5, 1, 1, 0.\n6, 2.0E0, 1\n*element, elset=Plate,\n type=cps4r\n1, 1, 2,\n 5, 4\n2, 2, 3, 6, 5\n";

fn read(more: &str) -> MeshFile {
    parse_text(format!("{DECK}{more}").as_bytes(), "d.inp").unwrap()
}

fn mesh(more: &str) -> TriMesh {
    read(more).region(Some("Plate"), RegionOptions::default()).unwrap().mesh().unwrap()
}

fn refused(more: &str) -> String {
    parse_text(format!("{DECK}{more}").as_bytes(), "d.inp").unwrap_err().to_string()
}

/// Returns the edges of a group by their nodes' numbers in the deck.
fn side(mesh: &TriMesh, name: &str) -> Vec<[u32; 2]> {
    let edges = mesh.group(name).unwrap_or_default();
    edges.iter().map(|e| mesh.topology().facets()[*e].map(|n| u32::from(n) + 1)).collect()
}

#[test]
fn surfaces_sets_of_lines_and_sets_of_nodes_are_sides() {
    let more = "*SURFACE, NAME=low, TYPE=ELEMENT\nPLATE, S1\n*SURFACE, NAME=\"the top\"\n1, S3\n2, s3\n\
        *ELEMENT, TYPE=T3D2, ELSET=ends\n7, 4, 1\n8, 6, 3\n*NSET, NSET=up\n4, 5\n 6,\n*NSET, NSET=left, GENERATE\n1, 4, 3\n\
        *NSET, NSET=both\nup, left\n*SURFACE, TYPE=NODE, NAME=again\nup\n";
    let mesh = mesh(more);
    assert_eq!(side(&mesh, "low"), [[1, 2], [2, 3]]);
    assert_eq!(side(&mesh, "the top"), [[4, 5], [5, 6]]);
    assert_eq!(side(&mesh, "ends"), [[1, 4], [3, 6]]);
    assert_eq!(side(&mesh, "up"), [[4, 5], [5, 6]]);
    assert_eq!(side(&mesh, "left"), [[1, 4]]);
    assert_eq!(side(&mesh, "both"), [[1, 4], [4, 5], [5, 6]]);
    assert_eq!(side(&mesh, "again"), [[4, 5], [5, 6]]);
    // The edge between the squares has both its ends in the set, but is not free.
    assert_eq!(side(&mesh, "all").len(), 6);
}

#[test]
fn faces_of_shells_are_counted_after_their_two_sides_and_springs_are_no_cells() {
    let shells = DECK.replace("type=cps4r", "type=S4R");
    let more = "*SURFACE, NAME=third\n1, S3\n*SURFACE, NAME=edge\n1, E1\n*SURFACE, NAME=whole\nPlate, SPOS\n\
        *ELEMENT, TYPE=SPRINGA, ELSET=k\n9, 1, 2\n";
    let file = parse_text(format!("{shells}{more}").as_bytes(), "d.inp").unwrap();
    let mesh = file.region(Some("Plate"), RegionOptions::default()).unwrap().mesh().unwrap();
    assert_eq!(side(&mesh, "third"), [[1, 2]]);
    assert_eq!(side(&mesh, "edge"), [[1, 2]]);
    assert!(side(&mesh, "whole").is_empty());
    let axis = DECK.replace("type=cps4r", "type=CAX4");
    let refused = parse_text(axis.as_bytes(), "d.inp").unwrap_err().to_string();
    assert!(refused.contains("axisymmetric"), "{refused}");
}

#[test]
fn sets_grow_and_contain_earlier_ones() {
    let file = read(
        "*ELSET, ELSET=one\n1\n*ELSET, ELSET=ONE\n2\n*ELSET, ELSET=more, GENERATE\n1, 999, 2\n*ELSET,ELSET=x\none, more\n",
    );
    assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["Plate", "one", "more", "x"]);
    let cells = |name| file.region(Some(name), RegionOptions::default()).unwrap().cells().len();
    assert_eq!([cells("one"), cells("more"), cells("x")], [4, 2, 4]);
    let later = refused("*ELSET, ELSET=a\nb\n*ELSET, ELSET=b\n1\n");
    assert!(later.contains("d.inp:17: element set \"a\" contains the set \"b\""), "{later}");
    assert!(refused("*ELSET, ELSET=a\nA\n").contains("contains the set \"A\""));
    assert!(refused("*NSET, NSET=a\nal\n").contains("there is no node set \"al\"; expected"));
}

#[test]
fn other_keywords_are_ignored_and_counted() {
    let file =
        read("*MATERIAL, NAME=m\n*ELASTIC\n1., 0.3\n*STEP\n*NODE PRINT\n*ELEMENT OUTPUT\n*END STEP\n*STEP\n");
    let note = "6 keywords that do not describe the mesh were ignored: MATERIAL, ELASTIC, STEP, NODE PRINT, ELEMENT OUTPUT";
    assert_eq!(file.notes(), [note]);
}

#[test]
fn what_would_change_the_mesh_is_refused() {
    for keyword in ["NGEN", "NFILL", "ELGEN", "System", "NCOPY"] {
        let told = refused(&format!("*{keyword}, X=1\n"));
        assert!(told.starts_with(&format!("d.inp:16: *{} is not read", keyword.to_uppercase())), "{told}");
    }
    assert!(refused("*NODE, SYSTEM=C\n9, 1, 1\n").contains("Cartesian"));
    assert!(refused("*NODE, INPUT=n.inp\n").contains("*INCLUDE"));
    assert!(refused("*INCLUDE, INPUT=n.inp\n").contains("included files are not read here"));
    assert!(refused("*ELEMENT, TYPE=CAX4\n9, 1, 2, 5, 4\n").contains("1 element of type CAX4"));
    assert!(refused("*ELEMENT\n9, 1, 2, 5, 4\n").contains("*ELEMENT has no TYPE"));
}

#[test]
fn wrong_lines_are_found() {
    let expect = |more: &str, words: &str| {
        let told = refused(more);
        assert!(told.contains(words), "{told}");
    };
    expect("*NODE\nx, 1, 1\n", "d.inp:17: found `x`; expected the number of a node");
    expect("*NODE\n7, 1\n", "d.inp:17: node 7 has 1 coordinates; expected number, x, y");
    expect("*NODE\n7, 1, inf\n", "d.inp:17: node 7 has the coordinates (1, inf, 0)");
    expect("*ELEMENT, TYPE=CPS3\n3, 1, 2\n", "d.inp:17: an element of type CPS3 has 2 nodes; expected 3");
    expect("*ELEMENT, TYPE=CPS3\n3, 1, 2, 5, 6\n", "has 4 nodes; expected 3");
    expect("*ELEMENT, TYPE=CPS3\n3, 1, 2,\n", "the data of element 3 (CPS3) ended after 3 numbers");
    expect("*ELEMENT, TYPE=CPS3\n3, 1, -2, 5\n", "found `-2`; expected a whole number");
    expect("*ELSET, ELSET=a, GENERATE\n5, 1\n", "5, 1 do not make a range");
    expect("*ELSET, ELSET=a, GENERATE\n1, 5, 0\n", "1, 5, 0 do not make a range");
    expect("*SURFACE, NAME=a\n1, S9\n", "the face of a surface is `S9`");
    expect("*SURFACE, NAME=a\nPlate\n", "the face of a surface is missing");
    expect("*SURFACE, NAME=a, TYPE=CUTTING\n", "*SURFACE has the type CUTTING");
    expect("*SURFACE\n1, S1\n", "*SURFACE has no name");
    expect("*NSET\n1\n", "*NSET has no name");
    expect("*NSET, NSET=a\n1,,2\n", "an entry is empty");
}

#[test]
fn a_few_bytes_cannot_ask_for_much() {
    // Each line names a million millions of elements; there are two.
    let endless = "1, 1000000000000\n".repeat(1000);
    let file = read(&format!("*ELSET, ELSET=a, GENERATE\n{endless}"));
    assert_eq!(file.region(Some("a"), RegionOptions::default()).unwrap().cells().len(), 4);
    // A set of all elements a thousand times over is more than the deck may ask for.
    let cells: String = (0..5000).map(|k| format!("{}, 1, 2, 5\n", k + 10)).collect();
    let sets: String = (0..2000).map(|k| format!("*ELSET, ELSET=s{k}\nbig\n")).collect();
    let told = refused(&format!("*ELEMENT, TYPE=CPS3, ELSET=big\n{cells}{sets}"));
    assert!(told.contains("the sets expand to more members than this file can describe"), "{told}");
}

#[test]
fn every_element_type_of_the_plane_is_known_and_no_other() {
    use super::data::kind;
    for name in
        ["CPS3", "CPE3", "CPE4H", "CPS4I", "CPE6M", "CPS8R", "CPE8RH", "M3D9", "S4R", "B31", "B32H", "T2D3"]
    {
        assert!(kind(name).is_some(), "{name}");
    }
    for name in ["C3D7", "CAX4", "CPS5", "SPRINGA", "MASS", "S", "CPS", "CPS4-1", "R2D2", ""] {
        assert!(kind(name).is_none(), "{name}");
    }
}

#[test]
fn decimal_commas_in_a_deck_are_refused_and_not_read_as_two_coordinates() {
    let deck = |line: &str| {
        let text = DECK.replace("2, 1., 0\n", &format!("{line}\n"));
        parse_text(text.as_bytes(), "d.inp").map(|_| ()).map_err(|e| e.to_string())
    };
    // Read field by field this is the point (0, 5).
    let said = deck("2, 0,5, 1,5").unwrap_err();
    assert!(said.starts_with("d.inp:6: node 2 has 4 whole numbers for coordinates"), "{said}");
    assert!(said.ends_with("help: decimal comma: write 0.5"), "{said}");
    assert!(deck("2, -0,5, 1,5, 0,0").unwrap_err().ends_with("write -0.5"));
    let said = deck("2; 0,5; 1,5").unwrap_err();
    assert!(said.contains("found `2; 0`") && said.contains("separate numbers by commas"), "{said}");
    let said = deck("2, 1.5 mm, 0.").unwrap_err();
    assert!(
        said.ends_with("expected a coordinate; help: write it without unit: 1.5 (all units must agree)"),
        "{said}"
    );
    // Fortran's exponent is read, and so are whole numbers, with a normal behind them as well.
    for line in ["2, 1D0, 0", "2, 1, 0", "2, 1, 0, 0", "2, 1, 0, 0, 0, 0, 1", "2, 1, 0, 0, 0, 0, 0"] {
        assert_eq!(deck(line), Ok(()), "{line}");
    }
}

/// Two parts, one of them twice: moved, and turned by a right angle about (1, 0).
const PARTS: &str = "*Heading\n*Part, name=Plate\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n\
    *Element, type=CPS4\n1, 1, 2, 3, 4\n*Elset, elset=all, generate\n1, 1\n*Surface, name=low, type=ELEMENT\nall, S1\n*End Part\n\
    *Part, name=Wedge\n*Node\n1, 0., 0.\n2, 1., 0.\n3, 0., 1.\n*Element, type=CPS3\n7, 1, 2, 3\n*End Part\n\
    *Assembly, name=A\n*Instance, name=Plate-1, part=plate\n*End Instance\n*Instance, name=Plate-2, part=Plate\n0., 2.\n\
    1., 0., 0., 1., 0., 1., 90.\n*End Instance\n*Instance, name=Wedge-1, part=Wedge\n5., 0., 0.\n*End Instance\n\
    *Node\n1, 9., 9.\n*Nset, nset=point\n1\n*Elset, elset=_top_S3, internal, instance=Plate-2\n1\n\
    *Surface, type=ELEMENT, name=top\n_top_S3, S3\n*Surface, type=ELEMENT, name=bottom\nPlate-1.all, S1\n*End Assembly\n*Step\n*End Step\n";

#[test]
fn parts_are_read_once_for_each_of_their_instances() {
    let file = parse_text(PARTS.as_bytes(), "parts.inp").unwrap();
    let regions: Vec<&str> = file.group_names(2).collect();
    assert_eq!(regions, ["Plate-1", "Plate-1.all", "Plate-2", "Plate-2.all", "Wedge-1", "_top_S3"]);
    let body = |name| file.region(Some(name), RegionOptions::default()).unwrap().mesh().unwrap();
    let corners = |mesh: &TriMesh| mesh.points().iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>();
    let [plate, turned] = [body("Plate-1"), body("Plate-2")];
    assert_eq!(corners(&plate), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    // (0, 0) goes to (0, 2) and then, about (1, 0), to (−1, −1).
    let expected = [[-1.0, -1.0], [-1.0, 0.0], [-2.0, 0.0], [-2.0, -1.0]];
    for (found, expected) in corners(&turned).iter().zip(expected) {
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-14), "{found:?}");
    }
    assert_eq!(corners(&body("Wedge-1")), [[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]]);
    let ends = |mesh: &TriMesh, name: &str| -> Vec<[u32; 2]> {
        mesh.group(name)
            .unwrap_or_default()
            .iter()
            .map(|e| mesh.topology().facets()[*e].map(u32::from))
            .collect()
    };
    assert_eq!(ends(&plate, "bottom"), [[0, 1]]);
    assert_eq!(ends(&plate, "Plate-1.low"), [[0, 1]]);
    assert_eq!(ends(&turned, "top"), [[2, 3]]);
    assert_eq!(ends(&turned, "Plate-2.low"), [[0, 1]]);
}

#[test]
fn wrong_parts_and_instances_are_found() {
    let expect = |from: &str, to: &str, words: &str| {
        assert!(PARTS.contains(from), "{from}");
        let told = parse_text(PARTS.replacen(from, to, 1).as_bytes(), "p.inp").unwrap_err().to_string();
        assert!(told.contains(words), "{told}");
    };
    expect("part=plate", "part=Plaat", "p.inp:24: there is no part \"Plaat\"");
    expect("part=plate", "library=x", "*INSTANCE without its name or its part");
    expect("name=Plate-2", "name=plate-1", "instance \"plate-1\" has the name of another one or of a set");
    expect("*End Instance\n*Node", "*Node", "p.inp:42: instance \"Wedge-1\" has no end");
    expect("instance=Plate-2", "instance=Plate-3", "there is no instance \"Plate-3\"");
    expect(
        "1., 0., 0., 1., 0., 1., 90.",
        "1., 0., 0., 1., 0., 0., 90.",
        "p.inp:28: the axis of an instance's rotation has no direction",
    );
    expect(
        "0., 2.\n",
        "0., x\n",
        "p.inp:27: found `x` in the position of an instance; expected a finite number",
    );
    expect(
        "1., 0., 0., 1., 0., 1., 90.",
        "1., 0., 0., 1.",
        "the position of an instance has 4 numbers in a line",
    );
    expect(
        "*End Part\n*Assembly",
        "*Assembly",
        "p.inp:22: *ASSEMBLY before the end of part \"Wedge\"; expected *END PART",
    );
    expect("name=Wedge\n", "name=plate\n", "p.inp:15: part \"plate\" begins a second time");
    expect("*Assembly, name=A\n", "", "*INSTANCE outside an assembly");
    expect("*End Instance\n*Instance", "*Instance", "instance \"Plate-1\" has no end");
    expect("7, 1, 2, 3", "7, 1, 2, 3\n*End Instance", "*END INSTANCE before the end of part");
    expect("nset=point", "nset=plate-2", "the name \"plate-2\" of a set is that of an instance");
    expect("nset=point", "nset=Plate-2.x", "of a set is that of an instance or of a set in it");
    // Numbers stay in their instance; the assembly has numbers of its own.
    expect("*Nset, nset=point\n1\n", "*Nset, nset=point\n2\n", "node set \"point\" names node 1000000000002");
    expect("*Nset, nset=point\n1\n", "*Nset, nset=point, instance=Wedge-1\n4\n", "names node 3000000000004");
    expect(
        "1, 0., 0.\n",
        "1000000000000, 0., 0.\n",
        "found the number 1000000000000 in a part or an assembly",
    );
    expect("name=Wedge\n", "nam=Wedge\n", "*PART has no name");
    // The message names the line in the part.
    expect(
        "7, 1, 2, 3",
        "7, 1, 2, 4",
        "p.inp:21: element 3000000000007 (3-node triangle) uses node 3000000000004",
    );
    let alone = &PARTS[..PARTS.find("*Assembly").unwrap()];
    let told = parse_text(alone.as_bytes(), "p.inp").unwrap_err().to_string();
    assert!(told.contains("expected *INSTANCE of its parts"), "{told}");
    let unused = PARTS.replace("*Instance, name=Wedge-1, part=Wedge\n5., 0., 0.\n*End Instance\n", "");
    let file = parse_text(unused.as_bytes(), "p.inp").unwrap();
    assert_eq!(file.notes()[0], "1 part without an instance: Wedge");
}

#[test]
fn hundreds_of_instances_have_numbers_of_their_own() {
    let part = &PARTS[..PARTS.find("*Part, name=Wedge").unwrap()];
    let instances: String =
        (0..500).map(|k| format!("*Instance, name=I{k}, part=Plate\n{k}., 0.\n*End Instance\n")).collect();
    let text = format!("{part}*Assembly, name=A\n{instances}*End Assembly\n");
    let file = parse_text(text.as_bytes(), "many.inp").unwrap();
    for k in [0, 1, 17, 499] {
        let body = file.region(Some(&format!("I{k}")), RegionOptions::default()).unwrap().mesh().unwrap();
        let x: Vec<f64> = body.points().iter().map(|p| p[0]).collect();
        let k = f64::from(k);
        assert_eq!(x, [k, k + 1.0, k + 1.0, k]);
    }
}

#[test]
fn numbers_of_an_instance_do_not_reach_into_another_one() {
    // Ranges go beyond what there is; sets of the assembly name numbers of instances.
    let more = "*Elset, elset=far, instance=Plate-1, generate\n1, 999999999999999, 1\n*Elset, elset=named\nPlate-2.1\n\
        *Surface, name=left, type=ELEMENT\nWedge-1.7, S3\n";
    let text = PARTS.replace("1, 1\n*Surface, name=low", "1, 5000000000000\n*Surface, name=low");
    let text = text.replace("*End Assembly\n", &format!("{more}*End Assembly\n*Nset, nset=after\n1\n"));
    let file = parse_text(text.as_bytes(), "p.inp").unwrap();
    let cells = |name| file.region(Some(name), RegionOptions::default()).unwrap().cells().len();
    assert_eq!([cells("far"), cells("named"), cells("Plate-1.all"), cells("Plate-2.all")], [2; 4]);
    let wedge = file.region(Some("Wedge-1"), RegionOptions::default()).unwrap().mesh().unwrap();
    assert_eq!(wedge.group("left").unwrap_or_default().len(), 1);
    // A node of the assembly before the first instance is not one of it.
    let first =
        PARTS.replace("*Assembly, name=A\n", "*Assembly, name=A\n*Node\n2, 9., 8.\n*Nset, nset=early\n2\n");
    let plate = parse_text(first.as_bytes(), "p.inp").unwrap();
    let plate = plate.region(Some("Plate-1"), RegionOptions::default()).unwrap().mesh().unwrap();
    assert_eq!(plate.points().len(), 4);
}

/// A cube with corners 1 to 8, and the nodes from 9 on inside of it; the elements use their corners and as many other nodes as they need.
fn volumes(elements: &str) -> String {
    let mut text = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n".to_owned();
    (9..=40).for_each(|k| text += &format!("{k}, 0.5, 0.5, 0.{k}\n"));
    text + elements
}

fn solid(text: &str) -> (fem_core::mesh::TetMesh, Vec<String>) {
    let file = parse_text(text.as_bytes(), "v.inp").unwrap();
    let region = file.solid_regions(&[], RegionOptions::default()).unwrap();
    (region.mesh().unwrap(), region.notes().to_vec())
}

/// The nodes of a side, with their numbers in the deck.
fn nodes_of(mesh: &fem_core::mesh::TetMesh, name: &str) -> Vec<[f64; 3]> {
    let faces = mesh.group(name).unwrap_or_else(|| panic!("{name}"));
    let mut nodes: Vec<[f64; 3]> = faces
        .iter()
        .flat_map(|face| mesh.topology().facets()[*face])
        .map(|node| mesh.points()[node.index()].into())
        .collect();
    nodes.sort_by(|a, b| a.partial_cmp(b).unwrap());
    nodes.dedup();
    nodes
}

#[test]
fn every_volume_is_read_with_its_faces() {
    // Corners of each face by the tables of the manual.
    let tetrahedron: &[&[usize]] = &[&[1, 2, 3], &[1, 4, 2], &[2, 4, 3], &[3, 4, 1]];
    let pyramid: &[&[usize]] = &[&[1, 2, 3, 4], &[1, 5, 2], &[2, 5, 3], &[3, 5, 4], &[4, 5, 1]];
    let prism: &[&[usize]] = &[&[1, 2, 3], &[4, 6, 5], &[1, 4, 5, 2], &[2, 5, 6, 3], &[3, 6, 4, 1]];
    let hexahedron: &[&[usize]] =
        &[&[1, 2, 3, 4], &[5, 8, 7, 6], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 8, 4], &[4, 8, 5, 1]];
    type Kind<'a> = (&'a str, usize, &'a [usize], &'a [&'a [usize]]);
    let kinds: [Kind<'_>; 11] = [
        ("C3D4", 4, &[1, 2, 3, 5], tetrahedron),
        ("C3D10M", 10, &[1, 2, 3, 5], tetrahedron),
        ("C3D10MH", 10, &[1, 2, 3, 5], tetrahedron),
        ("C3D5", 5, &[1, 2, 3, 4, 5], pyramid),
        ("C3D6", 6, &[1, 2, 3, 5, 6, 7], prism),
        ("C3D15", 15, &[1, 2, 3, 5, 6, 7], prism),
        ("C3D8", 8, &[1, 2, 3, 4, 5, 6, 7, 8], hexahedron),
        ("C3D8RH", 8, &[1, 2, 3, 4, 5, 6, 7, 8], hexahedron),
        ("C3D8I", 8, &[1, 2, 3, 4, 5, 6, 7, 8], hexahedron),
        ("C3D20R", 20, &[1, 2, 3, 4, 5, 6, 7, 8], hexahedron),
        ("C3D27", 27, &[1, 2, 3, 4, 5, 6, 7, 8], hexahedron),
    ];
    for (name, count, corners, faces) in kinds {
        let others = 9..9 + count - corners.len();
        let mut row: Vec<String> =
            [77].iter().chain(corners).copied().chain(others).map(|n| n.to_string()).collect();
        // Data of one element in two lines.
        row[corners.len() / 2] += ",\n";
        let row = row.join(", ").replace(",\n,", ",\n");
        let surfaces: String =
            (1..=faces.len()).map(|k| format!("*SURFACE, NAME=face{k}, TYPE=ELEMENT\nall, S{k}\n")).collect();
        let text = volumes(&format!("*ELEMENT, TYPE={name}, ELSET=all\n{row}\n{surfaces}"));
        let (mesh, notes) = solid(&text);
        assert_eq!(mesh.points().len(), corners.len(), "{name}");
        assert_eq!(
            notes.iter().filter(|n| n.contains("quadratic cell")).count(),
            usize::from(count > 8),
            "{name}"
        );
        for (k, face) in faces.iter().enumerate() {
            let place = |corner: &usize| {
                let n = corners[corner - 1] - 1;
                [
                    f64::from(u8::from([1, 2, 5, 6].contains(&n))),
                    f64::from(u8::from([2, 3, 6, 7].contains(&n))),
                    (n / 4) as f64,
                ]
            };
            let mut expected: Vec<[f64; 3]> = face.iter().map(place).collect();
            expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
            assert_eq!(nodes_of(&mesh, &format!("face{}", k + 1)), expected, "{name} S{}", k + 1);
            assert_eq!(
                mesh.group(&format!("face{}", k + 1)).unwrap().len(),
                face.len() - 2,
                "{name} S{}",
                k + 1
            );
        }
        let beyond = text + &format!("*SURFACE, NAME=none\n77, S{}\n", faces.len() + 1);
        if faces.len() < 6 {
            let told = parse_text(beyond.as_bytes(), "v.inp").unwrap_err().to_string();
            assert!(told.contains("takes the face S") && told.contains("of element 77"), "{told}");
        }
    }
}

#[test]
fn decks_of_calculix_have_their_ways() {
    // A comment with a mark before it, no comma at the end of a line, couplings beside volumes, elements of other physics, a loop.
    let nodes: Vec<String> = (1..=20).map(|n| n.to_string()).collect();
    let text = format!(
        "*ELEMENT, TYPE=DC3D20\n1, {}\n{}\n*ELEMENT, TYPE=DCOUP3D, ELSET=c\n2, 1\n*ELEMENT, TYPE=D\n3, 1, 2, 3\n\
         *ELEMENT, TYPE=T3D2\n4, 1, 1\n",
        nodes[..10].join(", "),
        nodes[10..].join(", ")
    );
    let text = format!(">** A cube\n{}", volumes(&text));
    let file = crate::parse(text.as_bytes(), "ccx.inp").unwrap();
    assert!(
        file.notes().contains(&"1 edge from a node to itself: left out".to_owned()),
        "{:?}",
        file.notes()
    );
    let region = file.solid_regions(&[], RegionOptions::default()).unwrap();
    assert_eq!((region.cells().len(), region.points().len()), (6, 8));
    let short = text.replace(", 19, 20", "");
    let told = crate::parse(short.as_bytes(), "ccx.inp").unwrap_err().to_string();
    assert!(told.contains("the data of element 1 (DC3D20) ended after 19 numbers"), "{told}");
}

#[test]
fn a_set_of_nodes_takes_whole_quadrilaterals_only() {
    let cube = "*ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n";
    let sets = "*NSET, NSET=top\n5, 6, 7, 8\n*NSET, NSET=three\n1, 2, 3\n*NSET, NSET=two\n1, 2, 3, 4, 7, 8\n";
    let (mesh, _) = solid(&volumes(&format!("{cube}{sets}")));
    assert_eq!(mesh.group("top").map(<[_]>::len), Some(2));
    assert_eq!(mesh.group("three"), None);
    assert_eq!(mesh.group("two").map(<[_]>::len), Some(4));
}

#[test]
fn instances_of_solids_are_turned_about_any_axis() {
    let part = format!(
        "*PART, NAME=cube\n{}*SURFACE, NAME=top\n1, S2\n*END PART\n",
        volumes("*ELEMENT, TYPE=C3D8R\n1, 1, 2, 3, 4, 5, 6, 7, 8\n")
    );
    // About the x axis by a right angle, and by 120 degrees about the diagonal, which exchanges the axes; moved before.
    let instances = "*INSTANCE, NAME=a, PART=cube\n*END INSTANCE\n*INSTANCE, NAME=b, PART=cube\n3, 0, 0\n0, 0, 0, 5, 0, 0, 90\n*END INSTANCE\n\
        *INSTANCE, NAME=c, PART=cube\n0, 0, 4\n1, 1, 1, 2, 2, 2, 120\n*END INSTANCE\n";
    let text = format!("{part}*ASSEMBLY, NAME=x\n{instances}*END ASSEMBLY\n");
    let file = parse_text(text.as_bytes(), "p.inp").unwrap();
    assert_eq!(file.group_names(3).collect::<Vec<_>>(), ["a", "b", "c"]);
    let top = |name: &str| {
        let region = file.solid_regions(&[name], RegionOptions::default()).unwrap();
        nodes_of(&region.mesh().unwrap(), &format!("{name}.top"))
    };
    assert_eq!(top("a"), [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]);
    assert_eq!(top("b"), [[3.0, -1.0, 0.0], [3.0, -1.0, 1.0], [4.0, -1.0, 0.0], [4.0, -1.0, 1.0]]);
    // (x, y, z) goes to (z, x, y): the top at z = 5 to x = 5.
    let turned = top("c");
    let expected = [[5.0, 0.0, 0.0], [5.0, 0.0, 1.0], [5.0, 1.0, 0.0], [5.0, 1.0, 1.0]];
    for corner in expected {
        let near = |p: &[f64; 3]| (0..3).all(|k| (p[k] - corner[k]).abs() < 1e-14);
        assert!(turned.iter().any(near), "{corner:?} in {turned:?}");
    }
}
