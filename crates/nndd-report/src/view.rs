//! Looks at a solution in memory: the arrays that the tables and the ParaView files have.

use crate::paraview;
use crate::report;
use crate::solved::Solved;
use case_io::Case;
use case_io::table::ContactRow;
use fem_core::interface::ContactProblem;
use mesh_io::vtu::{VtuData, VtuMesh};

/// Returns the problem on the last mesh.
pub fn problem(solved: &Solved) -> &ContactProblem {
    solved.answer.fields().problem
}

/// Makes mesh and fields of a body, those of its file for ParaView; `None` without an estimate.
///
/// * `body`: its number in the case file, from 0.
pub fn body(case: &Case, solved: &Solved, body: usize) -> Option<(VtuMesh, VtuData)> {
    let fields = solved.answer.fields();
    Some(paraview::body_data(case, &fields, fields.estimate?, body))
}

/// Makes the rows of contact.csv of a pair; there are none without an estimate.
///
/// * `pair`: its number in the case file, from 0.
pub fn contact(solved: &Solved, pair: usize) -> Vec<ContactRow> {
    let fields = solved.answer.fields();
    fields.estimate.map(|_| report::contact_rows(&fields, pair)).unwrap_or_default()
}
