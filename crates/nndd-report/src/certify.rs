//! Certificates of displacements that another code computed, read from files or in memory.

use crate::convert;
use crate::failure::{FILES, Failure, INVALID_INPUT};
use case_io::Case;
use certified_contact::SolveError;
use cre_estimator::{FieldCertificate, Relaxation};
use fem_core::body::Body;
use fem_core::geometry::{Vector, cross, diagonal, norm, shown};
use fem_core::interface::ContactProblem;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::prepared::PreparedProblem;
use mesh_io::vtu::{PointVectors, point_vectors};
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Points closer than this fraction of the body's diagonal are the same.
const SAME: f64 = 1e-6;
/// A field is linear between its nodes up to this fraction of its largest value: numbers are written with few digits.
const LINEAR: f64 = 1e-4;
/// Names of the array of displacements, in the order in which they are looked for.
const NAMES: [&str; 6] = ["displacement", "displacements", "disp", "u", "U", "Displacement"];

/// Certifies displacements of other codes.
///
/// * `problem`: that of the case; `files`: one per body, in the order of the case file.
///
/// # Errors
/// Files that cannot be read, fields that do not have a value at every node of the meshes, a problem without a unique solution.
pub fn certify(case: &Case, problem: ContactProblem, files: &[PathBuf]) -> Result<FieldCertificate, Failure> {
    if files.len() != case.bodies.len() {
        let (found, expected) = (files.len(), case.bodies.len());
        return Err(Failure::command_line(format!(
            "{found} files of displacements are given, and the case has {expected} bodies\n  expected: one file per body, in the \
             order of the case file\n  fix: write `--displacement A.vtu B.vtu …`"
        )));
    }
    refuse_friction(case)?;
    let bodies = case.build_bodies()?;
    let mut fields = Vec::with_capacity(files.len());
    for (b, (file, body)) in files.iter().zip(&bodies).enumerate() {
        let read = read(file)?;
        // Such as the files of a run of this program, on meshes that were made to match.
        let refined = problem.bodies[b].mesh();
        if refined.points().len() > body.mesh().points().len()
            && let Ok(field) = at_nodes(&read, refined)
        {
            check_others(&read, refined, &field).map_err(|point| other_field(case, b, file, point))?;
            fields.push(field);
            continue;
        }
        let own = at_nodes(&read, body.mesh()).map_err(|(node, nearest)| {
            let [x, y] = body.mesh().points()[node].into();
            Failure::invalid(format!(
                    "{}: body \"{}\" has a node at ({}, {}), and the nearest point of the file is {} away\n  expected: a point at \
                     every node of the mesh of the case\n  fix: write the field on the same mesh, in the same units, and give the files in the order of the bodies",
                    file.display(),
                    case.bodies[b].name,
                    shown(x),
                    shown(y),
                    shown(nearest)
                ),
            )
        })?;
        check_others(&read, body.mesh(), &own).map_err(|point| other_field(case, b, file, point))?;
        fields.push(on_mesh(body, &own, refined));
    }
    bound(case, problem, &fields, None)
}

