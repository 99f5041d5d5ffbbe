//! The figures of a run, drawn by [`crate::plot`].

use crate::failure::Failure;
use crate::plot::{self, BodyPicture, ContactProfile, ConvergenceRow, PlotError};
use case_io::Case;
use case_io::report::AdaptiveRow;
use case_io::table::ContactRow;
use certified_contact::CertifiedSolution;

/// A named figure.
pub(crate) struct Picture {
    pub(crate) name: &'static str,
    pub(crate) svg: String,
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Self::defect(format!("a figure could not be drawn: {error}"))
    }
}

/// Computes the error density (squared error over area) in the triangles of a body, by its role.
pub(crate) fn error_density(solution: &CertifiedSolution, role: usize) -> Vec<f64> {
    let mesh = solution.problem.bodies[role].mesh();
    let Some(estimate) = &solution.estimate else { return vec![0.0; mesh.triangles().len()] };
    estimate.cre.by_cell[role].iter().enumerate().map(|(t, e)| e / mesh.area(t)).collect()
}

/// Draws the figures of a solve.
pub(crate) fn of_solve(
    case: &Case,
    solution: &CertifiedSolution,
    contact: &[ContactRow],
    steps: &[AdaptiveRow],
) -> Result<Vec<Picture>, Failure> {
    let rows: Vec<ConvergenceRow> = solution
        .rows
        .iter()
        .map(|row| ConvergenceRow {
            iteration: row.iteration.iteration,
            eta_nndd: row.iteration.eta_nndd,
            precision: row.iteration.precision,
            eta_dis: row.eta_dis,
            e_cre: row.e_cre,
        })
        .collect();
    let name = if case.title.is_empty() { case.file_name() } else { &case.title };
    let mut pictures = vec![Picture {
        name: "convergence",
        svg: plot::convergence(&format!("{name}: errors against the iteration"), &rows)?,
    }];
    if let Some(adapt) = &case.adapt {
        let steps: Vec<_> = steps.iter().map(|row| (row.nodes, row.relative)).collect();
        let title = format!("{name}: certified error against the number of nodes");
        pictures.push(Picture {
            name: "adaptive",
            svg: plot::adaptive(&title, &steps, adapt.target_relative_error)?,
        });
    }
    let Some(estimate) = &solution.estimate else { return Ok(pictures) };
    let densities = [0, 1].map(|role| error_density(solution, role));
    let bodies = [0, 1].map(|b| {
        let role = solution.role(b);
        let mesh = solution.problem.bodies[role].mesh();
        BodyPicture {
            name: &case.bodies[b].name,
            points: mesh.points(),
            triangles: mesh.triangles(),
            displacement: &estimate.pair.displacement[role],
            density: &densities[role],
        }
    });
    pictures
        .push(Picture { name: "deformed", svg: plot::deformed(&format!("{name}: error density"), &bodies)? });
    let column = |of: fn(&ContactRow) -> f64| contact.iter().map(of).collect::<Vec<f64>>();
    let (s, opening, pressure) = (column(|r| r.s), column(|r| r.gap), column(|r| r.pressure));
    let profile = ContactProfile { s: &s, opening: &opening, pressure: &pressure };
    pictures
        .push(Picture { name: "contact", svg: plot::contact(&format!("{name}: contact line"), &profile)? });
    Ok(pictures)
}
