//! Pairs two contact surfaces of solids that match node by node, and a side of a solid with an obstacle.
//!
//! The normal is a frozen field, linear on the faces between normals at the nodes: face normals would lock, since matching polyhedra
//! interlock at their edges.

pub(super) mod clamped;

use super::geometric_gap::{GeometricGap, Surfaces};
use super::matching::{TOLERANCE, nearest};
use super::normals::SUPPORT;
use super::obstacle::{change, check_apart, faces, pair_with};
use super::{FACING, depth, facet_size, pairing};
use fem_core::body::Body;
use fem_core::geometry::{FLAT_SIDE, norm};
use fem_core::interface::{
    ContactFacet, ContactInterface, Gap, InterfaceError, NodePair, Obstacle, RigidLine, SAME_NORMAL,
};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};
use std::collections::{BTreeSet, HashMap};

/// Two polyhedra with nodes on one surface are at most this part of their largest face apart: a face turns by up to 60 degrees.
const POLYHEDRA: f64 = 0.1;

/// Cosine of the largest angle between two normals of a face, or of two neighbouring faces: 60 degrees.
const TURN: f64 = 0.5;

type Vector = <Solid as Space>::Vector;

/// Pairs contact surfaces of two solids node by node.
///
/// Where the normals come from, in this order: the first body's side if it is declared round, `(x − c)/R`; that side if it is flat; the second body's side, declared
/// round or flat, likewise. Otherwise the normal of a pair is the mean of the first body's face normals around the node, weighted by area. At a node
/// on rollers that mean is turned into the direction that they leave free, if it is within the angle to the next normals: on a plane of
/// symmetry the normal of the whole surface lies in that plane. Where one of the two nodes cannot move it stays. Pairs that both bodies clamp are
/// removed, see [`ContactInterface::clamped`].
///
/// * `surfaces`: the face group of the first and of the second body.
/// * `gap`: the initial gap along the normal.
///
/// # Errors
/// Surfaces that do not match or do not face each other, that turn by more than 60 degrees along a face or between two, are held or loaded, or are
/// pressed into each other by their supports, see [`InterfaceError`].
pub fn pair_solids(
    first: &Body<Solid>,
    second: &Body<Solid>,
    surfaces: [&str; 2],
    gap: &Gap<Solid>,
) -> Result<ContactInterface<Solid>, InterfaceError> {
    pair_known([first, second], surfaces, gap, None)
}

/// What an overlay knows of the surfaces that it made to match.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// The second body's node that faces each of the first.
    pub(super) partner: HashMap<NodeId, NodeId>,
    /// The normals at the first body's nodes; none if a surface is flat.
    pub(super) normals: HashMap<NodeId, Vector>,
    /// The size of the largest face of both surfaces as they were, m.
    pub(super) size: f64,
}

/// Tells whether neither of two surfaces is flat.
pub(super) fn is_curved(bodies: [&Body<Solid>; 2], faces: [&[FacetId]; 2]) -> bool {
    (0..2).all(|b| plane(bodies[b], faces[b]).is_none())
}

