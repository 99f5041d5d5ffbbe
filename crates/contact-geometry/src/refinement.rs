//! The same contact problem on finer meshes that match along the interface.

use super::obstacle::refined_against;
use super::{measure_arc, outline};
use fem_core::body::{Body, BodyError, Piece};
use fem_core::geometry::{Point, Vector, norm};
use fem_core::interface::Line;
use fem_core::interface::Profile;
use fem_core::interface::{
    ContactFacet, ContactInterface, ContactPair, ContactProblem, Gap, InterfaceError, NodePair, Partner,
};
use fem_core::mesh::MeshError;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::refine::{self, Refinement, RefinementEdges};
use fem_core::mesh::topology::NONE;
use fem_core::parallel::try_each_body;
use fem_core::smooth::is_off_chord;
use std::collections::HashMap;
use thiserror::Error;

/// Why a problem cannot be refined.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RefineError {
    /// The finer mesh of a body is too large, or its triangles are too small for floating-point numbers.
    #[error("the finer mesh of body {body}: {source}")]
    Mesh {
        /// Its number, from 0.
        body: usize,
        /// The error of its mesh.
        source: MeshError,
    },
    /// A condition cannot be evaluated on the finer mesh.
    #[error("body {body} on the finer mesh: {source}")]
    Body {
        /// Its number, from 0.
        body: usize,
        /// The error of its conditions.
        source: BodyError,
    },
    /// Contact pairs join two nodes of one cell, which no refinement can tell apart.
    #[error(
        "body {body}: contact pairs join two nodes of one cell, one of them at {point}; a cell with both cannot be refined; use \
         smaller cells there, or take one of the pairs out"
    )]
    JoinedNodes {
        /// Its number, from 0.
        body: usize,
        /// One of the nodes.
        point: Point,
    },
    /// The gap cannot be evaluated on the finer interface.
    #[error("on the finer interface: {0}")]
    Interface(#[from] InterfaceError),
}

/// A refined problem and the origin of its parts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedProblem {
    /// The problem.
    pub problem: ContactProblem,
    /// The refinement of each body's mesh.
    pub refinements: Vec<Refinement>,
    /// The origin of each pair.
    pub pairs: Vec<RefinedPair>,
}

/// The origin of the pairs of nodes on a refined contact line.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedPair {
    /// For every new pair of nodes the two neighbouring old ones: the same one twice if it is an old pair, or the first
    /// one next to a clamped end. Of solids old pairs keep their numbers, and a neighbour may be a new pair with a smaller number.
    pub parents: Vec<[u32; 2]>,
    old: usize,
}

impl RefinedPair {
    pub(super) fn new(parents: Vec<[u32; 2]>, old: usize) -> Self {
        Self { parents, old }
    }

    /// Transfers values of the old pairs of nodes.
    ///
    /// * `join`: the values of two neighbours.
    ///
    /// # Panics
    /// If `values` does not have one entry per old pair of nodes.
    pub fn inherited<T: Copy>(&self, values: &[T], join: impl Fn(T, T) -> T) -> Vec<T> {
        let old = self.old;
        assert!(values.len() == old, "{} values, and {old} pairs before the refinement", values.len());
        let mut new: Vec<T> = Vec::with_capacity(self.parents.len());
        for parents in &self.parents {
            let [a, b] = parents.map(|p| values.get(p as usize).copied().unwrap_or_else(|| new[p as usize]));
            new.push(join(a, b));
        }
        new
    }

    /// Returns the number of pairs of nodes before the refinement.
    pub fn old(&self) -> usize {
        self.old
    }

    /// Transfers a P1 function on the contact line, one number per pair of nodes along its normal.
    ///
    /// # Panics
    /// If `values` does not have one entry per old pair of nodes.
    pub fn prolong(&self, values: &[f64]) -> Vec<f64> {
        self.inherited(values, |a, b| 0.5 * (a + b))
    }
}

