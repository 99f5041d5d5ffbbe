//! The figures of a run, drawn by [`crate::plot`].

pub(crate) mod solid;

use crate::corners;
use crate::nodal::{self, NodalPatch};
use crate::plot::{
    self, Along, BodyPicture, Closing, Field, Held, Labels, Measure, Motion, ObstaclePicture, Quantity,
    SketchBody, SketchEdge, SketchLoad,
};
use crate::solved::Fields;
use crate::words::{certified_digits, contact_parts, one_line};
use case_io::Case;
use case_io::case::{BodyCase, Dimension, Target};
use case_io::report::{AdaptiveRow, Report, StepSummary};
use case_io::table::ContactRow;
use cre_estimator::{AdmissibleBody, Estimate};
use fem_core::body::{Body, RigidSide};
use fem_core::directions::Directions;
use fem_core::geometry::{Coordinates, Vector, cross, norm};
use fem_core::interface::{ContactPair, NodePair, Partner};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::topology::NONE;
use fem_core::parallel::each_task;
use fem_core::space::Space;
use serde_json::Value;
use std::collections::BTreeSet;

/// The rows of contact.csv of each pair, with its name.
pub(crate) type NamedRows<'a> = [(&'a str, Vec<ContactRow>)];

/// A named figure.
pub struct Picture {
    /// Its name, as that of its file in `figures`.
    pub name: String,
    /// The drawing.
    pub svg: String,
    /// The text below the picture on the page.
    pub caption: String,
    /// The file with its numbers.
    pub(crate) numbers: Option<String>,
    /// The data of a view that turns, which the page shows in place of the picture if it can.
    pub(crate) view: Option<Value>,
}

/// Computes the error density (squared error over area or volume) in the cells of a body.
pub(crate) fn error_density<S: Space>(solution: &Fields<'_, S>, body: usize) -> Vec<f64> {
    let mesh = solution.problem.bodies[body].mesh();
    let Some(estimate) = solution.estimate else { return vec![0.0; mesh.cells().len()] };
    estimate.cre.by_cell[body].iter().enumerate().map(|(t, e)| e / mesh.measure(t)).collect()
}

/// Draws the figures of a solve.
pub(crate) fn of_solve(
    case: &Case,
    solution: &Fields<'_>,
    contact: &[(&str, Vec<ContactRow>)],
    report: &Report,
) -> Vec<Picture> {
    let labels = &Labels { units: case.units.clone(), of_solids: false };
    let drawn: [&(dyn Fn() -> Vec<Picture> + Sync); 8] = [
        &|| vec![problem(case, solution, labels)],
        &|| von_mises(case, solution, labels).into_iter().collect(),
        &|| displacement(case, solution, labels).into_iter().collect(),
        &|| contact_lines(case, solution, contact, report, labels),
        &|| density(case, solution, labels).into_iter().collect(),
        &|| convergence(case, report, labels).into_iter().collect(),
        &|| steps(contact, report, labels),
        &|| adaptive(case, report, labels).into_iter().collect(),
    ];
    each_task(drawn.len(), |k| drawn[k]()).into_iter().flatten().collect()
}

/// At most this many contact lines or surfaces are drawn.
const MOST_PAIRS: usize = 32;

/// Chooses the pairs that are drawn: if there are several, those under pressure, and of many those with the largest forces. Also returns the
/// number of all pairs under pressure.
fn drawn_pairs(contact: &NamedRows<'_>, report: &Report) -> (Vec<usize>, usize) {
    let pressed = |k: &usize| {
        let touches = report.contact[*k].max_tension.is_none();
        touches && (contact.len() == 1 || contact[*k].1.iter().any(|row| row.pressure > 0.0))
    };
    let mut pairs: Vec<usize> = (0..contact.len()).filter(pressed).collect();
    let count = pairs.len();
    if count > MOST_PAIRS {
        let force = |k: usize| report.contact[k].contact_force.unwrap_or(0.0);
        pairs.sort_by(|a, b| force(*b).total_cmp(&force(*a)));
        pairs.truncate(MOST_PAIRS);
        pairs.sort_unstable();
    }
    (pairs, count)
}

