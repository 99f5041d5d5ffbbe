//! Looks at a solution in memory: the arrays that the tables and the ParaView files have, and the figures.

use crate::body_fields::{AT_POINTS, BodyFields, IN_CELLS};
use crate::figures::NamedRows;
use crate::paraview;
use crate::paths;
use crate::report;
use crate::solved::Solved;
use crate::space::ReportSpace;
use case_io::Case;
use case_io::report::Report;
use case_io::table::{ContactRow, PathRow};
use fem_core::interface::ContactProblem;
use mesh_io::vtu::{VtuArray, VtuData, VtuMesh};
use serde_json::Value;

pub use crate::figures::Picture;

/// Names of the fields of a body at its nodes.
pub const POINT_FIELDS: [&str; 4] = AT_POINTS;
/// Names of the fields of a body in its cells.
pub const CELL_FIELDS: [&str; 10] = IN_CELLS;

/// Returns the problem on the last mesh.
pub fn problem<S: ReportSpace>(solved: &Solved<S>) -> &ContactProblem<S> {
    solved.answer.fields().problem
}

/// Makes a field of a body, as its file for ParaView has it; `None` without an estimate, and if it is unknown.
///
/// * `body`: its number in the case file, from 0.
/// * `name`: one of [`POINT_FIELDS`] and [`CELL_FIELDS`].
pub fn field<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    body: usize,
    name: &str,
) -> Option<VtuArray> {
    let solution = &solved.answer.fields();
    BodyFields { case, solution, estimate: solution.estimate?, body }.field(name)
}

/// Makes the rows of contact.csv of a pair; no rows without an estimate.
///
/// * `pair`: its number in the case file, from 0.
pub fn contact<S: ReportSpace>(solved: &Solved<S>, pair: usize) -> Vec<ContactRow> {
    let fields = solved.answer.fields();
    fields.estimate.map(|_| report::contact_rows(&fields, pair)).unwrap_or_default()
}

/// Makes the edges or faces of a pair with all fields, as its file for ParaView has them; `None` without an estimate.
///
/// * `pair`: its number in the case file, from 0.
pub fn contact_grid<S: ReportSpace>(solved: &Solved<S>, pair: usize) -> Option<(VtuMesh, VtuData)> {
    let fields = solved.answer.fields();
    fields.estimate.map(|estimate| paraview::contact_data(&fields, estimate, pair))
}

/// Draws the figures, in the order of the page.
pub fn pictures<S: ReportSpace>(case: &Case<S>, solved: &Solved<S>, report: &Report) -> Vec<Picture> {
    let fields = &solved.answer.fields();
    let pairs = case.contacts.iter().enumerate();
    let contact: Vec<(&str, Vec<ContactRow>)> =
        pairs.map(|(k, pair)| (pair.name.as_str(), report::contact_rows(fields, k))).collect();
    drawn(case, solved, report, &contact, &paths::all(case, fields))
}

/// Draws the figures from the rows of contact.csv and of the paths.
pub(crate) fn drawn<S: ReportSpace>(
    case: &Case<S>,
    solved: &Solved<S>,
    report: &Report,
    contact: &NamedRows<'_>,
    paths: &[Vec<PathRow>],
) -> Vec<Picture> {
    let seen: Vec<Value> = solved.steps.iter().filter_map(|step| step.view.clone()).collect();
    let mut pictures = S::pictures(case, &solved.answer.fields(), (contact, &seen), report);
    pictures.extend(paths::pictures(case, paths));
    pictures
}
