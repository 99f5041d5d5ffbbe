//! Looks at a solution in memory: the arrays that the tables and the ParaView files have.

use crate::body_fields::{AT_POINTS, BodyFields, IN_CELLS};
use crate::report;
use crate::solved::Solved;
use case_io::Case;
use case_io::table::ContactRow;
use fem_core::interface::ContactProblem;
use mesh_io::vtu::VtuArray;

/// Names of the fields of a body at its nodes.
pub const POINT_FIELDS: [&str; 4] = AT_POINTS;
/// Names of the fields of a body in its triangles.
pub const CELL_FIELDS: [&str; 10] = IN_CELLS;

/// Returns the problem on the last mesh.
pub fn problem(solved: &Solved) -> &ContactProblem {
    solved.answer.fields().problem
}

/// Makes a field of a body, as its file for ParaView has it; `None` without an estimate, and if it is unknown.
///
/// * `body`: its number in the case file, from 0.
/// * `name`: one of [`POINT_FIELDS`] and [`CELL_FIELDS`].
pub fn field(case: &Case, solved: &Solved, body: usize, name: &str) -> Option<VtuArray> {
    let solution = &solved.answer.fields();
    BodyFields { case, solution, estimate: solution.estimate?, body }.field(name)
}

/// Makes the rows of contact.csv of a pair; no rows without an estimate.
///
/// * `pair`: its number in the case file, from 0.
pub fn contact(solved: &Solved, pair: usize) -> Vec<ContactRow> {
    let fields = solved.answer.fields();
    fields.estimate.map(|_| report::contact_rows(&fields, pair)).unwrap_or_default()
}
