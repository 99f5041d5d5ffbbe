//! Bonded pairs: bodies that hang together. For a solution they become one body, and its fields are given back to each.
//!
//! Bonded sides have the displacements `u^a − u^b = d` with a constant offset `d`. Every body of a group of bonded ones has an offset `s` with
//! `s^a − s^b = d`, and `u − s` is continuous in the whole group: one body, with the same stresses and the same error. Its supports impose `u_D − s`, and
//! the gaps of its pairs are `g − (s^a − s^b)·n`.

use super::clamped_ends::{clamped, opening};
use super::{
    ClampedCorner, ClampedPair, ContactFacet, ContactInterface, ContactPair, ContactProblem, InterfaceError,
    NodePair, Partner,
};
use crate::body::{Body, JoinError, Merged};
use crate::geometry::{Coordinates, norm};
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::space::{Plane, Space};
use thiserror::Error;

/// Offsets of a circle of bonds add up to zero if their sum is below this part of their sizes.
const ROUND_OFF: f64 = 1e-12;

/// Why bonded bodies cannot become one.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BondError {
    /// Offsets that do not add up to zero.
    #[error("pair {}: the bonds of the bodies make a circle, and their offsets do not add up to zero: {distance:.3e} is left", pair + 1)]
    Circle {
        /// The pair that closes the circle, from 0.
        pair: usize,
        /// The size of the sum, m.
        distance: f64,
    },
    /// Friction beside a bond.
    #[error("pair {}: it has friction, and other bodies are bonded, which is not solved yet", pair + 1)]
    Friction {
        /// The pair with friction, from 0.
        pair: usize,
    },
    /// An offset along a bent contact surface.
    #[error("pair {}: it touches along a bent surface, and bonds move one of its bodies by an offset, which is not solved yet", pair + 1)]
    Bent {
        /// The pair, from 0.
        pair: usize,
    },
    /// A contact pair without a node of its own.
    #[error("pair {}: bonds or supports hold both bodies at every node of the contact", pair + 1)]
    NoNode {
        /// The pair, from 0.
        pair: usize,
    },
    /// The bodies of a bond make no body.
    #[error("pair {}: {source}", pair + 1)]
    Join {
        /// A bonded pair of the group, from 0.
        pair: usize,
        /// The reason.
        source: JoinError,
    },
    /// Bonded bodies that overlap where they touch beside the bond.
    #[error("pair {}: {source}", pair + 1)]
    Interface {
        /// The contact pair, from 0.
        pair: usize,
        /// The reason.
        source: InterfaceError,
    },
}

impl BondError {
    /// Returns the pair, from 0.
    pub fn pair(&self) -> usize {
        match self {
            Self::Circle { pair, .. }
            | Self::Friction { pair }
            | Self::Bent { pair }
            | Self::NoNode { pair }
            | Self::Join { pair, .. }
            | Self::Interface { pair, .. } => *pair,
        }
    }
}

/// A body as a part of the one that its group becomes.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Part<S: Space = Plane> {
    /// The body that the group becomes, by its number in [`Bonds::joined`].
    pub body: usize,
    /// The number of its first cell there; the others follow.
    pub first_cell: usize,
    /// The number of each of its nodes there.
    pub nodes: Vec<NodeId>,
    /// Its displacements less those of the whole, m.
    pub offset: S::Vector,
}

/// The problem that a problem with bonded pairs becomes.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Bonds<S: Space = Plane> {
    /// The problem of the joined bodies, without the bonded pairs.
    pub joined: ContactProblem<S>,
    /// Each body of the given problem.
    pub parts: Vec<Part<S>>,
    /// By pair: the number in the joined problem; `None` if it is bonded.
    pub pairs: Vec<Option<usize>>,
    /// For each pair of nodes of the given problem, pair after pair, its number in the joined problem; `None` in bonded pairs, and if its nodes were
    /// merged.
    pub node_pairs: Vec<Option<usize>>,
    /// By pair, for each of its facets the number among those of the joined pair; `None` in bonded pairs, and if all its nodes were merged.
    pub facets: Vec<Vec<Option<usize>>>,
}

impl<S: Space> ContactPair<S> {
    /// Tells whether the pair is bonded.
    pub fn is_bonded(&self) -> bool {
        self.interface.gap().is_bonded()
    }

    /// Tells whether both sides belong to one body, which bonds made.
    pub fn is_within_a_body(&self) -> bool {
        self.partner == Partner::Body(self.body)
    }
}

