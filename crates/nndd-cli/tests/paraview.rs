//! The ParaView files, read back by a reader of their own: the bound, forces, strains and numbers must come out of the
//! files alone. `cargo xtask check-vtk` does it by VTK and meshio.

// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use case_io::report::Report;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One file: points and cells, and every field by its name.
struct Grid {
    points: Vec<[f64; 2]>,
    cells: Vec<Vec<usize>>,
    fields: BTreeMap<String, Vec<f64>>,
}

/// The value of an attribute of an XML tag.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    tag.split(&format!(" {name}=\"")).nth(1)?.split('"').next()
}

impl Grid {
    /// Reads appended raw blocks, each behind its length in eight bytes.
    fn read(path: &Path) -> Self {
        let file = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mark = b"<AppendedData encoding=\"raw\">\n   _";
        let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
        let header = std::str::from_utf8(&file[..start]).unwrap();
        let word = |bytes: &[u8]| <[u8; 8]>::try_from(bytes).unwrap();
        let mut fields = BTreeMap::new();
        for tag in header.split('<').filter(|tag| tag.starts_with("DataArray")) {
            let at = start + attribute(tag, "offset").unwrap().parse::<usize>().unwrap();
            let length = u64::from_le_bytes(word(&file[at..at + 8])) as usize;
            let block = &file[at + 8..at + 8 + length];
            let values: Vec<f64> = match attribute(tag, "type").unwrap() {
                "Float64" => block.chunks(8).map(|b| f64::from_le_bytes(word(b))).collect(),
                "Int64" => block.chunks(8).map(|b| i64::from_le_bytes(word(b)) as f64).collect(),
                _ => block.iter().map(|b| f64::from(*b)).collect(),
            };
            fields.insert(attribute(tag, "Name").unwrap().to_owned(), values);
        }
        let points = fields["Points"].chunks(3).map(|p| [p[0], p[1]]).collect();
        let ends = fields["offsets"].iter().map(|end| *end as usize);
        let mut begin = 0;
        let mut cells = Vec::new();
        for end in ends {
            cells.push(fields["connectivity"][begin..end].iter().map(|n| *n as usize).collect());
            begin = end;
        }
        Self { points, cells, fields }
    }

    fn at(&self, name: &str) -> &[f64] {
        self.fields.get(name).unwrap_or_else(|| panic!("no field {name}"))
    }

    /// Area of each triangle, length of each line.
    fn sizes(&self) -> Vec<f64> {
        let size = |cell: &Vec<usize>| match cell.iter().map(|n| self.points[*n]).collect::<Vec<_>>()[..] {
            [a, b] => (b[0] - a[0]).hypot(b[1] - a[1]),
            [a, b, c] => 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs(),
            _ => panic!("neither a line nor a triangle"),
        };
        self.cells.iter().map(size).collect()
    }

    /// The integral of a field of the cells.
    fn integral(&self, name: &str) -> f64 {
        self.sizes().iter().zip(self.at(name)).map(|(size, value)| size * value).sum()
    }
}

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases")
}

/// Solves a case; what it says in its report, and where.
fn solved(case: &str, folder: &Path) -> (Report, PathBuf) {
    let out = folder.join(case);
    let output = Command::new(env!("CARGO_BIN_EXE_nndd"))
        .args(["solve", "--quiet", "--out"])
        .arg(&out)
        .arg(cases().join(format!("{case}.toml")))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(out.join("report.json")).unwrap();
    (Report::from_json(&text).unwrap(), out)
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{what}: {found:e} against {expected:e}");
}

/// The squared bound less the allowance for round-off, from three files: all of it, and by its origin.
fn squared_bound(bodies: [&Grid; 2], contact: &Grid) -> [f64; 2] {
    let over_bodies = |name: &str| bodies.iter().map(|grid| grid.integral(name)).sum::<f64>();
    let along_contact = contact.integral("error_density");
    let parts = over_bodies("error_density_mesh") + over_bodies("error_density_iteration");
    [over_bodies("error_density") + along_contact, parts + along_contact]
}