/// The pressure along each contact line that is drawn.
fn contact_lines(
    case: &Case,
    solution: &Fields<'_>,
    contact: &[(&str, Vec<ContactRow>)],
    report: &Report,
    labels: &Labels,
) -> Vec<Picture> {
    let digits = certified_digits(report.valid_certificate().and_then(|found| found.relative));
    if solution.estimate.is_none() {
        return Vec::new();
    }
    let (lines, count) = drawn_pairs(contact, report);
    let names = contact_parts(case);
    let picture = |(place, k): (usize, usize)| {
        let ((pair, rows), of) = (&contact[k], &solution.problem.contacts[k]);
        let title = match contact.len() {
            1 => "Contact line".to_owned(),
            _ => format!("Contact line of {}", one_line(pair)),
        };
        let (rows, start) = opened(rows, of);
        let (svg, mut caption) = plot::contact(&title, &rows, start, digits, labels);
        if place == 0 && count > MOST_PAIRS {
            caption +=
                &format!(" {MOST_PAIRS} of {count} contact lines are drawn, those with the largest forces.");
        }
        Picture { name: names[k].clone(), svg, caption, numbers: Some("contact.csv".into()), view: None }
    };
    lines.into_iter().enumerate().map(picture).collect()
}

/// The density of the error, or of the residual, on the deformed bodies.
fn density(case: &Case, solution: &Fields<'_>, labels: &Labels) -> Option<Picture> {
    let estimate = solution.estimate?;
    let count = solution.problem.bodies.len();
    let densities: Vec<Vec<f64>> = (0..count).map(|b| error_density(solution, b)).collect();
    let fields: Vec<Field<'_>> = densities.iter().map(|density| Field::Cells(density)).collect();
    let (title, what) = match solution.is_residual() {
        true => ("Density of the residual", "The squared residual"),
        false => ("Error density", "The certified squared error"),
    };
    Some(Picture {
        name: "deformed".into(),
        svg: of_bodies(case, solution, estimate, (title, Quantity::ErrorDensity, false), &fields, labels),
        caption: format!("{what} of each cell over its area. Large values show which cells to refine."),
        numbers: None,
        view: None,
    })
}

/// Draws the errors against the iteration; `None` if there is a single solution, as with the exact method.
fn convergence<S: Dimension>(case: &Case<S>, report: &Report, labels: &Labels) -> Option<Picture> {
    let title = match case.adapt {
        Some(_) => "Errors against the iteration, last mesh",
        None => "Errors against the iteration",
    };
    (report.iterations.len() != 1).then(|| Picture {
        name: "convergence".into(),
        svg: plot::convergence(title, &report.iterations, labels),
        caption: "The iteration ends when its error (eta_nndd) is a small part of that of the mesh. eta_dis is the error of the mesh \
                  with λ held fixed and may exceed e_cre, the bound of the whole error."
            .into(),
        numbers: Some("history.csv".into()),
        view: None,
    })
}

/// The forces against the load step, and against the factor that changes most often, if the two figures differ.
fn steps(contact: &[(&str, Vec<ContactRow>)], report: &Report, labels: &Labels) -> Vec<Picture> {
    if report.steps.is_empty() {
        return vec![];
    }
    let of = |k: usize| {
        let force = |step: &StepSummary| {
            let pair = &step.contact[k];
            [pair.contact_force, pair.friction.as_ref().map(|friction| friction.tangential_force.size())]
        };
        report.steps.iter().map(force).collect()
    };
    let forces: Vec<plot::Forces<'_>> =
        contact.iter().enumerate().map(|(k, (pair, _))| (*pair, of(k))).collect();
    let figure = |name: &str, along: &Along<'_>, caption: &str| Picture {
        name: name.into(),
        svg: plot::steps(along, &forces, labels),
        caption: caption.into(),
        numbers: Some("report.json".into()),
        view: None,
    };
    let caption = "The integral of the pressure over each contact interface, and that of the friction on its second body. All other figures \
                   show the last step.";
    let mut figures = vec![figure("steps", &Along::Step, caption)];
    if let Some((name, values)) = path(&report.steps) {
        let caption = "The same forces against the factor of the load or the motion that changes most often. With friction, loading and \
                       unloading follow different lines.";
        figures.push(figure("path", &Along::Factor(name, &values), caption));
    }
    figures
}

