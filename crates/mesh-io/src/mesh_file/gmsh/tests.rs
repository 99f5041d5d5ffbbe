//! Versions, traps and damaged sections, in small.

use super::parse;
use crate::mesh_file::{MeshFault, MeshFile, RegionOptions};
use fem_core::geometry::Vector;
use fem_core::mesh::id::NodeId;

/// Two triangles on four nodes with holes in their numbers, the lower side in two groups, the other sides in one.
const NODES: &str = "$Nodes\n4\n2 0 0 0\n30 1 0 0\n400 1 1 0\n5 0 1 0\n$EndNodes\n";
const NAMES: &str = "$PhysicalNames\n4\n1 1 \"a \"quoted\" näme\"\n1 2 \"body\"\n2 1 \"body\"\n0 9 \"corner\"\n$EndPhysicalNames\n";
const ELEMENTS: &str = "$Elements\n6\n1 1 2 1 1 2 30\n2 1 2 -2 1 30 2\n3 1 2 2 2 30 400\n9 15 2 9 1 2\n11 2 3 1 1 0 2 30 400\n12 2 2 1 1 2 5 400\n$EndElements\n";

fn two(names: &str, nodes: &str, elements: &str) -> String {
    format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}{nodes}{elements}")
}

fn sound() -> MeshFile {
    parse(two(NAMES, NODES, ELEMENTS).as_bytes(), "m.msh").unwrap()
}

fn refused(text: &str) -> String {
    parse(text.as_bytes(), "m.msh").unwrap_err().to_string()
}

#[test]
fn names_may_stand_in_two_dimensions_and_hold_anything() {
    let file = sound();
    assert_eq!(file.group_names(1).collect::<Vec<_>>(), ["a \"quoted\" näme", "body"]);
    assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["body"]);
    let region = file.region(Some("body"), RegionOptions::default()).unwrap();
    // Holes in the numbering are closed in the order of the numbers, clockwise cells turned.
    assert_eq!(region.node_numbers(), [2, 5, 30, 400]);
    assert_eq!(region.notes(), ["1 clockwise cell of region \"body\" was turned counter-clockwise"]);
    let mesh = region.mesh().unwrap();
    assert_eq!(mesh.cells(), [[0, 2, 3], [0, 3, 1]].map(|t| t.map(NodeId::new)));
    // An edge written twice, once backwards, is in both groups; its normal comes from its cell.
    let [low] = mesh.group("a \"quoted\" näme").unwrap() else { panic!() };
    assert!(mesh.group("body").unwrap().contains(low));
    assert_eq!(mesh.facet_normal(*low), Vector::new(0.0, -1.0));
}

#[test]
fn versions_2_0_and_2_1_are_read_like_2_2() {
    for version in ["2", "2.0", "2.1"] {
        let text = two(NAMES, NODES, ELEMENTS).replace("2.2 0 8", &format!("{version} 0 8"));
        let file = parse(text.as_bytes(), "m.msh").unwrap();
        assert_eq!(file.group_names(1).collect::<Vec<_>>(), ["a \"quoted\" näme", "body"], "{version}");
    }
    // Names without a dimension belong to every group of their number.
    let names = "$PhysicalNames\n2\n1 \"low\"\n2 \"right\"\n$EndPhysicalNames\n";
    let text = two(names, NODES, ELEMENTS).replace("2.2 0 8", "2 0 8");
    let file = parse(text.as_bytes(), "m.msh").unwrap();
    assert_eq!(file.group_names(1).collect::<Vec<_>>(), ["low", "right"]);
    assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["low"]);
}

