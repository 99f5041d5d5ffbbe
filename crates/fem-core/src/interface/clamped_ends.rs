//! Contact nodes that both bodies clamp at the ends of the line, or one body against an obstacle: their pairs are removed.
//!
//! A clamped pair has no unknown. Its opening is known, and along its edge the opening is linear from there to the next pair,
//! so it is nowhere negative if both ends are not. Its pressure is free, since the supports take the forces there: the pressure of
//! the next pair is used. Finer meshes have free nodes on the edge, whose pairs belong to the contact problem.

use super::profile::Profile;
use super::{
    ClampedCorner, ClampedPair, ContactFacet, ContactInterface, Gap, InterfaceError, NodePair, Obstacle,
    SAME_NORMAL,
};
use crate::body::Body;
use crate::geometry::{Coordinates, Vector, norm};
use crate::mesh::id::NodeId;
use crate::mesh::topology::NONE;
use crate::space::Space;

/// An overlap of clamped nodes up to this fraction of the data that it is computed from is round-off.
const ROUND_OFF: f64 = 1e-12;

/// All pairs of a contact line and the edges between them, also at clamped ends: an interface in the making.
#[derive(Clone, Debug)]
pub struct Line {
    /// The pairs, by increasing arc length.
    pub pairs: Vec<NodePair>,
    /// The edges between them.
    pub edges: Vec<ContactFacet>,
    /// The arc length at each pair, m.
    pub arc_lengths: Vec<f64>,
    /// The measured gap along each edge, if it is not linear there.
    pub profiles: Vec<Option<Profile>>,
}

/// The whole line, and for each of its pairs the number in the contact problem, or [`NONE`].
#[derive(Clone, Debug)]
pub(super) struct UntrimmedLine {
    pub(super) line: Line,
    pub(super) number: Vec<u32>,
}

/// Returns the displacements imposed on the two nodes of a pair; `None` unless both bodies clamp it.
pub(super) fn clamped<S: Space>(bodies: [&Body<S>; 2], pair: &NodePair<S>) -> Option<[S::Vector; 2]> {
    let imposed = |b: usize| {
        let constraint = &bodies[b].node_constraints()[pair.nodes[b]];
        constraint.is_clamped().then(|| constraint.displacement())
    };
    Some([imposed(0)?, imposed(1)?])
}

/// Computes the opening at a pair of nodes that both bodies clamp, m.
///
/// * `first`: the first body; `imposed`: on its node and on the second one, m.
///
/// # Errors
/// Supports that press the bodies into each other.
pub(super) fn opening<S: Space>(
    first: &Body<S>,
    pair: &NodePair<S>,
    imposed: [S::Vector; 2],
) -> Result<f64, InterfaceError> {
    let opening = pair.gap - (imposed[0] - imposed[1]).times(&pair.normal);
    let size = pair.gap.abs() + norm(imposed[0]) + norm(imposed[1]);
    if opening < -ROUND_OFF * size {
        let point = first.mesh().points()[pair.nodes[0]];
        return Err(InterfaceError::ClampedOverlap { point: point.into(), depth: -opening });
    }
    Ok(opening.max(0.0))
}

impl Line {
    /// Decides which edges are bent, and creates the interface of the line of two bodies without clamped pairs at its ends. Also
    /// returns, for each pair of the line, its number among the remaining ones, or [`NONE`].
    ///
    /// * `measured_on`: the side on whose surface gap and lengths are measured, 0 or 1.
    ///
    /// # Errors
    /// Clamped pairs inside the line, at curved edges, or with supports that press the bodies into each other.
    pub fn between(
        self,
        bodies: [&Body; 2],
        gap: Gap,
        measured_on: usize,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        // Bonded pairs have no unknowns of their own.
        let bonded = gap.is_bonded();
        let clamped = |pair: &NodePair| if bonded { None } else { clamped(bodies, pair) };
        self.without_clamped(bodies[0], &clamped, gap, measured_on)
    }

    /// [`Self::between`] a body and an obstacle: the second node of each remaining pair is its number.
    ///
    /// # Errors
    /// See [`Self::between`].
    pub fn against(
        self,
        body: &Body,
        obstacle: &Obstacle,
        gap: Gap,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        let clamped = |pair: &NodePair| obstacle.clamped(body, pair);
        let (mut interface, numbers) = self.without_clamped(body, &clamped, gap, 0)?;
        interface.pairs.iter_mut().enumerate().for_each(|(k, pair)| pair.nodes[1] = NodeId::new(k));
        Ok((interface, numbers))
    }

