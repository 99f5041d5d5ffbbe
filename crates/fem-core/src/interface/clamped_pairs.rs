//! Pairs of nodes that both bodies clamp, or the body against an obstacle: they have no unknown.
//!
//! The opening is known there. The pressure is free, since the supports take the forces: it is the mean of the pressures of the other pairs of the facets
//! around.

use super::clamped_ends::opening;
use super::{ContactFacet, ContactInterface, InterfaceError, NodePair};
use crate::body::Body;
use crate::space::{Plane, Space};

/// A pair of nodes that both bodies clamp.
#[derive(Clone, Debug, PartialEq)]
pub struct ClampedPair<S: Space = Plane> {
    /// Nodes, normal and gap; its weight counts for nothing.
    pub pair: NodePair<S>,
    /// The other pairs of the facets around that are not clamped, ascending: its pressure is the mean of their pressures.
    pub around: Vec<u32>,
}

/// A corner of a contact facet at which both bodies are clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClampedCorner<S: Space = Plane> {
    /// Its pair, by its number in [`ContactInterface::clamped`].
    pub number: u32,
    /// The opening that the supports impose there, ≥ 0, m.
    pub opening: f64,
    /// The displacement that they impose on the first side less the one on the second, m.
    pub jump: S::Vector,
}

/// What supports impose on both nodes of a clamped pair, m.
pub(super) type Imposed<'a, S> = dyn Fn(&NodePair<S>) -> Option<[<S as Space>::Vector; 2]> + 'a;

impl<S: Space> ContactInterface<S> {
    /// Creates the same interface of bodies whose supports impose other displacements: clamped corners open by another amount.
    ///
    /// * `imposed`: on the nodes of a clamped pair, m.
    ///
    /// # Errors
    /// Supports that press the bodies into each other.
    pub(super) fn with_supports(
        mut self,
        first: &Body<S>,
        imposed: &Imposed<'_, S>,
    ) -> Result<Self, InterfaceError> {
        for facet in &mut self.facets {
            for corner in facet.clamped.as_mut().iter_mut().flatten() {
                let pair = &self.clamped[corner.number as usize].pair;
                if let Some([a, b]) = imposed(pair) {
                    (corner.opening, corner.jump) = (opening(first, pair, [a, b])?, a - b);
                }
            }
        }
        Ok(self)
    }

    /// Notes the clamped pairs to which corners of facets belong.
    #[must_use]
    pub fn with_clamped(self, clamped: Vec<ClampedPair<S>>) -> Self {
        Self { clamped, ..self }
    }

    /// Returns the pairs that were removed because both bodies clamp them and that facets of the interface have as corners.
    pub fn clamped(&self) -> &[ClampedPair<S>] {
        &self.clamped
    }

    /// Returns the pair at a corner of a facet, clamped or not.
    pub fn corner_pair(&self, facet: &ContactFacet<S>, corner: usize) -> &NodePair<S> {
        match facet.clamped[corner] {
            None => &self.pairs[facet.pairs[corner] as usize],
            Some(clamped) => &self.clamped[clamped.number as usize].pair,
        }
    }

    /// Lists the pairs whose mean value a corner of a facet has: its own, or those around a clamped one.
    pub fn sources<'a>(&'a self, facet: &'a ContactFacet<S>, corner: usize) -> &'a [u32] {
        match facet.clamped[corner] {
            None => &facet.pairs.as_ref()[corner..=corner],
            Some(clamped) => &self.clamped[clamped.number as usize].around,
        }
    }

    /// Returns the pressures of the pairs at the corners of a facet; a clamped corner has the mean of those around.
    ///
    /// * `by_pair`: one number per pair.
    pub fn corners(&self, facet: &ContactFacet<S>, by_pair: &[f64]) -> S::Axes<f64> {
        S::axes(|corner| {
            let sources = self.sources(facet, corner);
            let sum: f64 = sources.iter().map(|k| by_pair[*k as usize]).sum();
            sum / sources.len().max(1) as f64
        })
    }

    /// Computes the pressure at the corners of a facet, Pa: the nodal values if the facet is flat; their mean at all corners if it is
    /// bent, so that `p n` is linear along it.
    ///
    /// * `by_pair`: nodal pressure, Pa.
    pub fn pressure(&self, facet: &ContactFacet<S>, by_pair: &[f64]) -> S::Axes<f64> {
        let corners = self.corners(facet, by_pair);
        if !facet.bent {
            return corners;
        }
        let mean = corners.as_ref().iter().sum::<f64>() / S::DIM as f64;
        S::axes(|_| mean)
    }
}