/// The factor that changes in most steps, and its values; `None` if it grows or falls by equal amounts: then it is the number of the step.
fn path(steps: &[StepSummary]) -> Option<(&str, Vec<f64>)> {
    let changes = |values: &[f64]| values.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let mut most: Option<(&str, Vec<f64>)> = None;
    for name in steps.first()?.factors.keys() {
        let values: Option<Vec<f64>> = steps.iter().map(|step| step.factors.get(name)?.as_f64()).collect();
        if let Some(values) = values
            && changes(&values) > most.as_ref().map_or(0, |(_, values)| changes(values))
        {
            most = Some((name, values));
        }
    }
    let (name, values) = most?;
    let differences = || values.windows(2).map(|pair| pair[1] - pair[0]);
    let first = differences().next()?;
    let rounding = f64::EPSILON * values.iter().fold(0.0, |most, value| f64::max(most, value.abs()));
    let even = differences().all(|difference| (difference - first).abs() <= 8.0 * rounding);
    (!even).then_some((name, values))
}

/// The error against the nodes of the meshes of an adaptive run.
fn adaptive<S: Dimension>(case: &Case<S>, report: &Report, labels: &Labels) -> Option<Picture> {
    let adapt = case.adapt.as_ref()?;
    let measured = |row: &AdaptiveRow| row.relative.or(row.relative_residual);
    let steps: Vec<_> = report.adaptive.iter().map(|row| (row.nodes, measured(row))).collect();
    let kind = match adapt.target {
        Target::RelativeError(_) => Measure::CertifiedError,
        Target::CoulombResidual(_) => Measure::Residual,
    };
    Some(Picture {
        name: "adaptive".into(),
        svg: plot::adaptive(kind, &steps, adapt.target.value(), labels.of_solids),
        caption: format!(
            "On fine meshes the error of linear {} falls at best like the dashed line.",
            S::WORDS.cells
        ),
        numbers: Some("adaptive.csv".into()),
        view: None,
    })
}

/// The recovered von Mises stress on the deformed bodies; `None` without it.
fn von_mises(case: &Case, solution: &Fields<'_>, labels: &Labels) -> Option<Picture> {
    let (estimate, results) = (solution.estimate?, solution.results?);
    let bodies = solution.problem.bodies.iter().zip(&results.recovered);
    let patches: Vec<Vec<NodalPatch>> =
        bodies.map(|(body, stress)| nodal::von_mises(body, stress)).collect::<Option<_>>()?;
    let fields: Vec<Field<'_>> = patches.iter().map(|of| Field::Nodes(of)).collect();
    let infinite = corners::has_infinite_stress(solution);
    let smooth = "The recovered stress: a smooth picture of the stress in equilibrium, for each material.";
    let caption = match infinite {
        true => format!(
            "{smooth} Its largest value is in a corner and grows with every refinement; if the scale ends below it, a ring shows it."
        ),
        false => smooth.to_owned(),
    };
    let what = ("Von Mises stress", Quantity::VonMises, infinite);
    let svg = of_bodies(case, solution, estimate, what, &fields, labels);
    Some(Picture { name: "von_mises".into(), svg, caption, numbers: None, view: None })
}

