//! Pairs two flat contact surfaces of solids that match node by node, and a side of a solid with an obstacle.

use super::geometric_gap::{GeometricGap, Surfaces};
use super::matching::{TOLERANCE, nearest};
use super::normals::SUPPORT;
use super::obstacle::{change, check_apart, faces, pair_with};
use super::{FACING, facet_size, pairing};
use fem_core::body::Body;
use fem_core::geometry::{FLAT_SIDE, norm};
use fem_core::interface::{
    ContactFacet, ContactInterface, Gap, InterfaceError, NodePair, Obstacle, SAME_NORMAL,
};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};
use std::collections::{BTreeSet, HashMap};

/// Cosine of the largest angle between the normals of an obstacle at the corners of a face: 60 degrees.
const TURN: f64 = 0.5;

type Vector = <Solid as Space>::Vector;

/// Pairs flat contact surfaces of two solids node by node. All pairs have the normal of the first body's plane.
///
/// * `surfaces`: the face group of the first and of the second body.
/// * `gap`: the initial gap along the normal.
///
/// # Errors
/// Surfaces that are not flat, do not match or do not face each other, or are held or loaded, see [`InterfaceError`].
pub fn pair_flat(
    first: &Body<Solid>,
    second: &Body<Solid>,
    surfaces: [&str; 2],
    gap: &Gap<Solid>,
) -> Result<ContactInterface<Solid>, InterfaceError> {
    let bodies = [first, second];
    let groups = [pairing::surface(first, 0, surfaces[0])?, pairing::surface(second, 1, surfaces[1])?];
    let normals = [plane(first, 0, groups[0])?, plane(second, 1, groups[1])?];
    if normals[0].dot(&normals[1]) >= FACING {
        return Err(InterfaceError::NotFacing { point: first.mesh().facet_middle(groups[0][0]).into() });
    }
    let normal = normals[0];
    let across = |point: Vector| match gap {
        Gap::Geometric => point - point.dot(&normal) * normal,
        Gap::Given(_) | Gap::Touching => point,
    };
    let nodes = nodes(first, groups[0]);
    let partner = nearest(bodies, groups, nodes.iter().copied(), across)?;
    let new = |node: &NodeId| NodePair { nodes: [*node, partner[node]], normal, gap: 0.0, weight: 0.0 };
    let mut pairs: Vec<NodePair<Solid>> = nodes.iter().map(new).collect();
    let facets = facets(bodies, groups, &pairs)?;
    weigh(&mut pairs, &facets);
    pairs.iter().try_for_each(|pair| check_supports(bodies, pair))?;
    let drawn = GeometricGap::measure(bodies, &pairs, &facets, None)?;
    let found = Surfaces { drawn: &drawn, facets: &facets, between: &[] };
    let points = first.mesh().points();
    match gap {
        Gap::Given(data) => {
            check_distances(points, &pairs, &facets, drawn.gaps())?;
            pairing::given_gap(points, &mut pairs, data)?;
        }
        Gap::Touching => found.check_touching(points, &pairs)?,
        Gap::Geometric => found.take_gaps(points, &mut pairs)?,
    }
    let gap_change = drawn.change(points, &pairs);
    Ok(ContactInterface::new(pairs, facets, gap.clone()).with_gap_change(gap_change))
}