    /// [`Self::between`] a body, the first one of two, and what clamps its pairs.
    ///
    /// * `clamped`: what is imposed on the two sides of a clamped pair, m.
    fn without_clamped(
        mut self,
        body: &Body,
        clamped: &dyn Fn(&NodePair) -> Option<[Vector; 2]>,
        gap: Gap,
        measured_on: usize,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        for edge in &mut self.edges {
            let [a, b] = edge.pairs.map(|k| self.pairs[k as usize].normal);
            edge.bent = norm(a - b) > SAME_NORMAL;
        }
        let mut number = vec![NONE; self.pairs.len()];
        let mut pairs = Vec::with_capacity(self.pairs.len());
        let mut arc_lengths = Vec::with_capacity(self.pairs.len());
        let mut known = vec![(0.0, Vector::zeros()); self.pairs.len()];
        for (k, pair) in self.pairs.iter().enumerate() {
            match clamped(pair) {
                Some(imposed) => known[k] = (self.check(body, k, imposed)?, imposed[0] - imposed[1]),
                None => {
                    number[k] = pairs.len() as u32;
                    pairs.push(NodePair { weight: 0.0, ..*pair });
                    arc_lengths.push(self.arc_lengths[k]);
                }
            }
        }
        if pairs.is_empty() {
            return Err(self.refused(body, 0));
        }
        let all = pairs.len() == self.pairs.len();
        let (mut edges, mut profiles, mut removed) = (Vec::new(), Vec::new(), Vec::new());
        for (edge, profile) in self.edges.iter().zip(&self.profiles) {
            let ends = edge.pairs.map(|k| number[k as usize]);
            let mut at = |end: usize, other: u32| {
                let k = edge.pairs[end] as usize;
                let (number, (opening, jump)) = (removed.len() as u32, known[k]);
                removed.push(ClampedPair { pair: self.pairs[k], around: vec![other] });
                Some(ClampedCorner { number, opening, jump })
            };
            let (ends, clamped) = match ends {
                [NONE, NONE] => continue,
                [NONE, k] => ([k; 2], [at(0, k), None]),
                [k, NONE] => ([k; 2], [None, at(1, k)]),
                _ => (ends, [None; 2]),
            };
            let edge = ContactFacet { pairs: ends, clamped, ..*edge };
            for end in edge.free_corners() {
                pairs[ends[end] as usize].weight += 0.5 * edge.measure;
            }
            edges.push(edge);
            profiles.push(*profile);
        }
        let whole = if all {
            None
        } else {
            self.pairs.iter_mut().for_each(|p| p.weight = 0.0);
            Some(Box::new(UntrimmedLine { line: self, number: number.clone() }))
        };
        let interface = ContactInterface::new(pairs, edges, gap).with_clamped(removed);
        let interface = ContactInterface { measured_on, arc_lengths, profiles, whole, ..interface };
        Ok((interface, number))
    }

    /// Checks that the clamped pair `k` may be removed, and returns its opening, ≥ 0, m.
    ///
    /// * `imposed`: on its nodes, m.
    fn check(&self, body: &Body, k: usize, imposed: [Vector; 2]) -> Result<f64, InterfaceError> {
        let mut edges = self.edges.iter().filter(|e| e.pairs.contains(&(k as u32)));
        if !matches!((edges.next(), edges.next()), (Some(edge), None) if !edge.bent) {
            return Err(self.refused(body, k));
        }
        let pair = &self.pairs[k];
        opening(body, pair, imposed)
    }

    fn refused(&self, body: &Body, k: usize) -> InterfaceError {
        let point = body.mesh().points()[self.pairs[k].nodes[0]];
        InterfaceError::SupportedNode { body: 0, point: point.into() }
    }
}

impl ContactInterface {
    /// Returns the arc lengths at all pairs of the whole line, m.
    pub fn line_arc_lengths(&self) -> &[f64] {
        self.whole.as_ref().map_or(&self.arc_lengths, |whole| &whole.line.arc_lengths)
    }

    /// Returns the whole line, with the removed pairs and edges.
    pub fn line(&self) -> (&[NodePair], &[ContactFacet], &[Option<Profile>]) {
        match &self.whole {
            Some(whole) => (&whole.line.pairs, &whole.line.edges, &whole.line.profiles),
            None => (&self.pairs, &self.facets, &self.profiles),
        }
    }

    /// Maps two neighbouring pairs of the whole line to pairs of the contact problem: a clamped one to the other, two
    /// clamped ones to the first pair of all.
    pub fn numbers(&self, parents: [u32; 2]) -> [u32; 2] {
        let Some(whole) = &self.whole else { return parents };
        let number = |k: u32| Some(whole.number[k as usize]).filter(|n| *n != NONE);
        match parents.map(number) {
            [Some(a), Some(b)] => [a, b],
            [Some(k), None] | [None, Some(k)] => [k; 2],
            [None, None] => [0; 2],
        }
    }
}