/// The size of the displacement on the deformed bodies.
fn displacement(case: &Case, solution: &Fields<'_>, labels: &Labels) -> Option<Picture> {
    let estimate = solution.estimate?;
    let size = |(body, of): (&Body, &AdmissibleBody)| {
        let values = of.displacement.iter().map(|u| norm(*u)).collect();
        vec![NodalPatch { triangles: body.mesh().cells().to_vec(), values }]
    };
    let patches: Vec<Vec<NodalPatch>> =
        solution.problem.bodies.iter().zip(&estimate.pair.bodies).map(size).collect();
    let fields: Vec<Field<'_>> = patches.iter().map(|of| Field::Nodes(of)).collect();
    let what = ("Displacement", Quantity::Displacement, false);
    Some(Picture {
        name: "displacement".into(),
        svg: of_bodies(case, solution, estimate, what, &fields, labels),
        caption: "The size of the displacement from the bodies at rest.".into(),
        numbers: None,
        view: None,
    })
}

/// Draws the deformed bodies with a field for each.
fn of_bodies(
    case: &Case,
    solution: &Fields<'_>,
    estimate: &Estimate,
    (title, quantity, infinite): (&str, Quantity, bool),
    fields: &[Field<'_>],
    labels: &Labels,
) -> String {
    let bodies = fields.iter().enumerate().map(|(b, field)| BodyPicture {
        name: &case.bodies[b].name,
        mesh: solution.problem.bodies[b].mesh(),
        displacement: &estimate.pair.bodies[b].displacement,
        field: *field,
    });
    let bodies: Vec<BodyPicture<'_>> = bodies.collect();
    plot::deformed(title, quantity, &bodies, &obstacles(solution), &closing(solution), infinite, labels)
}

/// Opens a closed contact line in the middle of the longest stretch without pressure, so that no contact zone is cut in two;
/// the arc length at which it was opened, if it was.
fn opened(rows: &[ContactRow], pair: &ContactPair) -> (Vec<ContactRow>, Option<f64>) {
    let (n, edges) = (rows.len(), pair.interface.facets());
    let closed = n > 2
        && edges.len() == n
        && edges.iter().enumerate().all(|(k, edge)| edge.pairs == [k as u32, ((k + 1) % n) as u32]);
    let apart = |k: usize| rows[k % n].pressure <= 0.0;
    if !closed {
        return (rows.to_vec(), None);
    }
    // The node that has the most nodes without pressure around it on both sides.
    let around = |k: usize| (0..n).take_while(|d| apart(k + d) && apart(k + n - d)).count();
    let start = (0..n).max_by_key(|k| (around(*k), n - k)).filter(|k| around(*k) > 0).unwrap_or(0);
    let length = pair.interface.measure();
    let turn = |k: usize| {
        let row = &rows[(start + k) % n];
        let turned = row.arc_length() - rows[start].arc_length() + if start + k >= n { length } else { 0.0 };
        ContactRow { s: Some(turned), ..row.clone() }
    };
    ((0..=n).map(turn).collect(), (start > 0).then(|| rows[start].arc_length()))
}

/// The distances of the contact nodes at rest, and by how much the displacements bring them together.
fn closing<S: Space>(solution: &Fields<'_, S>) -> Vec<Closing> {
    let Some(estimate) = solution.estimate else { return vec![] };
    let problem = &solution.problem;
    let displacements = estimate.pair.displacements();
    let of_pair = |pair: &ContactPair<S>| -> Vec<Closing> {
        let points = pair.partners().map(|of| match of {
            Partner::Body(body) => problem.bodies[body].mesh().points(),
            Partner::Obstacle(obstacle) => problem.obstacles[obstacle].points(),
        });
        let displacement = problem.places_of(pair).map(|b| displacements[b]);
        let obstacle = problem.obstacle_of(pair);
        let of_nodes = |nodes: &NodePair<S>| {
            let of = |field: [&[S::Vector]; 2]| {
                let [first, second] = [0, 1].map(|side: usize| field[side][nodes.nodes[side]]);
                nodes.normal.times(&(second - first))
            };
            // The points of a round obstacle are the nodes themselves once its normals are not of length one.
            let node = points[0][nodes.nodes[0]];
            let apart = obstacle.map(|obstacle| obstacle.line.distance(node).0 * nodes.normal_length());
            Closing { gap: apart.unwrap_or_else(|| of(points)), approach: -of(displacement) }
        };
        pair.interface.pairs().iter().map(of_nodes).collect()
    };
    problem.contacts.iter().flat_map(of_pair).collect()
}

/// Draws the problem of the last mesh.
fn problem<'a>(case: &'a Case, solution: &Fields<'a>, labels: &Labels) -> Picture {
    let sketch = |(given, body): (&'a BodyCase, &'a Body)| SketchBody {
        name: &given.name,
        mesh: body.mesh(),
        materials: between_materials(body),
        cuts: body
            .cuts()
            .iter()
            .flat_map(|cut| &cut.facets)
            .map(|(facet, _)| body.mesh().facet_corners(*facet))
            .collect(),
        edges: sketch_edges(body),
        body_force: body.resultant_inside(),
        rigid: body.rigid_sides().iter().filter_map(|side| rigid_load(body, side)).collect(),
    };
    let bodies: Vec<SketchBody<'_>> = case.bodies.iter().zip(&solution.problem.bodies).map(sketch).collect();
    let line = |pair: &ContactPair| -> Vec<[Vector; 2]> {
        let points = solution.problem.bodies[pair.body].mesh().points();
        let nodes = solution.problem.bodies[pair.body].mesh().topology().facets();
        let edges = pair.interface.facets().iter();
        edges.map(|edge| nodes[edge.facets[0]].map(|n| points[n])).collect()
    };
    let contact: Vec<[Vector; 2]> = solution.problem.contacts.iter().flat_map(line).collect();
    Picture {
        name: "problem".into(),
        svg: plot::sketch("The problem", &bodies, &obstacles(solution), &contact, labels),
        caption: "Supports, loads and imposed displacements as the program read them.".into(),
        numbers: None,
        view: None,
    }
}