/// Marks further edges until the refinements of all bodies are conforming and match: a contact edge is marked in both
/// of its bodies or in neither. Returns the number of nodes that each refined body will have.
///
/// * `marked`: one entry per edge of each body.
///
/// # Panics
/// If the arrays do not belong to the bodies' meshes.
pub fn close(
    problem: &ContactProblem,
    refinement_edges: &[RefinementEdges],
    marked: &mut [Vec<bool>],
) -> Vec<usize> {
    loop {
        for ((body, edges), marked) in problem.bodies.iter().zip(refinement_edges).zip(&mut *marked) {
            refine::close(body.mesh(), edges, marked);
        }
        let mut added = false;
        for pair in &problem.contacts {
            let Some([first, second]) = pair.bodies() else { continue };
            for contact in pair.interface.line().1 {
                let [a, b] = contact.facets;
                if marked[first][a] != marked[second][b] {
                    (marked[first][a], marked[second][b], added) = (true, true, true);
                }
            }
        }
        if !added {
            let count = |(body, marked): (&Body, &Vec<bool>)| {
                body.mesh().points().len() + marked.iter().filter(|m| **m).count()
            };
            return problem.bodies.iter().zip(&*marked).map(count).collect();
        }
    }
}

/// Halves the marked edges of all bodies, after [`close()`]: the same problem on finer meshes, but for nodes
/// that are moved onto declared curves ([`Body::with_curves`]).
///
/// The parts of an edge inherit its conditions. New nodes on contact edges become new pairs. Functions, including
/// the gap, are evaluated at the new nodes; a measured gap is evaluated between declared curves and straight stretches, or if a
/// side is neither, between smooth curves through the nodes of the first meshes. If the normal changes along an edge, the new
/// normal is the mean of the two at its ends, which is shorter than one: the normal field is the same on all meshes. On a
/// circle's polygon it stays proportional to the arm from the centre, so rotations about the centre remain free. At a node
/// that is moved onto a curve its length is one, for the same reason. A new node stays on the chord of its edge if a cell
/// would turn over ([`Body::nodes_on_chords`]).
///
/// # Errors
/// Meshes that become too large or too small, functions that are not finite at new nodes.
///
/// # Panics
/// See [`close()`].
pub fn refined(
    problem: &ContactProblem,
    refinement_edges: &[RefinementEdges],
    marked: &[Vec<bool>],
) -> Result<RefinedProblem, RefineError> {
    if problem.contacts.iter().any(|pair| pair.slip_before.is_some()) {
        return Err(InterfaceError::SlipOnCoarserMesh.into());
    }
    let mut marked = marked.to_vec();
    close(problem, refinement_edges, &mut marked);
    let places = on_curves(problem, &marked);
    let refine = |b: usize| -> Result<(Refinement, Body), RefineError> {
        let old = &problem.bodies[b];
        let curve = |edge| places[b].get(&edge).copied();
        let refinement = refine::refine_onto(old.mesh(), &refinement_edges[b], &marked[b], |_| None, curve)
            .map_err(|source| RefineError::Mesh { body: b, source })?;
        let body = old.refined(&refinement).map_err(|source| RefineError::Body { body: b, source })?;
        Ok((refinement, body))
    };
    let (refinements, bodies): (Vec<_>, Vec<_>) =
        try_each_body(problem.bodies.len(), refine)?.into_iter().unzip();
    let refine = |pair: &ContactPair| match pair.partner {
        Partner::Body(second) => {
            let both = [pair.body, second];
            refined_interface(&pair.interface, both.map(|b| &bodies[b]), both.map(|b| &refinements[b]))
        }
        Partner::Obstacle(k) => {
            let (body, middle) = (&bodies[pair.body], &refinements[pair.body].middle);
            refined_against(&pair.interface, body, middle, &problem.obstacles[k])
        }
    };
    let interfaces: Vec<_> = problem.contacts.iter().map(refine).collect::<Result<_, _>>()?;
    let (mut finer, mut pairs) = (ContactProblem::new(bodies), Vec::new());
    for (k, (pair, (interface, parents))) in problem.contacts.iter().zip(interfaces).enumerate() {
        finer = match pair.partner {
            Partner::Body(second) => finer.contact([pair.body, second], interface),
            Partner::Obstacle(o) => finer.obstacle(pair.body, interface, problem.obstacles[o].clone()),
        };
        finer.contacts[k].roles = pair.roles;
        finer = finer.with_friction(k, pair.friction.clone())?;
        pairs.push(RefinedPair::new(parents, pair.interface.pairs().len()));
    }
    Ok(RefinedProblem { problem: finer, refinements, pairs })
}

