//! Exodus files made by hand: every shape and version, and damaged ones.

use super::*;
use crate::{RegionOptions, parse};
use fem_core::space::Solid;

/// A variable: name, dimensions, text of `elem_type`, type, values.
type Row = (String, Vec<usize>, &'static str, u32, Vec<u8>);

/// A classic netCDF file.
#[derive(Clone, Default)]
struct Writer {
    dimensions: Vec<(String, usize)>,
    variables: Vec<Row>,
}

impl Writer {
    fn dimension(&mut self, name: &str, length: usize) -> usize {
        self.dimensions.push((name.to_owned(), length));
        self.dimensions.len() - 1
    }

    fn variable(&mut self, name: &str, shape: &[usize], kind: u32, values: Vec<u8>) {
        let lengths =
            shape.iter().enumerate().map(|(k, length)| (format!("{name}_{k}"), *length)).collect::<Vec<_>>();
        let places = lengths.iter().map(|(name, length)| self.dimension(name, *length)).collect();
        self.variables.push((name.to_owned(), places, "", kind, values));
    }

    fn integers(&mut self, name: &str, shape: &[usize], values: &[i32]) {
        self.variable(name, shape, 4, values.iter().flat_map(|v| v.to_be_bytes()).collect());
    }

    fn reals(&mut self, name: &str, values: &[f64]) {
        self.variable(name, &[values.len()], 6, values.iter().flat_map(|v| v.to_be_bytes()).collect());
    }

    fn texts(&mut self, name: &str, texts: &[&str]) {
        let row = |text: &&str| format!("{text:\0<12}").into_bytes();
        self.variable(name, &[texts.len(), 12], 2, texts.iter().flat_map(row).collect());
    }

    fn block(&mut self, number: usize, kind: &'static str, nodes: usize, values: &[i32]) {
        self.integers(&format!("connect{number}"), &[values.len() / nodes, nodes], values);
        self.variables.last_mut().unwrap().2 = kind;
    }

    fn bytes(&self, version: u8) -> Vec<u8> {
        let count = |value: usize| match version {
            5 => (value as u64).to_be_bytes().to_vec(),
            _ => (value as u32).to_be_bytes().to_vec(),
        };
        let word = |value: u32| value.to_be_bytes().to_vec();
        let padded = |text: &[u8]| [text, &vec![0; text.len().next_multiple_of(4) - text.len()]].concat();
        let name = |text: &str| [count(text.len()), padded(text.as_bytes())].concat();
        let list =
            |tag: u32, length: usize| [word(if length == 0 { 0 } else { tag }), count(length)].concat();
        let header = |mut begin: usize| {
            let mut out =
                [b"CDF".to_vec(), vec![version], count(0), list(10, self.dimensions.len())].concat();
            self.dimensions
                .iter()
                .for_each(|(text, length)| out.extend([name(text), count(*length)].concat()));
            let title =
                [list(12, 1), name("title"), word(6), count(1), 1.5f64.to_be_bytes().to_vec()].concat();
            out.extend([title, list(11, self.variables.len())].concat());
            for (text, shape, kind, code, values) in &self.variables {
                out.extend([name(text), count(shape.len())].concat());
                shape.iter().for_each(|k| out.extend(count(*k)));
                match kind.len() {
                    0 => out.extend(list(12, 0)),
                    length => out.extend(
                        [list(12, 1), name("elem_type"), word(2), count(length), padded(kind.as_bytes())]
                            .concat(),
                    ),
                }
                let place =
                    if version == 1 { word(begin as u32) } else { (begin as u64).to_be_bytes().to_vec() };
                out.extend([word(*code), count(values.len()), place].concat());
                begin += values.len().next_multiple_of(4);
            }
            out
        };
        let mut out = header(header(0).len());
        self.variables.iter().for_each(|(.., values)| out.extend(padded(values)));
        out
    }
}

/// Two unit cubes above each other: the lower one a hexahedron, the upper one six pyramids, with two prisms beside the lower one, and a
/// tetrahedron on top.
fn sample() -> Writer {
    let mut w = Writer::default();
    w.dimension("num_dim", 3);
    // Layers of six nodes: (0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1); then the centre and the apex.
    let [x, y] = [[0.0, 1.0, 1.0, 0.0, 2.0, 2.0], [0.0, 0.0, 1.0, 1.0, 0.0, 1.0]];
    w.reals("coordx", &[&x[..], &x[..], &x[..4], &[0.5, 0.0]].concat());
    w.reals("coordy", &[&y[..], &y[..], &y[..4], &[0.5, 0.0]].concat());
    w.reals("coordz", &[&[0.0; 6][..], &[1.0; 6], &[2.0; 4], &[1.5, 3.0]].concat());
    w.integers("eb_prop1", &[5], &[10, 20, 30, 40, 50]);
    w.texts("eb_names", &["cube", "", "wedges", "cap", "skin"]);
    w.block(1, "HEX8", 8, &[1, 2, 3, 4, 7, 8, 9, 10]);
    let pyramids =
        [[7, 8, 9, 10], [13, 16, 15, 14], [7, 13, 14, 8], [8, 14, 15, 9], [9, 15, 16, 10], [10, 16, 13, 7]];
    w.block(2, "PYRAMID", 5, &pyramids.map(|[a, b, c, d]| [a, b, c, d, 17]).concat());
    w.block(3, "wedge", 6, &[2, 5, 6, 8, 11, 12, 2, 6, 3, 8, 12, 9]);
    w.block(4, "TETRA\0", 4, &[13, 14, 15, 18]);
    w.block(5, "SHELL4", 4, &[1, 2, 3, 4]);
    w.integers("ss_prop1", &[2], &[1, 2]);
    w.texts("ss_names", &["foot", ""]);
    w.integers("elem_ss1", &[3], &[1, 8, 9]);
    w.integers("side_ss1", &[3], &[5, 4, 4]);
    w.integers("elem_ss2", &[1], &[10]);
    w.integers("side_ss2", &[1], &[4]);
    w.integers("ns_prop1", &[2], &[7, 8]);
    w.texts("ns_names", &["foot", "left"]);
    w.integers("node_ns1", &[1], &[1]);
    w.integers("node_ns2", &[4], &[1, 4, 7, 10]);
    w
}

fn region(bytes: &[u8], names: &[&str]) -> crate::Region<Solid> {
    parse(bytes, "a.e").unwrap().solid_regions(names, RegionOptions::default()).unwrap()
}

#[test]
fn blocks_are_regions_and_sets_are_sides_in_every_version() {
    for (version, words) in [(1, "netCDF classic"), (2, "64-bit offsets"), (5, "CDF-5")] {
        let bytes = sample().bytes(version);
        let file = parse(&bytes, "a.e").unwrap();
        assert!(file.format().ends_with(words), "{}", file.format());
        assert_eq!(file.group_names(3).collect::<Vec<_>>(), ["cube", "block_20", "wedges", "cap"]);
        assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["skin", "foot", "surface_2"]);
        let volumes: Vec<f64> = file.summary().groups.iter().take(4).filter_map(|g| g.measure).collect();
        assert!(
            volumes.iter().zip([1.0, 1.0, 1.0, 1.0 / 6.0]).all(|(a, b)| (a - b).abs() < 1e-14),
            "{volumes:?}"
        );
        let whole = region(&bytes, &["cube", "block_20", "wedges", "cap"]);
        let mesh = whole.mesh().unwrap();
        assert_eq!(mesh.cells().len(), 6 + 12 + 6 + 1);
        let faces = |name: &str| mesh.group(name).map(<[_]>::len);
        assert_eq!(["skin", "foot", "surface_2", "left"].map(faces), [Some(2), Some(4), Some(1), Some(2)]);
        assert!(whole.notes().iter().any(|note| note.starts_with("1 node set with the name of a side set")));
    }
}

