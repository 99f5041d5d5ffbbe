//! What a run leaves on disk.

use crate::failure::Failure;
use crate::figures;
use crate::html;
use crate::paraview;
use crate::report::contact_rows;
use crate::run::Solved;
use case_io::Case;
use case_io::output::OutputDirectory;
use case_io::report::Report;
use case_io::table;

/// Writes tables, pictures, ParaView files and the page; everything but report.json.
pub(crate) fn write(
    case: &Case,
    solved: &Solved,
    report: &Report,
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    let mut put =
        |name: &str, text: &str| directory.write(name, text.as_bytes()).map_err(|e| Failure::output(&e));
    put("history.csv", &table::history_csv(&report.iterations)?)?;
    let solution = &solved.solution;
    let contact = contact_rows(solution);
    if solution.estimate.is_some() {
        put("contact.csv", &table::contact_csv(&contact)?)?;
    }
    if !report.adaptive.is_empty() {
        put("adaptive.csv", &table::adaptive_csv(&report.adaptive)?)?;
    }
    let pictures = figures::of_solve(case, solution, &contact, &report.adaptive)?;
    for picture in &pictures {
        put(&format!("figures/{}.svg", picture.name), &picture.svg)?;
    }
    let angles = [0, 1].map(|b| solution.problem.bodies[b].mesh().smallest_angle());
    put("report.html", &html::page(case, report, angles, &pictures))?;
    if case.output.vtu && solution.estimate.is_some() {
        paraview::write(case, solution, &report.adaptive, directory)?;
    }
    Ok(())
}