#[test]
fn without_physical_groups_the_elementary_entities_are_the_groups() {
    let names =
        |file: &MeshFile, dimension: u8| file.group_names(dimension).map(str::to_owned).collect::<Vec<_>>();
    let lines = "1 1 2 0 4 2 30\n3 1 2 0 7 30 400\n9 15 2 0 1 2\n";
    let elements = format!("$Elements\n5\n{lines}11 2 2 0 12 2 30 400\n12 2 2 0 3 2 400 5\n$EndElements\n");
    let old = two("", NODES, &elements);
    let new = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n2 12 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n\
               $Elements\n4 4 1 4\n1 4 1 1\n1 1 2\n1 7 1 1\n2 2 3\n2 12 2 1\n3 1 2 3\n2 3 2 1\n4 1 3 4\n$EndElements\n";
    for text in [old.as_str(), new] {
        let file = parse(text.as_bytes(), "m.msh").unwrap();
        assert_eq!([names(&file, 1), names(&file, 2)], [["4", "7"], ["12", "3"]]);
        assert_eq!(
            file.notes(),
            ["no physical groups: elementary entities take their place, called by number"]
        );
        // One surface, or the whole mesh without a name.
        let one = file.region(Some("3"), RegionOptions::default()).unwrap();
        assert_eq!(one.cells().len(), 1);
        let whole = file.region(None, RegionOptions::default()).unwrap();
        assert_eq!(whole.cells().len(), 2);
        assert_eq!(whole.mesh().unwrap().group("7").unwrap().len(), 1);
        assert!(file.summary().problems.is_empty(), "{:?}", file.summary().problems);
    }
    // One group is enough: what lies in none has no name.
    let named = old.replace("1 1 2 0 4 2 30", "1 1 2 9 4 2 30");
    let file = parse(named.as_bytes(), "m.msh").unwrap();
    assert_eq!([names(&file, 1), names(&file, 2)], [vec!["9".to_owned()], vec![]]);
    assert_eq!(file.notes(), ["1 physical group without a name: called by number"]);
}

#[test]
fn control_characters_in_names_reach_no_terminal() {
    let names = "$PhysicalNames\n1\n2 1 \"\u{1b}[31mred\"\n$EndPhysicalNames\n";
    let file = parse(two(names, NODES, ELEMENTS).as_bytes(), "m.msh").unwrap();
    assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["\u{FFFD}[31mred"]);
}

#[test]
fn ten_thousand_groups_are_accepted() {
    let names: String = (1..=10_000).map(|k| format!("1 {k} \"side {k}\"\n")).collect();
    let names = format!("$PhysicalNames\n10000\n{names}$EndPhysicalNames\n");
    let file = parse(two(&names, NODES, ELEMENTS).as_bytes(), "m.msh").unwrap();
    assert_eq!(file.group_names(1).count(), 10_000);
    let mesh = file.region(None, RegionOptions::default()).unwrap().mesh().unwrap();
    assert_eq!(mesh.groups().len(), 2);
}

#[test]
fn groups_without_a_name_are_called_by_their_number() {
    let file = parse(two("", NODES, ELEMENTS).as_bytes(), "m.msh").unwrap();
    assert_eq!(file.group_names(1).collect::<Vec<_>>(), ["1", "2"]);
    assert_eq!(file.notes(), ["3 physical groups without a name: called by number"]);
    assert!(file.region(Some("1"), RegionOptions::default()).is_ok());
}

#[test]
fn a_file_without_groups_is_one_region_without_sides() {
    let elements =
        ELEMENTS.replace(" 2 1 1 ", " 2 0 1 ").replace(" 2 -2 1 ", " 2 0 1 ").replace(" 2 2 2 ", " 2 0 2 ");
    let elements = elements.replace(" 3 1 1 0 ", " 3 0 1 0 ");
    let file = parse(two("", NODES, &elements).as_bytes(), "m.msh").unwrap();
    assert_eq!(file.group_names(1).count() + file.group_names(2).count(), 0);
    let region = file.region(None, RegionOptions::default()).unwrap();
    let told = region.without_sides().unwrap().to_string();
    assert!(told.contains("its free boundary has 4 edges"), "{told}");
}

#[test]
fn carriage_returns_comments_and_unknown_sections_are_passed_over() {
    let more = "$Comments\nanything $End at all\n$EndComments\n";
    let data = "$NodeData\n1\n\"x\"\n$EndNodeData\n";
    let text = format!("{more}{}{data}", two(NAMES, NODES, ELEMENTS)).replace('\n', "\r\n");
    let file = parse(text.as_bytes(), "m.msh").unwrap();
    assert_eq!(file.region(None, RegionOptions::default()).unwrap().cells().len(), 2);
    let text = format!("\u{FEFF}{text}");
    assert!(parse(text.as_bytes(), "m.msh").is_ok());
}

