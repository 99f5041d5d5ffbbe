//! Certificates of displacements that another code computed, read from files or in memory.

mod matched;
mod output;

use crate::convert;
use crate::failure::{FILES, Failure, INVALID_INPUT};
use crate::report::projected;
use crate::verdict::{mostly_round_off, without_loads};
use crate::words::{rounded_up, with_digits};
use case_io::Case;
use certified_contact::{SolveError, without_spin};
use cre_estimator::{FieldCertificate, Relaxation};
use fem_core::body::Body;
use fem_core::geometry::{Vector, bounding_box, diagonal, shown};
use fem_core::interface::ContactProblem;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::mesh_field::MeshField;
use fem_core::prepared::PreparedProblem;
use fem_core::tensor::SymTensor2;
use matched::{Matched, Mismatch, matched};
use mesh_io::read_point_vectors;
use mesh_io::vtu::{FieldError, PointVectors};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

pub use output::write;

/// A point is far from all bodies if it is outside of their common box by this fraction of its diagonal.
const FAR: f64 = 0.01;
/// Digits of what is printed for people.
const DIGITS: usize = 4;
/// Names of the array of displacements, in the order in which they are looked for.
const NAMES: [&str; 6] = ["displacement", "displacements", "disp", "u", "U", "Displacement"];

/// Certifies displacements of other codes.
///
/// * `problem`: see [`crate::run::build_last`]; `files`: one per body, in the order of the case file.
///
/// # Errors
/// Files that cannot be read, fields that do not have a value at every node of the meshes, a problem without a unique solution.
pub fn certify(
    case: &Case,
    problem: &ContactProblem,
    files: &[PathBuf],
) -> Result<FieldCertificate, Failure> {
    if files.len() != case.bodies.len() {
        let (found, expected) = (files.len(), case.bodies.len());
        return Err(Failure::command_line(format!(
            "{found} files of displacements are given, and the case has {expected} bodies\n  expected: one file per body, in the \
             order of the case file\n  fix: write `--displacement A.vtu B.vtu …`"
        )));
    }
    refuse(case, problem)?;
    let meshes = meshes(case)?;
    let mut all = Vec::with_capacity(files.len());
    for (b, file) in files.iter().enumerate() {
        let read = read(file)?;
        refuse_far(file, &read, &meshes)?;
        all.push(field_of(case, b, file, &read, [&meshes[b], problem.bodies[b].mesh()])?);
    }
    let spread =
        all.iter().zip(&problem.bodies).map(|(of, body)| of.spread * largest_stiffness(body, of.spread));
    let spread = spread.sum::<f64>().sqrt();
    let given: Vec<MeshField<'_>> = all.iter().map(|of| MeshField::new(of.mesh, &of.field)).collect();
    let prepared = prepare(case, problem.clone())?;
    let mut found = bound(case, &prepared, &given, None)?;
    found.widen(spread);
    Ok(found)
}

/// Makes the meshes as the case describes them, before nodes are added and moved so that surfaces match.
fn meshes(case: &Case) -> Result<Vec<TriMesh>, Failure> {
    (0..case.bodies.len()).map(|b| Ok(case.mesh_of(b)?)).collect()
}

/// Matches the field of a file to the mesh of the case or, if that fails, to the refined mesh of the problem, on which
/// a run of this program writes its fields.
fn field_of<'a>(
    case: &Case,
    b: usize,
    file: &Path,
    read: &PointVectors,
    [own, refined]: [&'a TriMesh; 2],
) -> Result<Matched<'a>, Failure> {
    let changed = own.points() != refined.points();
    if changed && refined.points().len() > own.points().len() {
        match matched(read, refined) {
            Err(Mismatch::Point(point)) => return Err(other_field(case, b, file, read.points[point])),
            Ok(found) => return Ok(found),
            Err(Mismatch::Node { .. }) => {}
        }
    }
    match matched(read, own) {
        Ok(found) => Ok(found),
        Err(Mismatch::Point(point)) => Err(other_field(case, b, file, read.points[point])),
        Err(Mismatch::Node { node, nearest }) => {
            // Nodes were moved and none was added.
            if let (true, Ok(found)) = (changed, matched(read, refined)) {
                return Ok(found);
            }
            let [x, y] = [0, 1].map(|axis| shown(own.points()[NodeId::new(node)][axis]));
            Err(Failure::invalid(format!(
                "{}: body \"{}\" has a node at ({x}, {y}), and the nearest point of the file is {} away\n  expected: a point at \
                 every node of the mesh of the case\n  fix: write the field on the same mesh, in the same units, and give the files in the order of the bodies",
                file.display(),
                case.bodies[b].name,
                shown(nearest)
            )))
        }
    }
}

