//! Pairs two flat contact surfaces of solids that match node by node.

use super::geometric_gap::{GeometricGap, Surfaces};
use super::matching::{TOLERANCE, nearest};
use super::normals::SUPPORT;
use super::{ContactFacet, ContactInterface, Gap, InterfaceError, NodePair, facet_size, pairing};
use crate::body::Body;
use crate::geometry::{FLAT_SIDE, norm};
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Solid, Space};
use std::collections::{BTreeSet, HashMap};

/// Cosine of the smallest angle between the outward normals of two facing facets: 120 degrees.
const FACING: f64 = -0.5;

type Vector = <Solid as Space>::Vector;

impl ContactInterface<Solid> {
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
    ) -> Result<Self, InterfaceError> {
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
        let topology = first.mesh().topology();
        let nodes: BTreeSet<NodeId> = groups[0].iter().flat_map(|f| topology.facets()[*f]).collect();
        let partner = nearest(bodies, groups, nodes.iter().copied(), across)?;
        let new = |node: &NodeId| NodePair { nodes: [*node, partner[node]], normal, gap: 0.0, weight: 0.0 };
        let mut pairs: Vec<NodePair<Solid>> = nodes.iter().map(new).collect();
        let facets = facets(bodies, groups, &pairs)?;
        for facet in &facets {
            facet.pairs.iter().for_each(|k| pairs[*k as usize].weight += facet.measure / Solid::DIM as f64);
        }
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
        Ok(Self {
            pairs,
            facets,
            gap: gap.clone(),
            measured_on: 0,
            arc_lengths: Vec::new(),
            profiles: Vec::new(),
            gap_change,
            radial: None,
            whole: None,
        })
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
    let number: HashMap<NodeId, u32> = pairs.iter().map(|p| p.nodes[0]).zip(0..).collect();
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
