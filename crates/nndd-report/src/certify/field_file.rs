//! The field of a file: read, found near the bodies, brought onto a mesh of the case.

use super::matched::{Matched, Mismatch, matched};
use crate::failure::{FILES, Failure, INVALID_INPUT};
use crate::space::ReportSpace;
use case_io::Case;
use fem_core::geometry::{Point, bounding_box, diagonal, shown};
use fem_core::mesh::Mesh;
use fem_core::mesh::id::NodeId;
use mesh_io::vtu::{FieldError, PointVectors};
use mesh_io::{FIELD_COLUMNS, read_point_vectors};
use std::path::Path;

/// A point is far from all bodies if it is outside of their common box by this fraction of its diagonal.
const FAR: f64 = 0.01;
/// Names of the array of displacements, in the order in which they are looked for.
const NAMES: [&str; 6] = ["displacement", "displacements", "disp", "u", "U", "Displacement"];

/// Matches the field of a file to the mesh of the case or, if that fails, to the refined mesh of the problem, on which
/// a run of this program writes its fields.
pub(super) fn field_of<'a, S: ReportSpace>(
    case: &Case<S>,
    b: usize,
    file: &Path,
    read: &PointVectors<S>,
    [own, refined]: [&'a Mesh<S>; 2],
) -> Result<Matched<'a, S>, Failure> {
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
            let place = Point::from(own.points()[NodeId::new(node)]);
            Err(Failure::invalid(format!(
                "{}: body \"{}\" has a node at {place}, and the nearest point of the file is {} away\n  expected: a point at \
                 every node of the mesh of the case\n  fix: write the field on the same mesh, in the same units, and give the files in the order of the bodies",
                file.display(),
                case.bodies[b].name,
                shown(nearest)
            )))
        }
    }
}

/// Refuses points that are far from all bodies: damaged lines, other units.
pub(super) fn refuse_far<S: ReportSpace>(
    file: &Path,
    read: &PointVectors<S>,
    meshes: &[Mesh<S>],
) -> Result<(), Failure> {
    let ends: Vec<S::Vector> = meshes.iter().flat_map(|mesh| bounding_box(mesh.points())).collect();
    let [low, high] = bounding_box(&ends);
    let margin = FAR * diagonal(&ends);
    let is_far = |p: &S::Vector| (0..S::DIM).any(|k| !(p[k] >= low[k] - margin && p[k] <= high[k] + margin));
    let Some(k) = read.points.iter().position(is_far) else { return Ok(()) };
    let place = read.lines.get(k).map_or_else(|| format!("point {k}"), |line| format!("line {line}"));
    Err(Failure::invalid(format!(
        "{}: {place}: the point {} is far from all bodies\n  expected: points of the meshes of the case\n  fix: mend the line, \
         or write the points in the units of the case",
        file.display(),
        Point::from(read.points[k])
    )))
}

/// Makes the failure for a file whose value at a point is not interpolated from the nodes of the mesh.
fn other_field<S: ReportSpace>(case: &Case<S>, b: usize, file: &Path, point: S::Vector) -> Failure {
    Failure::invalid(format!(
        "{}: the value at the point {} is not that of a linear field between the nodes of the mesh of body \"{}\"\n  expected: \
             one value per node of the mesh of the case, and no points between them with other values\n  fix: write one file per body, on \
             the mesh of the case; of quadratic elements keep the corner nodes",
        file.display(),
        Point::from(point),
        case.bodies[b].name
    ))
}

/// Reads a `.vtu` file, or a table with the columns x, y, ux, uy, in space also z and uz.
pub(super) fn read<S: ReportSpace>(file: &Path) -> Result<PointVectors<S>, Failure> {
    read_point_vectors(file, &NAMES).map_err(|error| {
        let (code, fix) = match &error {
            FieldError::Unreadable { .. } => (FILES, "check its name"),
            FieldError::Line { .. } => (INVALID_INPUT, "mend the line"),
            _ => (INVALID_INPUT, "write it again, for instance with meshio"),
        };
        let columns = [0, 1].into_iter().flat_map(|of| (0..S::DIM).map(move |c| FIELD_COLUMNS[c][of]));
        let said = format!(
            "{}: {error}\n  expected: a .vtu file with the array `displacement` at its points, or a .csv file with the columns {}\n  \
             fix: {fix}",
            file.display(),
            columns.collect::<Vec<_>>().join(", ")
        );
        Failure::plain(code, said)
    })
}
