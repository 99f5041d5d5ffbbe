//! The files of a certificate of another code's field.

use super::{summary, verdict};
use crate::failure::{Failure, NOT_CERTIFIED};
use crate::figures::Picture;
use crate::html;
use crate::paraview::write_vtu;
use crate::plot::{self, BodyPicture, Field, Labels, Quantity};
use crate::space::ReportSpace;
use case_io::Case;
use case_io::output::{OutputDirectory, ResultKind};
use case_io::report::{CASE_HASH, SCHEMA};
use cre_estimator::FieldCertificate;
use fem_core::interface::ContactProblem;
use mesh_io::vtu::{VtuArray, VtuData, VtuMesh};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Writes report.json, report.html with a map of the error, of solids with tables, and a `.vtu` file of each body with the error density and the admissible field.
/// Returns the names of the files.
///
/// * `problem`, `notes`: see [`crate::run::build_last`]; `files`: with the field; `path`: the directory, which may hold something else if `force` is
///   given.
///
/// # Errors
/// Files that cannot be written, a directory with another result.
pub fn write<S: ReportSpace>(
    case: &Case<S>,
    (problem, notes): (&ContactProblem<S>, &[String]),
    found: &FieldCertificate<S>,
    files: &[PathBuf],
    (path, force): (&Path, bool),
) -> Result<Vec<String>, Failure> {
    let named: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    // The mark tells this directory from the directories of other fields and of a solve.
    let mark = format!("certify {named:?} {}", case.hash());
    let mut directory = OutputDirectory::open(path, ResultKind::Solve, &mark, force)?;
    let densities: Vec<Vec<f64>> = (problem.bodies.iter().zip(&found.estimate.cre.by_cell))
        .map(|(body, cells)| cells.iter().enumerate().map(|(t, e)| e / body.mesh().measure(t)).collect())
        .collect();
    for (b, density) in densities.iter().enumerate() {
        let displacement = &found.estimate.pair.bodies[b].displacement;
        let data = VtuData {
            point: vec![VtuArray::vectors("displacement", displacement)],
            cell: vec![VtuArray::scalars("error_density", density.clone())],
            field: Vec::new(),
        };
        let name = format!("{}.vtu", case.bodies[b].file_stem());
        write_vtu(&mut directory, &name, &VtuMesh::from(problem.bodies[b].mesh()), &data)?;
    }
    let picture = S::error_map(case, problem, found, &densities);
    if let Some(picture) = &picture {
        directory.write(&format!("figures/{}.svg", picture.name), picture.svg.as_bytes())?;
    }
    let lines = verdict(case, found);
    let page = html::of_field(case, (problem, found), &lines, picture.as_ref(), &named);
    directory.write("report.html", page.as_bytes())?;
    let text = serde_json::to_string_pretty(&report(case, (problem, notes), found, (&lines, &named, &mark)));
    let text = text.map_err(|error| Failure::defect(error.to_string()))?;
    directory.write(ResultKind::Solve.record(), text.as_bytes())?;
    let written = directory.written().map(|p| p.display().to_string()).collect();
    directory.finish()?;
    Ok(written)
}

/// Draws the density of the squared error on the deformed bodies.
pub(crate) fn map(
    case: &Case,
    problem: &ContactProblem,
    found: &FieldCertificate,
    densities: &[Vec<f64>],
) -> Picture {
    let bodies = densities.iter().enumerate().map(|(b, density)| BodyPicture {
        name: &case.bodies[b].name,
        mesh: problem.bodies[b].mesh(),
        displacement: &found.estimate.pair.bodies[b].displacement,
        field: Field::Cells(density),
    });
    let bodies: Vec<BodyPicture<'_>> = bodies.collect();
    let labels = &Labels { units: case.units.clone(), of_solids: false };
    let svg = plot::deformed("Error density", Quantity::ErrorDensity, &bodies, &[], &[], false, labels);
    Picture {
        name: "deformed".into(),
        svg,
        caption: "The squared error of the admissible field in each cell over its area; what was changed to make the given field \
                  admissible is not in it. Large values show which cells to refine."
            .into(),
        numbers: None,
        view: None,
    }
}

/// Makes the contents of report.json.
fn report<S: ReportSpace>(
    case: &Case<S>,
    (problem, notes): (&ContactProblem<S>, &[String]),
    found: &FieldCertificate<S>,
    (lines, files, mark): (&str, &[String], &str),
) -> Value {
    let valid = found.bound().is_some();
    let bodies = problem.bodies.iter().zip(&case.bodies).zip(&found.unknowns).map(|((body, given), unknowns)| {
        let mesh = body.mesh();
        json!({ "name": given.name, "nodes": mesh.points().len(), (S::WORDS.cells): mesh.cells().len(), "unknowns": unknowns })
    });
    json!({
        "schema": SCHEMA,
        "status": {
            "word": if valid { "completed" } else { "not_certified" },
            "code": if valid { 0 } else { NOT_CERTIFIED },
            "reason": lines.lines().last().unwrap_or_default(),
        },
        "certificate": summary(case, found),
        "bodies": bodies.collect::<Vec<_>>(),
        "case": case.settings_json(),
        "notes": notes,
        "run": {
            CASE_HASH: mark,
            "version": env!("CARGO_PKG_VERSION"),
            "case_file": case.file_name(),
            "displacement": files,
        },
    })
}
