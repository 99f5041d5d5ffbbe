//! Files that Gmsh 4.15.2 wrote: every format gives the same mesh, whatever Gmsh does to it on the way.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use fem_core::mesh::TriMesh;
use mesh_io::{MeshFile, RegionOptions};

fn file(name: &str) -> MeshFile {
    mesh_io::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

fn meshes(name: &str) -> [TriMesh; 2] {
    let file = file(name);
    ["upper", "lower"]
        .map(|region| file.region(Some(region), RegionOptions::default()).unwrap().mesh().unwrap())
}

fn close(a: &TriMesh, b: &TriMesh, tolerance: f64) -> bool {
    let points = a.points().iter().zip(b.points());
    a.points().len() == b.points().len()
        && points
            .into_iter()
            .all(|(p, q)| (p[0] - q[0]).abs() <= tolerance && (p[1] - q[1]).abs() <= tolerance)
}

#[test]
fn all_formats_hold_the_same_two_blocks() {
    let meant = meshes("blocks-41.msh");
    assert_eq!(meant.each_ref().map(|m| (m.points().len(), m.cells().len())), [(56, 86), (45, 64)]);
    // Text has 16 digits, the deck 14.
    let others = [
        ("blocks-22.msh", 0.0),
        ("blocks-22-binary.msh", 1e-15),
        ("blocks-41-binary.msh", 1e-15),
        ("partitioned-41-binary.msh", 1e-15),
        ("blocks.inp", 1e-13),
        // The corners of quadratic cells are the nodes of the linear ones.
        ("quadratic-41.msh", 0.0),
        ("quadratic.inp", 1e-13),
    ];
    for (name, tolerance) in others {
        for (found, meant) in meshes(name).iter().zip(&meant) {
            assert!(close(found, meant, tolerance), "{name}");
            for (side, edges) in meant.groups() {
                let found = found.group(side).unwrap_or_else(|| panic!("{name}: {side}"));
                assert_eq!(found.len(), edges.len(), "{name}: {side}");
            }
            let area = |m: &TriMesh| (0..m.cells().len()).map(|t| m.measure(t)).sum::<f64>();
            assert!((area(found) - 2.0).abs() < 1e-12, "{name}");
        }
    }
}

#[test]
fn an_edge_in_two_groups_is_in_both() {
    for name in
        ["blocks-22.msh", "blocks-22-binary.msh", "blocks-41.msh", "blocks-41-binary.msh", "blocks.inp"]
    {
        let [_, lower] = meshes(name);
        let mut both = [lower.group("lower.left").unwrap(), lower.group("lower.right").unwrap()].concat();
        both.sort_unstable();
        assert_eq!(lower.group("lower.sides"), Some(&both[..]), "{name}");
    }
}

#[test]
fn what_was_done_to_the_cells_is_told() {
    let region = file("quadratic-41.msh").region(Some("lower"), RegionOptions::default()).unwrap();
    let notes = region.notes().join("\n");
    assert!(notes.contains("32 quadrilaterals of region \"lower\" were split"), "{notes}");
    assert!(notes.contains("32 quadratic cells of region \"lower\" were reduced to the corners"), "{notes}");
    let summary = file("quadratic.inp").summary();
    assert_eq!(summary.problems, []);
    let upper = summary.groups.iter().find(|g| g.name == "upper").unwrap();
    assert!((upper.measure.unwrap() - 2.0).abs() < 1e-12);
}