#[test]
fn lines_with_too_many_or_too_few_numbers_are_found() {
    let short = refused(&two("", &NODES.replace("30 1 0 0", "30 1 0"), ELEMENTS));
    assert!(short.starts_with("m.msh:7: this line of $Nodes has fewer numbers than expected"), "{short}");
    let long = refused(&two("", &NODES.replace("30 1 0 0", "30 1 0 0 0"), ELEMENTS));
    assert!(long.starts_with("m.msh:7: this line of $Nodes has more numbers than expected"), "{long}");
    let word = refused(&two("", &NODES.replace("30 1 0 0", "30 1 zero 0"), ELEMENTS));
    assert!(word.starts_with("m.msh:7: found `zero` in $Nodes; expected a coordinate"), "{word}");
    let short = refused(&two("", NODES, &ELEMENTS.replace("2 30 400\n12", "2 30\n12")));
    assert!(short.starts_with("m.msh:17: this line of $Elements has fewer"), "{short}");
}

#[test]
fn sections_stand_once_and_are_complete() {
    assert!(refused(&two("", &NODES.repeat(2), ELEMENTS)).contains("second section $Nodes"));
    assert!(refused(&two("", NODES, "")).contains("ends without a section $Elements"));
    assert!(refused(&two("", "", ELEMENTS)).contains("without a section $Nodes"));
    assert!(
        refused(&two("", NODES, "$Elements\n6\n1 1 2 1 1 2 30\n"))
            .contains("ended inside $Elements after 1 of 6 elements")
    );
    assert!(refused(&two("stray\n", NODES, ELEMENTS)).contains("found `stray` between two sections"));
    let twice = "$PhysicalNames\n2\n1 1 \"a\"\n1 2 \"a\"\n$EndPhysicalNames\n";
    assert!(
        refused(&two(twice, NODES, ELEMENTS)).contains("two physical groups of dimension 1 are called \"a\"")
    );
    // Some programs write names without quotes.
    let bare = two("$PhysicalNames\n1\n1 1 a\n$EndPhysicalNames\n", NODES, ELEMENTS);
    let file = parse(bare.as_bytes(), "m.msh").unwrap();
    assert!(file.group_names(1).any(|name| name == "a"));
}

#[test]
fn the_first_version_and_4_0_are_read() {
    let first = "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$ENDNOD\n$ELM\n3\n1 1 7 1 2 1 2\n2 2 5 1 3 1 2 3\n3 2 5 1 3 1 3 4\n$ENDELM\n";
    let file = parse(first.as_bytes(), "m.msh").unwrap();
    let region = file.region(None, RegionOptions::default()).unwrap();
    assert_eq!((region.cells().len(), file.group_names(1).collect::<Vec<_>>()), (2, vec!["7"]));
    // Number, dimension and parameters of an entity, the numbers of its nodes with their places; types of elements in blocks.
    let fourth = "$MeshFormat\n4 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 1 5 0\n$EndEntities\n\
        $Nodes\n1 4\n1 2 0 4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
        $Elements\n1 2\n1 2 2 2\n1 1 2 3\n2 1 3 4\n$EndElements\n";
    let file = parse(fourth.as_bytes(), "m.msh").unwrap();
    assert_eq!(file.region(Some("5"), RegionOptions::default()).unwrap().cells().len(), 2);
}

