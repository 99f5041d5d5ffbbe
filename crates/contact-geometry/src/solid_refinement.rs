//! The same contact problem of solids on finer meshes that match along the surfaces: see [`fem_core::mesh::bisect`].

use super::obstacle::pair_with;
use super::refinement::{RefineError, RefinedPair};
use super::solid_pairs::clamped::without_clamped;
use super::solid_pairs::{check_face, check_supports, round_side, turns, weigh};
use fem_core::body::{Body, FinerBody, move_onto_surfaces};
use fem_core::geometry::norm;
use fem_core::interface::{
    ContactFacet, ContactInterface, ContactPair, ContactProblem, Gap, InterfaceError, NodePair, Obstacle,
    Partner, RigidLine,
};
use fem_core::mesh::TetMesh;
use fem_core::mesh::bisect::{BodyTets, EdgeOrder, TetRefinement, Tets};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::parallel::try_each_body;
use fem_core::space::{Solid, Space};
use std::collections::{BTreeMap, HashMap, HashSet};

type Vector = <Solid as Space>::Vector;

/// A refined problem of solids and the origin of its parts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedSolids {
    /// The problem.
    pub problem: ContactProblem<Solid>,
    /// The refinement of each body's mesh.
    pub refinements: Vec<TetRefinement>,
    /// The origin of each pair.
    pub pairs: Vec<RefinedPair>,
    /// The order of the edges of the finer meshes.
    pub order: EdgeOrder,
}

/// Chooses the order of the edges of first meshes: nodes that face each other in contact pairs are one.
///
/// # Errors
/// A cell two of whose nodes are one.
pub fn edge_order(problem: &ContactProblem<Solid>) -> Result<EdgeOrder, RefineError> {
    let of_pair = |pair: &ContactPair<Solid>| {
        let both = pair.bodies().into_iter();
        let nodes = |[a, b]: [usize; 2]| {
            whole(&pair.interface).into_iter().map(move |of| [(a, of.nodes[0]), (b, of.nodes[1])])
        };
        both.flat_map(nodes).collect::<Vec<_>>()
    };
    let joined: Vec<_> = problem.contacts.iter().flat_map(of_pair).collect();
    EdgeOrder::new(&meshes(problem), &joined).map_err(|of| RefineError::JoinedNodes {
        body: of.body,
        point: problem.bodies[of.body].mesh().points()[of.node].into(),
    })
}

fn meshes(problem: &ContactProblem<Solid>) -> Vec<&TetMesh> {
    problem.bodies.iter().map(Body::mesh).collect()
}

/// Counts the nodes of all bodies after cells are halved a number of times, with their parts.
///
/// * `cells`: of each body.
pub fn count_halved(
    problem: &ContactProblem<Solid>,
    order: &EdgeOrder,
    cells: &[Vec<u32>],
    times: usize,
) -> usize {
    let start = Tets::of(&meshes(problem), order);
    (0..times).fold(start, |tets, _| tets.halved(&tets.descendants(cells))).nodes()
}