#[test]
fn the_files_hold_the_squared_bound() {
    let temp = tempfile::tempdir().unwrap();
    for case in ["paper", "hertz", "rings", "nonmatching", "materials", "gmsh"] {
        let (report, out) = solved(case, temp.path());
        let grids = [0, 1].map(|b: usize| Grid::read(&out.join(format!("{}.vtu", report.bodies[b].name))));
        let contact = Grid::read(&out.join("contact.vtu"));
        let e_cre = report.certificate.as_ref().unwrap().e_cre.unwrap();
        let allowance = contact.at("round_off")[0];
        assert!(allowance >= 0.0 && allowance <= 1e-6 * e_cre, "{case}: {allowance:e}");
        for found in squared_bound(grids.each_ref(), &contact) {
            near(found, (e_cre - allowance).powi(2), 1e-9, case);
        }
        assert!(contact.at("error_density").iter().all(|d| *d >= -1e-12 * e_cre * e_cre), "{case}");
        for (b, grid) in grids.iter().enumerate() {
            let energy: f64 = grid
                .sizes()
                .iter()
                .zip(grid.at("stress").chunks(6).zip(grid.at("strain").chunks(6)))
                .map(|(area, (s, e))| area * (s[0] * e[0] + s[1] * e[1] + s[2] * e[2] + 2.0 * s[3] * e[3]))
                .sum();
            near(energy, report.results.energy_norm_squared.as_ref().unwrap()[b], 1e-9, case);
            assert!(grid.at("body_id").iter().all(|id| *id == b as f64));
        }
        // One nodal stress, and the report has its largest value.
        let nodal = grids.iter().flat_map(|grid| {
            assert_eq!(grid.at("stress_recovered").len(), 6 * grid.points.len());
            assert_eq!(grid.at("von_mises_recovered").len(), grid.points.len());
            assert!(!grid.fields.contains_key("stress_nodal"));
            grid.at("von_mises_recovered")
        });
        let largest = nodal.copied().fold(0.0, f64::max);
        assert_eq!(largest, report.results.peak_stress.as_ref().unwrap().von_mises, "{case}");
        for grid in grids.iter().chain([&contact]) {
            assert_eq!(grid.at("certified"), [1.0], "{case}");
            assert_eq!(grid.at("e_cre"), [e_cre], "{case}");
            assert_eq!(grid.at("iteration"), [report.iterations.last().unwrap().iteration as f64]);
            // Only the paper's iteration has one.
            let theta = report.iterations.last().unwrap().theta;
            assert_eq!(grid.fields.get("theta").cloned(), theta.map(|theta| vec![theta]));
        }
        let tractions = contact.at("traction_1").iter().zip(contact.at("traction_2"));
        let sums: Vec<f64> = tractions.map(|(a, b)| a + b).collect();
        assert_eq!(contact.at("traction_imbalance"), sums, "{case}");
    }
}

#[test]
fn reactions_are_those_of_supports_and_contact() {
    let temp = tempfile::tempdir().unwrap();
    let (report, out) = solved("paper", temp.path());
    let contact = Grid::read(&out.join("contact.vtu"));
    let lengths = contact.sizes();
    for (b, traction) in ["traction_1", "traction_2"].into_iter().enumerate() {
        let grid = Grid::read(&out.join(format!("{}.vtu", report.bodies[b].name)));
        let reaction: Vec<[f64; 2]> = grid.at("reaction").chunks(3).map(|r| [r[0], r[1]]).collect();
        let sum = reaction.iter().fold([0.0; 2], |sum, r| [sum[0] + r[0], sum[1] + r[1]]);
        let of_body = report.results.reactions.iter().flatten().filter(|r| r.body == report.bodies[b].name);
        let mut expected = of_body.fold([0.0; 2], |sum, r| [sum[0] + r.fx, sum[1] + r.fy]);
        // Out of the upper body is down.
        for (cell, length) in contact.cells.iter().zip(&lengths) {
            expected[1] -= cell.iter().map(|n| 0.5 * length * contact.at(traction)[*n]).sum::<f64>();
        }
        let scale = reaction.iter().flatten().fold(0.0_f64, |m, r| m.max(r.abs()));
        for c in 0..2 {
            assert!((sum[c] - expected[c]).abs() <= 1e-9 * scale, "{sum:?} against {expected:?}");
        }
        let box_of = |c: usize| {
            let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
            grid.points.iter().fold((low, high), |(a, b), p| (a.min(p[c]), b.max(p[c])))
        };
        let limits = [0, 1].map(box_of);
        let inside = |p: &[f64; 2]| (0..2).all(|c| limits[c].0 < p[c] && p[c] < limits[c].1);
        let within: Vec<_> = grid.points.iter().zip(&reaction).filter(|(p, _)| inside(p)).collect();
        assert!(!within.is_empty() && within.iter().all(|(_, r)| **r == [0.0; 2]));
    }
}

