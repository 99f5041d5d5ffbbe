//! What the tables of the matrix of promises count.

use crate::page::median;
use std::collections::BTreeMap;
use tests::matrix::{Promise, Verdict};

/// Verdicts and effectivities of some problems.
#[derive(Default)]
pub(crate) struct Counts {
    /// By promise: judged and violated.
    cells: BTreeMap<Promise, [usize; 2]>,
    /// Effectivities: at most this.
    effectivities: Vec<f64>,
}

impl Counts {
    pub(crate) fn add(&mut self, verdicts: &[Verdict], effectivity: Option<f64>) {
        for verdict in verdicts {
            let cell = self.cells.entry(verdict.promise).or_default();
            cell[0] += 1;
            cell[1] += usize::from(!verdict.holds);
        }
        self.effectivities.extend(effectivity);
    }

    /// Counts all verdicts.
    pub(crate) fn verdicts(&self) -> usize {
        self.cells.values().map(|cell| cell[0]).sum()
    }

    /// Makes the cells of a line: one for each promise, the effectivities and their number.
    pub(crate) fn columns(&mut self, promises: impl Iterator<Item = Promise>) -> Vec<String> {
        let of_promise = |promise: Promise| match self.cells.get(&promise) {
            None => String::new(),
            Some([judged, 0]) => judged.to_string(),
            Some([judged, violated]) => format!("**{violated}** of {judged}"),
        };
        let mut columns: Vec<String> = promises.map(of_promise).collect();
        let middle = median(&mut self.effectivities);
        columns.push(match [self.effectivities.first(), self.effectivities.last()] {
            [Some(low), Some(high)] => format!("{low:.2} / {middle:.2} / {high:.2}"),
            _ => String::new(),
        });
        columns.push(self.effectivities.len().to_string());
        columns
    }
}

/// Names a promise.
pub(crate) fn name(promise: Promise) -> &'static str {
    Promise::ALL.iter().find(|(p, _)| *p == promise).map_or("", |(_, name)| name)
}

/// Writes what a verdict says for a cell of a table.
pub(crate) fn said(verdict: &Verdict) -> String {
    verdict.said.replace(['"', '\n'], " ").chars().take(300).collect()
}
