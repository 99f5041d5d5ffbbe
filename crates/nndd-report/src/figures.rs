//! The figures of a run, drawn by [`crate::plot`].

use crate::plot::{
    self, BodyPicture, Closing, Held, Motion, ObstaclePicture, SketchBody, SketchEdge, SketchLoad,
};
use crate::words::{contact_parts, one_line};
use case_io::Case;
use case_io::case::BodyCase;
use case_io::report::Report;
use case_io::table::ContactRow;
use certified_contact::CertifiedSolution;
use fem_core::body::{Body, EdgeReaction, NodeConstraint, RigidSide};
use fem_core::geometry::{Vector, cross, norm};
use fem_core::interface::{ContactPair, NodePair};
use fem_core::mesh::id::{EdgeId, NodeId};
use std::collections::BTreeSet;

/// A named figure.
pub(crate) struct Picture {
    pub(crate) name: String,
    pub(crate) svg: String,
    /// What there is to see, for the page.
    pub(crate) caption: &'static str,
    /// The file with its numbers.
    pub(crate) numbers: Option<&'static str>,
}

/// Computes the error density (squared error over area) in the triangles of a body.
pub(crate) fn error_density(solution: &CertifiedSolution, body: usize) -> Vec<f64> {
    let mesh = solution.problem.bodies[body].mesh();
    let Some(estimate) = &solution.estimate else { return vec![0.0; mesh.triangles().len()] };
    estimate.cre.by_cell[body].iter().enumerate().map(|(t, e)| e / mesh.area(t)).collect()
}

/// Draws the figures of a solve.
pub(crate) fn of_solve(
    case: &Case,
    solution: &CertifiedSolution,
    contact: &[(&str, Vec<ContactRow>)],
    report: &Report,
) -> Vec<Picture> {
    let name = one_line(if case.title.is_empty() { case.file_name() } else { &case.title });
    let mut pictures = vec![problem(case, solution, &format!("{name}: the problem"))];
    if let Some(estimate) = &solution.estimate {
        let count = solution.problem.bodies.len();
        let densities: Vec<Vec<f64>> = (0..count).map(|b| error_density(solution, b)).collect();
        let picture = |b: usize| BodyPicture {
            name: &case.bodies[b].name,
            mesh: solution.problem.bodies[b].mesh(),
            displacement: &estimate.pair.bodies[b].displacement,
            density: &densities[b],
        };
        let bodies: Vec<BodyPicture<'_>> = (0..count).map(picture).collect();
        pictures.push(Picture {
            name: "deformed".into(),
            svg: plot::deformed(&format!("{name}: error density"), &bodies, &obstacles(solution), &closing(solution)),
            caption: "The certified squared error of each cell over its area. Large values show which cells to refine.",
            numbers: None,
        });
        for ((pair, rows), part) in contact.iter().zip(contact_parts(case)) {
            let line = match contact.len() {
                1 => "contact line".to_owned(),
                _ => format!("contact line of {}", one_line(pair)),
            };
            pictures.push(Picture {
                name: part,
                svg: plot::contact(&format!("{name}: {line}"), rows),
                caption: "The opening is zero where there is pressure; the pressure is zero where the bodies are apart.",
                numbers: Some("contact.csv"),
            });
        }
    }
    pictures.push(Picture {
        name: "convergence".into(),
        svg: plot::convergence(&format!("{name}: errors against the iteration"), &report.iterations),
        caption: "The error of the iteration (eta_nndd) falls below that of the mesh (eta_dis); e_cre bounds both together.",
        numbers: Some("history.csv"),
    });
    if let Some(adapt) = &case.adapt {
        let steps: Vec<_> = report.adaptive.iter().map(|row| (row.nodes, row.relative)).collect();
        let title = format!("{name}: certified error against the number of nodes");
        pictures.push(Picture {
            name: "adaptive".into(),
            svg: plot::adaptive(&title, &steps, adapt.target_relative_error),
            caption: "Linear triangles cannot converge faster than the slope of the dashed line.",
            numbers: Some("adaptive.csv"),
        });
    }
    pictures
}

/// The distances of the contact nodes at rest, and by how much the displacements bring them together.
fn closing(solution: &CertifiedSolution) -> Vec<Closing> {
    let Some(estimate) = &solution.estimate else { return vec![] };
    let problem = &solution.problem;
    let displacements = estimate.pair.displacements();
    let of_pair = |pair: &ContactPair| -> Vec<Closing> {
        let of_partner = |b: usize| match problem.bodies.get(b) {
            Some(body) => body.mesh().points(),
            None => problem.obstacles[b - problem.bodies.len()].points(),
        };
        let points = pair.bodies.map(of_partner);
        let displacement = pair.bodies.map(|b| displacements[b]);
        let of_nodes = |nodes: &NodePair| {
            let of = |field: [&[Vector]; 2]| {
                let [first, second] = [0, 1].map(|side: usize| field[side][nodes.nodes[side]]);
                nodes.normal.dot(&(second - first))
            };
            Closing { gap: of(points), approach: -of(displacement) }
        };
        pair.interface.pairs().iter().map(of_nodes).collect()
    };
    problem.contacts.iter().flat_map(of_pair).collect()
}

