//! Meshes of tetrahedra that cover a place twice, as a user has them: refused with the elements and the place.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// A mesh file of boxes, each cut into six tetrahedra.
#[derive(Default)]
struct Boxes {
    nodes: Vec<[f64; 3]>,
    /// The number of the region and four nodes, from 1.
    cells: Vec<(usize, [usize; 4])>,
    /// The number of the side and three nodes.
    faces: Vec<(usize, [usize; 3])>,
}

/// The corners of the six tetrahedra of a box around its diagonal: steps along the axes.
const STEPS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];

impl Boxes {
    /// Adds a box of cells; its lowest and its highest side get a number.
    fn add(&mut self, region: usize, low: [f64; 3], size: [f64; 3], counts: [usize; 3], sides: [usize; 2]) {
        let first = self.nodes.len() + 1;
        let number = |at: [usize; 3]| first + at[0] + (counts[0] + 1) * (at[1] + (counts[1] + 1) * at[2]);
        for k in 0..=counts[2] {
            for j in 0..=counts[1] {
                for i in 0..=counts[0] {
                    let at = [i, j, k];
                    self.nodes.push([0, 1, 2].map(|c| low[c] + size[c] * at[c] as f64 / counts[c] as f64));
                }
            }
        }
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                for i in 0..counts[0] {
                    for steps in STEPS {
                        let mut at = [i, j, k];
                        let mut corners = [number(at); 4];
                        for (corner, axis) in corners[1..].iter_mut().zip(steps) {
                            at[axis] += 1;
                            *corner = number(at);
                        }
                        self.cells.push((region, corners));
                    }
                }
            }
        }
        for (side, k) in sides.into_iter().zip([0, counts[2]]) {
            for j in 0..counts[1] {
                for i in 0..counts[0] {
                    let at = |i, j| number([i, j, k]);
                    self.faces.push((side, [at(i, j), at(i + 1, j), at(i + 1, j + 1)]));
                    self.faces.push((side, [at(i, j), at(i, j + 1), at(i + 1, j + 1)]));
                }
            }
        }
    }

    fn text(&self) -> String {
        let names = "3 1 \"lower\"\n3 2 \"upper\"\n2 3 \"lower_bottom\"\n2 4 \"lower_top\"\n2 5 \"upper_bottom\"\n2 6 \"upper_top\"\n2 7 \"other\"\n";
        let mut text =
            format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n7\n{names}$EndPhysicalNames\n");
        let _ = writeln!(text, "$Nodes\n{}", self.nodes.len());
        for (k, [x, y, z]) in self.nodes.iter().enumerate() {
            let _ = writeln!(text, "{} {x} {y} {z}", k + 1);
        }
        let _ = writeln!(text, "$EndNodes\n$Elements\n{}", self.cells.len() + self.faces.len());
        let listed = |nodes: &[usize]| nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
        let cells = self.cells.iter().map(|(region, nodes)| format!("4 2 {region} 1 {}", listed(nodes)));
        let faces = self.faces.iter().map(|(side, nodes)| format!("2 2 {side} 1 {}", listed(nodes)));
        for (k, element) in cells.chain(faces).enumerate() {
            let _ = writeln!(text, "{} {element}", k + 1);
        }
        text + "$EndElements\n"
    }
}

