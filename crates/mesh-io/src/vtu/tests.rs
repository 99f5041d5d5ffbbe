//! Reads files back by their own offsets.

use super::*;
use fem_core::geometry::Vector;

fn sample() -> (VtuMesh, VtuData) {
    let mesh = VtuMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        cells: VtuCells::Triangles(vec![[0, 1, 2], [0, 2, 3]]),
    };
    let displacement = [[0.1, -0.2], [0.3, 0.4], [0.5, 0.6], [0.7, 0.8]].map(Vector::from);
    let data = VtuData {
        point: vec![VtuArray::vectors("displacement", &displacement)],
        cell: vec![
            VtuArray::tensors(
                "stress",
                vec![[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [7.0, 8.0, 9.0, 10.0, 11.0, 12.0]],
            ),
            VtuArray::scalars("a <\"b\"> & c", vec![0.25, 1e-300]),
        ],
        field: vec![VtuArray::scalars("iteration", vec![7.0])],
    };
    (mesh, data)
}

/// Finds an array in the header and returns the bytes of its block.
fn bytes<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
    let marker = b"<AppendedData encoding=\"raw\">\n   _";
    let start = file.windows(marker.len()).position(|w| w == marker).unwrap() + marker.len();
    let header = std::str::from_utf8(&file[..start]).unwrap();
    let line = header.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset: usize = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    let block = &file[start + offset..];
    let length = u64::from_le_bytes(block[..8].try_into().unwrap()) as usize;
    &block[8..8 + length]
}

