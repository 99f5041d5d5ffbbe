//! The search for the right set of closed rows: Newton's method where it gains, and what ends its cycles.

use std::collections::HashSet;

/// Newton steps in which the number of wrong rows must fall.
const PATIENCE: usize = 4;

/// Newton steps that change one row, at most.
const MOST_SINGLE: usize = 100;

/// What the next set is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// All wrong rows change sides.
    All,
    /// The set is the one of the exact solution.
    Exact,
    /// One row changes sides.
    One(usize),
    /// The set stays wrong.
    GiveUp,
}

/// The sets so far, and their wrong rows.
#[derive(Default)]
pub(crate) struct SetSearch {
    seen: HashSet<Vec<bool>>,
    /// The fewest wrong rows, and the steps since.
    fewest: Option<usize>,
    idle: usize,
    /// Whether the set of the exact solution was taken.
    pub(crate) knows: bool,
    single: usize,
}

impl SetSearch {
    /// Remembers a set.
    pub(crate) fn see(&mut self, closed: &[bool]) {
        self.seen.insert(closed.to_vec());
    }

    /// Chooses the next set. If sets come back, or the wrong rows get no fewer, the exact solution has it; a wrong row that is left after that
    /// changes alone, the last one first.
    ///
    /// * `wrong`: rows with the wrong sign of a force or an opening; `next`: the set if all change.
    pub(crate) fn turn(&mut self, wrong: &[usize], next: &[bool]) -> Turn {
        self.idle += 1;
        if self.fewest.is_none_or(|fewest| wrong.len() < fewest) {
            (self.fewest, self.idle) = (Some(wrong.len()), 0);
        }
        if self.idle < PATIENCE && !self.seen.contains(next) {
            return Turn::All;
        }
        if !std::mem::replace(&mut self.knows, true) {
            (self.fewest, self.idle) = (None, 0);
            return Turn::Exact;
        }
        self.single += 1;
        match wrong.last() {
            Some(row) if self.single <= MOST_SINGLE => Turn::One(*row),
            _ => Turn::GiveUp,
        }
    }
}