/// Pairs a side of a solid with a rigid obstacle: each node with its nearest point. Faces that do not face the obstacle, by more than 60 degrees,
/// are free; the side need not be flat. Against a sphere or a cylinder the normals are `±(x − c)/R`, with the radius `R` of the obstacle, and linear
/// on the faces; the distances at the nodes are exact, and between them the gap is the one of [`ContactInterface::middle_openings`].
///
/// * `surface`: the face group; `obstacle`: the one that the pair is made with.
/// * `gap`: overrides the distance from the obstacle, which is then at most 5 % of the size of a face; `None`: the distance, ≥ 0 to rounding of
///   the mesh.
///
/// # Errors
/// A side that does not face the obstacle, overlaps it, or is held or loaded, faces along which the normal turns by more than 60 degrees, see
/// [`InterfaceError`].
pub fn solid_against(
    body: &Body<Solid>,
    surface: &str,
    obstacle: &Obstacle<Solid>,
    gap: Option<&Gap<Solid>>,
) -> Result<ContactInterface<Solid>, InterfaceError> {
    let line = &obstacle.line;
    let (mesh, all) = (body.mesh(), pairing::group(body, 0, surface)?);
    let group: Vec<FacetId> = all.iter().copied().filter(|f| faces(body, line, *f)).collect();
    if group.is_empty() {
        return Err(InterfaceError::NotFacing { point: mesh.facet_middle(all[0]).into() });
    }
    pairing::check_free(body, 0, surface, &group)?;
    check_apart(body, line, &group, gap)?;
    let mut pairs = Vec::new();
    for (k, node) in nodes(body, &group).into_iter().enumerate() {
        let mut pair = pair_with(body, line, [node, NodeId::new(k)], gap)?;
        let constraint = &body.node_constraints()[node];
        if constraint.rigid_side.is_some() || norm(constraint.held.components(pair.normal)) > SUPPORT {
            return Err(InterfaceError::HeldNode { body: 0, point: mesh.points()[node].into() });
        }
        pair.normal = line.frozen_normal(mesh.points()[node]);
        pair.gap *= pair.normal_length();
        pairs.push(pair);
    }
    let number = numbers(&pairs);
    let mut facets = Vec::with_capacity(group.len());
    for &facet in &group {
        let corners = mesh.topology().facets()[facet].map(|node| number[&node]);
        let bent = turns(corners.map(|k| pairs[k as usize].normal), mesh.facet_middle(facet))?;
        let measure = mesh.facet_measure(facet);
        facets.push(ContactFacet { pairs: corners, facets: [facet; 2], measure, bent, clamped: None });
    }
    weigh(&mut pairs, &facets);
    let gap_change = gap.and_then(|_| change(body, line, &pairs));
    let gap = gap.cloned().unwrap_or(Gap::Geometric);
    Ok(ContactInterface::new(pairs, facets, gap).with_gap_change(gap_change))
}

/// Tells whether the normal turns along a face by more than round-off.
///
/// * `normals`: at its corners; `middle`: of the face, m.
///
/// # Errors
/// A turn of more than 60 degrees.
fn turns(normals: [Vector; 3], middle: Vector) -> Result<bool, InterfaceError> {
    let edges = || ContactFacet::<Solid>::edges().map(|ends| ends.map(|corner| normals[corner]));
    let cosine = |[a, b]: [Vector; 2]| a.dot(&b) / (norm(a) * norm(b));
    let worst = edges().map(cosine).fold(1.0, |least, cosine| if cosine >= least { least } else { cosine });
    if !(worst >= TURN) {
        let degrees = worst.clamp(-1.0, 1.0).acos().to_degrees();
        return Err(InterfaceError::CoarseFace { point: middle.into(), degrees });
    }
    Ok(edges().any(|[a, b]| norm(a - b) > SAME_NORMAL))
}

/// Lists the nodes of facets, ascending.
fn nodes(body: &Body<Solid>, facets: &[FacetId]) -> BTreeSet<NodeId> {
    facets.iter().flat_map(|facet| body.mesh().topology().facets()[*facet]).collect()
}

/// Returns the number of the pair of each of the first body's nodes.
fn numbers(pairs: &[NodePair<Solid>]) -> HashMap<NodeId, u32> {
    pairs.iter().map(|pair| pair.nodes[0]).zip(0..).collect()
}

/// Gives a third of each facet to each of its corners.
fn weigh(pairs: &mut [NodePair<Solid>], facets: &[ContactFacet<Solid>]) {
    for facet in facets {
        facet.pairs.iter().for_each(|k| pairs[*k as usize].weight += facet.measure / Solid::DIM as f64);
    }
}

