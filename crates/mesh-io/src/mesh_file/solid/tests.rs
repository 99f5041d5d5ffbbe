//! A box of tetrahedra, written in every format and read again.

use super::*;
use crate::{RegionOptions, parse};
use fem_core::mesh::TetMesh;
use fem_core::mesh::generate::cuboid;
use std::fmt::Write as _;

fn sample() -> TetMesh {
    cuboid([0.0; 3], [2.0, 1.0, 1.5], [2, 1, 1]).unwrap()
}

/// The nodes of the faces of each side, from 0, in the order in which the mesh has them.
fn sides(mesh: &TetMesh) -> Vec<(String, Vec<[usize; 3]>)> {
    let nodes = |f: &fem_core::mesh::id::FacetId| mesh.topology().facets()[*f].map(|node| node.index());
    mesh.groups().iter().map(|(name, faces)| (name.clone(), faces.iter().map(nodes).collect())).collect()
}

/// The corners of the tetrahedra; every second one with two corners exchanged.
fn corners(mesh: &TetMesh) -> Vec<[usize; 4]> {
    let exchanged = |(k, cell): (usize, &[fem_core::mesh::id::NodeId; 4])| {
        let [a, b, c, d] = cell.map(|node| node.index());
        if k % 2 == 0 { [a, b, c, d] } else { [a, c, b, d] }
    };
    mesh.cells().iter().enumerate().map(exchanged).collect()
}

fn listed(nodes: &[usize], between: &str) -> String {
    nodes.iter().map(|n| (n + 1).to_string()).collect::<Vec<_>>().join(between)
}

fn gmsh22(mesh: &TetMesh) -> String {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    let sides = sides(mesh);
    let _ = writeln!(text, "{}\n3 1 \"block\"", sides.len() + 1);
    for (k, (name, _)) in sides.iter().enumerate() {
        let _ = writeln!(text, "2 {} \"{name}\"", k + 2);
    }
    let _ = writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", mesh.points().len());
    for (k, p) in mesh.points().iter().enumerate() {
        let _ = writeln!(text, "{} {} {} {}", k + 1, p[0], p[1], p[2]);
    }
    let cells = corners(mesh);
    let count = cells.len() + sides.iter().map(|(_, faces)| faces.len()).sum::<usize>();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{count}");
    let mut number = 0;
    for (k, (_, faces)) in sides.iter().enumerate() {
        for face in faces {
            number += 1;
            let _ = writeln!(text, "{number} 2 2 {} 1 {}", k + 2, listed(face, " "));
        }
    }
    for cell in &cells {
        number += 1;
        let _ = writeln!(text, "{number} 4 2 1 1 {}", listed(cell, " "));
    }
    text + "$EndElements\n"
}

fn gmsh41(mesh: &TetMesh) -> String {
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    let (sides, cells) = (sides(mesh), corners(mesh));
    let _ = writeln!(text, "{}\n3 1 \"block\"", sides.len() + 1);
    for (k, (name, _)) in sides.iter().enumerate() {
        let _ = writeln!(text, "2 {} \"{name}\"", k + 2);
    }
    let _ = writeln!(text, "$EndPhysicalNames\n$Entities\n0 0 {} 1", sides.len());
    for k in 0..sides.len() {
        let _ = writeln!(text, "{} 0 0 0 2 1 1.5 1 {} 0", k + 1, k + 2);
    }
    let count = mesh.points().len();
    let _ = writeln!(text, "1 0 0 0 2 1 1.5 1 1 0\n$EndEntities\n$Nodes\n1 {count} 1 {count}\n3 1 0 {count}");
    for k in 1..=count {
        let _ = writeln!(text, "{k}");
    }
    for p in mesh.points() {
        let _ = writeln!(text, "{} {} {}", p[0], p[1], p[2]);
    }
    let all = cells.len() + sides.iter().map(|(_, faces)| faces.len()).sum::<usize>();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{} {all} 1 {all}", sides.len() + 1);
    let mut number = 0;
    for (k, (_, faces)) in sides.iter().enumerate() {
        let _ = writeln!(text, "2 {} 2 {}", k + 1, faces.len());
        for face in faces {
            number += 1;
            let _ = writeln!(text, "{number} {}", listed(face, " "));
        }
    }
    let _ = writeln!(text, "3 1 4 {}", cells.len());
    for cell in &cells {
        number += 1;
        let _ = writeln!(text, "{number} {}", listed(cell, " "));
    }
    text + "$EndElements\n"
}

/// A deck whose sides are faces of elements, but for the last one, which is a set of nodes.
fn deck(mesh: &TetMesh) -> String {
    const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let mut text = String::from("*NODE\n");
    for (k, p) in mesh.points().iter().enumerate() {
        let _ = writeln!(text, "{}, {}, {}, {}", k + 1, p[0], p[1], p[2]);
    }
    text += "*ELEMENT, TYPE=C3D4, ELSET=block\n";
    let cells = corners(mesh);
    for (k, cell) in cells.iter().enumerate() {
        let _ = writeln!(text, "{}, {}", k + 1, listed(cell, ", "));
    }
    let sides = sides(mesh);
    let (last, others) = sides.split_last().unwrap();
    for (name, faces) in others {
        let _ = writeln!(text, "*SURFACE, NAME={name}, TYPE=ELEMENT");
        for face in faces {
            let place = cells.iter().enumerate().find_map(|(cell, corners)| {
                let is_face = |k: &usize| FACES[*k].iter().all(|corner| face.contains(&corners[*corner]));
                Some((cell, (0..4).find(is_face)?))
            });
            let (cell, place) = place.unwrap();
            let _ = writeln!(text, "{}, S{}", cell + 1, place + 1);
        }
    }
    let mut nodes: Vec<usize> = last.1.as_flattened().to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    let _ = writeln!(text, "*NSET, NSET={}\n{}", last.0, listed(&nodes, ",\n"));
    text
}