impl<S: Space> Bonds<S> {
    /// Joins the bodies of bonded pairs; `None` if there is no bonded pair.
    ///
    /// # Errors
    /// See [`BondError`].
    pub fn new(problem: &ContactProblem<S>) -> Result<Option<Self>, BondError> {
        if !problem.contacts.iter().any(ContactPair::<S>::is_bonded) {
            return Ok(None);
        }
        if let Some(pair) = problem.contacts.iter().position(|pair| pair.friction.acts()) {
            return Err(BondError::Friction { pair });
        }
        let offsets = offsets(problem)?;
        let count = offsets.iter().map(|(group, _)| group + 1).max().unwrap_or(0);
        let (mut bodies, mut parts) = (Vec::with_capacity(count), vec![None; offsets.len()]);
        for group in 0..count {
            let members: Vec<usize> = (0..offsets.len()).filter(|b| offsets[*b].0 == group).collect();
            if let [only] = members[..] {
                let body = problem.bodies[only].clone();
                let nodes = (0..body.mesh().points().len()).map(NodeId::new).collect();
                bodies.push(body);
                parts[only] = Some(Part { body: group, first_cell: 0, nodes, offset: S::Vector::default() });
                continue;
            }
            let (body, nodes) = join(problem, &members, &offsets)?;
            bodies.push(body);
            let mut first_cell = 0;
            for (member, nodes) in members.into_iter().zip(nodes) {
                parts[member] = Some(Part { body: group, first_cell, nodes, offset: offsets[member].1 });
                first_cell += problem.bodies[member].mesh().cells().len();
            }
        }
        let joined = ContactProblem::new(bodies);
        let parts = parts.into_iter().flatten().collect();
        let mut bonds = Self { joined, parts, pairs: Vec::new(), node_pairs: Vec::new(), facets: Vec::new() };
        for k in 0..problem.contacts.len() {
            bonds.take_pair(problem, k)?;
        }
        Ok(Some(bonds))
    }