/// See [`pair_solids`].
///
/// * `known`: of surfaces that were made to match.
pub(super) fn pair_known(
    bodies: [&Body<Solid>; 2],
    surfaces: [&str; 2],
    gap: &Gap<Solid>,
    known: Option<&Known>,
) -> Result<ContactInterface<Solid>, InterfaceError> {
    let [first, second] = bodies;
    let groups = [pairing::surface(first, 0, surfaces[0])?, pairing::surface(second, 1, surfaces[1])?];
    let planes = [plane(first, groups[0]), plane(second, groups[1])];
    if let [Some(one), Some(other)] = planes
        && one.dot(&other) >= FACING
    {
        return Err(InterfaceError::NotFacing { point: first.mesh().facet_middle(groups[0][0]).into() });
    }
    let round = round_side(bodies, groups)?;
    let flat = planes[0].or(planes[1].map(|normal| -normal)).filter(|_| round.is_none());
    let across = |point: Vector| match (gap, flat, round) {
        (Gap::Geometric | Gap::Interference, Some(normal), _) => point - point.dot(&normal) * normal,
        (Gap::Geometric | Gap::Interference, None, Some((_, line))) => {
            let (distance, out) = line.distance(point);
            point + distance * out
        }
        _ => point,
    };
    let nodes = nodes(first, groups[0]);
    let normal = flat.unwrap_or_default();
    let new = |nodes: [NodeId; 2]| NodePair { nodes, normal, gap: 0.0, weight: 0.0 };
    let mut pairs: Vec<NodePair<Solid>> = match known {
        Some(known) => {
            // Another overlay may have put nodes on the rim.
            let alone = |node: NodeId| InterfaceError::FacetWithoutPartner {
                body: 0,
                point: first.mesh().points()[node].into(),
                words: Solid::WORDS,
            };
            let pair = |node: &NodeId| match known.partner.get(node) {
                Some(other) => Ok(new([*node, *other])),
                None => Err(alone(*node)),
            };
            nodes.iter().map(pair).collect::<Result<_, _>>()?
        }
        None => {
            let partner = nearest(bodies, groups, nodes.iter().copied(), across)?;
            nodes.iter().map(|node| new([*node, partner[node]])).collect()
        }
    };
    let mut facets = facets(bodies, groups, &pairs)?;
    weigh(&mut pairs, &facets);
    match round {
        Some((b, line)) => pairs.iter_mut().for_each(|pair| {
            let normal = line.frozen_normal(bodies[b].mesh().points()[pair.nodes[b]]);
            pair.normal = if b == 0 { normal } else { -normal };
        }),
        None if flat.is_some() => {}
        None => match known {
            Some(known) => {
                let normal = |pair: &NodePair<Solid>| known.normals.get(&pair.nodes[0]).copied();
                pairs.iter_mut().for_each(|pair| pair.normal = normal(pair).unwrap_or_default());
            }
            None => averaged(bodies, &mut pairs, &facets)?,
        },
    }
    for facet in &mut facets {
        facet.bent = check_face(bodies, facet, &pairs)?;
    }
    if !gap.is_bonded() {
        pairs.iter().try_for_each(|pair| check_supports(bodies, pair))?;
    }
    // Surfaces laid over each other face each other along one direction, not along their normals.
    let is_overlay = known.is_some() && flat.is_none();
    let drawn = match is_overlay {
        true => GeometricGap::between(bodies, &pairs, &facets),
        false => GeometricGap::measure(bodies, &pairs, &facets, None)?,
    };
    let found = Surfaces { drawn: &drawn, facets: &facets, between: &[] };
    let apart = known.filter(|_| is_overlay).map_or(0.0, |known| POLYHEDRA * known.size);
    let points = first.mesh().points();
    match gap {
        Gap::Given(data) => {
            check_distances(points, &pairs, &facets, (drawn.gaps(), apart))?;
            pairing::given_gap(points, &mut pairs, data)?;
        }
        Gap::Touching | Gap::Bonded { .. } if is_overlay => {
            check_distances(points, &pairs, &facets, (drawn.gaps(), apart))?
        }
        Gap::Touching | Gap::Bonded { .. } => found.check_touching(points, &pairs)?,
        Gap::Geometric | Gap::Interference => found.take_gaps(points, &mut pairs, gap)?,
    }
    depth::check(bodies.map(Some), &pairs, &facets)?;
    let gap_change = drawn.change(points, &pairs);
    let whole = ContactInterface::new(pairs, facets, gap.clone());
    Ok(clamped::without_clamped(bodies, whole)?.with_gap_change(gap_change))
}

/// Pairs a side of a solid with a rigid obstacle: each node with its nearest point. Faces that do not face the obstacle, by more than 60 degrees,
/// are free; the side need not be flat. Against a sphere or a cylinder the normals are `±(x − c)/R`, with the radius `R` of the obstacle, and linear
/// on the faces; the distances at the nodes are exact, and between them the gap is the one of [`ContactInterface::middle_openings`].
///
/// * `surface`: the face group; `obstacle`: the one that the pair is made with.
/// * `gap`: a given one overrides the distance from the obstacle, which is then at most 5 % of the size of a face; `None`: the distance, ≥ 0 to
///   rounding of the mesh; [`Gap::Interference`] keeps an overlap.
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
        facets.push(ContactFacet { pairs: corners, facets: [facet; 2], measure, bent, clamped: [None; 3] });
    }
    weigh(&mut pairs, &facets);
    depth::check([Some(body), None], &pairs, &facets)?;
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
pub(super) fn turns(normals: [Vector; 3], middle: Vector) -> Result<bool, InterfaceError> {
    let edges = || ContactFacet::<Solid>::edges().map(|ends| ends.map(|corner| normals[corner]));
    check_turns(edges(), middle)?;
    Ok(edges().any(|[a, b]| norm(a - b) > SAME_NORMAL))
}