/// Certifies displacements in memory.
///
/// * `problem`: that of the case.
/// * `fields`: at the nodes of each body's mesh as the case describes it, Cartesian, m.
/// * `pressures`: for each pair, at the nodes of the mesh of its first body, Pa; `None`: from the equilibrium of the fields.
///
/// # Errors
/// Fields of another length than the meshes, friction, a problem without a unique solution.
pub fn of_fields(
    case: &Case,
    problem: ContactProblem,
    fields: &[Vec<Vector>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate, Failure> {
    refuse_friction(case)?;
    let bodies = case.build_bodies()?;
    let counted = |what: &str, found: usize, expected: usize| {
        let said = format!(
            "{what}: found {found}, and the case has {expected}\n  expected: as many, in the order of the case\n  fix: check the \
             lists and the meshes they belong to"
        );
        if found == expected { Ok(()) } else { Err(Failure::invalid(said)) }
    };
    counted("fields of displacements", fields.len(), bodies.len())?;
    for (field, (body, given)) in fields.iter().zip(bodies.iter().zip(&case.bodies)) {
        counted(
            &format!("displacements of body \"{}\"", given.name),
            field.len(),
            body.mesh().points().len(),
        )?;
    }
    let refined = fields.iter().zip(&bodies).zip(&problem.bodies);
    let refined: Vec<Vec<Vector>> =
        refined.map(|((field, body), refined)| on_mesh(body, field, refined.mesh())).collect();
    let Some(pressures) = pressures else { return bound(case, problem, &refined, None) };
    counted("pressures", pressures.len(), case.contacts.len())?;
    let mut at_pairs = Vec::with_capacity(pressures.len());
    for (pressure, (given, pair)) in pressures.iter().zip(case.contacts.iter().zip(&problem.contacts)) {
        let first = pair.bodies[0];
        let mesh = bodies[first].mesh();
        counted(&format!("pressures of the pair \"{}\"", given.name), pressure.len(), mesh.points().len())?;
        let as_vectors: Vec<Vector> = pressure.iter().map(|p| Vector::new(*p, 0.0)).collect();
        let field = on_mesh(&bodies[first], &as_vectors, problem.bodies[first].mesh());
        at_pairs.push(pair.interface.pairs().iter().map(|p| field[p.nodes[0]][0]).collect());
    }
    bound(case, problem, &refined, Some(&at_pairs))
}

fn refuse_friction(case: &Case) -> Result<(), Failure> {
    let Some(pair) = case.contacts.iter().find(|contact| contact.friction.is_some()) else { return Ok(()) };
    Err(Failure::invalid(format!(
        "the pair \"{}\" has friction, and displacements of other programs are certified without friction only\n  expected: \
         pairs without friction\n  fix: solve the case with nndd",
        pair.name
    )))
}

/// * `fields`: at the nodes of the problem; `pressures`: at its pairs.
fn bound(
    case: &Case,
    problem: ContactProblem,
    fields: &[Vec<Vector>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate, Failure> {
    let prepared =
        PreparedProblem::new(problem).map_err(|error| Failure::solve(case, &SolveError::Prepare(error)))?;
    let relaxation: Relaxation = convert::settings(case).relaxation;
    cre_estimator::certify(&prepared, fields, pressures, relaxation)
        .map_err(|error| Failure::solve(case, &SolveError::Estimator(error)))
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
        "energy_norm": found.estimate.energy_norm(),
        "failed_checks": checks,
        "missed_support": found.missed_support.map(|missed| json!({
            "body": case.bodies[missed.body].name,
            "point": [missed.point[0], missed.point[1]],
            "distance": missed.distance,
        })),
    })
}

/// Says that a file has another field than that of the nodes of the mesh.
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
    let fault = |code: u8, reason: String, fix: &str| {
        Failure::plain(
            code,
            format!(
                "{}: {reason}\n  expected: a .vtu file with the array `displacement` at its points, or a .csv file with the columns x, \
                 y, ux, uy\n  fix: {fix}",
                file.display()
            ),
        )
    };
    if let Err(error) = std::fs::metadata(file) {
        return Err(fault(FILES, format!("cannot be read: {error}"), "check its name"));
    }
    let is_table = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if is_table {
        let text = std::fs::read_to_string(file);
        let text =
            text.map_err(|error| fault(FILES, format!("cannot be read: {error}"), "check the file"))?;
        return table(&text).map_err(|reason| fault(INVALID_INPUT, reason, "mend the line"));
    }
    point_vectors(file, &NAMES)
        .map_err(|error| fault(INVALID_INPUT, error.to_string(), "write it again, for instance with meshio"))
}

/// Reads a table with a head; other columns are left out.
fn table(text: &str) -> Result<PointVectors, String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, head) = lines.next().ok_or("the file is empty")?;
    let names: Vec<String> =
        head.split(',').map(|name| name.trim().trim_matches('"').to_lowercase()).collect();
    let mut columns = [0; 4];
    for (column, wanted) in columns.iter_mut().zip(["x", "y", "ux", "uy"]) {
        let found = names.iter().position(|name| name == wanted);
        *column = found.ok_or_else(|| format!("line 1 has no column {wanted}"))?;
    }
    let mut read = PointVectors::default();
    for (k, line) in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let mut numbers = [0.0; 4];
        for (number, column) in numbers.iter_mut().zip(columns) {
            let text = cells.get(column).map_or("", |cell| cell.trim());
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            *number = value.ok_or_else(|| format!("line {}: \"{text}\" is not a finite number", k + 1))?;
        }
        read.points.push(Vector::new(numbers[0], numbers[1]));
        read.values.push(Vector::new(numbers[2], numbers[3]));
    }
    Ok(read)
}

/// Points by their places on a grid that is coarser than the tolerance.
struct Places<'a> {
    points: &'a [Vector],
    size: f64,
    by_cell: HashMap<[i64; 2], Vec<u32>>,
}