/// Finds the normal of a flat surface, out of its body.
fn plane(body: &Body<Solid>, number: usize, facets: &[FacetId]) -> Result<Vector, InterfaceError> {
    let mesh = body.mesh();
    let corners = |facet: &FacetId| {
        mesh.topology().oriented_facet(*facet, mesh.cells()).map(|node| mesh.points()[node])
    };
    let corners: Vec<[Vector; 3]> = facets.iter().map(corners).collect();
    let outward = |normal: &Vector| corners.iter().all(|c| Solid::facet_normal(c).dot(normal) > -FACING);
    if let Some(normal) = Solid::flat_normal(&corners, FLAT_SIDE).filter(outward) {
        return Ok(normal);
    }
    let sum: Vector = corners.iter().map(|c| Solid::facet_normal(c) * Solid::facet_measure(c)).sum();
    let (start, length) = (corners[0][0], norm(sum));
    let normal = if length > 0.0 { sum / length } else { Solid::facet_normal(&corners[0]) };
    let distance = |point: &Vector| (point - start).dot(&normal).abs();
    let farthest = corners.as_flattened().iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
    let point = farthest.copied().unwrap_or(start);
    Err(InterfaceError::NotFlat { body: number, point: point.into(), distance: distance(&point) })
}

/// Finds the second body's facet for each of the first.
fn facets(
    bodies: [&Body<Solid>; 2],
    groups: [&[FacetId]; 2],
    pairs: &[NodePair<Solid>],
) -> Result<Vec<ContactFacet<Solid>>, InterfaceError> {
    let alone = |body: usize, facet: FacetId| InterfaceError::FacetWithoutPartner {
        body,
        point: bodies[body].mesh().facet_middle(facet).into(),
        words: Solid::WORDS,
    };
    let number = numbers(pairs);
    let mut seen = BTreeSet::new();
    let mut found = Vec::with_capacity(groups[0].len());
    for &facet in groups[0] {
        let corners = bodies[0].mesh().topology().facets()[facet].map(|node| number[&node]);
        let facing = corners.map(|k| pairs[k as usize].nodes[1]);
        let other = bodies[1].mesh().topology().find_facet(facing);
        let other = other.filter(|f| groups[1].binary_search(f).is_ok()).ok_or_else(|| alone(0, facet))?;
        seen.insert(other);
        let measure = bodies[0].mesh().facet_measure(facet);
        found.push(ContactFacet {
            pairs: corners,
            facets: [facet, other],
            measure,
            bent: false,
            clamped: None,
        });
    }
    match groups[1].iter().find(|facet| !seen.contains(*facet)) {
        Some(facet) => Err(alone(1, *facet)),
        None => Ok(found),
    }
}

/// Refuses a pair one of whose nodes a support holds along the normal, or both of whose nodes are clamped.
fn check_supports(bodies: [&Body<Solid>; 2], pair: &NodePair<Solid>) -> Result<(), InterfaceError> {
    let constraints = [0, 1].map(|b: usize| &bodies[b].node_constraints()[pair.nodes[b]]);
    let both = constraints.iter().all(|constraint| constraint.is_clamped());
    for (body, constraint) in constraints.into_iter().enumerate() {
        let held = constraint.held;
        let along = !held.is_all() && norm(held.components(pair.normal)) > SUPPORT;
        if both || along || constraint.rigid_side.is_some() {
            let point = bodies[body].mesh().points()[pair.nodes[body]].into();
            return Err(InterfaceError::HeldNode { body, point });
        }
    }
    Ok(())
}

/// Refuses surfaces that are too far apart, or overlap too much, for a given gap.
fn check_distances(
    points: &[Vector],
    pairs: &[NodePair<Solid>],
    facets: &[ContactFacet<Solid>],
    drawn: &[f64],
) -> Result<(), InterfaceError> {
    for facet in facets {
        let spacing = facet_size::<Solid>(facet.measure);
        for k in facet.pairs.map(|k| k as usize) {
            if !(drawn[k].abs() <= TOLERANCE * spacing) {
                let point = points[pairs[k].nodes[0]].into();
                return Err(InterfaceError::Distance { point, gap: drawn[k], spacing });
            }
        }
    }
    Ok(())
}