#[test]
fn binary_files_of_either_byte_order_or_a_wrong_one() {
    let head = |version: &str, mark: [u8; 4]| {
        [format!("$MeshFormat\n{version} 1 8\n").as_bytes(), &mark, b"\n$EndMeshFormat\n$Nodes\n"].concat()
    };
    let error = parse(&head("2.2", [0, 1, 0, 0]), "m.msh").unwrap_err();
    assert_eq!(error.fault, MeshFault::Format);
    assert!(error.to_string().contains("the mark of the byte order is 256"), "{error}");
    // Counts that the file cannot hold, in both orders and versions.
    let huge = 1_000_000_000_000u64;
    let mut two = head("2.2", [1, 0, 0, 0]);
    two.extend(format!("{huge}\n0123456789").bytes());
    let error = parse(&two, "m.msh").unwrap_err().to_string();
    assert!(error.contains("ended inside $Nodes after 0 of 1000000000000 nodes"), "{error}");
    for (mark, bytes) in [([1, 0, 0, 0], huge.to_le_bytes()), ([0, 0, 0, 1], huge.to_be_bytes())] {
        let mut four = head("4.1", mark);
        four.extend([[0; 8], bytes, [0; 8], [0; 8]].concat());
        let error = parse(&four, "m.msh").unwrap_err().to_string();
        assert!(error.contains("ended inside $Nodes after 0 of 1000000000000 nodes"), "{error}");
    }
    assert!(refused("$MeshFormat\n2.2 0 4\n").contains("numbers have 4 bytes"));
    assert!(refused("$MeshFormat\n2.2 2 8\n").contains("the file type is 2"));
}

#[test]
fn blocks_of_version_four_agree_with_their_heads() {
    let file = |entities: &str, nodes: &str, elements: &str| {
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n{entities}$EndEntities\n$Nodes\n{nodes}$EndNodes\n$Elements\n{elements}$EndElements\n"
        )
    };
    // The curve carries two groups, one with the sign of its sense; nodes carry parametric coordinates.
    let entities = "0 1 1 0\n7 0 0 0 1 0 0 2 -4 5 2 1 -2\n3 0 0 0 1 1 0 1 6 1 7\n";
    let nodes = "2 3 1 9\n1 7 1 2\n1\n9\n0 0 0 0\n1 0 0 1\n2 3 0 1\n4\n0 1 0\n";
    let elements = "2 2 1 2\n1 7 1 1\n1 9 1\n2 3 2 1\n2 1 9 4\n";
    let mesh = parse(file(entities, nodes, elements).as_bytes(), "m.msh").unwrap();
    assert_eq!(mesh.group_names(1).collect::<Vec<_>>(), ["4", "5"]);
    let region = mesh.region(Some("6"), RegionOptions::default()).unwrap();
    assert_eq!(region.mesh().unwrap().groups().values().map(Vec::len).collect::<Vec<_>>(), [1, 1]);
    let faults = [
        (
            nodes.replace("2 3 1 9", "2 4 1 9"),
            elements.to_owned(),
            "the blocks hold 3 nodes, the head of the section says 4",
        ),
        (nodes.replace("2 3 0 1", "2 3 0 2"), elements.to_owned(), "a block of 2 nodes begins after 2 of 3"),
        (nodes.replace("1 7 1 2", "1 7 2 2"), elements.to_owned(), "parametric mark 2"),
        (
            nodes.to_owned(),
            elements.replace("2 3 2 1", "1 3 2 1"),
            "3-node triangles lies on an entity of dimension 1",
        ),
        (nodes.to_owned(), elements.replace("2 3 2 1", "3 3 92 1"), "1 higher-order volume element"),
    ];
    for (nodes, elements, expected) in faults {
        let found = refused(&file(entities, &nodes, &elements));
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn fortran_exponents_and_decimal_commas_in_coordinates_are_told_how_to_write_them() {
    let four = |nodes: &str| {
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n{nodes}$EndNodes\n\
             $Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n"
        )
    };
    for (written, help) in [
        ("1D0", "Fortran exponent: write 1E0"),
        ("-2.5d-3", "Fortran exponent: write -2.5E-3"),
        ("0,5", "decimal comma: write 0.5"),
        ("1mm", "write it without unit: 1 (all units must agree)"),
    ] {
        let end = format!("found `{written}` in $Nodes; expected a coordinate; help: {help}");
        let nodes = NODES.replace("30 1 0 0", &format!("30 {written} 0 0"));
        assert_eq!(refused(&two(NAMES, &nodes, ELEMENTS)), format!("m.msh:14: {end}"));
        assert_eq!(refused(&four(&format!("0 0 0\n{written} 0 0\n0 1 0\n"))), format!("m.msh:11: {end}"));
    }
}