impl<'a> Places<'a> {
    fn new(points: &'a [Vector], size: f64) -> Self {
        let mut by_cell: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        for (k, point) in points.iter().enumerate() {
            by_cell.entry(Self::cell(*point, size)).or_default().push(k as u32);
        }
        Self { points, size, by_cell }
    }

    fn cell(point: Vector, size: f64) -> [i64; 2] {
        [(point[0] / size).floor() as i64, (point[1] / size).floor() as i64]
    }

    /// Finds the nearest point within the tolerance.
    fn at(&self, point: Vector) -> Option<usize> {
        let [i, j] = Self::cell(point, self.size);
        let cells = (-1..=1).flat_map(|a| (-1..=1).map(move |b| [i + a, j + b]));
        let near = cells.filter_map(|cell| self.by_cell.get(&cell)).flatten().map(|k| *k as usize);
        let distance = |k: &usize| norm(self.points[*k] - point);
        near.filter(|k| distance(k) <= self.size).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

fn tolerance(mesh: &TriMesh) -> f64 {
    SAME * diagonal(mesh.points())
}

/// Takes the value at every node of a mesh, or the first node without one, and its distance from the nearest point.
fn at_nodes(read: &PointVectors, mesh: &TriMesh) -> Result<Vec<Vector>, (usize, f64)> {
    let places = Places::new(&read.points, tolerance(mesh));
    let value = |(node, point): (usize, &Vector)| match places.at(*point) {
        Some(k) => Ok(read.values[k]),
        None => {
            let nearest = read.points.iter().map(|p| norm(p - point)).fold(f64::INFINITY, f64::min);
            Err((node, nearest))
        }
    };
    mesh.points().iter().enumerate().map(value).collect()
}

/// Checks that all points of a file have the values of a field of a mesh; points outside the mesh are left out. Else another field
/// than that of the file would be certified. Returns the first other point.
fn check_others(read: &PointVectors, mesh: &TriMesh, field: &[Vector]) -> Result<(), Vector> {
    let nodes = Places::new(mesh.points(), tolerance(mesh));
    let cells = Cells::new(mesh);
    let largest = field.iter().fold(0.0f64, |m, u| m.max(u.amax()));
    for (point, value) in read.points.iter().zip(&read.values) {
        let expected = match nodes.at(*point) {
            Some(node) => Some(field[node]),
            None => cells.around(*point).map(|(nodes, weights)| {
                nodes.iter().zip(weights).map(|(n, w)| w * field[*n]).sum::<Vector>()
            }),
        };
        if expected.is_some_and(|expected| !((value - expected).amax() <= LINEAR * largest)) {
            return Err(*point);
        }
    }
    Ok(())
}

/// The triangles of a mesh by the squares of a grid that they may meet.
struct Cells<'a> {
    mesh: &'a TriMesh,
    size: f64,
    by_square: HashMap<[i64; 2], Vec<u32>>,
}

impl<'a> Cells<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let size = diagonal(mesh.points()) / (mesh.triangles().len() as f64).sqrt();
        let mut by_square: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        for t in 0..mesh.triangles().len() {
            let corners = mesh.corners(t);
            let low = corners.into_iter().reduce(|a, b| a.inf(&b)).unwrap_or_default();
            let high = corners.into_iter().reduce(|a, b| a.sup(&b)).unwrap_or_default();
            let [from, to] = [low, high].map(|corner| Places::cell(corner, size));
            for i in from[0]..=to[0] {
                for j in from[1]..=to[1] {
                    by_square.entry([i, j]).or_default().push(t as u32);
                }
            }
        }
        Self { mesh, size, by_square }
    }

    /// Finds a triangle that contains a point: its nodes and their weights.
    fn around(&self, point: Vector) -> Option<([NodeId; 3], [f64; 3])> {
        let near = self.by_square.get(&Places::cell(point, self.size))?;
        near.iter().find_map(|t| {
            let weights = weights(self.mesh, *t as usize, point);
            let inside = weights.iter().all(|w| *w >= -SAME);
            inside.then(|| (self.mesh.triangles()[*t as usize], weights))
        })
    }
}

/// Computes the weights of the corners of a triangle at a point.
fn weights(mesh: &TriMesh, t: usize, point: Vector) -> [f64; 3] {
    let [a, b, c] = mesh.corners(t);
    let whole = cross(b - a, c - a);
    let (s, r) = (cross(point - a, c - a) / whole, cross(b - a, point - a) / whole);
    [1.0 - s - r, s, r]
}