/// Finds the places of the new nodes of each body on declared curves, by edge. On a contact edge the second body's node lies on the
/// contact normal of the first one's.
fn on_curves(problem: &ContactProblem, marked: &[Vec<bool>]) -> Vec<HashMap<FacetId, Vector>> {
    let own = |(body, marked): (&Body, &Vec<bool>)| -> HashMap<FacetId, Vector> {
        if !body.has_curves() {
            return HashMap::new();
        }
        let edges = (0..marked.len()).map(FacetId::new).filter(|e| marked[*e]);
        edges.filter_map(|e| Some((e, body.curve_middle(e)?))).collect()
    };
    let mut places: Vec<HashMap<FacetId, Vector>> = problem.bodies.iter().zip(marked).map(own).collect();
    for pair in &problem.contacts {
        let Some(both) = pair.bodies() else { continue };
        for edge in pair.interface.line().1 {
            // Gaps are measured on one of the bodies; on an arc that gives the normals, these come from its nodes.
            let radial = pair.interface.radial();
            let m = radial.map_or(pair.interface.measured_on(), |radial| radial.side);
            let o = 1 - m;
            let [own, other] = [m, o].map(|b| (&problem.bodies[both[b]], edge.facets[b]));
            let Some(curve) = other.0.curve(other.1).filter(|_| marked[both[o]][other.1]) else {
                continue;
            };
            let point = places[both[m]].get(&own.1).copied();
            let point = point.unwrap_or_else(|| own.0.mesh().facet_middle(own.1));
            let [i, j] = edge.pairs.map(|k| pair.interface.line().0[k as usize].normal);
            let normal = radial.map_or(i + j, |radial| radial.at(point));
            let normal = 1.0 / norm(normal) * normal;
            if let Some(found) = curve.crossing(other.0.mesh().facet_corners(other.1), point, normal) {
                places[both[o]].insert(other.1, found);
            }
        }
    }
    places
}

/// Creates the interface of the refined bodies, and the parents of its pairs.
fn refined_interface(
    interface: &ContactInterface,
    bodies: [&Body; 2],
    refinements: [&Refinement; 2],
) -> Result<(ContactInterface, Vec<[u32; 2]>), InterfaceError> {
    let side = interface.measured_on();
    let (old_pairs, old_edges, old_profiles) = interface.line();
    let mut starting = vec![None; old_pairs.len()];
    for (edge, profile) in old_edges.iter().zip(old_profiles) {
        starting[edge.pairs[0] as usize] = Some((edge, profile.as_ref()));
    }
    let old_arcs = interface.line_arc_lengths();
    let (mut pairs, mut arc_lengths) = (Vec::new(), Vec::new());
    let mut parents = Vec::new();
    let mut number = vec![NONE; old_pairs.len()];
    let mut middle = vec![NONE; old_pairs.len()];
    for (k, pair) in old_pairs.iter().enumerate() {
        number[k] = pairs.len() as u32;
        pairs.push(NodePair { weight: 0.0, ..*pair });
        arc_lengths.push(old_arcs[k]);
        parents.push([k as u32; 2]);
        let nodes = |edge: &ContactFacet| [0, 1].map(|b| refinements[b].middle[edge.facets[b]]);
        let halved = starting[k].map(|(edge, profile)| (edge, profile, nodes(edge)));
        if let Some((edge, profile, nodes)) = halved.filter(|(.., n)| *n != [NodeId::NONE; 2]) {
            middle[k] = pairs.len() as u32;
            pairs.push(middle_pair(interface, old_pairs, (edge, profile), nodes, bodies)?);
            arc_lengths.push(old_arcs[k] + 0.5 * edge.measure);
            parents.push(edge.pairs);
        }
    }
    let (mut edges, mut profiles) = (Vec::new(), Vec::new());
    for (edge, profile) in old_edges.iter().zip(old_profiles) {
        let [i, j] = edge.pairs.map(|k| number[k as usize]);
        let parts = match middle[edge.pairs[0] as usize] {
            NONE => vec![([i, j], *profile)],
            m => {
                let halves = profile.as_ref().map(Profile::halves);
                vec![([i, m], halves.map(|h| h[0])), ([m, j], halves.map(|h| h[1]))]
            }
        };
        for (ends, profile) in parts {
            if let Some(part) = part(side, bodies, &mut pairs, ends) {
                edges.push(part);
                profiles.push(profile.and_then(|profile| measured(side, bodies, &pairs, &part, profile)));
            }
        }
    }
    if bodies[side].has_curves() {
        arc_lengths = measure_arc(pairs.len(), &edges);
    }
    let line = Line { pairs, edges, arc_lengths, profiles };
    let (finer, numbers) = line.between(bodies, interface.gap().clone(), side)?;
    let kept = parents.into_iter().zip(numbers).filter(|(_, n)| *n != NONE).map(|(p, _)| p);
    let parents = kept.map(|parents| interface.numbers(parents)).collect();
    Ok((finer.with_radial(interface.radial()).with_gap_factor(interface.gap_factor()), parents))
}