/// Refuses normals of which two differ by more than 60 degrees.
///
/// * `normals`: two by two; `middle`: of a face where they are, m.
fn check_turns(normals: impl IntoIterator<Item = [Vector; 2]>, middle: Vector) -> Result<(), InterfaceError> {
    let cosine = |[a, b]: [Vector; 2]| a.dot(&b) / (norm(a) * norm(b));
    let worst = normals
        .into_iter()
        .map(cosine)
        .fold(1.0, |least, cosine| if cosine >= least { least } else { cosine });
    if !(worst >= TURN) {
        let degrees = worst.clamp(-1.0, 1.0).acos().to_degrees();
        return Err(InterfaceError::CoarseFace { point: middle.into(), degrees });
    }
    Ok(())
}

/// Finds the side from whose declared round surface the normals come, and that surface: the first body's, or the second's if the first is not flat.
///
/// # Errors
/// Sides on several surfaces.
pub(super) fn round_side(
    bodies: [&Body<Solid>; 2],
    groups: [&[FacetId]; 2],
) -> Result<Option<(usize, RigidLine<Solid>)>, InterfaceError> {
    let shapes = [declared(bodies[0], 0, groups[0])?, declared(bodies[1], 1, groups[1])?];
    let round =
        |b: usize| shapes[b].filter(|line| !matches!(line, RigidLine::Plane { .. })).map(|line| (b, line));
    Ok(round(0).or_else(|| round(1).filter(|_| plane(bodies[0], groups[0]).is_none())))
}

/// Finds the declared surface of all contact faces of a body; `None` if none is declared there.
///
/// # Errors
/// Faces on several surfaces, or of which only some are on one.
fn declared(
    body: &Body<Solid>,
    number: usize,
    facets: &[FacetId],
) -> Result<Option<RigidLine<Solid>>, InterfaceError> {
    let found = body.surface(facets[0]);
    match facets.iter().find(|facet| body.surface(**facet) != found) {
        Some(facet) => {
            let point = body.mesh().facet_middle(*facet).into();
            Err(InterfaceError::MixedSurface { body: number, point })
        }
        None => Ok(found.copied()),
    }
}

/// Computes the normals of the nodes of a surface: the mean of the normals of the faces around each, see [`pair_solids`].
///
/// # Errors
/// Two neighbouring faces at more than 60 degrees.
pub(super) fn averaged_normals(
    body: &Body<Solid>,
    surface: &[FacetId],
) -> Result<HashMap<NodeId, Vector>, InterfaceError> {
    let new = |node| NodePair { nodes: [node; 2], normal: Vector::zeros(), gap: 0.0, weight: 0.0 };
    let mut pairs: Vec<NodePair<Solid>> = nodes(body, surface).into_iter().map(new).collect();
    let number = numbers(&pairs);
    let facet = |facet: &FacetId| ContactFacet {
        pairs: body.mesh().topology().facets()[*facet].map(|node| number[&node]),
        facets: [*facet; 2],
        measure: body.mesh().facet_measure(*facet),
        bent: false,
        clamped: [None; 3],
    };
    averaged([body; 2], &mut pairs, &surface.iter().map(facet).collect::<Vec<_>>())?;
    Ok(pairs.into_iter().map(|pair| (pair.nodes[0], pair.normal)).collect())
}

/// Gives each pair the mean of the normals of the first body's faces around it, or the direction next to it that supports leave free.
///
/// # Errors
/// Two neighbouring faces at more than 60 degrees.
fn averaged(
    bodies: [&Body<Solid>; 2],
    pairs: &mut [NodePair<Solid>],
    facets: &[ContactFacet<Solid>],
) -> Result<(), InterfaceError> {
    let mesh = bodies[0].mesh();
    let mut along: HashMap<[u32; 2], Vector> = HashMap::new();
    for facet in facets {
        let normal = mesh.facet_normal(facet.facets[0]);
        facet.pairs.iter().for_each(|k| pairs[*k as usize].normal += facet.measure * normal);
        for ends in ContactFacet::<Solid>::edges() {
            let mut edge = ends.map(|corner| facet.pairs[corner]);
            edge.sort_unstable();
            if let Some(other) = along.insert(edge, normal) {
                check_turns([[normal, other]], mesh.facet_middle(facet.facets[0]))?;
            }
        }
    }
    pairs.iter_mut().for_each(|pair| pair.normal /= norm(pair.normal));
    let mut turns = vec![0.0f64; pairs.len()];
    for ends in facets.iter().flat_map(|facet| {
        ContactFacet::<Solid>::edges().map(|ends| ends.map(|corner| facet.pairs[corner] as usize))
    }) {
        let [a, b] = ends.map(|k| pairs[k].normal);
        ends.iter().for_each(|k| turns[*k] = turns[*k].max(a.angle(&b)));
    }
    for (pair, turn) in pairs.iter_mut().zip(turns) {
        let held = [0, 1].map(|b: usize| bodies[b].node_constraints()[pair.nodes[b]].held);
        if held.iter().any(|held| held.is_all()) {
            continue;
        }
        for held in held.into_iter().filter(|held| !held.is_none()) {
            if let Some(free) = held.complement().nearest(pair.normal)
                && pair.normal.angle(&free) <= 2.0 * turn
            {
                pair.normal = free;
            }
        }
    }
    Ok(())
}

