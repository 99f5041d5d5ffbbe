//! The values of a factor: front by front, children before parents.
//!
//! A front gathers its columns of the matrix and the corresponding parts of its children's updates, eliminates its
//! columns by dense algebra, and passes its own update, `U = −L₂₁ L₂₁ᵀ` plus the rest of the children's, to its
//! parent.

use super::CholeskyError;
use super::symbolic::{Layout, SymbolicCholesky, column_start};
use super::workspace::{Run, SmallestPivot, Workspace};
use crate::dense::triangular;
use crate::sparse::SymmetricCsc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Subtrees of more than this share of all operations, divided by the number of threads, are separate tasks.
const SHARE: f64 = 0.25;

/// Computes the values of the factor and the smallest pivot.
pub(super) fn factorise(
    symbolic: &SymbolicCholesky,
    matrix: &SymmetricCsc,
) -> Result<(Vec<f64>, SmallestPivot), CholeskyError> {
    let mut values = super::workspace::zeros(symbolic.stored_values(), symbolic.dimension())?;
    let threads = rayon::current_num_threads();
    // One thread needs no tasks; the values are the same in any case.
    let task = if threads == 1 { f64::INFINITY } else { SHARE * symbolic.operations() / threads as f64 };
    let job = Job { symbolic, matrix, task };
    let mut smallest = SmallestPivot::default();
    for root in symbolic.roots() {
        let layout = &symbolic.layouts()[root];
        let own = &mut values[symbolic.values_start(layout)..layout.values.end];
        let mut work = Workspace::new(symbolic, &[root as u32], 0)?;
        job.subtree(root, own, &mut work, 0)?;
        smallest = smallest.and(work.smallest);
    }
    Ok((values, smallest))
}

struct Job<'a> {
    symbolic: &'a SymbolicCholesky,
    matrix: &'a SymmetricCsc,
    /// Subtrees of more operations may run in parallel with others.
    task: f64,
}

/// A workspace that was used for a front's children from this number on.
type Beside = Option<(usize, Workspace)>;

