//! Notes about curved sides.

use crate::check::MOST_NAMED;
use crate::solved::Fields;
use crate::words::place;
use case_io::Case;
use fem_core::body::Body;
use fem_core::geometry::{Vector, shown};
use fem_core::interface::ContactProblem;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use mesh_io::words::{counted, listed};
use std::collections::BTreeSet;

/// Lists the edges of each body on a first mesh that seem to approximate a curve and are not declared.
pub(crate) fn undeclared(problem: &ContactProblem) -> Vec<Vec<[NodeId; 2]>> {
    problem.bodies.iter().map(Body::undeclared_curves).collect()
}

/// Says which undeclared curves were refined as polygons.
///
/// * `undeclared`: of [`undeclared`], on the first mesh, whose nodes keep their numbers.
pub(crate) fn refined(
    case: &Case,
    undeclared: &[Vec<[NodeId; 2]>],
    problem: &ContactProblem,
) -> Option<String> {
    let mut found = Vec::new();
    for ((given, body), edges) in case.bodies.iter().zip(&problem.bodies).zip(undeclared) {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        let mut halved = edges.iter().filter(|[a, b]| topology.find_edge(*a, *b).is_none());
        let Some(first) = halved.next() else { continue };
        let count = 1 + halved.count();
        let at = place(mesh.points()[first[0]].as_slice(), mesh.diagonal());
        let sides = sides_at(mesh, edges);
        let of = match sides.is_empty() {
            true => "a side without a name".to_owned(),
            false => format!("on {}", listed(&sides)),
        };
        found.push(format!("{} of body \"{}\" ({of}, such as at {at})", counted(count, "edge"), given.name));
    }
    let more = found.len().saturating_sub(MOST_NAMED);
    found.truncate(MOST_NAMED);
    match more {
        0 => {}
        1 => found.push("some of one more body".to_owned()),
        _ => found.push(format!("some of {more} more bodies")),
    }
    (!found.is_empty()).then(|| {
        format!(
            "{} became finer on what seems to be a curve, as a polygon whose corners raise the stress the more the finer the mesh is: \
             declare the curve with [[body.curve]], kind = \"arc\" or \"smooth\"",
            found.join(", ")
        )
    })
}

/// Lists the sides with an edge at two of the nodes of edges of the first mesh.
fn sides_at<'a>(mesh: &'a TriMesh, edges: &[[NodeId; 2]]) -> Vec<&'a str> {
    let nodes: BTreeSet<NodeId> = edges.iter().flatten().copied().collect();
    let touches = |group: &[FacetId]| {
        let found = group.iter().flat_map(|e| mesh.topology().facets()[*e]).filter(|n| nodes.contains(n));
        found.collect::<BTreeSet<_>>().len() > 1
    };
    mesh.groups().iter().filter(|(_, group)| touches(group)).map(|(name, _)| name.as_str()).collect()
}

/// Says what the bound of a problem with declared curves is a bound of, and which nodes are not on them.
pub(crate) fn of_solution(case: &Case, solution: &Fields<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    let bodies = || case.bodies.iter().zip(&solution.problem.bodies);
    let curved: Vec<&str> =
        bodies().filter(|(_, body)| body.has_curves()).map(|(given, _)| given.name.as_str()).collect();
    if !curved.is_empty() && (solution.is_certified || solution.is_residual()) {
        notes.push(format!(
            "curved sides ({}): {} is for the polygons of the last mesh; the difference to the curves is outside it",
            listed(&curved),
            solution.what()
        ));
    }
    for (given, body) in bodies() {
        let nodes = body.nodes_on_chords();
        let Some(first) = nodes.first() else { continue };
        let point: Vector = body.mesh().points()[*first];
        notes.push(format!(
            "body \"{}\": {} of a curved side stayed on the chord of the edge, such as at ({}, {}), since a cell would have turned \
             over or lost most of its area; use smaller cells at this side",
            given.name,
            counted(nodes.len(), "new node"),
            shown(point[0]),
            shown(point[1])
        ));
    }
    notes
}
