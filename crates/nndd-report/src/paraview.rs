//! The files for ParaView: one per body and one of the contact line, on the last mesh and on each of an adaptive run.

use crate::body_fields::{AT_POINTS, BodyFields, IN_CELLS};
use crate::failure::Failure;
use crate::report;
use crate::solved::Fields;
use crate::space::ReportSpace;
use crate::words;
use case_io::Case;
use case_io::output::OutputDirectory;
use case_io::table::FrictionRow;
use cre_estimator::Estimate;
use fem_core::geometry::Coordinates;
use fem_core::interface::ContactFacet;
use fem_core::space::{Solid, Space};
use mesh_io::vtu::{self, PvdEntry, VtuArray, VtuData, VtuError, VtuMesh};
use std::io;

/// Writes bodies and contact line on the last mesh, and the collections of the files of all meshes or load steps.
///
/// * `collections`: names, with the numbers of the meshes or load steps; a collection without any is not written.
pub(crate) fn write<S: ReportSpace>(
    case: &Case<S>,
    solution: &Fields<'_, S>,
    collections: &[(&str, Vec<usize>)],
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    write_parts(case, solution, None, &|part| format!("{part}.vtu"), directory)?;
    let mut some = collections.iter().filter(|(_, steps)| !steps.is_empty());
    some.try_for_each(|(name, steps)| write_collections(case, name, steps, directory))
}

/// Writes bodies and contact line on one mesh of an adaptive run, or in one load step.
pub(crate) fn write_step<S: ReportSpace>(
    case: &Case<S>,
    solution: &Fields<'_, S>,
    step: usize,
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    write_parts(case, solution, Some(step), &|part| words::step_file(part, step), directory)
}

fn write_parts<S: ReportSpace>(
    case: &Case<S>,
    solution: &Fields<'_, S>,
    step: Option<usize>,
    name: &dyn Fn(&str) -> String,
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    let Some(estimate) = solution.estimate else { return Ok(()) };
    for (part, file) in words::parts(case).iter().enumerate() {
        let (grid, mut data) = match part.checked_sub(case.bodies.len()) {
            None => {
                let fields = BodyFields { case, solution, estimate, body: part };
                let data =
                    VtuData { point: fields.all(&AT_POINTS), cell: fields.all(&IN_CELLS), field: Vec::new() };
                (VtuMesh::from(solution.problem.bodies[part].mesh()), data)
            }
            Some(pair) => contact_data(solution, estimate, pair),
        };
        data.field = field_data(solution, estimate, step);
        write_vtu(directory, &name(file), &grid, &data)?;
    }
    Ok(())
}

/// Writes a collection with all parts, and a series for each of them.
fn write_collections<S: ReportSpace>(
    case: &Case<S>,
    collection: &str,
    steps: &[usize],
    directory: &mut OutputDirectory,
) -> Result<(), Failure> {
    let lines = words::contact_parts(case);
    let bodies = case.bodies.iter().map(|body| body.name.as_str());
    let names: Vec<&str> = bodies.chain(lines.iter().map(String::as_str)).collect();
    let parts = words::parts(case);
    let mut entries = Vec::new();
    for &step in steps {
        for (part, (name, file)) in names.iter().zip(&parts).enumerate() {
            let (name, file) = ((*name).to_owned(), words::step_file(file, step));
            entries.push(PvdEntry { timestep: step as f64, part, name, file });
        }
    }
    let mut put = |name: &str, text: Result<String, VtuError>| {
        let text = text.map_err(|e| Failure::defect(format!("{name}: {e}")))?;
        directory.write(name, text.as_bytes()).map_err(Failure::from)
    };
    put(collection, vtu::pvd(&entries))?;
    for part in &parts {
        let files: Vec<_> = steps.iter().map(|step| (words::step_file(part, *step), *step as f64)).collect();
        put(&format!("{part}.vtu.series"), vtu::series(&files))?;
    }
    Ok(())
}

/// Returns the values of the whole state. `(e_cre − round_off)²`, with Coulomb friction `(e_b − round_off)²`, is the
/// integral of `error_density` over bodies and contact line. An iteration without θ has none here, and only a mesh of a
/// series has a time.
fn field_data<S: ReportSpace>(
    solution: &Fields<'_, S>,
    estimate: &Estimate<S>,
    step: Option<usize>,
) -> Vec<VtuArray> {
    let last = solution.last;
    let one = |name: &str, value: f64| VtuArray::scalars(name, vec![value]);
    let theta = Some(last.theta).filter(|theta| theta.is_finite() && *theta > 0.0);
    let found = estimate.unchecked();
    let mut data = vec![one("iteration", last.iteration as f64)];
    if solution.is_residual() {
        // Without a bound there are no parts of it either.
        data.push(one("e_b", found.e_cre));
    } else {
        let bounds = [("e_cre", found.e_cre), ("eta_dis", found.eta_dis), ("eta_nndd", found.eta_nndd)];
        data.extend(bounds.map(|(name, value)| one(name, value)));
        let parts = found.parts.list().into_iter().filter(|(name, _)| *name != "round_off");
        data.extend(parts.map(|(name, value)| one(&format!("part_{name}"), value)));
    }
    data.push(one("round_off", estimate.round_off));
    data.push(one("certified", f64::from(u8::from(solution.is_certified))));
    data.extend(theta.map(|theta| one("theta", theta)));
    data.extend(step.map(|step| one("TimeValue", step as f64)));
    data
}