    /// Takes the values of the pairs of nodes that the joined problem has.
    pub fn kept<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.node_pairs.iter().zip(values).filter(|(kept, _)| kept.is_some()).map(|(_, v)| *v).collect()
    }

    /// Takes the joined problem out, to solve it.
    pub fn take_joined(&mut self) -> ContactProblem<S> {
        std::mem::replace(&mut self.joined, ContactProblem::new(Vec::new()))
    }

    /// Lists the bodies of which a body of the joined problem was made.
    pub fn members(&self, joined: usize) -> impl Iterator<Item = usize> + '_ {
        self.parts.iter().enumerate().filter(move |(_, part)| part.body == joined).map(|(body, _)| body)
    }

    /// Adds a pair to the joined problem.
    fn take_pair(&mut self, problem: &ContactProblem<S>, k: usize) -> Result<(), BondError> {
        let pair = &problem.contacts[k];
        let first = self.joined.node_pairs();
        if pair.is_bonded() {
            self.pairs.push(None);
            self.node_pairs.extend(pair.interface.pairs().iter().map(|_| None));
            self.facets.push(vec![None; pair.interface.facets().len()]);
            return Ok(());
        }
        let interface = self.moved(problem, k)?;
        let (bodies, obstacle) = (self.body_of(pair), problem.obstacle_of(pair));
        let merged = |of: &NodePair<S>| {
            let [a, b] = bodies;
            match (obstacle, b) {
                (Some(obstacle), _) if obstacle.is_held() => obstacle.clamped(&self.joined.bodies[a], of),
                (Some(_), _) => None,
                (None, b) if a == b && of.nodes[0] == of.nodes[1] => Some([S::Vector::default(); 2]),
                (None, b) => clamped([a, b].map(|body| &self.joined.bodies[body]), of),
            }
        };
        let imposed: Vec<Option<[S::Vector; 2]>> = interface.pairs.iter().map(merged).collect();
        let known = |(of, imposed): (&NodePair<S>, &Option<[S::Vector; 2]>)| {
            let Some([a, b]) = *imposed else { return Ok(None) };
            Ok(Some((opening(&self.joined.bodies[bodies[0]], of, [a, b])?, a - b)))
        };
        let known = interface.pairs.iter().zip(&imposed).map(known).collect::<Result<Vec<_>, _>>();
        let known = known.map_err(|source| BondError::Interface { pair: k, source })?;
        let facets = interface.facets.iter().map(|facet| interface.stays(facet, &known));
        self.facets.push(numbered(facets, 0));
        self.node_pairs.extend(numbered(known.iter().map(Option::is_none), first));
        self.pairs.push(Some(self.joined.contacts.len()));
        let mut interface = interface.without(&known);
        if obstacle.is_some() {
            // The second node against an obstacle is the number of the pair.
            interface.pairs.iter_mut().enumerate().for_each(|(k, of)| of.nodes[1] = NodeId::new(k));
        }
        if interface.pairs.is_empty() {
            return Err(BondError::NoNode { pair: k });
        }
        let joined = std::mem::replace(&mut self.joined, ContactProblem::new(Vec::new()));
        self.joined = match obstacle {
            Some(obstacle) => joined.obstacle(bodies[0], interface, obstacle.clone()),
            None => joined.contact(bodies, interface),
        };
        if let Some(last) = self.joined.contacts.last_mut() {
            last.roles = pair.roles;
        }
        Ok(())
    }

    /// Returns the joined bodies of a pair; against an obstacle the first one twice.
    fn body_of(&self, pair: &ContactPair<S>) -> [usize; 2] {
        let first = self.parts[pair.body].body;
        [first, pair.partner.body().map_or(first, |body| self.parts[body].body)]
    }

    /// Returns the interface of a pair with the nodes and facets of the joined bodies, and with its gaps between their displacements.
    fn moved(&self, problem: &ContactProblem<S>, k: usize) -> Result<ContactInterface<S>, BondError> {
        let pair = &problem.contacts[k];
        let second = pair.partner.body();
        let sides = [Some(pair.body), second].map(|body| body.map(|body| (body, &self.parts[body])));
        let offset = sides.map(|side| side.map_or(S::Vector::default(), |(_, part)| part.offset));
        let offset = offset[0] - offset[1];
        if pair.interface.has_bent_facets() && offset != S::Vector::default() {
            return Err(BondError::Bent { pair: k });
        }
        let node = |side: usize, node: NodeId| sides[side].map_or(node, |(_, part)| part.nodes[node.index()]);
        let facet = |side: usize, facet: FacetId| {
            let Some((body, part)) = sides[side].or(sides[0]) else { return facet };
            let mesh: &Mesh<S> = self.joined.bodies[part.body].mesh();
            mesh.facet_of_part(problem.bodies[body].mesh(), facet, &part.nodes).0.unwrap_or(facet)
        };
        let moved = |of: &NodePair<S>| NodePair {
            nodes: [node(0, of.nodes[0]), node(1, of.nodes[1])],
            gap: of.gap - offset.times(&of.normal),
            ..*of
        };
        let mut interface = pair.interface.clone();
        interface.whole = None;
        interface.pairs.iter_mut().for_each(|of| *of = moved(of));
        interface.clamped.iter_mut().for_each(|of| of.pair = moved(&of.pair));
        for of in &mut interface.facets {
            of.facets = [facet(0, of.facets[0]), facet(1, of.facets[1])];
        }
        Ok(interface)
    }
}

impl<S: Space> ContactInterface<S> {
    /// Tells whether a facet stays if pairs of nodes are removed: all stay if none are.
    fn stays(&self, facet: &ContactFacet<S>, known: &[Option<(f64, S::Vector)>]) -> bool {
        known.iter().all(Option::is_none)
            || facet.free_corners().any(|corner| known[facet.pairs[corner] as usize].is_none())
    }

    /// Removes pairs of nodes that have no unknown. Facets all of whose corners are known go with them.
    ///
    /// * `known`: the opening and the jump at each pair that is removed, m.
    fn without(self, known: &[Option<(f64, S::Vector)>]) -> Self {
        if known.iter().all(Option::is_none) {
            return self;
        }
        let mut clamped = self.clamped;
        let (mut pairs, mut arc_lengths, mut number) = (Vec::new(), Vec::new(), Vec::new());
        for (k, (pair, known)) in self.pairs.iter().zip(known).enumerate() {
            number.push(if known.is_some() { clamped.len() } else { pairs.len() } as u32);
            if known.is_some() {
                clamped.push(ClampedPair { pair: *pair, around: Vec::new() });
            } else {
                pairs.push(*pair);
                arc_lengths.extend(self.arc_lengths.get(k));
            }
        }
        for of in &mut clamped {
            let kept = of.around.iter().filter(|k| known[**k as usize].is_none());
            of.around = kept.map(|k| number[*k as usize]).collect();
        }
        let (mut facets, mut profiles) = (Vec::new(), Vec::new());
        for (place, facet) in self.facets.iter().enumerate() {
            let removed = |corner: &usize| known[facet.pairs[*corner] as usize].is_some();
            let free: Vec<u32> = facet
                .free_corners()
                .filter(|corner| !removed(corner))
                .map(|corner| number[facet.pairs[corner] as usize])
                .collect();
            let Some(&substitute) = free.first() else { continue };
            let (mut of_corner, mut corners) = (facet.pairs, facet.clamped);
            for corner in 0..S::DIM {
                let own = number[facet.pairs[corner] as usize];
                match (facet.clamped[corner], known[facet.pairs[corner] as usize]) {
                    (None, None) => of_corner[corner] = own,
                    (None, Some((opening, jump))) => {
                        corners[corner] = Some(ClampedCorner { number: own, opening, jump });
                        clamped[own as usize].around.extend(&free);
                        of_corner[corner] = substitute;
                    }
                    (Some(_), _) => of_corner[corner] = substitute,
                }
            }
            facets.push(ContactFacet { pairs: of_corner, clamped: corners, ..*facet });
            profiles.extend(self.profiles.get(place).copied());
        }
        for of in &mut clamped {
            of.around.sort_unstable();
            of.around.dedup();
        }
        Self { pairs, facets, clamped, arc_lengths, profiles, ..self }
    }
}

