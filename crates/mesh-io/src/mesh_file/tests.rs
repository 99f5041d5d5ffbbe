//! Regions and summaries: cells that are split or turned, and content that is refused or noted.

use super::{MeshFile, RegionOptions, parse};

/// A deck with the given nodes and elements, all in region `r`.
fn deck(nodes: &[[f64; 3]], elements: &str) -> MeshFile {
    let mut text = "*NODE\n".to_owned();
    for (k, [x, y, z]) in nodes.iter().enumerate() {
        text += &format!("{}, {x:?}, {y:?}, {z:?}\n", k + 1);
    }
    let text = text + elements;
    parse(text.as_bytes(), "d.inp").unwrap_or_else(|e| panic!("{e}"))
}

const QUAD: &str = "*ELEMENT, TYPE=CPS4, ELSET=r\n1, 1, 2, 3, 4\n";

fn quad(points: [[f64; 2]; 4]) -> MeshFile {
    deck(&points.map(|[x, y]| [x, y, 0.0]), QUAD)
}

fn region(file: &MeshFile) -> super::Region {
    file.region(Some("r"), RegionOptions::default()).unwrap()
}

fn refused(file: &MeshFile) -> String {
    file.region(Some("r"), RegionOptions::default()).unwrap_err().to_string()
}

#[test]
fn quadrilaterals_are_split_along_the_shorter_diagonal() {
    let triangles = |points| region(&quad(points)).cells;
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(triangles(square), [[0, 1, 2], [0, 2, 3]]);
    // The diagonal from the second to the fourth corner is shorter.
    assert_eq!(triangles([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [0.0, 1.0]]), [[0, 1, 3], [1, 2, 3]]);
    // Clockwise: turned, same diagonal.
    let turned = region(&quad([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]));
    assert_eq!(turned.cells, [[0, 3, 2], [0, 2, 1]]);
    assert!(turned.notes().iter().any(|n| n.starts_with("1 clockwise cell")), "{:?}", turned.notes());
    // The shorter diagonal of a dart lies outside it.
    assert_eq!(triangles([[0.0, 0.0], [0.3, 0.3], [1.0, 0.0], [0.3, 2.0]]), [[0, 1, 3], [1, 2, 3]]);
    assert!(refused(&quad([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])).contains("crosses itself"));
    assert!(refused(&quad([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])).contains("has no area"));
}

#[test]
fn a_plane_of_its_own_is_noted_and_another_refused() {
    let at = |f: fn(f64, f64) -> [f64; 3]| deck(&[f(0.0, 0.0), f(1.0, 0.0), f(1.0, 1.0), f(0.0, 1.0)], QUAD);
    let raised = region(&at(|x, y| [x, y, 3.5]));
    assert!(raised.notes().contains(&"all nodes of region \"r\" have z = 3.5, which is left out".to_owned()));
    assert!(refused(&at(|x, y| [x, 0.0, y])).contains("x-z plane"));
    assert!(refused(&at(|x, y| [2.0, x, y])).contains("y-z plane"));
    assert!(refused(&at(|x, y| [x, y, x])).contains("not plane: z runs from 0 to 1 (node 2"));
    // Round-off is not a slope.
    assert!(region(&at(|x, y| [x, y, 1e-14 * x])).notes().iter().all(|n| !n.contains("z =")));
}

#[test]
fn nodes_without_an_element_are_left_out_and_counted() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [9.0, 9.0, 9.0],
        [8.0, 8.0, 0.0],
    ];
    let file = deck(&square, QUAD);
    let region = region(&file);
    assert_eq!(region.node_numbers(), [1, 2, 3, 4]);
    assert!(region.notes()[0].starts_with("2 nodes that no element uses: left out (the first is node 5)"));
    assert_eq!(file.summary().bounding_box, [[0.0; 3], [1.0, 1.0, 0.0]]);
}

#[test]
fn edges_that_no_cell_has_are_told_and_left_out() {
    let lines = "*ELEMENT, TYPE=T3D2, ELSET=s\n7, 1, 2\n8, 2, 4\n";
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let region = region(&deck(&square, &format!("{QUAD}{lines}")));
    assert_eq!(
        region.warnings()[0].to_string(),
        "1 edge of \"s\" join nodes of region \"r\" that no cell joins; they are left out"
    );
    assert_eq!(region.mesh().unwrap().group("s").unwrap().len(), 1);
}

#[test]
fn a_summary_tells_what_may_stand_against_a_file() {
    let nodes = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [5.0, 0.0, 0.0],
        [6.0, 0.0, 0.0],
        [5.0, 1.0, 0.0],
    ];
    let cells = "*ELEMENT, TYPE=CPS4, ELSET=r\n1, 1, 2, 3, 4\n*ELEMENT, TYPE=CPS4, ELSET=q\n2, 4, 3, 5, 6\n\
        *ELEMENT, TYPE=CPS3, ELSET=r\n3, 7, 8, 9\n";
    let summary = deck(&nodes, cells).summary();
    let problems: Vec<String> = summary.problems.iter().map(ToString::to_string).collect();
    let problems = problems.join("\n");
    for expected in [
        "no group of edges",
        "region \"r\" consists of 2 parts that are not connected",
        "\"r\", \"q\" are regions with 2 nodes in common",
    ] {
        assert!(problems.contains(expected), "{expected} is not in\n{problems}");
    }
    let nameless = "9 edges of the free boundary in no group: free of loads and supports";
    assert!(summary.notes.iter().any(|note| note == nameless), "{:?}", summary.notes);
    assert_eq!(summary.cells.iter().map(|(_, n)| n).sum::<usize>(), 3);
    let quality = summary.quality.unwrap();
    assert!((quality.smallest_angle - 45.0).abs() < 1e-9);
}

#[test]
fn numbers_near_overflow_are_refused_without_a_nan() {
    let file = quad([[0.0, 0.0], [1e200, 0.0], [1e200, 1e200], [0.0, 1e200]]);
    assert!(refused(&file).contains("has no area"));
    let summary = file.summary();
    assert_eq!(summary.groups[0].measure, None);
    assert_eq!(summary.quality, None);
}
