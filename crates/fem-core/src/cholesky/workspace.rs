//! The memory of one task of a factorisation, allocated once and reused for every front.

use super::CholeskyError;
use super::symbolic::SymbolicCholesky;

/// Two stacks of update matrices, one for fronts of even depth and one for odd depth. So a front's own update is never
/// on top of the updates that it is computed from.
pub(super) struct Workspace {
    pub(super) updates: [Vec<f64>; 2],
    /// The end of each stack.
    pub(super) top: [usize; 2],
    pub(super) runs: Vec<Run>,
    /// The columns of one front, `(width + rows) × width`, column-major.
    pub(super) panel: Vec<f64>,
    /// The smallest pivot of the fronts so far.
    pub(super) smallest: SmallestPivot,
}

/// A pivot relative to the diagonal entry of the matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmallestPivot {
    pub(super) pivot: usize,
    pub(super) ratio: f64,
}

impl Default for SmallestPivot {
    /// Of no pivot at all: larger than any.
    fn default() -> Self {
        Self { pivot: 0, ratio: f64::INFINITY }
    }
}

impl SmallestPivot {
    /// Returns the smaller one of two, NaN before all others; of equal ones the first in the order of elimination, whichever task found it.
    pub(super) fn and(self, other: Self) -> Self {
        let ratio = |of: &Self| if of.ratio.is_nan() { f64::NEG_INFINITY } else { of.ratio };
        let order = ratio(&self).total_cmp(&ratio(&other)).then(self.pivot.cmp(&other.pivot));
        if order.is_le() { self } else { other }
    }
}

impl Workspace {
    /// Creates a workspace for the subtrees of some fronts, one after another; their updates are on stack
    /// `side`.
    pub(super) fn new(
        symbolic: &SymbolicCholesky,
        fronts: &[u32],
        side: usize,
    ) -> Result<Self, CholeskyError> {
        let dimension = symbolic.dimension();
        let (mut peak, mut held, mut largest) = ([0; 2], 0, 0);
        for layout in fronts.iter().map(|&front| &symbolic.layouts()[front as usize]) {
            peak[side] = peak[side].max(held + layout.peak[0]);
            peak[1 - side] = peak[1 - side].max(layout.peak[1]);
            held += layout.rows.len().pow(2);
            largest = largest.max(layout.largest);
        }
        Ok(Self {
            updates: [zeros(peak[0], dimension)?, zeros(peak[1], dimension)?],
            top: [0; 2],
            runs: Vec::new(),
            panel: zeros(largest, dimension)?,
            smallest: SmallestPivot::default(),
        })
    }
}

/// Rows of a child that are also consecutive in the parent: they are added as one block.
#[derive(Clone, Copy)]
pub(super) struct Run {
    /// First and last row (excluded) in the child.
    from: u32,
    end: u32,
    /// Place of the first one in the parent.
    to: u32,
}

impl Run {
    /// Collects the runs of a child whose rows have these places in the parent.
    pub(super) fn collect(places: impl Iterator<Item = u32>, runs: &mut Vec<Self>) {
        runs.clear();
        for (k, to) in (0..).zip(places) {
            match runs.last_mut() {
                Some(run) if run.to + (k - run.from) == to => run.end = k + 1,
                _ => runs.push(Self { from: k, end: k + 1, to }),
            }
        }
    }

    /// Iterates over the rows of a child and their places in the parent.
    pub(super) fn places(runs: &[Self]) -> impl Iterator<Item = (usize, usize)> {
        runs.iter().flat_map(|run| (run.from as usize..run.end as usize).zip(run.to as usize..))
    }

    /// Adds the rows of a child's column from `first` on to the parent's, whose places are counted from `offset`.
    pub(super) fn add(runs: &[Self], column: &[f64], first: usize, target: &mut [f64], offset: usize) {
        for run in &runs[runs.partition_point(|run| run.end as usize <= first)..] {
            let (from, end) = (first.max(run.from as usize), run.end as usize);
            let to = run.to as usize + (from - run.from as usize) - offset;
            for (value, add) in target[to..to + (end - from)].iter_mut().zip(&column[from..end]) {
                *value += add;
            }
        }
    }
}

/// Allocates zeros without touching them, after checking the available memory.
pub(super) fn zeros(count: usize, dimension: usize) -> Result<Vec<f64>, CholeskyError> {
    Vec::<f64>::new().try_reserve_exact(count).map_err(|_| CholeskyError::OutOfMemory { dimension })?;
    Ok(vec![0.0; count])
}