/// Refuses points that are far from all bodies: damaged lines, other units.
fn refuse_far(file: &Path, read: &PointVectors, meshes: &[TriMesh]) -> Result<(), Failure> {
    let ends: Vec<Vector> = meshes.iter().flat_map(|mesh| bounding_box(mesh.points())).collect();
    let [low, high] = bounding_box(&ends);
    let margin = FAR * diagonal(&ends);
    let is_far = |p: &Vector| (0..2).any(|k| !(p[k] >= low[k] - margin && p[k] <= high[k] + margin));
    let Some(k) = read.points.iter().position(is_far) else { return Ok(()) };
    let place = read.lines.get(k).map_or_else(|| format!("point {k}"), |line| format!("line {line}"));
    let [x, y] = [0, 1].map(|axis| shown(read.points[k][axis]));
    Err(Failure::invalid(format!(
        "{}: {place}: the point ({x}, {y}) is far from all bodies\n  expected: points of the meshes of the case\n  fix: mend the line, \
         or write the points in the units of the case",
        file.display()
    )))
}

/// Bounds the energy density over `|∇d|²`, Pa: the trace of the stiffness, the largest of all cells. Not computed if there is nothing to bound.
fn largest_stiffness(body: &Body, spread: f64) -> f64 {
    if spread == 0.0 {
        return 0.0;
    }
    let units = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.5f64.sqrt())];
    let strains = units.map(|(xx, yy, xy)| SymTensor2 { xx, yy, xy });
    let of_cell = |t: usize| {
        let material = body.material(t);
        strains.iter().map(|e| material.stress(*e).contract(*e)).sum::<f64>()
    };
    (0..body.mesh().cells().len()).map(of_cell).fold(0.0, f64::max)
}

