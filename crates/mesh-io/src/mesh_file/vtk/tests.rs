//! Grids made by hand: every type of cell, regions by arrays, and damaged files.

use crate::{RegionOptions, parse as read};

/// A grid whose arrays are text.
fn grid(points: &[[f64; 3]], cells: &[(i64, Vec<usize>)], data: &str) -> String {
    let listed = |numbers: &mut dyn Iterator<Item = String>| numbers.collect::<Vec<_>>().join(" ");
    let mut end = 0;
    let ends = &mut cells.iter().map(|(_, nodes)| {
        end += nodes.len();
        end.to_string()
    });
    let array = |name: &str, numbers: String| {
        format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">{numbers}</DataArray>")
    };
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\
         <UnstructuredGrid><Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\"><Points><DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points><Cells>{}{}{}</Cells><CellData>{data}</CellData></Piece>\
         </UnstructuredGrid></VTKFile>",
        points.len(),
        cells.len(),
        listed(&mut points.as_flattened().iter().map(f64::to_string)),
        array("connectivity", listed(&mut cells.iter().flat_map(|(_, nodes)| nodes).map(usize::to_string))),
        array("offsets", listed(ends)),
        array("types", listed(&mut cells.iter().map(|(code, _)| code.to_string()))),
    )
}

/// Corners of the unit cube as VTK orders voxels: x first.
fn voxel() -> Vec<[f64; 3]> {
    (0..8).map(|k| [f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)]).collect()
}

#[test]
fn every_type_of_volume_is_read() {
    // Wedges are turned over in VTK.
    let types: [(i64, usize, &[usize], f64); 11] = [
        (10, 4, &[0, 1, 3, 7], 1.0 / 6.0),
        (24, 10, &[0, 1, 3, 7], 1.0 / 6.0),
        (11, 8, &[0, 1, 2, 3, 4, 5, 6, 7], 1.0),
        (12, 8, &[0, 1, 3, 2, 4, 5, 7, 6], 1.0),
        (25, 20, &[0, 1, 3, 2, 4, 5, 7, 6], 1.0),
        (29, 27, &[0, 1, 3, 2, 4, 5, 7, 6], 1.0),
        (13, 6, &[0, 3, 1, 4, 7, 5], 0.5),
        (26, 15, &[0, 3, 1, 4, 7, 5], 0.5),
        (32, 18, &[0, 3, 1, 4, 7, 5], 0.5),
        (14, 5, &[0, 1, 3, 2, 4], 1.0 / 3.0),
        (27, 13, &[0, 1, 3, 2, 4], 1.0 / 3.0),
    ];
    for (code, count, corners, volume) in types {
        let mut points = voxel();
        points.resize(40, [0.5, 0.5, 0.5]);
        let nodes = corners.iter().copied().chain(8..8 + count - corners.len()).collect();
        let text = grid(
            &points,
            &[(code, nodes)],
            "<DataArray type=\"Int32\" Name=\"part\" format=\"ascii\">-3</DataArray>",
        );
        let file = read(text.as_bytes(), "a.vtu").unwrap();
        let region = file.solid_regions(&["part_-3"], RegionOptions::default()).unwrap();
        assert_eq!(region.points().len(), corners.len(), "{code}");
        let measure = file.summary().groups[0].measure.unwrap();
        assert!((measure - volume).abs() < 1e-14, "{code}: {measure}");
        assert!(region.mesh().is_ok(), "{code}");
    }
}

