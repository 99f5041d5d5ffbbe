//! Contact nodes that both bodies clamp at the ends of the line, or one body against an obstacle: their pairs are removed.
//!
//! A clamped pair has no unknown. Its opening is known, and along its edge the opening is linear from there to the next pair,
//! so it is nowhere negative if both ends are not. Its pressure is free, since the supports take the forces there: the pressure of
//! the next pair is used. Finer meshes have free nodes on the edge, whose pairs belong to the contact problem.

use super::profile::Profile;
use super::{ClampedEnd, ContactFacet, ContactInterface, Gap, InterfaceError, NodePair, SAME_NORMAL};
use crate::body::Body;
use crate::geometry::{Vector, norm};
use crate::mesh::topology::NONE;

/// An overlap of clamped nodes up to this fraction of the data that it is computed from is round-off.
const ROUND_OFF: f64 = 1e-12;

/// All pairs of the line and the edges between them.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) pairs: Vec<NodePair>,
    pub(super) edges: Vec<ContactFacet>,
    /// At each pair, m.
    pub(super) arc_lengths: Vec<f64>,
    /// Of a measured gap, along each edge, if it is not linear there.
    pub(super) profiles: Vec<Option<Profile>>,
}

/// The whole line, and for each of its pairs the number in the contact problem, or [`NONE`].
#[derive(Clone, Debug)]
pub(super) struct UntrimmedLine {
    pub(super) line: Line,
    pub(super) number: Vec<u32>,
}

/// Returns the displacements imposed on the two nodes of a pair; `None` unless both bodies clamp it.
pub(super) fn clamped(bodies: [&Body; 2], pair: &NodePair) -> Option<[Vector; 2]> {
    let imposed = |b: usize| {
        let constraint = &bodies[b].node_constraints()[pair.nodes[b]];
        constraint.is_clamped().then(|| constraint.displacement())
    };
    Some([imposed(0)?, imposed(1)?])
}

/// Tells whether both bodies clamp a pair.
pub(super) fn is_clamped(bodies: [&Body; 2], pair: &NodePair) -> bool {
    clamped(bodies, pair).is_some()
}

impl Line {
    /// Decides which edges are bent, and creates the interface of the line without clamped pairs at its ends. Also
    /// returns, for each pair of the line, its number among the remaining ones, or [`NONE`].
    ///
    /// # Errors
    /// Clamped pairs inside the line, at curved edges, or with supports that press the bodies into each other.
    pub(super) fn into_interface(
        self,
        bodies: [&Body; 2],
        gap: Gap,
        measured_on: usize,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        self.without_clamped(bodies[0], &|pair| clamped(bodies, pair), gap, measured_on)
    }