/// Draws the problem of the last mesh.
fn problem<'a>(case: &'a Case, solution: &'a CertifiedSolution, title: &str) -> Picture {
    let sketch = |(given, body): (&'a BodyCase, &'a Body)| SketchBody {
        name: &given.name,
        mesh: body.mesh(),
        edges: sketch_edges(body),
        body_force: body.body_force(),
        rigid: body.rigid_sides().iter().filter_map(|side| rigid_load(body, side)).collect(),
    };
    let bodies: Vec<SketchBody<'_>> = case.bodies.iter().zip(&solution.problem.bodies).map(sketch).collect();
    let line = |pair: &ContactPair| -> Vec<[Vector; 2]> {
        let points = solution.problem.bodies[pair.bodies[0]].mesh().points();
        let nodes = solution.problem.bodies[pair.bodies[0]].mesh().topology().edges();
        let edges = pair.interface.edges().iter();
        edges.map(|edge| nodes[edge.edges[0]].map(|n| points[n])).collect()
    };
    let contact: Vec<[Vector; 2]> = solution.problem.contacts.iter().flat_map(line).collect();
    Picture {
        name: "problem".into(),
        svg: plot::sketch(title, &bodies, &obstacles(solution), &contact),
        caption: "Supports, loads and imposed displacements as the program read them.",
        numbers: None,
    }
}

/// The obstacles, with the motion that was found.
fn obstacles(solution: &CertifiedSolution) -> Vec<ObstaclePicture<'_>> {
    let found = solution.estimate.as_ref().map_or(&[][..], |estimate| &estimate.pair.obstacles);
    let obstacles = solution.problem.obstacles.iter().enumerate();
    let pictures = obstacles.map(|(k, obstacle)| ObstaclePicture {
        line: obstacle.line,
        points: obstacle.points(),
        motion: motion(obstacle.points(), found.get(k).map_or(&[][..], Vec::as_slice)),
        imposed: obstacle.translation.map(|t| t.unwrap_or(0.0)).into(),
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
    let nearest = |edge: &EdgeId| {
        let [a, b] = mesh.topology().edges()[*edge].map(|v| mesh.points()[v]);
        let part = (side.about - a).dot(&(b - a)) / (b - a).norm_squared();
        (a + part.clamp(0.0, 1.0) * (b - a), mesh.edge_normal(*edge))
    };
    let places = side.edges.iter().map(nearest);
    let (at, normal) = places.min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)))?;
    (force != Vector::zeros() || moment != 0.0).then_some(SketchLoad { at, normal, force, moment })
}

/// What is imposed on the boundary edges of a body.
fn sketch_edges(body: &Body) -> Vec<SketchEdge> {
    let mesh = body.mesh();
    let nodes_of = mesh.topology().edges();
    let imposed = |node: NodeId| match body.node_constraints()[node] {
        NodeConstraint::Free => Vector::zeros(),
        NodeConstraint::Along { direction, value } => value * direction,
        NodeConstraint::Fixed { value } | NodeConstraint::Rigid { value, .. } => value,
    };
    let mean = |[a, b]: [Vector; 2]| 0.5 * (a + b);
    let free = |side: &&RigidSide| !side.motions.is_empty();
    let rigid: BTreeSet<EdgeId> =
        body.rigid_sides().iter().filter(free).flat_map(|side| side.edges.iter().copied()).collect();
    mesh.topology()
        .boundary_edges()
        .iter()
        .filter_map(|edge| {
            let condition = body.edge_condition(*edge)?;
            let nodes = nodes_of[*edge];
            let held = match condition.reaction {
                EdgeReaction::None => Held::Free,
                EdgeReaction::Along(_) => Held::Roller,
                EdgeReaction::Both if rigid.contains(edge) => Held::Rigid,
                EdgeReaction::Both => Held::Fixed,
            };
            // Only what the edge itself imposes: its ends may belong to another side too.
            let mean_imposed = mean(nodes.map(imposed));
            let displacement = match condition.reaction {
                EdgeReaction::None => Vector::zeros(),
                EdgeReaction::Along(d) => d.dot(&mean_imposed) * d,
                EdgeReaction::Both => mean_imposed,
            };
            Some(SketchEdge {
                ends: nodes.map(|v| mesh.points()[v]),
                normal: mesh.edge_normal(*edge),
                held,
                displacement,
                traction: mean(condition.traction),
            })
        })
        .collect()
}
