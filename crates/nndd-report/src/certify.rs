//! Certificates of displacements that another code computed, read from files or in memory.

mod field_file;
mod found;
mod matched;
mod output;

use crate::convert;
use crate::failure::Failure;
use crate::space::ReportSpace;
use case_io::Case;
use certified_contact::SolveError;
use cre_estimator::{FieldCertificate, Relaxation};
use fem_core::body::Body;
use fem_core::interface::{ContactPair, ContactProblem};
use fem_core::mesh::Mesh;
use fem_core::mesh_field::MeshField;
use fem_core::prepared::PreparedProblem;
use field_file::{field_of, read, refuse_far};
use std::path::PathBuf;

pub(crate) use output::map;

pub use found::{summary, verdict};
pub use output::write;

/// Certifies displacements of other codes.
///
/// * `problem`: see [`crate::run::build_last`]; `files`: one per body, in the order of the case file.
///
/// # Errors
/// Files that cannot be read, fields that do not have a value at every node of the meshes, a problem without a unique solution.
pub fn certify<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    files: &[PathBuf],
) -> Result<FieldCertificate<S>, Failure> {
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
    let given: Vec<MeshField<'_, S>> = all.iter().map(|of| MeshField::new(of.mesh, &of.field)).collect();
    let prepared = prepare(case, problem.clone())?;
    let mut found = bound(case, &prepared, &given, None)?;
    found.widen(spread);
    Ok(found)
}

/// Makes the meshes as the case describes them, before nodes are added and moved so that surfaces match.
fn meshes<S: ReportSpace>(case: &Case<S>) -> Result<Vec<Mesh<S>>, Failure> {
    (0..case.bodies.len()).map(|b| Ok(case.mesh_of(b)?)).collect()
}

/// Bounds the energy density over `|∇d|²`, Pa: the trace of the stiffness, the largest of all cells. Not computed if there is nothing to bound.
fn largest_stiffness<S: ReportSpace>(body: &Body<S>, spread: f64) -> f64 {
    if spread == 0.0 {
        return 0.0;
    }
    let unit = |k: usize| if k < S::DIM { 1.0 } else { 0.5f64.sqrt() };
    let strain = |k: usize| S::Tensor::from(S::components(|c| if c == k { unit(k) } else { 0.0 }));
    let of_cell = |t: usize| {
        let material = body.material(t);
        let density = |k: usize| S::contracted(material.stress(strain(k)), strain(k));
        (0..S::COMPONENTS).map(density).sum::<f64>()
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
pub fn of_fields<S: ReportSpace>(
    case: &Case<S>,
    problem: &ContactProblem<S>,
    fields: &[Vec<S::Vector>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate<S>, Failure> {
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
    let given: Vec<MeshField<'_, S>> =
        meshes.iter().zip(fields).map(|(mesh, field)| MeshField::new(mesh, field)).collect();
    let prepared = prepare(case, problem.clone())?;
    let Some(pressures) = pressures else { return bound(case, &prepared, &given, None) };
    counted("pressures", pressures.len(), case.contacts.len())?;
    let mut at_pairs = Vec::with_capacity(pressures.len());
    for (pressure, (given, pair)) in pressures.iter().zip(case.contacts.iter().zip(&problem.contacts)) {
        let first = pair.body;
        let mesh = &meshes[first];
        counted(&format!("pressures of the pair \"{}\"", given.name), pressure.len(), mesh.points().len())?;
        let mut on_side = vec![S::Vector::default(); pressure.len()];
        let facets = mesh.group(&given.surfaces[0]).unwrap_or(&[]);
        for node in facets.iter().flat_map(|facet| mesh.topology().facets()[*facet]) {
            on_side[node.index()][0] = pressure[node.index()];
        }
        let field = MeshField::new(mesh, &on_side).on(problem.bodies[first].mesh());
        at_pairs.push(pair.interface.pairs().iter().map(|p| field[p.nodes[0]][0]).collect());
    }
    bound(case, &prepared, &given, Some(&at_pairs))
}

/// Refuses problems whose fields are more than displacements of the bodies.
fn refuse<S: ReportSpace>(case: &Case<S>, problem: &ContactProblem<S>) -> Result<(), Failure> {
    let is_free = |of: &ContactPair<S>| {
        problem.obstacle_of(of).is_some_and(|obstacle| !obstacle.free_motions().is_empty())
    };
    if let Some(k) = problem.contacts.iter().position(is_free) {
        return Err(Failure::invalid(format!(
            "the obstacle of the pair \"{}\" is free to move, and its motion is not among the displacements of the bodies\n  expected: \
             obstacles whose motion is imposed\n  fix: give its motion as {} and rotation, or solve the case with nndd",
            case.contacts[k].name,
            S::MOTIONS[..S::DIM].join(", ")
        )));
    }
    if let Some(pair) = case.contacts.iter().find(|contact| contact.bond.is_some()) {
        return Err(Failure::invalid(format!(
            "the pair \"{}\" is bonded, and displacements of other programs are certified without bonds only\n  expected: pairs in \
             contact\n  fix: mesh the bonded bodies as one, or solve the case with nndd",
            pair.name
        )));
    }
    if let Some(body) = case.bodies.iter().find(|body| !body.cuts.is_empty()) {
        return Err(Failure::invalid(format!(
            "body \"{}\" has a cut, across which its displacement jumps, and displacements of other programs are certified without cuts \
             only\n  expected: bodies without [[body.cut]]\n  fix: take the cut out, or solve the case with nndd",
            body.name
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
fn prepare<S: ReportSpace>(
    case: &Case<S>,
    problem: ContactProblem<S>,
) -> Result<PreparedProblem<S>, Failure> {
    S::without_spin(problem)
        .and_then(|problem| PreparedProblem::new(problem).map_err(SolveError::Prepare))
        .map_err(|error| Failure::solve(case, &error))
}

/// * `fields`: of the bodies; `pressures`: at the pairs of the problem.
fn bound<S: ReportSpace>(
    case: &Case<S>,
    prepared: &PreparedProblem<S>,
    fields: &[MeshField<'_, S>],
    pressures: Option<&[Vec<f64>]>,
) -> Result<FieldCertificate<S>, Failure> {
    let relaxation: Relaxation = convert::settings(case).relaxation;
    cre_estimator::certify(prepared, fields, pressures, relaxation)
        .map_err(|error| Failure::solve(case, &SolveError::Estimator(error)))
}

#[cfg(test)]
mod tests;