/// Makes the edges or faces of a pair with all fields.
pub(crate) fn contact_data<S: ReportSpace>(
    solution: &Fields<'_, S>,
    estimate: &Estimate<S>,
    pair: usize,
) -> (VtuMesh, VtuData) {
    let rows = report::contact_rows(solution, pair);
    let of = &solution.problem.contacts[pair];
    let nodes = of.interface.pairs();
    let last = solution.last;
    let first = solution.problem.blocks().nth(pair).map_or(0, |block| block.start);
    let of_first = |k: usize| last.reaction[first + k] / nodes[k].weight;
    let of_second = |k: usize| last.contact.normal_reaction[first + k] / nodes[k].weight;
    let drawn = S::drawn_facets(solution, pair);
    let count = drawn.points.len();
    // A clamped end has the values of the pair at the other end of its edge, but for the opening.
    let clamped = |k: usize| drawn.clamped.get(k.wrapping_sub(rows.len()));
    let pair_of = |k: usize| clamped(k).map_or(k, |(pair, _)| *pair);
    let opening = |k: usize| clamped(k).map_or_else(|| rows[k].opening, |(_, opening)| *opening);
    let scalars = |name: &str, of: &dyn Fn(usize) -> f64| {
        VtuArray::scalars(name, (0..count).map(|k| of(pair_of(k))).collect())
    };
    // Over the measure as it is drawn, so that the file alone gives the integral.
    let squares = drawn.measures.iter().zip(&estimate.cre.by_contact_edge[pair]);
    let density = squares.map(|(measure, squared)| squared / measure);
    let vectors = |name: &str, at: &dyn Fn(usize) -> S::Vector| {
        let all: Vec<S::Vector> = (0..count).map(|k| at(pair_of(k))).collect();
        VtuArray::vectors(name, &all)
    };
    let displacement = &estimate.pair.bodies[of.body].displacement;
    let normal = |k: usize| nodes[k].normal;
    let mean = |facet: &ContactFacet<S>| {
        let corners = facet.pairs.into_iter().map(|k| rows[k as usize].pressure);
        corners.sum::<f64>() / S::DIM as f64
    };
    let mut data = VtuData {
        point: vec![
            // Of the first body, so that the interface is warped with it.
            vectors("displacement", &|k| displacement[nodes[k].nodes[0].index()]),
            vectors("normal", &normal),
            vectors("traction", &|k| {
                let friction = |row| S::friction_traction(normal(k), row);
                let friction = rows[k].friction.as_ref().map_or(S::Vector::ZERO, friction);
                normal(k) * -rows[k].pressure + friction
            }),
            scalars("gap", &|k| rows[k].gap),
            VtuArray::scalars("opening", (0..count).map(opening).collect()),
            scalars("contact_pressure", &|k| rows[k].pressure),
            scalars("contact_pressure_recovered", &|k| {
                rows[k].pressure_recovered.unwrap_or(rows[k].pressure)
            }),
            VtuArray::integers("active", (0..count).map(|k| usize::from(rows[pair_of(k)].active)).collect()),
            scalars("lambda", &|k| last.lambda[first + k]),
            scalars("traction_1", &of_first),
            scalars("traction_2", &of_second),
            scalars("traction_imbalance", &|k| of_first(k) + of_second(k)),
        ],
        cell: vec![
            VtuArray::scalars("error_density", density.collect()),
            VtuArray::scalars("contact_pressure_mean", of.interface.facets().iter().map(mean).collect()),
        ],
        field: Vec::new(),
    };
    if rows.iter().any(|row| row.friction.is_some()) {
        let friction = |name: &str, of: fn(&FrictionRow) -> f64| {
            scalars(name, &|k| rows[k].friction.as_ref().map_or(0.0, of))
        };
        let in_space = |k: usize| rows[k].friction.as_ref().and_then(|friction| friction.in_space);
        let both = match rows.iter().any(|row| row.friction.as_ref().is_some_and(|f| f.in_space.is_some())) {
            true => ["friction_traction", "slip"]
                .into_iter()
                .enumerate()
                .map(|(place, name)| {
                    let of = |k: usize| in_space(pair_of(k)).map_or([0.0; 3], |both| both[place]).into();
                    VtuArray::vectors(name, &(0..count).map(of).collect::<Vec<<Solid as Space>::Vector>>())
                })
                .collect(),
            false => vec![friction("friction_traction", |f| f.tangential), friction("slip", |f| f.slip)],
        };
        data.point.extend(both);
        data.point.extend([
            friction("friction_limit", |f| f.limit),
            friction("friction_state", |f| match f.state.as_str() {
                "stick" => 1.0,
                "slip" => 2.0,
                _ => 0.0,
            }),
        ]);
    }
    let points = drawn.points.iter().map(vtu::three).collect();
    (VtuMesh { points, cells: drawn.cells }, data)
}

pub(crate) fn write_vtu(
    directory: &mut OutputDirectory,
    name: &str,
    grid: &VtuMesh,
    data: &VtuData,
) -> Result<(), Failure> {
    let mut refused = None;
    let written = directory.write_with(name, |out| {
        vtu::write(out, grid, data).map_err(|e| match e {
            VtuError::Io(e) => e,
            other => {
                refused = Some(Failure::overflow(&other));
                io::Error::other("refused")
            }
        })
    });
    match refused {
        Some(failure) => Err(failure),
        None => Ok(written?),
    }
}