/// Halves cells of all bodies and those that have to be with them: the same problem on finer meshes, but for nodes that are moved onto declared
/// surfaces ([`move_onto_surfaces`]).
///
/// The parts of a face inherit its conditions and its surface. New nodes on contact surfaces become new pairs. Functions, including the gap, are
/// evaluated at the new nodes. If a side is declared round, the new normals are `(x − c)/R`, and a measured gap is measured along them; otherwise
/// normals and measured gaps stay linear on the faces of the first meshes.
///
/// * `order`: of the edges of these meshes; `cells`: of each body.
///
/// # Errors
/// Meshes that become too large or too small, functions that are not finite at new nodes.
pub fn halved(
    problem: &ContactProblem<Solid>,
    order: &EdgeOrder,
    cells: &[Vec<u32>],
) -> Result<RefinedSolids, RefineError> {
    if problem.contacts.iter().any(|pair| pair.slip_before.is_some()) {
        return Err(InterfaceError::SlipOnCoarserMesh.into());
    }
    let Tets { bodies: tets, order } = Tets::of(&meshes(problem), order).halved(cells);
    let surfaces = surfaces(problem);
    let finer = |((body, tets), surfaces)| FinerBody::new(body, tets, surfaces);
    let mut moving: Vec<FinerBody<'_>> = problem.bodies.iter().zip(&tets).zip(&surfaces).map(finer).collect();
    move_onto_surfaces(&mut moving, &order);
    let points: Vec<Vec<Vector>> = moving.into_iter().map(|body| body.points).collect();
    let refine = |b: usize| -> Result<(TetRefinement, Body<Solid>), RefineError> {
        let old = &problem.bodies[b];
        let refinement = TetRefinement::new(old.mesh(), tets[b].clone(), points[b].clone())
            .map_err(|source| RefineError::Mesh { body: b, source })?;
        let body = old.refined(&refinement).map_err(|source| RefineError::Body { body: b, source })?;
        Ok((refinement, body))
    };
    let (refinements, bodies): (Vec<_>, Vec<_>) =
        try_each_body(problem.bodies.len(), refine)?.into_iter().unzip();
    let (mut finer, mut pairs) = (ContactProblem::new(bodies), Vec::new());
    for (k, pair) in problem.contacts.iter().enumerate() {
        let surface = FinerSurface::of(pair, &tets, &refinements)?;
        finer = match pair.partner {
            Partner::Body(second) => {
                let interface =
                    surface.between(&pair.interface, [pair.body, second].map(|b| &finer.bodies[b]))?;
                finer.contact([pair.body, second], interface)
            }
            Partner::Obstacle(o) => {
                let obstacle = &problem.obstacles[o];
                let interface = surface.against(&pair.interface, &finer.bodies[pair.body], obstacle)?;
                finer.obstacle(pair.body, interface, obstacle.clone())
            }
        };
        finer.contacts[k].roles = pair.roles;
        finer = finer.with_friction(k, pair.friction.clone())?;
        let parents = surface.kept_parents(&finer.contacts[k].interface);
        pairs.push(RefinedPair::new(parents, pair.interface.pairs().len()));
    }
    Ok(RefinedSolids { problem: finer, refinements, pairs, order })
}

/// Lists all pairs of a surface: first those of the contact problem, then those that both bodies clamp.
fn whole(interface: &ContactInterface<Solid>) -> Vec<NodePair<Solid>> {
    interface.pairs().iter().chain(interface.clamped().iter().map(|of| &of.pair)).copied().collect()
}

/// Lists the faces of each body with their surfaces. A side that touches a declared one of another body has its surface.
fn surfaces(problem: &ContactProblem<Solid>) -> Vec<BTreeMap<FacetId, RigidLine<Solid>>> {
    let mut all: Vec<_> = problem.bodies.iter().map(|body| body.surfaces().clone()).collect();
    for pair in problem.contacts.iter().filter(|pair| !pair.interface.gap().is_measured()) {
        let Some(bodies) = pair.bodies() else { continue };
        for facet in pair.interface.facets() {
            let of = [0, 1].map(|side: usize| problem.bodies[bodies[side]].surface(facet.facets[side]));
            for side in [0, 1] {
                if let (None, Some(line)) = (of[side], of[1 - side]) {
                    all[bodies[side]].insert(facet.facets[side], *line);
                }
            }
        }
    }
    all
}

/// The parts of a contact surface, before normals and gaps are known.
struct FinerSurface {
    /// The nodes of the pairs, the old ones first.
    nodes: Vec<[NodeId; 2]>,
    /// See [`RefinedPair::parents`].
    parents: Vec<[u32; 2]>,
    /// Pairs and facets of each part of a facet.
    facets: Vec<([u32; 3], [FacetId; 2])>,
}