/// Creates the pair in the middle of a contact edge.
fn middle_pair(
    interface: &ContactInterface,
    pairs: &[NodePair],
    (edge, profile): (&ContactFacet, Option<&Profile>),
    nodes: [NodeId; 2],
    bodies: [&Body; 2],
) -> Result<NodePair, InterfaceError> {
    let [i, j] = edge.pairs.map(|k| &pairs[k as usize]);
    let side = interface.measured_on();
    let points = bodies[side].mesh().points();
    let point = points[nodes[side]];
    let mean = 0.5 * (i.normal + j.normal);
    let length = if edge.bent { norm(mean) } else { 1.0 };
    let ends = [i, j].map(|pair| points[pair.nodes[side]]);
    let normal = match interface.radial() {
        Some(radial) => radial.normal(bodies, nodes),
        // A node on a curve is as far from its centre as its neighbours.
        None if is_off_chord(point, ends) => 1.0 / length * mean,
        None => mean,
    };
    let scale = if edge.bent { norm(normal) } else { 1.0 };
    let measured = |pieces: &[Piece; 2]| {
        let near = [0, 1].map(|b| bodies[b].mesh().points()[nodes[b]]);
        outline::gap(pieces, point, normal, near)
    };
    let factor = interface.gap_factor();
    let gap = match (interface.gap(), profile) {
        (Gap::Touching | Gap::Bonded { .. }, _) => 0.0,
        (Gap::Given(data), _) => factor * scale * data.at(point),
        (gap, Some(profile)) => {
            let distance = profile.pieces.as_ref().and_then(measured).unwrap_or_else(|| profile.at(0.5));
            factor * scale * gap.kept(distance)
        }
        (_, None) if edge.bent => 0.5 * (i.gap_vector() + j.gap_vector()).dot(&normal),
        (_, None) => 0.5 * (i.gap + j.gap),
    };
    if !gap.is_finite() {
        return Err(InterfaceError::BadGap { point: point.into(), value: gap });
    }
    Ok(NodePair { nodes, normal, gap, weight: 0.0 })
}

/// Measures the profile of an edge again if the pieces over it are known; otherwise it is a part of the old one.
fn measured(
    measured_on: usize,
    bodies: [&Body; 2],
    pairs: &[NodePair],
    edge: &ContactFacet,
    part: Profile,
) -> Option<Profile> {
    let Some(pieces) = part.pieces else { return Some(part) };
    let ends = edge.pairs.map(|k| &pairs[k as usize]);
    let at = |t: f64| {
        let mix = |a: Vector, b: Vector| (1.0 - t) * a + t * b;
        let near = [0, 1].map(|b| {
            let [from, to] = ends.map(|pair| bodies[b].mesh().points()[pair.nodes[b]]);
            mix(from, to)
        });
        outline::gap(&pieces, near[measured_on], mix(ends[0].normal, ends[1].normal), near)
    };
    let gaps = ends.map(|pair| pair.gap / norm(pair.normal));
    let between = at(1.0 / 3.0).zip(at(2.0 / 3.0)).map(<[f64; 2]>::from);
    between.map_or(Some(part), |between| Profile::of_pieces(pieces, gaps, between, edge.measure))
}

/// Creates the edge between two pairs and adds its length to their tributary lengths.
fn part(
    measured_on: usize,
    bodies: [&Body; 2],
    pairs: &mut [NodePair],
    ends: [u32; 2],
) -> Option<ContactFacet> {
    let [i, j] = ends.map(|k| pairs[k as usize].nodes);
    let find = |b: usize| bodies[b].mesh().topology().find_edge(i[b], j[b]);
    let edges = [find(0)?, find(1)?];
    let length = bodies[measured_on].mesh().facet_measure(edges[measured_on]);
    for k in ends {
        pairs[k as usize].weight += 0.5 * length;
    }
    Some(ContactFacet { pairs: ends, facets: edges, measure: length, bent: false, clamped: [None; 2] })
}

#[cfg(test)]
mod tests;