impl Job<'_> {
    /// Factorises the subtree of front `s` in its part of the factor. Its update is left on stack `side` of the
    /// workspace, `b × b` column-major, lower part; its children's are on the other one.
    fn subtree(
        &self,
        s: usize,
        values: &mut [f64],
        work: &mut Workspace,
        side: usize,
    ) -> Result<(), CholeskyError> {
        let layout = &self.symbolic.layouts()[s];
        let start = self.symbolic.values_start(layout);
        let (below, columns) = values.split_at_mut(layout.values.start - start);
        let floor = work.top[1 - side];
        let beside = self.children(s, below, work, 1 - side)?;
        let Workspace { updates, top, runs, panel, smallest } = work;
        let panel = &mut panel[..layout.height() * layout.width];
        let [even, odd] = updates;
        let (stack, held) = if side == 0 { (even, &*odd) } else { (odd, &*even) };
        let from = &held[floor..];
        let other = beside.as_ref().map(|(first, work)| (*first, work.updates[1 - side].as_slice()));

        self.gather(layout, panel);
        for (child, update) in self.updates(s, from, other) {
            self.add_to_panel(child, update, layout, panel, runs);
        }
        let size = [layout.height(), layout.width];
        triangular::eliminate(panel, size).map_err(|column| {
            let (pivot, dimension) = (layout.first + column, self.symbolic.dimension());
            CholeskyError::NotPositiveDefinite { pivot, dimension }
        })?;
        if let Some((_, beside)) = &beside {
            *smallest = smallest.and(beside.smallest);
        }
        *smallest = smallest.and(self.smallest(layout, panel));
        store(layout, panel, columns);
        let b = layout.rows.len();
        let own = &mut stack[top[side]..top[side] + b * b];
        triangular::update(panel, size, own);
        for (child, update) in self.updates(s, from, other) {
            self.add_to_update(child, update, layout, own, runs);
        }
        top[side] += b * b;
        top[1 - side] = floor;
        Ok(())
    }

    /// Factorises the children's subtrees; two large ones at the same time, the later one in a workspace of its own.
    fn children(
        &self,
        s: usize,
        values: &mut [f64],
        work: &mut Workspace,
        side: usize,
    ) -> Result<Beside, CholeskyError> {
        let children = self.symbolic.children(s);
        let layouts = self.symbolic.layouts();
        let base = self.symbolic.values_start(&layouts[s]);
        let in_turn = |children: &[u32], values: &mut [f64], base: usize, work: &mut Workspace| {
            children.iter().try_for_each(|&child| {
                let layout = &layouts[child as usize];
                let own = self.symbolic.values_start(layout) - base..layout.values.end - base;
                self.subtree(child as usize, &mut values[own], work, side)
            })
        };
        let is_large = |&child: &u32| layouts[child as usize].flops > self.task;
        let last_large = children.iter().rposition(is_large).unwrap_or(0);
        if !children[..last_large].iter().any(is_large) {
            in_turn(children, values, base, work)?;
            return Ok(None);
        }
        let (before, after) = children.split_at(last_large);
        let middle = self.symbolic.values_start(&layouts[after[0] as usize]);
        let (values_before, values_after) = values.split_at_mut(middle - base);
        let work = Mutex::new(work);
        let shared = || work.lock().unwrap_or_else(PoisonError::into_inner);
        let failed = AtomicBool::new(false);
        let (first, second) = rayon::join_context(
            |_| in_turn(before, values_before, base, *shared()).inspect_err(|_| failed.store(true, Relaxed)),
            |context| {
                // No other thread was free: the children before have finished, or left updates behind.
                if !context.migrated() {
                    if failed.load(Relaxed) {
                        return Ok(None);
                    }
                    return in_turn(after, values_after, middle, *shared()).map(|()| None);
                }
                let mut beside = Workspace::new(self.symbolic, after, side)?;
                in_turn(after, values_after, middle, &mut beside)?;
                Ok(Some((last_large, beside)))
            },
        );
        first.and(second)
    }

    /// Iterates over the updates of a front's children: the first ones are in `from`, one after another, the updates
    /// from number `other.0` on are in `other.1`.
    fn updates<'b>(
        &'b self,
        s: usize,
        mut from: &'b [f64],
        other: Option<(usize, &'b [f64])>,
    ) -> impl Iterator<Item = (&'b Layout, &'b [f64])> {
        self.symbolic.children(s).iter().enumerate().map(move |(k, &child)| {
            if let Some((_, beside)) = other.filter(|(first, _)| *first == k) {
                from = beside;
            }
            let layout = &self.symbolic.layouts()[child as usize];
            let (own, rest) = from.split_at(layout.rows.len().pow(2));
            from = rest;
            (layout, own)
        })
    }

    /// Copies the front's columns of the matrix to its panel, lower part.
    fn gather(&self, layout: &Layout, panel: &mut [f64]) {
        let rows = self.symbolic.below(layout);
        for (k, column) in panel.chunks_exact_mut(layout.height()).enumerate() {
            column[k..].fill(0.0);
            let mut next = 0;
            for (i, value) in self.matrix.column(layout.first + k) {
                let place = if i < layout.first + layout.width {
                    i - layout.first
                } else {
                    while (rows[next] as usize) < i {
                        next += 1;
                    }
                    layout.width + next
                };
                column[place] = value;
            }
        }
    }

    /// Finds the smallest pivot of a front.
    fn smallest(&self, layout: &Layout, panel: &[f64]) -> SmallestPivot {
        let SymmetricCsc { starts, values, .. } = self.matrix;
        let diagonal = panel.iter().step_by(layout.height() + 1);
        let pivots = diagonal.zip(&starts[layout.first..]).zip(layout.first..);
        pivots.fold(SmallestPivot::default(), |smallest, ((root, start), pivot)| {
            smallest.and(SmallestPivot { pivot, ratio: root * root / values[*start as usize] })
        })
    }

    /// Adds the columns of a child's update that belong to the front.
    fn add_to_panel(
        &self,
        child: &Layout,
        update: &[f64],
        layout: &Layout,
        panel: &mut [f64],
        runs: &mut Vec<Run>,
    ) {
        self.find_runs(child, layout, runs);
        let (count, height) = (child.rows.len(), layout.height());
        for (j, column) in Run::places(runs).take_while(|(_, column)| *column < layout.width) {
            let target = &mut panel[column * height..(column + 1) * height];
            Run::add(runs, &update[j * count..(j + 1) * count], j, target, 0);
        }
    }

    /// Adds the other columns of a child's update to the front's.
    fn add_to_update(
        &self,
        child: &Layout,
        update: &[f64],
        layout: &Layout,
        own: &mut [f64],
        runs: &mut Vec<Run>,
    ) {
        self.find_runs(child, layout, runs);
        let (count, b, width) = (child.rows.len(), layout.rows.len(), layout.width);
        for (j, column) in Run::places(runs).skip_while(|(_, column)| *column < width) {
            let target = &mut own[(column - width) * b..(column - width + 1) * b];
            Run::add(runs, &update[j * count..(j + 1) * count], j, target, width);
        }
    }

    /// Finds the places of a child's rows in the front of its parent.
    fn find_runs(&self, child: &Layout, parent: &Layout, runs: &mut Vec<Run>) {
        let end = (parent.first + parent.width) as u32;
        let candidates = self.symbolic.below(parent);
        let mut next = 0;
        Run::collect(
            self.symbolic.below(child).iter().map(|&row| {
                if row < end {
                    return row - parent.first as u32;
                }
                while candidates[next] < row {
                    next += 1;
                }
                (parent.width + next) as u32
            }),
            runs,
        );
    }
}

/// Keeps the lower part of a panel.
fn store(layout: &Layout, panel: &[f64], columns: &mut [f64]) {
    let height = layout.height();
    for (k, column) in panel.chunks_exact(height).enumerate() {
        let start = column_start(k, height);
        columns[start..start + height - k].copy_from_slice(&column[k..]);
    }
}