/// Evaluates a field of a body's mesh at the nodes of the mesh that a common refinement made of it.
fn on_mesh(body: &Body, field: &[Vector], refined: &TriMesh) -> Vec<Vector> {
    let mesh = body.mesh();
    if mesh.points() == refined.points() {
        return field.to_vec();
    }
    let places = Places::new(mesh.points(), tolerance(mesh));
    let at =
        |point: &Vector| places.at(*point).map_or_else(|| interpolated(mesh, field, *point), |k| field[k]);
    refined.points().iter().map(at).collect()
}

/// Evaluates a field in the triangle that contains a point, or is nearest to it.
fn interpolated(mesh: &TriMesh, field: &[Vector], point: Vector) -> Vector {
    let mut best = (f64::NEG_INFINITY, Vector::zeros());
    for (t, nodes) in mesh.triangles().iter().enumerate() {
        let weights = weights(mesh, t, point);
        let least = weights.into_iter().fold(f64::INFINITY, f64::min);
        if least > best.0 {
            let value = nodes.iter().zip(weights).map(|(n, w)| w * field[*n]).sum();
            best = (least, value);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::mesh::generate::block;

    /// The paper's problem, and its displacements.
    fn solved() -> (Case, ContactProblem, Vec<Vec<Vector>>) {
        let mut case = Case::parse(case_io::template::PAPER, "paper.toml", &[]).unwrap();
        let problem = case.build_problem().unwrap();
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
        let of_files = certify(&case, problem.clone(), &files).unwrap();
        let in_memory = of_fields(&case, problem.clone(), &fields, None).unwrap();
        assert!(in_memory.bound().is_some());
        assert_eq!(summary(&case, &of_files), summary(&case, &in_memory));
        assert_eq!(in_memory.missed_support, None);
        // Pressures of the nodes that are not in contact do not count.
        let mut pressure = vec![f64::MAX; fields[0].len()];
        let pair = &problem.contacts[0];
        for node in pair.interface.pairs() {
            pressure[node.nodes[0].index()] = 0.0;
        }
        let without = of_fields(&case, problem, &fields, Some(&[pressure])).unwrap();
        assert!(without.estimate.unchecked().e_cre > in_memory.estimate.unchecked().e_cre);
    }

    #[test]
    fn fields_of_other_lengths_are_refused() {
        let (case, problem, mut fields) = solved();
        let said = |fields: &[Vec<Vector>], pressures: Option<&[Vec<f64>]>| {
            of_fields(&case, problem.clone(), fields, pressures).unwrap_err().message.unwrap()
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

    #[test]
    fn a_table_names_the_line_of_a_fault() {
        for end in ["\n", "\r\n"] {
            let rows = ["node, X ,\"Y\",ux,uy", "1,0,1,2,3", "", "2,1,1e0, 5,7"].join(end);
            let found = table(&rows).unwrap();
            assert_eq!(found.points, [Vector::new(0.0, 1.0), Vector::new(1.0, 1.0)]);
            assert_eq!(found.values, [Vector::new(2.0, 3.0), Vector::new(5.0, 7.0)]);
            let fault = table(&format!("{rows}{end}{end}3,0,0,0,inf{end}")).unwrap_err();
            assert_eq!(fault, "line 6: \"inf\" is not a finite number", "{end:?}");
        }
    }

    #[test]
    fn points_that_are_no_nodes_must_have_the_values_of_the_field() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
        let field: Vec<Vector> = mesh.points().iter().map(|x| Vector::new(x[0] * x[1], 1.0 - x[0])).collect();
        let mut read = PointVectors { points: mesh.points().to_vec(), values: field.clone() };
        check_others(&read, &mesh, &field).unwrap();
        // In the middle of an edge the field is linear; outside of the body there may be anything.
        read.points.extend([Vector::new(0.25, 0.0), Vector::new(3.0, 0.5)]);
        read.values.extend([Vector::new(0.0, 0.75), Vector::new(9.0, 9.0)]);
        check_others(&read, &mesh, &field).unwrap();
        // A node twice with two values, as on a contact line of two bodies in one file; a node of a finer or a quadratic mesh.
        for (point, value) in [([2.0, 1.0], [2.0, 0.0]), ([0.25, 0.25], [0.07, 0.75])] {
            read.points.push(point.into());
            read.values.push(value.into());
            assert_eq!(check_others(&read, &mesh, &field), Err(point.into()));
            read.points.pop();
            read.values.pop();
        }
    }
}