/// Nodes and triangles of a Gmsh file (MSH 4.1, text), by number.
fn gmsh(text: &str) -> (BTreeMap<u64, [f64; 2]>, BTreeMap<u64, [u64; 3]>) {
    let section = |name: &str| {
        let body = text.split(&format!("${name}\n")).nth(1).unwrap();
        body.split(&format!("$End{name}")).next().unwrap().lines().skip(1)
    };
    fn numbers(line: &str) -> Vec<f64> {
        line.split_whitespace().map(|word| word.parse().unwrap()).collect()
    }
    let mut nodes = BTreeMap::new();
    let mut lines = section("Nodes");
    while let Some(head) = lines.next() {
        let count = numbers(head)[3] as usize;
        let tags: Vec<u64> = lines.by_ref().take(count).map(|line| line.trim().parse().unwrap()).collect();
        for (tag, line) in tags.iter().zip(lines.by_ref().take(count)) {
            nodes.insert(*tag, [numbers(line)[0], numbers(line)[1]]);
        }
    }
    let mut triangles = BTreeMap::new();
    let mut lines = section("Elements");
    while let Some(head) = lines.next() {
        let head = numbers(head);
        for line in lines.by_ref().take(head[3] as usize).filter(|_| head[2] == 2.0) {
            let n: Vec<u64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            triangles.insert(n[0], [n[1], n[2], n[3]]);
        }
    }
    (nodes, triangles)
}

#[test]
fn cells_carry_the_numbers_of_the_mesh_file() {
    let temp = tempfile::tempdir().unwrap();
    let (report, out) = solved("gmsh", temp.path());
    let (nodes, triangles) =
        gmsh(&std::fs::read_to_string(cases().join("meshes/blocks.msh")).unwrap().replace('\r', ""));
    let sorted = |mut corners: [[f64; 2]; 3]| {
        corners.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        corners
    };
    let mut seen = 0;
    for (b, body) in report.bodies.iter().enumerate() {
        let grid = Grid::read(&out.join(format!("{}.vtu", body.name)));
        for (cell, id) in grid.cells.iter().zip(grid.at("element_id")) {
            let corners = [0, 1, 2].map(|k: usize| grid.points[cell[k]]);
            let of_file = triangles[&(*id as u64)].map(|n| nodes[&n]);
            assert_eq!(sorted(corners), sorted(of_file), "element {id}");
            seen += 1;
        }
        // [materials] of the file: stiff, then soft.
        assert!(grid.at("material_id").iter().all(|id| *id == b as f64));
    }
    assert_eq!(seen, triangles.len());
    // Generated meshes have no numbers but their own.
    let (report, out) = solved("paper", temp.path());
    let grid = Grid::read(&out.join(format!("{}.vtu", report.bodies[0].name)));
    assert!(grid.at("element_id").iter().enumerate().all(|(t, id)| *id == t as f64));
}

#[test]
fn regions_have_their_material() {
    let temp = tempfile::tempdir().unwrap();
    let (report, out) = solved("materials", temp.path());
    let materials = report.case["materials"].as_object().unwrap().len();
    let mut ids: Vec<u64> = Vec::new();
    for body in &report.bodies {
        let grid = Grid::read(&out.join(format!("{}.vtu", body.name)));
        ids.extend(grid.at("material_id").iter().map(|id| *id as u64));
    }
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids, (0..materials as u64).collect::<Vec<_>>());
}

#[test]
fn an_adaptive_run_leaves_bodies_and_contact_line_of_every_mesh() {
    let temp = tempfile::tempdir().unwrap();
    let (report, out) = solved("adaptive", temp.path());
    let collection = std::fs::read_to_string(out.join("adaptive.pvd")).unwrap();
    let [upper, lower] = [0, 1].map(|b: usize| report.bodies[b].name.clone());
    for part in [upper.as_str(), lower.as_str(), "contact"] {
        let series = std::fs::read_to_string(out.join(format!("{part}.vtu.series"))).unwrap();
        let series: serde_json::Value = serde_json::from_str(&series).unwrap();
        assert_eq!(series["file-series-version"], "1.0");
        assert_eq!(series["files"].as_array().unwrap().len(), report.adaptive.len());
        for (row, file) in report.adaptive.iter().zip(series["files"].as_array().unwrap()) {
            let name = file["name"].as_str().unwrap();
            assert_eq!(name, format!("fields/{part}-step-{:02}.vtu", row.step));
            assert_eq!(file["time"].as_f64(), Some(row.step as f64));
            assert!(collection.contains(&format!("file=\"{name}\"")), "{collection}");
            assert_eq!(Grid::read(&out.join(name)).at("TimeValue"), [row.step as f64]);
        }
    }
    for row in &report.adaptive {
        let read = |part: &str| Grid::read(&out.join(format!("fields/{part}-step-{:02}.vtu", row.step)));
        let (grids, contact) = ([read(&upper), read(&lower)], read("contact"));
        assert_eq!(contact.points.len(), row.pairs);
        let allowance = contact.at("round_off")[0];
        let e_cre = row.e_cre.unwrap();
        assert!(allowance >= 0.0 && allowance <= 1e-6 * e_cre, "{allowance:e}");
        for found in squared_bound(grids.each_ref(), &contact) {
            near(found, (e_cre - allowance).powi(2), 1e-9, "adaptive");
        }
    }
    // A run without meshes in steps leaves none of these behind.
    let paper = cases().join("paper.toml");
    let replaced = Command::new(env!("CARGO_BIN_EXE_nndd"))
        .args(["solve", "--quiet", "--force", "--out"])
        .args([&out, &paper])
        .status()
        .unwrap();
    assert!(replaced.success());
    assert!(!out.join("adaptive.pvd").exists() && !out.join("contact.vtu.series").exists());
    assert_eq!(std::fs::read_dir(out.join("fields")).unwrap().count(), 0);
}

