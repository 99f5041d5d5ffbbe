//! The directions that a body retains as interface unknowns when it is condensed.

use crate::geometry::Vector;
use crate::mesh::id::NodeId;
use std::ops::Range;

/// One direction at one node that a body retains as an interface unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retained {
    /// The node.
    pub node: NodeId,
    /// The direction `d` in which traces and forces are positive: the trace is `u·d`, the force `r d`.
    pub direction: Vector,
}

/// The directions that one body retains as interface unknowns, in blocks: one block per side that the body has in a pair.
///
/// A node may have one or two directions, in the same block or in different ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceSide {
    retained: Vec<Retained>,
    /// The end of each block in `retained`.
    ends: Vec<usize>,
}

impl InterfaceSide {
    /// Adds a block.
    #[must_use]
    pub fn with_block(mut self, retained: impl IntoIterator<Item = Retained>) -> Self {
        self.retained.extend(retained);
        self.ends.push(self.retained.len());
        self
    }

    /// Returns the directions of all blocks.
    pub fn retained(&self) -> &[Retained] {
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