fn region(text: &str, name: &str) -> Region<Solid> {
    let file = parse(text.as_bytes(), name).unwrap();
    assert!(file.has_volumes());
    file.solid_regions(&["block"], RegionOptions::default()).unwrap()
}

#[test]
fn every_format_gives_the_same_mesh_with_the_same_sides() {
    let expected = sample();
    for (text, name) in
        [(gmsh22(&expected), "a.msh"), (gmsh41(&expected), "b.msh"), (deck(&expected), "c.inp")]
    {
        let region = region(&text, name);
        assert_eq!(region.warnings(), [], "{name}");
        let mesh = region.mesh().unwrap();
        assert_eq!(mesh.points(), expected.points(), "{name}");
        assert_eq!((mesh.cells().len(), mesh.turned()), (12, 6), "{name}");
        let faces = |mesh: &TetMesh| {
            let mut sides = sides(mesh);
            sides.iter_mut().for_each(|(_, faces)| faces.sort_unstable());
            sides
        };
        assert_eq!(faces(&mesh), faces(&expected), "{name}");
        assert_eq!(region.cell_numbers().len(), 12);
        assert!(region.is_cell_group("block") && region.without_sides().is_none());
    }
}

#[test]
fn a_mesh_of_volumes_is_no_plane_body_and_a_plane_one_no_solid() {
    let file = parse(gmsh22(&sample()).as_bytes(), "a.msh").unwrap();
    let error = file.region(None, RegionOptions::default()).unwrap_err();
    assert!(error.to_string().contains("the mesh has 12 tetrahedra"), "{error}");
    let plane =
        parse(b"*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n", "p.inp").unwrap();
    let error = plane.solid_regions(&[], RegionOptions::default()).unwrap_err();
    assert!(error.to_string().contains("1 2D element and no volumes"), "{error}");
    let error = file.solid_regions(&["blokc"], RegionOptions::default()).unwrap_err();
    assert!(error.to_string().contains("there is no region \"blokc\""), "{error}");
    let error = file.solid_regions(&["left"], RegionOptions::default()).unwrap_err();
    assert!(error.to_string().contains("is a group of faces"), "{error}");
}

#[test]
fn faces_inside_and_outside_of_a_region_are_told_apart() {
    // A face between two tetrahedra is a facet of the region, one of nodes that no tetrahedron joins is not.
    let text = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, 1, 1, 1\n\
        *ELEMENT, TYPE=C3D4, ELSET=block\n1, 1, 2, 3, 4\n2, 2, 3, 4, 5\n\
        *ELEMENT, TYPE=S3, ELSET=stray\n7, 1, 2, 5\n*ELEMENT, TYPE=S3, ELSET=base\n8, 1, 2, 3\n";
    let region = region(text, "two.inp");
    let names: Vec<&str> = region.sides().map(|(name, _)| name).collect();
    assert_eq!(names, ["base"]);
    assert!(region.warnings()[0].to_string().contains("1 face of \"stray\""), "{:?}", region.warnings());
    let mesh = region.mesh().unwrap();
    assert_eq!((mesh.cells().len(), mesh.group("base").map(<[_]>::len)), (2, Some(1)));
    // Without a side there is advice.
    let bare = text.split("*ELEMENT, TYPE=S3").next().unwrap();
    let nameless = self::region(bare, "two.inp").without_sides().unwrap();
    assert!(nameless.to_string().contains("its free boundary has 6 faces within"), "{nameless}");
}

#[test]
fn quadratic_and_flat_tetrahedra_are_said() {
    let nodes = "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0.3, 0.3, 1e-3\n5, 0.5, 0, 0\n6, 0.5, 0.5, 0\n7, 0, 0.5, 0\n\
        8, 0.15, 0.15, 5e-4\n9, 0.65, 0.15, 5e-4\n10, 0.15, 0.65, 5e-4\n";
    let text = format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D10, ELSET=block\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10\n");
    let region = region(&text, "flat.inp");
    assert!(region.notes().iter().any(|n| n.contains("1 quadratic cell of region \"block\" was reduced")));
    assert!(region.warnings()[0].to_string().contains("1 tetrahedron of region \"block\" with an angle"));
    assert_eq!(region.points().len(), 4);
}

#[test]
fn quadratic_tetrahedra_of_gmsh_are_reduced() {
    let nodes: String = (1..=10).map(|k| format!("{k} {} {} {}\n", k % 3, k % 4, (k * k) % 7)).collect();
    let version2 = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n{nodes}$EndNodes\n$Elements\n1\n1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n\
         $EndElements\n"
    );
    let numbers: String = (1..=10).map(|k| format!("{k}\n")).collect();
    let places: String = nodes.lines().map(|line| format!("{}\n", line.split_once(' ').unwrap().1)).collect();
    let version4 = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 10 1 10\n3 1 0 10\n{numbers}{places}$EndNodes\n$Elements\n1 1 1 1\n3 1 11 1\n\
         1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n"
    );
    for text in [version2, version4] {
        let file = parse(text.as_bytes(), "ten.msh").unwrap();
        let region = file.solid_regions(&[], RegionOptions::default()).unwrap();
        assert_eq!((region.cells().len(), region.points().len()), (1, 4));
    }
}