#[test]
fn whole_number_arrays_give_regions_and_sides() {
    let mut points = voxel();
    points.extend([[2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0]]);
    let cells = [
        (11, (0..8).collect()),
        (11, vec![1, 8, 3, 9, 5, 10, 7, 11]),
        (8, vec![0, 1, 2, 3]),
        (5, vec![4, 5, 7]),
    ];
    let data = "<DataArray type=\"UInt8\" Name=\"material\" format=\"ascii\">1 2 7 8</DataArray>\
        <DataArray type=\"Float64\" Name=\"density\" format=\"ascii\">1 2 7 8</DataArray>";
    let file = read(grid(&points, &cells, data).as_bytes(), "a.vtu").unwrap();
    assert_eq!(file.group_names(3).collect::<Vec<_>>(), ["material_1", "material_2"]);
    assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["material_7", "material_8"]);
    let first = file.solid_regions(&["material_1"], RegionOptions::default()).unwrap();
    let mesh = first.mesh().unwrap();
    assert_eq!(mesh.group("material_7").map(<[_]>::len), Some(2));
    // Messages count from 0.
    assert_eq!(first.node_numbers(), [0, 1, 2, 3, 4, 5, 6, 7]);
    let plane = grid(&voxel()[..4], &[(8, vec![0, 1, 2, 3])], "");
    let file = read(plane.as_bytes(), "b.vtu").unwrap();
    assert_eq!(file.region(None, RegionOptions::default()).unwrap().cells().len(), 2);
    let ids = (0..1001).map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    let many = grid(
        &voxel()[..3],
        &vec![(5, vec![0, 1, 2]); 1001],
        &format!("<DataArray type=\"Int32\" Name=\"id\" format=\"ascii\">{ids}</DataArray>"),
    );
    let file = read(many.as_bytes(), "c.vtu").unwrap();
    assert_eq!((file.group_names(2).count(), file.notes().len()), (0, 1));
}

#[test]
fn faults_are_told() {
    let said = |points: &[[f64; 3]], cells: &[(i64, Vec<usize>)], from: &str, to: &str| {
        let text = grid(points, cells, "");
        assert!(text.contains(from));
        read(text.replace(from, to).as_bytes(), "a.vtu").unwrap_err().to_string()
    };
    let (cube, cell) = (voxel(), [(11, (0..8).collect::<Vec<usize>>())]);
    let faults = [
        ("type=\"UnstructuredGrid\"", "type=\"PolyData\"", "it is not an unstructured grid of VTK XML"),
        (">11<", ">42<", "cell 0 has the VTK type 42; expected lines, triangles"),
        (">11<", ">10<", "cell 0 (4-node tetrahedron) has other nodes than its type; expected 4 nodes"),
        ("6 7<", "6 9<", "element 0 (8-node hexahedron) uses node 9, which the file does not have"),
        ("6 7<", "6 -7<", "which the file does not have"),
        ("NumberOfPoints=\"8\"", "NumberOfPoints=\"9\"", "it has 24 coordinates for 9 points"),
        (">11<", "><", "the grid has 0 types and 1 offsets of cells"),
        ("Name=\"offsets\"", "Name=\"ends\"", "a piece has no array \"offsets\" of its cells"),
        (">11<", ">x<", "\"x\" is not a number"),
    ];
    for (from, to, words) in faults {
        let said = said(&cube, &cell, from, to);
        assert!(said.contains(words), "{said}");
    }
    assert!(read(b"<html><body>", "a.vtu").unwrap_err().to_string().contains("web page"));
}

#[test]
fn damaged_grids_are_errors_or_meshes() {
    let text = grid(
        &voxel(),
        &[(11, (0..8).collect())],
        "<DataArray type=\"Int8\" Name=\"m\" format=\"ascii\">1</DataArray>",
    );
    let use_it = |bytes: &[u8]| {
        let Ok(file) = read(bytes, "damaged.vtu") else { return };
        let _ = file.summary();
        let _ = file.solid_regions(&[], RegionOptions::default()).map(|region| region.mesh().is_ok());
    };
    for place in 0..text.len() {
        use_it(&text.as_bytes()[..place]);
        for byte in [b'-', b'9', 0xFF, b'<'] {
            let mut changed = text.clone().into_bytes();
            changed[place] = byte;
            use_it(&changed);
        }
    }
}