/// The columns of contact.csv by their names.
fn columns(out: &Path) -> BTreeMap<String, Vec<f64>> {
    let text = std::fs::read_to_string(out.join("contact.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(names[..7], ["s", "x", "y", "gap", "opening", "pressure", "active"]);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let column = |k: usize| rows.iter().map(|row| row[k].parse().unwrap()).collect();
    names.iter().enumerate().map(|(k, name)| ((*name).to_owned(), column(k))).collect()
}

#[test]
fn gap_is_the_initial_one_and_opening_the_current_one() {
    let temp = tempfile::tempdir().unwrap();
    let (report, out) = solved("hertz", temp.path());
    let table = columns(&out);
    let contact = Grid::read(&out.join("contact.vtu"));
    for name in ["gap", "opening"] {
        assert_eq!(contact.at(name), table[name], "{name}");
    }
    // At nodes that press on each other the drawn gap is closed: the opening is zero, the gap is not.
    let pressed = |k: &usize| table["pressure"][*k] > 0.0;
    let closed: Vec<usize> = (0..table["gap"].len()).filter(pressed).collect();
    assert!(closed.iter().all(|k| table["opening"][*k].abs() < 1e-12), "{table:?}");
    assert!(closed.iter().any(|k| table["gap"][*k] > 1e-6), "{table:?}");
    // A half disc on a half disc: the gap grows as the square of the distance from the pole, on both sides.
    let largest = table["gap"].iter().copied().fold(0.0, f64::max);
    assert!(largest == table["gap"][0].max(*table["gap"].last().unwrap()));
    let results = &report.results;
    let extreme = |name: &str, of: fn(f64, f64) -> f64| table[name].iter().copied().reduce(of).unwrap();
    assert_eq!(results.min_opening, Some(extreme("opening", f64::min)));
    assert_eq!(results.max_pressure, Some(extreme("pressure", f64::max)));
    assert!(results.max_edge_pressure.unwrap() <= results.max_pressure.unwrap());
    assert_eq!(contact.at("contact_pressure"), table["pressure"]);
}

#[test]
fn the_largest_pressure_is_the_same_number_on_the_page_and_in_the_tables() {
    let temp = tempfile::tempdir().unwrap();
    for case in ["paper", "rings"] {
        let (report, out) = solved(case, temp.path());
        let largest = columns(&out)["pressure"].iter().copied().fold(0.0, f64::max);
        let results = &report.results;
        assert_eq!(results.max_pressure, Some(largest), "{case}");
        let stretches = results.lines.as_ref().unwrap().contact_stretches.as_deref().unwrap();
        let of_stretches = stretches.iter().map(|s| s.max_pressure).fold(0.0, f64::max);
        assert_eq!(of_stretches, largest, "{case}");
        let of_edges = stretches.iter().map(|s| s.max_edge_pressure).fold(0.0, f64::max);
        assert_eq!(results.max_edge_pressure, Some(of_edges), "{case}");
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        let after = |name: &str| {
            let rest = page.split(&format!("<td>{name}</td><td>")).nth(1).unwrap();
            rest.split('<').next().unwrap().to_owned()
        };
        // Rounded to the digits that the certified error leaves: 2 at 18.8 %, 3 at 2.7 %.
        let digits = if case == "paper" { 2 } else { 3 };
        let rounded = |x: f64| format!("{x:.*e}", digits - 1).parse::<f64>().unwrap();
        for (name, exact) in
            [("largest nodal pressure", largest), ("largest mean pressure of an edge", of_edges)]
        {
            let shown = after(name);
            assert_eq!(shown.parse::<f64>().unwrap(), rounded(exact), "{case}: {name}");
            assert_eq!(shown.replace('.', "").trim_start_matches('0').len(), digits, "{case}: {shown}");
        }
        assert!(page.contains("<td>smallest opening</td>"), "{case}");
        let checks = &serde_json::to_value(&report.certificate.as_ref().unwrap().checks).unwrap();
        for key in ["supports", "imposed_displacement"] {
            assert!(checks[key].is_f64(), "{case}: {checks}");
            assert!(page.contains(&format!("<td>{}</td>", key.replace('_', " "))), "{case}: {key}");
        }
    }
}
