//! The fronts of the factorisation.

use crate::cholesky::Front;
use crate::ordering::ROOT;

/// Turns the tree of parts into fronts: parts without unknowns disappear.
#[derive(Default)]
pub(super) struct Fronts {
    fronts: Vec<Front>,
    /// The front of each part; `None` if the part is empty, and the front of its parent is used.
    front_of: Vec<Option<u32>>,
    parents: Vec<u32>,
    end: usize,
    /// The front of the rigid sides, if there is one.
    above: Option<u32>,
}

impl Fronts {
    /// Takes the next part, whose unknowns end at `end`.
    pub(super) fn part(&mut self, parent: u32, end: usize) {
        let number = (end > self.end).then_some(self.fronts.len() as u32);
        if number.is_some() {
            self.fronts.push(Front { columns: self.end as u32..end as u32, parent: ROOT });
        }
        self.front_of.push(number);
        self.parents.push(parent);
        self.end = end;
    }

    /// Adds the front of the rigid sides, whose unknowns end at `end`: above all parts.
    pub(super) fn above(&mut self, end: usize) {
        if end > self.end {
            self.above = Some(self.fronts.len() as u32);
            self.fronts.push(Front { columns: self.end as u32..end as u32, parent: ROOT });
            self.end = end;
        }
    }

    /// Adds the front of the interface and joins the fronts to a tree.
    pub(super) fn finish(mut self, interior: usize, interface: usize) -> Vec<Front> {
        let root = if interface > 0 { self.fronts.len() as u32 } else { ROOT };
        for (part, front) in self.front_of.iter().enumerate() {
            let Some(front) = front else { continue };
            // Climb over parts without unknowns.
            let mut above = self.parents[part];
            while above != ROOT && self.front_of[above as usize].is_none() {
                above = self.parents[above as usize];
            }
            let parent = if above == ROOT { None } else { self.front_of[above as usize] };
            self.fronts[*front as usize].parent = parent.or(self.above).unwrap_or(root);
        }
        if let Some(above) = self.above {
            self.fronts[above as usize].parent = root;
        }
        if interface > 0 {
            let columns = interior as u32..(interior + interface) as u32;
            self.fronts.push(Front { columns, parent: ROOT });
        }
        self.fronts
    }
}