/// Tells whether the normal turns along a face, and checks it.
///
/// # Errors
/// Normals that turn by more than 60 degrees, also from those of the face itself, or point into the first body or out of the second.
pub(super) fn check_face(
    bodies: [&Body<Solid>; 2],
    facet: &ContactFacet<Solid>,
    pairs: &[NodePair<Solid>],
) -> Result<bool, InterfaceError> {
    let normals = facet.pairs.map(|k| pairs[k as usize].normal);
    let [own, other] = [0, 1].map(|b: usize| bodies[b].mesh().facet_normal(facet.facets[b]));
    let middle = bodies[0].mesh().facet_middle(facet.facets[0]);
    if !normals.iter().all(|normal| normal.dot(&own) > 0.0 && normal.dot(&other) < 0.0) {
        return Err(InterfaceError::NotFacing { point: middle.into() });
    }
    check_turns(normals.map(|normal| [normal, own]), middle)?;
    turns(normals, middle)
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
pub(super) fn weigh(pairs: &mut [NodePair<Solid>], facets: &[ContactFacet<Solid>]) {
    for facet in facets {
        facet.pairs.iter().for_each(|k| pairs[*k as usize].weight += facet.measure / Solid::DIM as f64);
    }
}

/// Finds the normal of a flat surface, out of its body; `None` if it is not flat.
pub(super) fn plane(body: &Body<Solid>, facets: &[FacetId]) -> Option<Vector> {
    let corners = body.outward_faces(facets);
    let outward = |normal: &Vector| corners.iter().all(|c| Solid::facet_normal(c).dot(normal) > -FACING);
    Solid::flat_normal(&corners, FLAT_SIDE).filter(outward)
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
            clamped: [None; 3],
        });
    }
    match groups[1].iter().find(|facet| !seen.contains(*facet)) {
        Some(facet) => Err(alone(1, *facet)),
        None => Ok(found),
    }
}

/// Refuses a pair one of whose nodes a support holds along the normal; it may be clamped.
pub(super) fn check_supports(
    bodies: [&Body<Solid>; 2],
    pair: &NodePair<Solid>,
) -> Result<(), InterfaceError> {
    let constraints = [0, 1].map(|b: usize| &bodies[b].node_constraints()[pair.nodes[b]]);
    for (body, constraint) in constraints.into_iter().enumerate() {
        let held = constraint.held;
        let along = !held.is_all() && norm(held.components(pair.normal)) > SUPPORT * norm(pair.normal);
        if along || constraint.rigid_side.is_some() {
            let point = bodies[body].mesh().points()[pair.nodes[body]].into();
            return Err(InterfaceError::HeldNode { body, point });
        }
    }
    Ok(())
}

/// Refuses surfaces that are too far apart, or overlap too much, for a given gap.
///
/// * `drawn`: the distances at the pairs; `apart`: that of polyhedra through the nodes of one surface, m.
fn check_distances(
    points: &[Vector],
    pairs: &[NodePair<Solid>],
    facets: &[ContactFacet<Solid>],
    (drawn, apart): (&[f64], f64),
) -> Result<(), InterfaceError> {
    for facet in facets {
        let spacing = facet_size::<Solid>(facet.measure);
        for k in facet.pairs.map(|k| k as usize) {
            if !(drawn[k].abs() <= (TOLERANCE * spacing).max(apart)) {
                let point = points[pairs[k].nodes[0]].into();
                return Err(InterfaceError::Distance { point, gap: drawn[k], spacing });
            }
        }
    }
    Ok(())
}