#[test]
fn every_side_of_every_shape_is_the_face_that_exodus_means() {
    // The corners of each side, from the tables of the manual.
    let shapes: [(&str, ElementKind, &[&[u32]]); 4] = [
        ("TETRA", ElementKind::Tetra4, &[&[1, 2, 4], &[2, 3, 4], &[1, 4, 3], &[1, 3, 2]]),
        ("PYRAMID", ElementKind::Pyramid5, &[&[1, 2, 5], &[2, 3, 5], &[3, 4, 5], &[1, 5, 4], &[1, 4, 3, 2]]),
        (
            "WEDGE",
            ElementKind::Prism6,
            &[&[1, 2, 5, 4], &[2, 3, 6, 5], &[1, 4, 6, 3], &[1, 3, 2], &[4, 5, 6]],
        ),
        (
            "HEX",
            ElementKind::Hexa8,
            &[&[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 4, 8, 7], &[1, 5, 8, 4], &[1, 4, 3, 2], &[5, 6, 7, 8]],
        ),
    ];
    for (name, kind, sides) in shapes {
        let corners: Vec<u32> = (1..=kind.corners() as u32).collect();
        let cell = crate::mesh_file::MeshCell::new(1, kind, &corners);
        let ascending = |nodes: &[u32]| {
            let mut nodes = nodes.to_vec();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        for (side, expected) in (1u64..).zip(sides) {
            let face = cell.exodus_face(side).unwrap();
            assert_eq!(ascending(&face), ascending(expected), "{name} {side}");
        }
        assert_eq!(cell.exodus_face(0).or(cell.exodus_face(sides.len() as u64 + 1)), None, "{name}");
    }
}

#[test]
fn second_order_elements_other_types_and_one_array_of_coordinates_are_read() {
    // Nodes besides the corners are anywhere.
    for (name, nodes, corners, volume) in [
        ("TETRA10", 10, 4, 1.0 / 6.0),
        ("TETRA14", 14, 4, 1.0 / 6.0),
        ("HEX20", 20, 8, 1.0),
        ("HEX27", 27, 8, 1.0),
        ("WEDGE15", 15, 6, 0.5),
        ("PYRAMID13", 13, 5, 1.0 / 3.0),
    ] {
        let cube = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let order: &[usize] = match corners {
            4 => &[0, 1, 2, 4],
            5 => &[0, 1, 2, 3, 4],
            6 => &[0, 1, 2, 4, 5, 6],
            _ => &[0, 1, 2, 3, 4, 5, 6, 7],
        };
        let place = |k: usize| order.get(k).map_or([0.5, 0.5, 0.5], |corner| cube[*corner].map(f64::from));
        let mut w = Writer::default();
        w.dimension("num_dim", 3);
        let axis = |c: usize| (0..nodes).flat_map(move |k| (place(k)[c] as f32).to_be_bytes());
        w.variable("coord", &[3, nodes], 5, (0..3).flat_map(axis).collect());
        w.variable("eb_prop1", &[1], 10, 3i64.to_be_bytes().to_vec());
        w.variable("connect1", &[1, nodes], 10, (1..=nodes as i64).flat_map(i64::to_be_bytes).collect());
        w.variables.last_mut().unwrap().2 = name;
        let region = region(&w.bytes(5), &[]);
        assert_eq!(region.points().len(), corners, "{name}");
        assert!(region.notes().iter().any(|note| note.contains("1 quadratic cell")), "{name}");
        let measure = parse(&w.bytes(5), "a.e").unwrap().summary().groups[0].measure.unwrap();
        assert!((measure - volume).abs() < 1e-14, "{name}");
    }
}

#[test]
fn plane_meshes_have_edges_for_sides() {
    let mut w = Writer::default();
    w.dimension("num_dim", 2);
    w.reals("coordx", &[0.0, 1.0, 1.0, 0.0, 2.0]);
    w.reals("coordy", &[0.0, 0.0, 1.0, 1.0, 0.0]);
    w.integers("eb_prop1", &[2], &[1, 2]);
    w.block(1, "QUAD4", 4, &[1, 2, 3, 4]);
    w.block(2, "TRI3", 3, &[2, 5, 3]);
    w.integers("ss_prop1", &[1], &[4]);
    w.integers("elem_ss1", &[2], &[1, 2]);
    w.integers("side_ss1", &[2], &[1, 1]);
    let file = parse(&w.bytes(1), "a.e").unwrap();
    let region = file.regions(&["block_1", "block_2"], RegionOptions::default()).unwrap();
    assert_eq!(region.mesh().unwrap().group("surface_4").map(<[_]>::len), Some(2));
}

#[test]
fn faults_are_told_with_their_places() {
    let said = |change: &dyn Fn(&mut Writer)| {
        let mut w = sample();
        change(&mut w);
        parse(&w.bytes(2), "a.e").map_or_else(|error| error.to_string(), |_| "nothing".to_owned())
    };
    let named = |w: &mut Writer, name: &str| w.variables.iter().position(|v| v.0 == name).unwrap();
    let set = |w: &mut Writer, name: &str, value: i32| {
        let k = named(w, name);
        w.variables[k].4[..4].copy_from_slice(&value.to_be_bytes());
    };
    type Change<'a> = &'a dyn Fn(&mut Writer);
    let faults: [(Change<'_>, &str); 9] = [
        (&|w| w.dimensions[0].1 = 1, "the mesh has 1 axes; expected 2 or 3"),
        (&|w| w.dimensions[0].0 = "n".into(), "a netCDF file without the dimension num_dim"),
        (
            &|w| set(w, "connect1", 99),
            "element 1 (8-node hexahedron) uses node 99, which the file does not have",
        ),
        (&|w| set(w, "connect1", -1), "connect1 holds -1; expected numbers from 1"),
        (
            &|w| set(w, "side_ss1", 7),
            "side set \"foot\" takes the side 7 of element 1; expected an element of the file",
        ),
        (&|w| set(w, "elem_ss1", 70), "side set \"foot\" takes the side 5 of element 70"),
        (&|w| set(w, "node_ns2", 19), "node set \"left\" holds node 19; expected numbers up to 18"),
        (
            &|w| w.variables[5].2 = "SUPER",
            "element block 1 has \"SUPER\" elements of 8 nodes; expected TETRA",
        ),
        (&|w| w.variables[0].3 = 4, "the variable coordx has the type 4; expected real numbers"),
    ];
    for (change, words) in faults {
        assert!(said(change).contains(words), "{}", said(change));
    }
    let hdf = parse(b"\x89HDF\r\n\x1a\nrest", "b.e").unwrap_err().to_string();
    assert!(hdf.contains("nccopy -k classic"), "{hdf}");
    assert!(parse(b"CDF\x03", "b.e").unwrap_err().to_string().contains("version 3 of classic netCDF"));
    let bytes = sample().bytes(1);
    let short = parse(&bytes[..bytes.len() - 4], "b.e").unwrap_err().to_string();
    assert!(short.contains("the file ends before the values of node_ns2"), "{short}");
}

#[test]
fn damaged_files_are_errors_or_meshes() {
    let use_it = |bytes: &[u8]| {
        let Ok(file) = parse(bytes, "damaged.e") else { return false };
        let _ = file.summary();
        let whole = file.solid_regions(&[], RegionOptions::default());
        whole.is_ok_and(|region| region.mesh().is_ok())
    };
    for version in [1, 2, 5] {
        let bytes = sample().bytes(version);
        let sound = (0..bytes.len()).filter(|length| parse(&bytes[..*length], "short.e").is_ok()).count();
        assert_eq!(sound, 0, "a file that was cut lacks its last node set");
        for place in 0..bytes.len() {
            for change in [0x01, 0xFF] {
                let mut changed = bytes.clone();
                changed[place] ^= change;
                use_it(&changed);
            }
        }
    }
}

#[test]
fn variables_that_overlap_cannot_ask_for_more_memory_than_the_file_has() {
    let mut w = sample();
    w.variables.retain(|v| !v.0.starts_with("ns_"));
    w.integers("ns_prop1", &[200], &(1..=200).collect::<Vec<i32>>());
    // The values of all these sets are those of the last variable.
    let shape = w.dimension("of_all", 1000);
    for k in 3..=200 {
        w.variables.push((format!("node_ns{k}"), vec![shape], "", 4, Vec::new()));
    }
    w.integers("last", &[1000], &[1; 1000]);
    let said = parse(&w.bytes(1), "a.e").unwrap_err().to_string();
    assert!(said.contains("the variables have more values than the file has bytes"), "{said}");
}
