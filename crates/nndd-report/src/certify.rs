//! Certificates of displacements that another code computed, read from files.

use crate::convert;
use crate::failure::{FILES, Failure, INVALID_INPUT};
use case_io::Case;
use certified_contact::SolveError;
use cre_estimator::{FieldCertificate, Relaxation};
use fem_core::body::Body;
use fem_core::geometry::{Vector, cross, diagonal, norm, shown};
use fem_core::interface::ContactProblem;
use fem_core::mesh::TriMesh;
use fem_core::prepared::PreparedProblem;
use mesh_io::vtu::{PointVectors, point_vectors};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Points closer than this fraction of the body's diagonal are the same.
const SAME: f64 = 1e-6;
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
    if let Some(pair) = case.contacts.iter().find(|contact| contact.friction.is_some()) {
        return Err(Failure::plain(
            INVALID_INPUT,
            format!(
                "the pair \"{}\" has friction, and displacements of other programs are certified without friction only\n  expected: \
                 pairs without friction\n  fix: solve the case with nndd",
                pair.name
            ),
        ));
    }
    let bodies = case.build_bodies()?;
    let mut fields = Vec::with_capacity(files.len());
    for (b, (file, body)) in files.iter().zip(&bodies).enumerate() {
        let read = read(file)?;
        // Such as the files of a run of this program, on meshes that were made to match.
        let refined = problem.bodies[b].mesh();
        if refined.points().len() > body.mesh().points().len()
            && let Ok(field) = at_nodes(&read, refined)
        {
            fields.push(field);
            continue;
        }
        let own = at_nodes(&read, body.mesh()).map_err(|(node, nearest)| {
            let [x, y] = body.mesh().points()[node].into();
            Failure::plain(
                INVALID_INPUT,
                format!(
                    "{}: body \"{}\" has a node at ({}, {}), and the nearest point of the file is {} away\n  expected: a point at \
                     every node of the mesh of the case\n  fix: write the field on the same mesh, in the same units",
                    file.display(),
                    case.bodies[b].name,
                    shown(x),
                    shown(y),
                    shown(nearest)
                ),
            )
        })?;
        fields.push(on_mesh(body, &own, refined));
    }
    let prepared =
        PreparedProblem::new(problem).map_err(|error| Failure::solve(case, &SolveError::Prepare(error)))?;
    let relaxation: Relaxation = convert::settings(case).relaxation;
    cre_estimator::certify(&prepared, &fields, None, relaxation)
        .map_err(|error| Failure::solve(case, &SolveError::Estimator(error)))
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

/// Evaluates a field of a body's mesh at the nodes of the mesh that a common refinement made of it.
fn on_mesh(body: &Body, field: &[Vector], refined: &TriMesh) -> Vec<Vector> {
    let mesh = body.mesh();
    let places = Places::new(mesh.points(), tolerance(mesh));
    let at =
        |point: &Vector| places.at(*point).map_or_else(|| interpolated(mesh, field, *point), |k| field[k]);
    refined.points().iter().map(at).collect()
}

/// Evaluates a field in the triangle that contains a point, or is nearest to it.
fn interpolated(mesh: &TriMesh, field: &[Vector], point: Vector) -> Vector {
    let mut best = (f64::NEG_INFINITY, Vector::zeros());
    for (t, nodes) in mesh.triangles().iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let whole = cross(b - a, c - a);
        let (s, r) = (cross(point - a, c - a) / whole, cross(b - a, point - a) / whole);
        let weights = [1.0 - s - r, s, r];
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
}