impl FinerSurface {
    /// Finds the parts.
    ///
    /// # Errors
    /// Parts of faces without a partner.
    fn of(
        pair: &ContactPair<Solid>,
        tets: &[BodyTets],
        refinements: &[TetRefinement],
    ) -> Result<Self, InterfaceError> {
        let mut nodes: Vec<[NodeId; 2]> = whole(&pair.interface).iter().map(|of| of.nodes).collect();
        let mut parents: Vec<[u32; 2]> = (0..nodes.len() as u32).map(|k| [k; 2]).collect();
        // A clamped pair has no value, but a neighbour has.
        for (own, of) in parents[pair.interface.pairs().len()..].iter_mut().zip(pair.interface.clamped()) {
            *own = [of.around.first().copied().unwrap_or(0); 2];
        }
        let mut number: HashMap<NodeId, u32> = nodes.iter().map(|of| of[0]).zip(0..).collect();
        let first = &refinements[pair.body];
        let facing: HashMap<FacetId, FacetId> =
            pair.interface.facets().iter().map(|facet| facet.facets.into()).collect();
        let old = first.mesh.points().len() - first.parent_nodes.len();
        let faces: Vec<([NodeId; 3], FacetId)> =
            tets[pair.body].faces_on(|face| facing.contains_key(&face)).collect();
        let mut new: Vec<NodeId> =
            faces.iter().flat_map(|(nodes, _)| *nodes).filter(|node| !number.contains_key(node)).collect();
        new.sort_unstable();
        new.dedup();
        // The node of the second body in the middle of two.
        let second = pair.partner.body().map(|b| &refinements[b]);
        let middles: HashMap<[NodeId; 2], NodeId> = second.map_or_else(HashMap::new, |of| {
            let old = of.mesh.points().len() - of.parent_nodes.len();
            of.parent_nodes.iter().map(|ends| sorted(*ends)).zip((old..).map(NodeId::new)).collect()
        });
        for node in new {
            let ends = first.parent_nodes[node.index() - old].map(|end| number.get(&end).copied());
            let [Some(i), Some(j)] = ends else { continue };
            let k = nodes.len();
            let other = match second {
                Some(_) => {
                    let facing = [i, j].map(|end| nodes[end as usize][1]);
                    match middles.get(&sorted(facing)) {
                        Some(found) => *found,
                        None => continue,
                    }
                }
                None => NodeId::new(k),
            };
            nodes.push([node, other]);
            parents.push([i, j]);
            number.insert(node, k as u32);
        }
        let facet = |(corners, _): &([NodeId; 3], FacetId)| {
            let own = first.mesh.topology().find_facet(*corners)?;
            let corners = first.mesh.topology().facets()[own];
            let [Some(a), Some(b), Some(c)] = corners.map(|node| number.get(&node).copied()) else {
                return None;
            };
            let pairs = [a, b, c];
            let other = match second {
                Some(of) => of.mesh.topology().find_facet(pairs.map(|k| nodes[k as usize][1]))?,
                None => own,
            };
            Some((pairs, [own, other]))
        };
        let alone = |body: usize, corners: [NodeId; 3]| {
            let points = refinements[body].mesh.points();
            let point = (corners.map(|node| points[node]).iter().sum::<Vector>() / 3.0).into();
            InterfaceError::FacetWithoutPartner { body, point, words: Solid::WORDS }
        };
        let found = |of: &([NodeId; 3], FacetId)| facet(of).ok_or_else(|| alone(pair.body, of.0));
        let mut facets: Vec<_> = faces.iter().map(found).collect::<Result<_, _>>()?;
        facets.sort_unstable_by_key(|(_, facets)| facets[0]);
        if let Some(body) = pair.partner.body() {
            let with_partner: HashSet<FacetId> = facets.iter().map(|(_, facets)| facets[1]).collect();
            let old: HashSet<FacetId> = facing.values().copied().collect();
            let topology = refinements[body].mesh.topology();
            let is_alone = |of: &[NodeId; 3]| {
                topology.find_facet(*of).is_none_or(|facet| !with_partner.contains(&facet))
            };
            let mut others = tets[body].faces_on(|face| old.contains(&face)).map(|(nodes, _)| nodes);
            if let Some(nodes) = others.find(is_alone) {
                return Err(alone(body, nodes));
            }
        }
        Ok(Self { nodes, parents, facets })
    }

    /// Makes pairs and facets. New pairs have the mean normal of their parents, and the mean of the vectors of their gaps.
    fn make(
        &self,
        old: &[NodePair<Solid>],
        gap: &Gap<Solid>,
        mesh: &TetMesh,
    ) -> (Vec<NodePair<Solid>>, Vec<ContactFacet<Solid>>) {
        let mut pairs: Vec<NodePair<Solid>> =
            old.iter().map(|pair| NodePair { weight: 0.0, ..*pair }).collect();
        for (nodes, parents) in self.nodes.iter().zip(&self.parents).skip(old.len()) {
            let [i, j] = parents.map(|k| pairs[k as usize]);
            let normal = if i.normal == j.normal { i.normal } else { 0.5 * (i.normal + j.normal) };
            let gap = match i.normal == j.normal {
                true => 0.5 * (i.gap + j.gap),
                false => gap.kept((0.5 * (i.gap_vector() + j.gap_vector())).dot(&normal)),
            };
            pairs.push(NodePair { nodes: *nodes, normal, gap, weight: 0.0 });
        }
        let facet = |(pairs, facets): &([u32; 3], [FacetId; 2])| ContactFacet {
            pairs: *pairs,
            facets: *facets,
            measure: mesh.facet_measure(facets[0]),
            bent: false,
            clamped: [None; 3],
        };
        let facets: Vec<ContactFacet<Solid>> = self.facets.iter().map(facet).collect();
        weigh(&mut pairs, &facets);
        (pairs, facets)
    }