/// The obstacles, with the motion that was found.
fn obstacles<'a>(solution: &Fields<'a>) -> Vec<ObstaclePicture<'a>> {
    let found = solution.estimate.map_or(&[][..], |estimate| &estimate.pair.obstacles);
    let obstacles = solution.problem.obstacles.iter().enumerate();
    let pictures = obstacles.map(|(k, obstacle)| ObstaclePicture {
        line: obstacle.line,
        points: obstacle.points(),
        motion: motion(obstacle.points(), found.get(k).map_or(&[][..], Vec::as_slice)),
        imposed: [0, 1].map(|c: usize| obstacle.motion[c].unwrap_or(0.0)).into(),
        load: (obstacle.force, obstacle.moment),
    });
    pictures.collect()
}

/// Finds the rigid motion that displaces the first of some points, and the one farthest from it, as given.
fn motion(points: &[Vector], displacement: &[Vector]) -> Motion {
    let known = points.first().zip(displacement.first());
    let (centre, translation) = known.map_or_else(Default::default, |(p, u)| (*p, *u));
    let moved = points.iter().zip(displacement).map(|(p, u)| (p - centre, u - translation));
    let farthest = moved.max_by(|a, b| norm(a.0).total_cmp(&norm(b.0)));
    let turned = farthest.filter(|(arm, _)| norm(*arm) > 0.0);
    let spin = turned.map_or(0.0, |(arm, difference)| cross(arm, difference) / arm.norm_squared());
    Motion { centre, translation, spin }
}

/// The load of a rigid side at the place of the side that is nearest to its point; `None` if there is no load.
fn rigid_load(body: &Body, side: &RigidSide) -> Option<SketchLoad> {
    let (mesh, force, moment) = (body.mesh(), side.force, side.moment);
    let distance = |at: &Vector| norm(at - side.about);
    let nearest = |edge: &FacetId| {
        let [a, b] = mesh.topology().facets()[*edge].map(|v| mesh.points()[v]);
        let part = (side.about - a).dot(&(b - a)) / (b - a).norm_squared();
        (a + part.clamp(0.0, 1.0) * (b - a), mesh.facet_normal(*edge))
    };
    let places = side.edges.iter().map(nearest);
    let (at, normal) = places.min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)))?;
    (force != Vector::zeros() || moment != 0.0).then_some(SketchLoad { at, normal, force, moment })
}

