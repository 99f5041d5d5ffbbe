//! Mesh files: the same problem from every format gives the same bits; damaged files give errors, never panics.

use case_io::Case;
use fem_core::interface::ContactProblem;
use fem_core::mesh::{TriMesh, generate::block};
use mesh_io::{MeshFile, RegionOptions};
use nndd::NnddSettings;
use tests::mesh_files::{self, ALL, Encoding, Format, write};
use tests::random::Random;
use tests::{certify, iterates, paper, prepare};

fn blocks(cells: [usize; 2]) -> [TriMesh; 2] {
    [[0.0, 1.0], [0.0, 0.0]].map(|origin| block(origin, [2.0, 1.0], cells).unwrap())
}

fn file(cells: [usize; 2], format: Format) -> Vec<u8> {
    let [upper, lower] = blocks(cells);
    write(&[("upper", &upper), ("lower", &lower)], format)
}

#[test]
fn every_format_gives_the_mesh_back_bit_for_bit() {
    for format in ALL {
        let parsed = mesh_io::parse(&file(paper::COARSE, format), "blocks").unwrap();
        for (name, meant) in ["upper", "lower"].into_iter().zip(blocks(paper::COARSE)) {
            let region = parsed.region(Some(name), RegionOptions::default()).unwrap();
            assert!(region.warnings().is_empty(), "{format:?}: {:?}", region.warnings());
            assert_eq!(region.notes().is_empty(), format != Format::QuadDeck, "{:?}", region.notes());
            let mesh = region.mesh().unwrap();
            let bits = |m: &TriMesh| m.points().iter().map(|p| p.map(f64::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&mesh), bits(&meant), "{format:?} {name}");
            assert_eq!(mesh.cells(), meant.cells(), "{format:?} {name}");
            assert_eq!(mesh.groups().len(), 4, "{format:?} {name}");
            for (side, edges) in meant.groups() {
                assert_eq!(
                    mesh.group(&format!("{name}.{side}")),
                    Some(&edges[..]),
                    "{format:?} {name} {side}"
                );
            }
        }
    }
}

/// The paper's case with its generators replaced by a mesh file.
fn case(folder: &std::path::Path, format: Format) -> Case {
    let name = format!("blocks.{}", format.ending());
    std::fs::write(folder.join(&name), file(paper::COARSE, format)).unwrap();
    let mut text = String::new();
    let mut body = "";
    for line in case_io::template::PAPER.lines() {
        if let Some(rest) = line.strip_prefix("name = \"") {
            body = rest.trim_end_matches('"');
        }
        if line.starts_with("generator") {
            text += &format!("mesh = {{ file = \"{name}\", region = \"{body}\" }}\n");
        } else if let Some(side) = line.strip_prefix("on = \"") {
            text += &format!("on = \"{body}.{side}\n");
        } else if line.starts_with("surfaces") {
            text += "surfaces = [\"upper.bottom\", \"lower.top\"]\n";
        } else {
            text += &format!("{line}\n");
        }
    }
    let mut case = Case::parse(&text, "paper.toml", &[]).unwrap();
    case.read_mesh_files(folder).unwrap();
    case
}

/// Indicators of some iterations and the certified bound, as bits.
fn results(problem: &ContactProblem) -> Vec<u64> {
    let prepared = prepare(problem);
    let mut settings = NnddSettings::paper(0.4);
    settings.max_iterations = 4;
    let (solution, all) = iterates(&prepared, &settings, 0.0).unwrap();
    let estimate = certify(&prepared, &all[3]).unwrap();
    let rows = solution.history.iter().flat_map(|r| [r.precision, r.eta_nndd, r.contact_force]);
    rows.chain([estimate.unchecked().e_cre, estimate.unchecked().eta_dis]).map(f64::to_bits).collect()
}

#[test]
fn the_papers_problem_from_a_file_has_the_generators_results_bit_for_bit() {
    let meant = results(&paper::problem(paper::COARSE).unwrap());
    let mut hashes = Vec::new();
    for format in ALL {
        let folder = tempfile::tempdir().unwrap();
        let case = case(folder.path(), format);
        assert_eq!(results(&case.build().unwrap().0), meant, "{format:?}");
        hashes.push(case.hash());
    }
    // The contents of the files count: all differ, though the names of the files are two only.
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), ALL.len());
}