    /// Makes the interface between two bodies.
    fn between(
        &self,
        interface: &ContactInterface<Solid>,
        bodies: [&Body<Solid>; 2],
    ) -> Result<ContactInterface<Solid>, InterfaceError> {
        let (old, points) = (whole(interface), bodies.map(|body| body.mesh().points()));
        let (mut pairs, mut facets) = self.make(&old, interface.gap(), bodies[0].mesh());
        let sides =
            [0, 1].map(|side: usize| facets.iter().map(|facet| facet.facets[side]).collect::<Vec<_>>());
        let round = round_side(bodies, [&sides[0], &sides[1]])?;
        for pair in &mut pairs[old.len()..] {
            let at = [0, 1].map(|b: usize| points[b][pair.nodes[b]]);
            if let Some((b, line)) = round {
                let normal = line.frozen_normal(at[b]);
                pair.normal = if b == 0 { normal } else { -normal };
            }
            let factor = interface.gap_factor();
            match interface.gap() {
                Gap::Given(data) => pair.gap = factor * data.at(at[0]) * norm(pair.normal),
                gap if gap.is_measured() && round.is_some() => {
                    pair.gap = factor * gap.kept((at[1] - at[0]).dot(&pair.normal));
                }
                _ => {}
            }
            check_gap(pair, at[0])?;
            if !interface.gap().is_bonded() {
                check_supports(bodies, pair)?;
            }
        }
        for facet in &mut facets {
            facet.bent = check_face(bodies, facet, &pairs)?;
        }
        let finer = ContactInterface::new(pairs, facets, interface.gap().clone());
        Ok(without_clamped(bodies, finer)?.with_gap_factor(interface.gap_factor()))
    }

    /// Returns the parents of the pairs that are not clamped. A clamped parent is replaced by the other one, or by a parent of its own.
    fn kept_parents(&self, finer: &ContactInterface<Solid>) -> Vec<[u32; 2]> {
        let kept: HashMap<NodeId, u32> = finer.pairs().iter().map(|pair| pair.nodes[0]).zip(0..).collect();
        // The pair from which each one takes its value, and whether it is clamped itself.
        let mut sources: Vec<(u32, bool)> = Vec::with_capacity(self.nodes.len());
        let mut found = Vec::with_capacity(kept.len());
        for (nodes, parents) in self.nodes.iter().zip(&self.parents) {
            let own = kept.get(&nodes[0]).copied();
            // A pair of the old surface is its own parent.
            let [a, b] =
                parents.map(|p| sources.get(p as usize).copied().unwrap_or((own.unwrap_or(0), false)));
            found.extend(own.map(|_| match [a, b] {
                [(a, false), (_, true)] => [a, a],
                [(_, true), (b, false)] => [b, b],
                [(a, _), (b, _)] => [a, b],
            }));
            sources.push((own.unwrap_or(a.0), own.is_none()));
        }
        found
    }

    /// Makes the interface of a body and an obstacle.
    fn against(
        &self,
        interface: &ContactInterface<Solid>,
        body: &Body<Solid>,
        obstacle: &Obstacle<Solid>,
    ) -> Result<ContactInterface<Solid>, InterfaceError> {
        let (old, points) = (interface.pairs().len(), body.mesh().points());
        let (mut pairs, mut facets) = self.make(interface.pairs(), interface.gap(), body.mesh());
        let given = Some(interface.gap()).filter(|gap| !matches!(gap, Gap::Geometric));
        for pair in &mut pairs[old..] {
            let new = pair_with(body, &obstacle.line, pair.nodes, given)?;
            pair.normal = obstacle.line.frozen_normal(points[pair.nodes[0]]);
            pair.gap = interface.gap_factor() * new.gap * pair.normal_length();
        }
        for facet in &mut facets {
            let normals = facet.pairs.map(|k| pairs[k as usize].normal);
            facet.bent = turns(normals, body.mesh().facet_middle(facet.facets[0]))?;
        }
        let finer = ContactInterface::new(pairs, facets, interface.gap().clone());
        Ok(finer.with_gap_factor(interface.gap_factor()))
    }
}

fn sorted([a, b]: [NodeId; 2]) -> [NodeId; 2] {
    [a.min(b), a.max(b)]
}

/// Refuses a gap that is not finite.
fn check_gap(pair: &NodePair<Solid>, point: Vector) -> Result<(), InterfaceError> {
    if pair.gap.is_finite() {
        return Ok(());
    }
    Err(InterfaceError::BadGap { point: point.into(), value: pair.gap / norm(pair.normal) })
}