/// The sign of a support that holds some directions.
fn sign_of(held: &Directions) -> Held {
    match (held.is_none(), held.is_all()) {
        (true, _) => Held::Free,
        (_, true) => Held::Fixed,
        _ => Held::Roller,
    }
}

/// The supports on single nodes of a body, as edges without length.
fn sketch_nodes(body: &Body) -> impl Iterator<Item = SketchEdge> + '_ {
    let (mesh, topology) = (body.mesh(), body.mesh().topology());
    body.supports().iter().filter_map(move |set| {
        let ([node], [reaction]) = (&set.nodes[..], &set.reactions[..]) else { return None };
        let around =
            topology.boundary_facets().iter().filter(|edge| topology.facets()[**edge].contains(node));
        Some(SketchEdge {
            ends: [mesh.points()[*node]; 2],
            normal: around.map(|edge| mesh.facet_normal(*edge)).sum(),
            held: sign_of(reaction),
            displacement: body.node_constraints()[*node].displacement(),
            traction: Vector::zeros(),
        })
    })
}

/// The edges whose two cells have different materials.
fn between_materials(body: &Body) -> Vec<[Vector; 2]> {
    let (mesh, topology) = (body.mesh(), body.mesh().topology());
    let differ = |cells: &[u32; 2]| {
        let [a, b] = cells.map(|t| (t != NONE).then(|| body.materials().index(t as usize)));
        a.zip(b).is_some_and(|(a, b)| a != b)
    };
    let edges = topology.facets().iter().zip(topology.facet_cells()).filter(|(_, cells)| differ(cells));
    edges.map(|(ends, _)| ends.map(|v| mesh.points()[v])).collect()
}

/// Lists the conditions on the boundary edges of a body and on single nodes, for the sketch.
fn sketch_edges(body: &Body) -> Vec<SketchEdge> {
    let mesh = body.mesh();
    let nodes_of = mesh.topology().facets();
    let imposed = |node: NodeId| body.node_constraints()[node].displacement();
    let mean = |[a, b]: [Vector; 2]| 0.5 * (a + b);
    let free = |side: &&RigidSide| !side.motions.is_empty();
    let rigid: BTreeSet<FacetId> =
        body.rigid_sides().iter().filter(free).flat_map(|side| side.edges.iter().copied()).collect();
    mesh.topology()
        .boundary_facets()
        .iter()
        .filter_map(|edge| {
            let condition = body.facet_condition(*edge)?;
            let nodes = nodes_of[*edge];
            let held = match sign_of(&condition.reaction) {
                _ if rigid.contains(edge) => Held::Rigid,
                Held::Free if !condition.springs.directions.is_none() => Held::Springs,
                held => held,
            };
            // Only what the edge itself imposes: its ends may belong to another side too.
            let displacement = condition.reaction.project(mean(nodes.map(imposed)));
            Some(SketchEdge {
                ends: nodes.map(|v| mesh.points()[v]),
                normal: mesh.facet_normal(*edge),
                held,
                displacement,
                traction: mean(condition.traction),
            })
        })
        .chain(sketch_nodes(body))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn step(factors: serde_json::Value) -> StepSummary {
        StepSummary { factors: factors.as_object().cloned().unwrap_or_default(), ..StepSummary::default() }
    }

    #[test]
    fn the_path_is_that_of_the_factor_that_changes_most_often() {
        let steps: Vec<StepSummary> = [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0]]
            .map(|[p, q]| step(json!({"p": p, "q": q})))
            .into();
        assert_eq!(path(&steps), Some(("q", vec![0.0, 0.0, 1.0, 0.0])));
        // Equal amounts are the number of the step.
        let even: Vec<StepSummary> = (1..8).map(|k| step(json!({ "p": 0.1 * f64::from(k) }))).collect();
        assert_eq!(path(&even), None);
        assert_eq!(path(&[]), None);
        assert_eq!(path(&[step(json!({"p": 1.0})), step(json!({"p": 1.0}))]), None);
    }
}