/// Does with a file everything that can be done with it.
fn use_everything(file: &MeshFile) {
    let summary = file.summary();
    let finite = |x: f64| assert!(x.is_finite(), "{summary:?}");
    summary.groups.iter().filter_map(|g| g.measure).for_each(finite);
    summary.quality.iter().for_each(|q| finite(q.smallest_angle));
    let names: Vec<String> = file.group_names(2).take(5).map(str::to_owned).collect();
    for name in names.iter().map(|n| Some(n.as_str())).chain([None, Some("absent")]) {
        for merge in [false, true] {
            if let Ok(region) = file.region(name, RegionOptions::with_merge(merge)) {
                let _ = (region.mesh(), region.without_sides());
            }
        }
    }
}

/// Reads damaged bytes; says whether they still are a mesh.
fn read(bytes: &[u8]) -> bool {
    let parsed = mesh_io::parse(bytes, "damaged");
    if let Ok(file) = &parsed {
        use_everything(file);
    }
    if let Err(error) = &parsed {
        assert!(error.to_string().starts_with("damaged"), "{error}");
    }
    parsed.is_ok()
}

#[test]
fn every_prefix_of_a_file_is_an_error_or_a_mesh() {
    for format in ALL {
        let whole = file([2, 1], format);
        assert!(read(&whole));
        let needed = whole.trim_ascii_end().len();
        for len in 0..needed {
            let is_mesh = read(&whole[..len]);
            // Decks have no end mark; the others must notice.
            assert!(!is_mesh || format.ending() == "inp", "{format:?} cut at {len} of {needed} was taken");
        }
    }
}

#[test]
fn random_damage_is_an_error_or_a_mesh() {
    let mut random = Random::new(2024);
    let (mut refused, mut taken) = (0, 0);
    for format in ALL {
        let whole = file([2, 1], format);
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..1 + (random.unit() * 3.0) as usize {
                let place = (random.unit() * bytes.len() as f64) as usize;
                match (random.unit() * 4.0) as usize {
                    0 => bytes[place] ^= 1 << (random.unit() * 8.0) as u32,
                    1 => bytes[place] = (random.unit() * 256.0) as u8,
                    // Numbers grow a digit, lines and columns vanish or double.
                    2 => bytes.insert(place, b"0159-.,$*\n eN"[(random.unit() * 13.0) as usize]),
                    _ => {
                        let end = (place + 1 + (random.unit() * 12.0) as usize).min(bytes.len());
                        bytes.drain(place..end);
                    }
                }
            }
            *(if read(&bytes) { &mut taken } else { &mut refused }) += 1;
        }
    }
    // Both happen, or the damage would test nothing.
    assert!(refused > 2000 && taken > 200, "{refused} refused, {taken} taken");
}

/// The mesh files of the example cases: the paper's blocks, once for Gmsh, once as a deck of quadrilaterals whose
/// nodes are in a file of their own.
fn examples() -> [(&'static str, Vec<u8>); 3] {
    let [upper, lower] = blocks(paper::COARSE);
    let bodies = [("upper", &upper), ("lower", &lower)];
    let head = "** The paper's two blocks, 18 x 9 quadrilaterals each.\n*HEADING\nTwo blocks\n*INCLUDE, INPUT=nodes.inp\n";
    let deck = format!("{head}{}", mesh_files::deck_elements(&bodies, true));
    [
        ("blocks.msh", write(&bodies, Format::Msh4(Encoding::Text))),
        ("blocks.inp", deck.into_bytes()),
        ("nodes.inp", mesh_files::deck_nodes(&bodies).into_bytes()),
    ]
}

#[test]
fn the_example_meshes_are_the_papers_blocks() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/meshes");
    for (name, meant) in examples() {
        let found = std::fs::read(folder.join(name)).unwrap();
        assert!(found == meant, "{name} is not what the writer of this test makes");
    }
}