    /// [`Self::into_interface`] of a line on a body, the first one of two.
    ///
    /// * `clamped`: what is imposed on the two sides of a clamped pair, m.
    pub(super) fn without_clamped(
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
        let (mut edges, mut profiles) = (Vec::new(), Vec::new());
        for (edge, profile) in self.edges.iter().zip(&self.profiles) {
            let ends = edge.pairs.map(|k| number[k as usize]);
            let at = |end: usize| {
                let (opening, jump) = known[edge.pairs[end] as usize];
                ClampedEnd { end, opening, jump }
            };
            let (ends, clamped) = match ends {
                [NONE, NONE] => continue,
                [NONE, k] => ([k; 2], Some(at(0))),
                [k, NONE] => ([k; 2], Some(at(1))),
                _ => (ends, None),
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
        let interface = ContactInterface {
            pairs,
            facets: edges,
            gap,
            measured_on,
            arc_lengths,
            profiles,
            whole,
            gap_change: None,
            radial: None,
        };
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
        let opening = pair.gap - (imposed[0] - imposed[1]).dot(&pair.normal);
        let size = pair.gap + norm(imposed[0]) + norm(imposed[1]);
        if opening < -ROUND_OFF * size {
            let point = body.mesh().points()[pair.nodes[0]];
            return Err(InterfaceError::ClampedOverlap { point: point.into(), depth: -opening });
        }
        Ok(opening.max(0.0))
    }

    fn refused(&self, body: &Body, k: usize) -> InterfaceError {
        let point = body.mesh().points()[self.pairs[k].nodes[0]];
        InterfaceError::SupportedNode { body: 0, point: point.into() }
    }
}

impl ContactInterface {
    /// Creates the same interface of bodies whose supports impose other displacements: clamped ends open by another amount.
    pub(super) fn with_supports(
        &self,
        first: &Body,
        clamped: &dyn Fn(&NodePair) -> Option<[Vector; 2]>,
    ) -> Result<Self, InterfaceError> {
        let Some(whole) = &self.whole else { return Ok(self.clone()) };
        let (found, _) =
            whole.line.clone().without_clamped(first, clamped, self.gap.clone(), self.measured_on)?;
        // Against an obstacle the second node is the number of the pair among the remaining ones.
        let pairs =
            found.pairs.iter().zip(&self.pairs).map(|(pair, old)| NodePair { nodes: old.nodes, ..*pair });
        Ok(Self { pairs: pairs.collect(), gap_change: self.gap_change, radial: self.radial, ..found })
    }

    /// Returns the arc lengths at all pairs of the whole line, m.
    pub(super) fn line_arc_lengths(&self) -> &[f64] {
        self.whole.as_ref().map_or(&self.arc_lengths, |whole| &whole.line.arc_lengths)
    }

    /// Returns the whole line, with the removed pairs and edges.
    pub(super) fn line(&self) -> (&[NodePair], &[ContactFacet], &[Option<Profile>]) {
        match &self.whole {
            Some(whole) => (&whole.line.pairs, &whole.line.edges, &whole.line.profiles),
            None => (&self.pairs, &self.facets, &self.profiles),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{BoundaryConditions, ScalarData};
    use crate::interface::ContactProblem;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::{block, ring};
    use crate::mesh::refine::RefinementEdges;

    fn body(y: f64, conditions: BoundaryConditions) -> Body {
        let material = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        Body::new(block([0.0, y], [2.0, 1.0], [4, 2]).unwrap(), material, &conditions).unwrap()
    }

    fn pair(upper: &Body, lower: &Body) -> Result<ContactInterface, InterfaceError> {
        ContactInterface::pair(upper, lower, ["bottom", "top"], &Gap::Given(0.0.into()))
    }

    #[test]
    fn contact_nodes_clamped_in_both_bodies_at_the_ends_of_the_line_have_no_unknown() {
        let clamped = || BoundaryConditions::new().fix("left").fix("right");
        let bodies = [body(1.0, clamped()), body(0.0, clamped())];
        let interface = pair(&bodies[0], &bodies[1]).unwrap();
        assert_eq!((interface.pairs().len(), interface.facets().len(), interface.measure()), (3, 4, 2.0));
        let lengths: Vec<f64> = interface.pairs().iter().map(|p| p.weight).collect();
        assert_eq!(lengths, [0.5; 3]);
        // A constant pressure reaches the clamped ends, whose forces the supports take.
        assert_eq!(interface.mass(&[3.0; 3]), [1.5; 3]);
        let first = interface.facets()[0];
        assert_eq!((first.pairs, first.openings(&[0.2, 0.0, 0.0])), ([0; 2], [0.0, 0.2]));
        // Halved: the new nodes of the removed edges are free and belong to the contact problem.
        let mut problem = ContactProblem::between(bodies, interface);
        for count in [7, 15] {
            let edges = |p: &ContactProblem| -> Vec<_> {
                p.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect()
            };
            let marked = |p: &ContactProblem, only: usize| {
                [0, 1].map(|b| vec![b == only; p.bodies[b].mesh().topology().facets().len()])
            };
            let labels = edges(&problem);
            // Marked in one body only: contact edges are halved in both.
            let finer = problem.refined(&labels, &marked(&problem, 0)).unwrap();
            assert_eq!(finer.problem.contacts[0].interface.pairs().len(), count);
            let constant = vec![3.0; problem.contacts[0].interface.pairs().len()];
            assert_eq!(finer.pairs[0].prolong(&constant), vec![3.0; count]);
            problem = finer.problem;
            let [a, b] = problem.bodies.as_slice() else { unreachable!() };
            assert_eq!(pair(a, b).unwrap().pairs().len(), count);
        }
    }

    #[test]
    fn clamped_contact_nodes_that_cannot_drop_out_are_refused() {
        let left = || BoundaryConditions::new().fix("left");
        // In one body only, the other one has the unknown.
        let one = pair(&body(1.0, left()), &body(0.0, BoundaryConditions::new().fix("bottom")));
        assert_eq!(one.unwrap().pairs().len(), 5);
        // Pressed into each other: the opening along the edge would be negative.
        let pressed = BoundaryConditions::new().displace("left", Some(0.0.into()), Some((-0.1).into()));
        let overlap = pair(&body(1.0, pressed), &body(0.0, left()));
        assert!(
            matches!(overlap, Err(InterfaceError::ClampedOverlap { depth, .. }) if (depth - 0.1).abs() < 1e-15)
        );
        let parted =
            BoundaryConditions::new().displace("left", Some(0.0.into()), Some(ScalarData::from(0.1)));
        assert_eq!(pair(&body(1.0, parted), &body(0.0, left())).unwrap().pairs().len(), 4);
        // A curved line, on which the opening between two openings >= 0 may be negative.
        let steel = || LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let arc = |radii| {
            let mesh = ring([0.0; 2], radii, [0.0, 90.0], [6, 1]).unwrap();
            Body::new(mesh, steel(), &BoundaryConditions::new().fix("start")).unwrap()
        };
        let [inner, outer] = [arc([1.0, 2.0]), arc([2.0, 3.0])];
        let bent = ContactInterface::pair(&inner, &outer, ["outer", "inner"], &Gap::Given(0.0.into()));
        assert!(matches!(bent, Err(InterfaceError::SupportedNode { .. })), "{bent:?}");
    }
}
