//! The directions that a body retains as interface unknowns when it is condensed.

use crate::mesh::id::NodeId;
use crate::space::{Plane, Space};
use std::ops::Range;

/// One direction at one node that a body retains as an interface unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retained<S: Space = Plane> {
    /// The node.
    pub node: NodeId,
    /// The direction `d` in which traces and forces are positive: the trace is `u·d`, the force `r d`.
    pub direction: S::Vector,
}

/// The directions that one body retains as interface unknowns, in blocks: one block per side that the body has in a pair.
///
/// A node may have as many directions as there are axes, in the same block or in different ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceSide<S: Space = Plane> {
    retained: Vec<Retained<S>>,
    /// The end of each block in `retained`.
    ends: Vec<usize>,
}

impl<S: Space> InterfaceSide<S> {
    /// Adds a block.
    #[must_use]
    pub fn with_block(mut self, retained: impl IntoIterator<Item = Retained<S>>) -> Self {
        self.retained.extend(retained);
        self.ends.push(self.retained.len());
        self
    }

    /// Returns the directions of all blocks.
    pub fn retained(&self) -> &[Retained<S>] {
        &self.retained
    }

    /// Returns the number of blocks.
    pub fn blocks(&self) -> usize {
        self.ends.len()
    }

    /// Returns the places of a block among the directions.
    ///
    /// # Panics
    /// If there is no such block.
    pub fn block(&self, block: usize) -> Range<usize> {
        let start = if block == 0 { 0 } else { self.ends[block - 1] };
        start..self.ends[block]
    }
}