/// Certifies displacements in memory.
///
/// * `problem`: see [`crate::run::build_last`].
/// * `fields`: at the nodes of each body's mesh as the case describes it, Cartesian, m.
/// * `pressures`: for each pair, at the nodes of the mesh of its first body, Pa; `None`: from the equilibrium of the fields.
///
/// # Errors
/// Fields of another length than the meshes, friction, a problem without a unique solution.
pub fn of_fields(
    case: &Case,
    problem: &ContactProblem,
    fields: &[Vec<Vector>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate, Failure> {
    refuse(case, problem)?;
    let meshes = meshes(case)?;
    let counted = |what: &str, found: usize, expected: usize| {
        let said = format!(
            "{what}: found {found}, and the case has {expected}\n  expected: as many, in the order of the case\n  fix: check the \
             lists and the meshes they belong to"
        );
        if found == expected { Ok(()) } else { Err(Failure::invalid(said)) }
    };
    counted("fields of displacements", fields.len(), meshes.len())?;
    for (field, (mesh, given)) in fields.iter().zip(meshes.iter().zip(&case.bodies)) {
        counted(&format!("displacements of body \"{}\"", given.name), field.len(), mesh.points().len())?;
    }
    let given: Vec<MeshField<'_>> =
        meshes.iter().zip(fields).map(|(mesh, field)| MeshField::new(mesh, field)).collect();
    let prepared = prepare(case, problem.clone())?;
    let Some(pressures) = pressures else { return bound(case, &prepared, &given, None) };
    counted("pressures", pressures.len(), case.contacts.len())?;
    let mut at_pairs = Vec::with_capacity(pressures.len());
    for (pressure, (given, pair)) in pressures.iter().zip(case.contacts.iter().zip(&problem.contacts)) {
        let first = pair.body;
        let mesh = &meshes[first];
        counted(&format!("pressures of the pair \"{}\"", given.name), pressure.len(), mesh.points().len())?;
        let mut on_side = vec![Vector::zeros(); pressure.len()];
        let edges = mesh.group(&given.surfaces[0]).unwrap_or(&[]);
        for node in edges.iter().flat_map(|edge| mesh.topology().facets()[*edge]) {
            on_side[node.index()][0] = pressure[node.index()];
        }
        let field = MeshField::new(mesh, &on_side).on(problem.bodies[first].mesh());
        at_pairs.push(pair.interface.pairs().iter().map(|p| field[p.nodes[0]][0]).collect());
    }
    bound(case, &prepared, &given, Some(&at_pairs))
}

/// Refuses problems whose fields are more than displacements of the bodies.
fn refuse(case: &Case, problem: &ContactProblem) -> Result<(), Failure> {
    let is_free = |of: &fem_core::interface::ContactPair| {
        problem.obstacle_of(of).is_some_and(|obstacle| !obstacle.free_motions().is_empty())
    };
    if let Some(k) = problem.contacts.iter().position(is_free) {
        return Err(Failure::invalid(format!(
            "the obstacle of the pair \"{}\" is free to move, and its motion is not among the displacements of the bodies\n  expected: \
             obstacles whose motion is imposed\n  fix: give its motion as ux, uy and rotation, or solve the case with nndd",
            case.contacts[k].name
        )));
    }
    let Some(pair) = case.contacts.iter().find(|contact| contact.friction.is_some()) else { return Ok(()) };
    Err(Failure::invalid(format!(
        "the pair \"{}\" has friction, and displacements of other programs are certified without friction only\n  expected: \
         pairs without friction\n  fix: solve the case with nndd",
        pair.name
    )))
}

/// Prepares the problem that a solve would certify: without loads that only the error of the polygon resists.
fn prepare(case: &Case, problem: ContactProblem) -> Result<PreparedProblem, Failure> {
    without_spin(problem)
        .and_then(|problem| PreparedProblem::new(problem).map_err(SolveError::Prepare))
        .map_err(|error| Failure::solve(case, &error))
}

/// * `fields`: of the bodies; `pressures`: at the pairs of the problem.
fn bound(
    case: &Case,
    prepared: &PreparedProblem,
    fields: &[MeshField<'_>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate, Failure> {
    let relaxation: Relaxation = convert::settings(case).relaxation;
    cre_estimator::certify(prepared, fields, pressures, relaxation)
        .map_err(|error| Failure::solve(case, &SolveError::Estimator(error)))
}

/// Says in a line or two what was found.
pub fn verdict(case: &Case, found: &FieldCertificate) -> String {
    let mut text = String::new();
    if found.change > 0.0 {
        text += &format!(
            "changed to be admissible: penetration up to {} removed, supports met by up to {}; energy norm of the change {}\n",
            rounded_up(found.penetration),
            rounded_up(found.support_change),
            rounded_up(found.change)
        );
    }
    let round_off = found.estimate.unchecked().parts.round_off;
    let mostly = found.bound().map_or_else(String::new, |bound| mostly_round_off(round_off, bound));
    text + &match (found.bound(), found.relative()) {
        (Some(bound), Some(relative)) => format!(
            "certified error <= {} % of the energy norm: {} of {}{mostly}\n",
            rounded_up(100.0 * relative),
            rounded_up(bound),
            with_digits(found.estimate.energy_norm(), DIGITS)
        ),
        (Some(bound), None) => {
            format!("certified error <= {} in the energy norm{mostly}\n", rounded_up(bound))
        }
        (None, _) => {
            let failed = found.estimate.admissibility.failed();
            let checks: Vec<String> = failed.map(|(name, value)| format!("{name} {value:.1e}")).collect();
            let reason = match found.missed_support {
                Some(missed) => format!(
                    "body \"{}\" misses its support at ({}, {}) by {}",
                    case.bodies[missed.body].name,
                    shown(missed.point[0]),
                    shown(missed.point[1]),
                    with_digits(missed.distance, DIGITS)
                ),
                None => {
                    "the field violates supports, contact or balance by more than can be mended".to_owned()
                }
            };
            format!("NOT certified, the bound is not valid: {}; {reason}\n", checks.join(", "))
        }
    } + &without_loads(&projected(case, &found.left_out))
}

/// Makes one object of what was found.
pub fn summary(case: &Case, found: &FieldCertificate) -> Value {
    let failed = found.estimate.admissibility.failed();
    let checks: Map<String, Value> = failed.map(|(name, value)| (name.to_owned(), json!(value))).collect();
    json!({
        "valid": found.bound().is_some(),
        "bound": found.bound(),
        "relative": found.relative(),
        "e_cre": found.estimate.unchecked().e_cre,
        "change": found.change,
        "penetration": found.penetration,
        "support_change": found.support_change,
        "round_off": found.estimate.unchecked().parts.round_off,
        "energy_norm": found.estimate.energy_norm(),
        "projected_load": projected(case, &found.left_out),
        "failed_checks": checks,
        "missed_support": found.missed_support.map(|missed| json!({
            "body": case.bodies[missed.body].name,
            "point": [missed.point[0], missed.point[1]],
            "distance": missed.distance,
        })),
    })
}

/// Makes the failure for a file whose value at a point is not interpolated from the nodes of the mesh.
fn other_field(case: &Case, b: usize, file: &Path, point: Vector) -> Failure {
    Failure::invalid(format!(
        "{}: the value at the point ({}, {}) is not that of a linear field between the nodes of the mesh of body \"{}\"\n  expected: \
             one value per node of the mesh of the case, and no points between them with other values\n  fix: write one file per body, on \
             the mesh of the case; of quadratic elements keep the corner nodes",
        file.display(),
        shown(point[0]),
        shown(point[1]),
        case.bodies[b].name
    ))
}

/// Reads a `.vtu` file, or a table with the columns x, y, ux, uy.
fn read(file: &Path) -> Result<PointVectors, Failure> {
    read_point_vectors(file, &NAMES).map_err(|error| {
        let (code, fix) = match &error {
            FieldError::Unreadable { .. } => (FILES, "check its name"),
            FieldError::Line { .. } => (INVALID_INPUT, "mend the line"),
            _ => (INVALID_INPUT, "write it again, for instance with meshio"),
        };
        let said = format!(
            "{}: {error}\n  expected: a .vtu file with the array `displacement` at its points, or a .csv file with the columns x, y, \
             ux, uy\n  fix: {fix}",
            file.display()
        );
        Failure::plain(code, said)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's problem, and its displacements.
    fn solved() -> (Case, ContactProblem, Vec<Vec<Vector>>) {
        let case = Case::parse(case_io::template::PAPER, "paper.toml", &[]).unwrap();
        let problem = case.build().unwrap().0;
        let settings = convert::settings(&case);
        let found = certified_contact::solve(problem.clone(), &settings, &mut certified_contact::Silent);
        let bodies = found.unwrap().estimate.unwrap().pair.bodies;
        (case, problem, bodies.into_iter().map(|body| body.displacement).collect())
    }

    #[test]
    fn fields_in_memory_are_certified_as_those_of_files() {
        let (case, problem, fields) = solved();
        let folder = tempfile::tempdir().unwrap();
        let written = |(k, field): (usize, &Vec<Vector>)| {
            let rows = problem.bodies[k].mesh().points().iter().zip(field);
            let rows = rows.map(|(x, u)| format!("{:e},{:e},{:e},{:e}\n", x[0], x[1], u[0], u[1]));
            let path = folder.path().join(format!("{k}.csv"));
            std::fs::write(&path, format!("x,y,ux,uy\n{}", rows.collect::<String>())).unwrap();
            path
        };
        let files: Vec<PathBuf> = fields.iter().enumerate().map(written).collect();
        let of_files = certify(&case, &problem, &files).unwrap();
        let in_memory = of_fields(&case, &problem, &fields, None).unwrap();
        assert!(in_memory.bound().is_some());
        assert_eq!(summary(&case, &of_files), summary(&case, &in_memory));
        assert_eq!(in_memory.missed_support, None);
        // Pressures of the nodes that are not in contact do not count.
        let mut pressure = vec![f64::MAX; fields[0].len()];
        let pair = &problem.contacts[0];
        for node in pair.interface.pairs() {
            pressure[node.nodes[0].index()] = 0.0;
        }
        let without = of_fields(&case, &problem, &fields, Some(&[pressure])).unwrap();
        assert!(without.estimate.unchecked().e_cre > in_memory.estimate.unchecked().e_cre);
    }

    #[test]
    fn fields_of_other_lengths_are_refused() {
        let (case, problem, mut fields) = solved();
        let said = |fields: &[Vec<Vector>], pressures: Option<&[Vec<f64>]>| {
            of_fields(&case, &problem, fields, pressures).unwrap_err().message.unwrap()
        };
        assert!(said(&fields[..1], None).starts_with("fields of displacements: found 1, and the case has 2"));
        assert!(said(&fields, Some(&[])).starts_with("pressures: found 0, and the case has 1"));
        let short = said(&fields, Some(&[vec![0.0; 3]]));
        assert!(
            short.starts_with("pressures of the pair \"upper-lower\": found 3, and the case has 190"),
            "{short}"
        );
        fields[1].pop();
        assert!(
            said(&fields, None)
                .starts_with("displacements of body \"lower\": found 189, and the case has 190")
        );
    }

    /// Random numbers from 0 to 1.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn pick<T: Copy>(&mut self, all: &[T]) -> T {
            all[((self.next() * all.len() as f64) as usize).min(all.len() - 1)]
        }
    }

    /// Two blocks under pressure whose meshes do not match: nodes of both are moved so that they do. The exact solution is linear.
    fn unmatched() -> (Case, ContactProblem, Vec<Body>, PathBuf) {
        let folder =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/cases/true_numbers/certify-snap");
        let case = crate::run::read_case(&folder.join("case.toml"), &[]).unwrap().into_plane().unwrap();
        let problem = case.build().unwrap().0;
        let bodies = case.build_bodies().unwrap();
        (case, problem, bodies, folder)
    }

    fn exact(bodies: &[Body]) -> Vec<Vec<Vector>> {
        let at = |x: &Vector| Vector::new(0.0039 * x[0], -0.0091 * x[1]);
        bodies.iter().map(|body| body.mesh().points().iter().map(at).collect()).collect()
    }

    /// The energy norm of the error of fields on the meshes of the case.
    fn true_error(bodies: &[Body], fields: &[Vec<Vector>]) -> f64 {
        let all = bodies.iter().zip(fields).zip(exact(bodies));
        let squared = all.map(|((body, u), v)| fem_core::norm::energy_distance_squared(body, u, &v));
        squared.sum::<f64>().sqrt()
    }

    #[test]
    fn the_bound_is_for_the_field_of_the_file_though_nodes_are_moved() {
        let (case, problem, bodies, folder) = unmatched();
        let files = ["u.csv", "l.csv"].map(|name| folder.join(name));
        let fields: Vec<Vec<Vector>> = files
            .iter()
            .zip(&bodies)
            .map(|(file, body)| matched(&read(file).unwrap(), body.mesh()).ok().unwrap().field)
            .collect();
        let truth = true_error(&bodies, &fields);
        assert!((truth - 1.592).abs() < 1e-3, "{truth}");
        let found = certify(&case, &problem, &files).unwrap();
        let bound = found.bound().unwrap();
        assert!(bound >= truth && bound < 1.5 * truth, "{bound} {truth}");
        // Without the change of the field there would be no bound.
        assert!(found.estimate.unchecked().e_cre < truth && found.change > 0.0, "{}", found.change);
    }

    #[test]
    fn no_field_and_no_pressure_gets_a_false_bound() {
        let (case, problem, bodies, _) = unmatched();
        let mut random = Random(7);
        let mut valid = 0;
        for k in 0..60 {
            let amplitude = random.pick(&[0.0, 1e-9, 1e-5, 1e-3, 0.03, 10.0]);
            let keeps_supports = k % 4 != 0;
            let mut fields = exact(&bodies);
            for (field, body) in fields.iter_mut().zip(&bodies) {
                for (u, x) in field.iter_mut().zip(body.mesh().points()) {
                    let free = [x[0] > 0.0 || !keeps_supports, x[1] > 0.0 || !keeps_supports];
                    for c in (0..2).filter(|c| free[*c]) {
                        u[c] += amplitude * (random.next() - 0.5);
                    }
                }
            }
            let size = random.pick(&[0.0, 1e-3, 10.0, 1e6]);
            let kind = random.pick(&[0, 1, 2, 3]);
            let nodes = bodies[0].mesh().points().len();
            let pressures: Vec<f64> = (0..nodes).map(|_| size * (random.next() - 0.3)).collect();
            let given = [vec![10.0; nodes], pressures];
            let given = (kind > 0).then(|| &given[usize::from(kind > 1)..][..1]);
            let found = of_fields(&case, &problem, &fields, given).unwrap();
            let truth = true_error(&bodies, &fields);
            if let Some(bound) = found.bound() {
                assert!(bound >= truth, "{k}: amplitude {amplitude}, kind {kind}: {bound} {truth}");
                valid += 1;
            }
        }
        assert!(valid >= 30, "{valid}");
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let (case, problem, bodies, _) = unmatched();
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            let mut fields = exact(&bodies);
            let mut pressure = vec![10.0; fields[0].len()];
            let side = bodies[0].mesh().group("u_bottom").unwrap()[1];
            pressure[bodies[0].mesh().topology().facets()[side][0].index()] = bad;
            let found = of_fields(&case, &problem, &fields, Some(&[pressure]));
            // A finite pressure is brought into balance.
            let sound = found.as_ref().is_ok_and(|found| found.bound().is_none_or(f64::is_finite));
            assert!(found.is_err() || (bad == 1e300 && sound), "{bad}");
            fields[1][7][0] = bad;
            assert!(of_fields(&case, &problem, &fields, None).is_err(), "{bad}");
        }
    }

    #[test]
    fn damaged_tables_are_refused_or_bounded() {
        let (case, problem, _, folder) = unmatched();
        let temp = tempfile::tempdir().unwrap();
        let [upper, lower] =
            ["u.csv", "l.csv"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
        let files = ["u.csv", "l.csv"].map(|name| temp.path().join(name));
        std::fs::write(&files[1], lower).unwrap();
        let mut random = Random(3);
        for _ in 0..80 {
            let mut lines: Vec<Vec<String>> =
                upper.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
            let at = 1 + (random.next() * (lines.len() - 1) as f64) as usize;
            let column = random.pick(&[0, 1, 2, 3]);
            let bad = ["nan", "inf", "1e308", "-1e308", "5e-324", "1e300", "9e999", "-0", "", "0x1", "1e17"];
            let added = if random.next() < 0.5 { at } else { lines.len() };
            let mut line = lines[at].clone();
            line[column] = random.pick(&bad).to_owned();
            lines.insert(added, line);
            let text: Vec<String> = lines.iter().map(|cells| cells.join(",")).collect();
            std::fs::write(&files[0], text.join("\n")).unwrap();
            if let Ok(found) = certify(&case, &problem, &files) {
                assert!(found.bound().is_none_or(|bound| bound >= 1.592), "{}", lines[added].join(","));
            }
        }
    }
}