fn floats(file: &[u8], name: &str) -> Vec<f64> {
    bytes(file, name).chunks(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect()
}

fn integers(file: &[u8], name: &str) -> Vec<i64> {
    bytes(file, name).chunks(8).map(|c| i64::from_le_bytes(c.try_into().unwrap())).collect()
}

#[test]
fn every_array_is_found_at_its_offset() {
    let (mesh, data) = sample();
    let mut file = Vec::new();
    write(&mut file, &mesh, &data).unwrap();
    assert_eq!(floats(&file, "Points"), [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    assert_eq!(floats(&file, "displacement"), data.point[0].values);
    assert_eq!(floats(&file, "stress"), data.cell[0].values);
    assert_eq!(floats(&file, "a &lt;&quot;b&quot;&gt; &amp; c"), [0.25, 1e-300]);
    assert_eq!(floats(&file, "iteration"), [7.0]);
    assert_eq!(integers(&file, "connectivity"), [0, 1, 2, 0, 2, 3]);
    assert_eq!(integers(&file, "offsets"), [3, 6]);
    assert_eq!(bytes(&file, "types"), [5, 5]);
    assert!(file.ends_with(b"\n  </AppendedData>\n</VTKFile>\n"));
}

#[test]
fn large_blocks_are_written_in_pieces() {
    let count = 30_000u32;
    let mesh = VtuMesh {
        points: (0..=count).map(|k| [f64::from(k), 0.5, 0.0]).collect(),
        cells: VtuCells::Lines((0..count).map(|k| [k, k + 1]).collect()),
    };
    let mut file = Vec::new();
    write(&mut file, &mesh, &VtuData::default()).unwrap();
    assert_eq!(floats(&file, "Points")[3 * 29_999..3 * 29_999 + 2], [29_999.0, 0.5]);
    assert_eq!(integers(&file, "offsets")[29_999], 60_000);
    assert_eq!(bytes(&file, "types").len(), 30_000);
    assert!(bytes(&file, "types").iter().all(|&t| t == 3));
}

#[test]
fn tetrahedra_have_four_corners_and_three_coordinates() {
    let mesh = fem_core::mesh::generate::cuboid([0.0; 3], [1.0, 2.0, 3.0], [1, 1, 1]).unwrap();
    let mut file = Vec::new();
    write(&mut file, &VtuMesh::from(&mesh), &VtuData::default()).unwrap();
    assert_eq!(bytes(&file, "types"), [10; 6]);
    assert_eq!(integers(&file, "offsets"), [4, 8, 12, 16, 20, 24]);
    let corners: Vec<i64> = mesh.cells().iter().flatten().map(|node| node.index() as i64).collect();
    assert_eq!(integers(&file, "connectivity"), corners);
    let points: Vec<f64> = mesh.points().iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    assert_eq!(floats(&file, "Points"), points);
    assert_eq!(VtuCells::of_corners(5, &[0; 5]), VtuCells::Lines(Vec::new()));
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |change: &dyn Fn(&mut VtuMesh, &mut VtuData)| {
        let (mut mesh, mut data) = sample();
        change(&mut mesh, &mut data);
        let mut file = Vec::new();
        let error = write(&mut file, &mesh, &data).unwrap_err();
        assert!(file.is_empty(), "nothing is written before the checks");
        error
    };
    assert!(matches!(refused(&|m, _| m.cells = VtuCells::Lines(vec![[0, 4]])), VtuError::NoSuchPoint { .. }));
    assert!(matches!(refused(&|m, _| m.points[1][0] = f64::NAN), VtuError::NotFinite { entry: 1, .. }));
    assert!(matches!(refused(&|_, d| d.cell[0].values[7] = f64::NAN), VtuError::NotFinite { entry: 1, .. }));
    assert!(matches!(refused(&|_, d| d.point[0].components = 2), VtuError::Size { .. }));
    assert!(matches!(refused(&|_, d| d.point[0].components = 0), VtuError::Size { .. }));
    assert!(matches!(refused(&|_, d| d.cell[1].values.truncate(1)), VtuError::Size { .. }));
}

#[test]
fn a_collection_names_its_files() {
    let entry = |timestep, name: &str| PvdEntry {
        timestep,
        part: 0,
        name: name.into(),
        file: format!("fields/it_{timestep}_{name}.vtu"),
    };
    let xml = pvd(&[entry(1.0, "upper"), entry(2.0, "a&b")]).unwrap();
    assert!(xml.contains(
        "<DataSet timestep=\"1\" group=\"\" part=\"0\" name=\"upper\" file=\"fields/it_1_upper.vtu\"/>"
    ));
    assert!(xml.contains("name=\"a&amp;b\""));
    assert!(pvd(&[entry(f64::NAN, "x")]).is_err());
}

#[test]
fn blocks_stand_against_the_order_of_the_header() {
    let (mesh, data) = sample();
    let mut file = Vec::new();
    write(&mut file, &mesh, &data).unwrap();
    let header = String::from_utf8_lossy(&file).into_owned();
    let offsets: Vec<usize> = header
        .split("offset=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
        .collect();
    assert!(offsets.windows(2).all(|w| w[0] > w[1]) && offsets.last() == Some(&0), "{offsets:?}");
}

#[test]
fn a_series_is_json_as_paraview_reads_it() {
    let files = [
        ("fields/a-step-01.vtu".to_owned(), 1.0),
        ("fields/a \"b\".vtu".to_owned(), 2.5),
        ("\\\u{1}ä".to_owned(), 1e-9),
    ];
    let text = series(&files).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["file-series-version"], "1.0");
    assert_eq!(json["files"][0], serde_json::json!({ "name": "fields/a-step-01.vtu", "time": 1.0 }));
    assert_eq!(json["files"][1]["name"], "fields/a \"b\".vtu");
    assert_eq!(json["files"][2], serde_json::json!({ "name": "\\\u{1}ä", "time": 1e-9 }));
    assert_eq!(text, format!("{json:#}\n"));
    let nothing: serde_json::Value = serde_json::from_str(&series(&[]).unwrap()).unwrap();
    assert_eq!(series(&[]).unwrap(), format!("{nothing:#}\n"));
    assert!(series(&[("x".to_owned(), f64::INFINITY)]).is_err());
}