const CASE: &str = "schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = \"lower\"
material = \"m\"
mesh = { file = \"m.msh\", region = \"lower\" }
[[body.displacement]]
on = \"lower_bottom\"
fixed = true
[[body]]
name = \"upper\"
material = \"m\"
mesh = { file = \"m.msh\", region = \"upper\" }
[[body.displacement]]
on = \"upper_top\"
fixed = true
[contact]
surfaces = [\"lower_top\", \"upper_bottom\"]
";

/// Two boxes on each other.
fn two() -> Boxes {
    let mut boxes = Boxes::default();
    boxes.add(1, [0.0; 3], [1.0; 3], [4, 3, 3], [3, 4]);
    boxes.add(2, [0.0, 0.0, 1.0], [1.0; 3], [4, 3, 3], [5, 6]);
    boxes
}

/// Checks the case; returns the status and what is said.
fn checked(boxes: &Boxes, folder: &Path) -> (i32, String) {
    std::fs::write(folder.join("m.msh"), boxes.text()).unwrap();
    std::fs::write(folder.join("case.toml"), CASE).unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_nndd")).args(["check", "case.toml"]).current_dir(folder).output();
    let output = output.unwrap();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn cells_that_overlap_are_refused_wherever_they_lie() {
    let temp = tempfile::tempdir().unwrap();
    let (status, said) = checked(&two(), temp.path());
    assert_eq!(status, 0, "{said}");
    // Inside one cell, across many, at a corner, around everything.
    for (low, size) in [
        ([0.55, 0.5, 0.52], [1e-3; 3]),
        ([-0.5, 0.4, 0.4], [2.0, 0.2, 0.2]),
        ([0.99, 0.99, -0.3], [0.5; 3]),
        ([-1.0, -1.0, -0.5], [3.0, 3.0, 1.49]),
    ] {
        let mut boxes = two();
        boxes.add(1, low, size, [1, 2, 1], [7, 7]);
        let (status, said) = checked(&boxes, temp.path());
        let expected = [
            "region \"lower\": the elements",
            "overlap at (",
            "touch along their faces",
            "take one of the two parts out",
        ];
        assert!(status == 3 && expected.iter().all(|words| said.contains(words)), "{low:?}: {status} {said}");
    }
    // A piece that touches: its other nodes lie on the faces, rounded to seven digits.
    let mut boxes = two();
    boxes.add(1, [1.000_000_03, 0.1, 0.1], [0.5, 0.7, 0.7], [2, 5, 4], [3, 7]);
    let (status, said) = checked(&boxes, temp.path());
    assert!(status == 0 && !said.contains("overlap"), "{status} {said}");
}

#[test]
fn a_piece_inside_another_body_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    let mut boxes = two();
    boxes.add(2, [0.3, 0.4, 0.2], [0.3, 0.2, 0.3], [2, 1, 1], [7, 6]);
    let (status, said) = checked(&boxes, temp.path());
    let words =
        "body \"upper\": a piece of it that has no contact face lies inside body \"lower\": the elements";
    assert!(status == 3 && said.contains(words) && said.contains("cover no place twice"), "{status} {said}");
    // The same piece may lie beside both.
    let mut boxes = two();
    boxes.add(2, [3.0, 0.4, 0.2], [0.3, 0.2, 0.3], [2, 1, 1], [7, 6]);
    let (status, said) = checked(&boxes, temp.path());
    assert_eq!(status, 0, "{said}");
}

#[test]
fn folded_cells_and_faces_of_three_cells_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    // An inner node beyond the other side: cells are turned over.
    let mut boxes = two();
    let inner = boxes.nodes.iter().position(|p| p.iter().all(|x| *x > 0.2 && *x < 0.8)).unwrap();
    boxes.nodes[inner][0] += 2.0;
    let (status, said) = checked(&boxes, temp.path());
    assert!(status == 3 && said.contains("or to two on the same side"), "{status} {said}");
    // A cell between a face that two cells have and a new node.
    let mut boxes = two();
    let [a, b, c, _] = boxes.cells[0].1;
    let third = boxes.cells.iter().filter(|(_, t)| [a, b, c].iter().all(|n| t.contains(n))).count();
    boxes.nodes.push([0.1, 0.05, 5.0]);
    boxes.cells.push((1, [boxes.cells[0].1[0], boxes.cells[0].1[1], boxes.cells[0].1[3], boxes.nodes.len()]));
    let (status, said) = checked(&boxes, temp.path());
    assert!(status == 3 && said.contains("belongs to more than two cells"), "{third}: {status} {said}");
    // A cell twice.
    let mut boxes = two();
    boxes.cells.push(boxes.cells[7]);
    let (status, said) = checked(&boxes, temp.path());
    assert!(status == 3 && said.contains("belongs to more than two cells"), "{status} {said}");
    // A cell without volume.
    let mut boxes = two();
    let [a, b, c, _] = boxes.cells[0].1;
    let (p, q) = (boxes.nodes[a - 1], boxes.nodes[b - 1]);
    boxes.nodes.push([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
    boxes.cells.push((1, [a, b, c, boxes.nodes.len()]));
    let (status, said) = checked(&boxes, temp.path());
    assert!(status == 3, "{status} {said}");
}

#[test]
fn a_strip_of_tetrahedra_that_winds_over_itself_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    for (turn, found) in [(340.0f64, false), (400.0, true)] {
        let mut boxes = two();
        let first = boxes.nodes.len();
        boxes.add(1, [0.0, 2.0, 0.0], [1.0, 1.0, 0.5], [36, 1, 1], [3, 7]);
        // Bends the box into a ring.
        for p in &mut boxes.nodes[first..] {
            let (s, c) = (turn * p[0]).to_radians().sin_cos();
            *p = [5.0 + p[1] * c, 5.0 + p[1] * s, p[2]];
        }
        let (status, said) = checked(&boxes, temp.path());
        assert_eq!(status == 3 && said.contains("overlap at ("), found, "{turn}: {status} {said}");
    }
}
