//! The part of an interface that is in contact.

use super::ContactInterface;
use crate::partition::Partition;
use crate::space::Space;

/// The area in contact, seen from both sides: it lies between two numbers, whose difference the mesh decides. In the plane areas are lengths.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactArea {
    /// Facets that are closed at every node, m or m².
    pub inner: f64,
    /// Facets that are closed at one node at least, m or m².
    pub outer: f64,
    /// The sets of closed nodes that facets join, by their first pairs.
    pub patches: Vec<ContactPatch>,
}

/// Closed nodes that facets join.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactPatch {
    /// Its facets that are closed at every node, m or m².
    pub area: f64,
    /// Its pairs of nodes, ascending.
    pub pairs: Vec<usize>,
}

impl<S: Space> ContactInterface<S> {
    /// Measures the area in contact. Clamped corners do not count.
    ///
    /// * `is_closed`: whether a pair of nodes is closed, by its number.
    pub fn contact_area(&self, is_closed: impl Fn(usize) -> bool) -> ContactArea {
        let mut found = ContactArea::default();
        let mut patches = Partition::new(self.pairs().len());
        let mut closed_facets = Vec::new();
        for facet in self.facets() {
            let corners = facet.free_corners().map(|corner| facet.pairs[corner] as usize);
            let (mut closed, mut open) = (None, false);
            for pair in corners {
                if !is_closed(pair) {
                    open = true;
                    continue;
                }
                patches.join(pair, closed.unwrap_or(pair));
                closed = Some(pair);
            }
            if let Some(pair) = closed {
                found.outer += facet.measure;
                if !open {
                    found.inner += facet.measure;
                    closed_facets.push((pair, facet.measure));
                }
            }
        }
        let mut of_pair = vec![0; self.pairs().len()];
        for pair in (0..of_pair.len()).filter(|pair| is_closed(*pair)) {
            let first = patches.first(pair);
            if first == pair {
                of_pair[pair] = found.patches.len();
                found.patches.push(ContactPatch::default());
            }
            found.patches[of_pair[first]].pairs.push(pair);
        }
        for (pair, measure) in closed_facets {
            found.patches[of_pair[patches.first(pair)]].area += measure;
        }
        found
    }
}