/// Numbers what is kept.
///
/// * `first`: the first number.
fn numbered(kept: impl Iterator<Item = bool>, first: usize) -> Vec<Option<usize>> {
    let mut next = first;
    let number = |kept: bool| {
        next += usize::from(kept);
        kept.then(|| next - 1)
    };
    kept.map(number).collect()
}

/// Finds the group of each body, and its offset from the first body of the group.
fn offsets<S: Space>(problem: &ContactProblem<S>) -> Result<Vec<(usize, S::Vector)>, BondError> {
    let mut found: Vec<Option<(usize, S::Vector)>> = vec![None; problem.bodies.len()];
    let mut groups = 0;
    for first in 0..found.len() {
        if found[first].is_some() {
            continue;
        }
        found[first] = Some((groups, S::Vector::default()));
        let mut open = vec![first];
        while let Some(body) = open.pop() {
            let Some((_, own)) = found[body] else { continue };
            for (pair, other, difference) in bonds_of(problem, body) {
                let offset = own - difference;
                match found[other] {
                    None => {
                        found[other] = Some((groups, offset));
                        open.push(other);
                    }
                    Some((_, known)) => {
                        let distance = norm(known - offset);
                        if distance > ROUND_OFF * (norm(known) + norm(own) + norm(difference)) {
                            return Err(BondError::Circle { pair, distance });
                        }
                    }
                }
            }
        }
        groups += 1;
    }
    Ok(found.into_iter().flatten().collect())
}

/// Lists the bonds of a body: pair, other body, and the displacement of this body less that of the other one, m.
fn bonds_of<S: Space>(
    problem: &ContactProblem<S>,
    body: usize,
) -> impl Iterator<Item = (usize, usize, S::Vector)> + '_ {
    problem.contacts.iter().enumerate().filter_map(move |(k, pair)| {
        let super::Gap::Bonded { offset } = *pair.interface.gap() else { return None };
        match pair.bodies()? {
            [a, b] if a == body => Some((k, b, offset)),
            [a, b] if b == body => Some((k, a, -offset)),
            _ => None,
        }
    })
}

/// Joins the bodies of a group, and returns the number of each of their nodes.
fn join<S: Space>(
    problem: &ContactProblem<S>,
    members: &[usize],
    offsets: &[(usize, S::Vector)],
) -> Result<(Body<S>, Vec<Vec<NodeId>>), BondError> {
    let place = |body: usize| members.iter().position(|member| *member == body);
    let (mut same, mut last) = (Vec::new(), 0);
    for (k, pair) in problem.contacts.iter().enumerate().filter(|(_, pair)| pair.is_bonded()) {
        let Some([Some(a), Some(b)]) = pair.bodies().map(|both| both.map(place)) else { continue };
        same.extend(pair.interface.pairs().iter().map(|of| [(a, of.nodes[0]), (b, of.nodes[1])]));
        last = k;
    }
    let counts: Vec<usize> =
        members.iter().map(|member| problem.bodies[*member].mesh().points().len()).collect();
    let merged = Merged::new(&counts, &same);
    let parts: Vec<(&Body<S>, S::Vector)> =
        members.iter().map(|member| (&problem.bodies[*member], offsets[*member].1)).collect();
    let body = Body::joined(&parts, &merged).map_err(|source| BondError::Join { pair: last, source })?;
    Ok((body, merged.nodes))
}
