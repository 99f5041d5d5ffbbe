//! The structure of a factor: fronts, their rows, and the places of their values.

use super::CholeskyError;
use crate::ordering::ROOT;
use crate::sparse::SymmetricCsc;
use std::ops::Range;

/// Columns eliminated together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Front {
    /// The columns; fronts are consecutive.
    pub columns: Range<u32>,
    /// The front that receives the update of this one, later in the list, or [`ROOT`].
    pub parent: u32,
}

/// The places of a front's columns, rows and values.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) first: usize,
    pub(super) width: usize,
    /// Its rows below the diagonal block, in `SymbolicCholesky::below`.
    pub(super) rows: Range<usize>,
    /// Its values in the factor, column by column from the diagonal down.
    pub(super) values: Range<usize>,
    /// The first front of its subtree.
    pub(super) subtree: usize,
    /// Operations of its subtree.
    pub(super) flops: f64,
    /// Values of updates that exist at once while one thread factorises its subtree, on the stack of its own update
    /// and on the stack of its children's updates.
    pub(super) peak: [usize; 2],
    /// The largest number of values of a front's columns, upper half of the diagonal block included, in its subtree.
    pub(super) largest: usize,
}

impl Layout {
    /// Counts the rows of its columns, diagonal block included.
    pub(super) fn height(&self) -> usize {
        self.width + self.rows.len()
    }
}

/// Place of the diagonal entry of column `k` among the values of a front with columns of `height` rows.
pub(super) fn column_start(k: usize, height: usize) -> usize {
    k * height - k * k.saturating_sub(1) / 2
}

/// The structure of a factor, for every matrix of the same pattern.
#[derive(Clone, Debug)]
pub struct SymbolicCholesky {
    dimension: usize,
    layouts: Vec<Layout>,
    /// Rows of all fronts below their diagonal blocks, each ascending.
    below: Vec<u32>,
    /// The children of all fronts, each front's ascending, and their starts.
    children: Vec<u32>,
    child_starts: Vec<u32>,
    roots: Vec<u32>,
    stored_values: usize,
}

impl SymbolicCholesky {
    /// Finds the structure of the factor of a matrix on a given tree.
    ///
    /// * `fronts`: children before parents, each subtree contiguous.
    ///
    /// # Errors
    /// Fronts that do not cover the matrix, or that do not form a tree for it.
    pub fn analyse(matrix: &SymmetricCsc, fronts: &[Front]) -> Result<Self, CholeskyError> {
        let dimension = matrix.dimension();
        let fault = |reason| CholeskyError::Tree { dimension, reason };
        check(fronts, dimension).map_err(fault)?;
        let (child_starts, children) = children(fronts);
        let mut symbolic = Self {
            dimension,
            layouts: Vec::with_capacity(fronts.len()),
            below: Vec::new(),
            children,
            child_starts,
            roots: Vec::new(),
            stored_values: 0,
        };
        let mut seen = vec![ROOT; dimension];
        let mut rows = Vec::new();
        for (s, front) in fronts.iter().enumerate() {
            symbolic.rows_below(matrix, front, s, &mut seen, &mut rows);
            if front.parent == ROOT && !rows.is_empty() {
                return Err(fault("a root has rows below it"));
            }
            let start = symbolic.below.len();
            symbolic.below.extend_from_slice(&rows);
            let layout = symbolic.layout(front, s, start..symbolic.below.len());
            symbolic.stored_values = layout.values.end;
            if front.parent == ROOT {
                symbolic.roots.push(s as u32);
            }
            symbolic.layouts.push(layout);
        }
        symbolic.check_parents(fronts).map_err(fault)?;
        Ok(symbolic)
    }

    /// Lists the rows of front `s` below its diagonal block, ascending: the rows of its columns and of its children.
    ///
    /// * `seen`: for every row the last front that has it.
    fn rows_below(
        &self,
        matrix: &SymmetricCsc,
        front: &Front,
        s: usize,
        seen: &mut [u32],
        rows: &mut Vec<u32>,
    ) {
        let (first, end) = (front.columns.start as usize, front.columns.end as usize);
        rows.clear();
        let mut take = |row: u32| {
            if row as usize >= end && seen[row as usize] != s as u32 {
                seen[row as usize] = s as u32;
                rows.push(row);
            }
        };
        matrix.rows[matrix.starts[first] as usize..matrix.starts[end] as usize]
            .iter()
            .for_each(|&row| take(row));
        for &child in self.children(s) {
            self.below[self.layouts[child as usize].rows.clone()].iter().for_each(|&row| take(row));
        }
        rows.sort_unstable();
    }

    /// Lays out front `s`, with its values after the earlier fronts, and counts the needs of its subtree.
    ///
    /// * `rows`: the places of its rows below the diagonal block in `below`.
    fn layout(&self, front: &Front, s: usize, rows: Range<usize>) -> Layout {
        let (first, end) = (front.columns.start as usize, front.columns.end as usize);
        let (width, height) = (end - first, end - first + rows.len());
        let mut layout = Layout {
            first,
            width,
            rows: rows.clone(),
            values: self.stored_values..self.stored_values + column_start(width, height),
            subtree: s,
            flops: operations(width, rows.len()),
            peak: [0; 2],
            largest: width * height,
        };
        let mut held = 0;
        for child in self.children(s).iter().map(|&c| &self.layouts[c as usize]) {
            layout.flops += child.flops;
            layout.subtree = layout.subtree.min(child.subtree);
            layout.largest = layout.largest.max(child.largest);
            let [own, other] = child.peak;
            layout.peak = [layout.peak[0].max(other), layout.peak[1].max(held + own)];
            held += child.rows.len().pow(2);
        }
        layout.peak[0] = layout.peak[0].max(rows.len().pow(2));
        layout
    }

    /// Checks that every row of a front below its diagonal block has its place in the front of its parent.
    fn check_parents(&self, fronts: &[Front]) -> Result<(), &'static str> {
        for (layout, front) in self.layouts.iter().zip(fronts).filter(|(_, f)| f.parent != ROOT) {
            let parent = &self.layouts[front.parent as usize];
            let candidates = self.below(parent);
            let mut next = 0;
            for &row in self.below(layout) {
                if (row as usize) < parent.first {
                    // It would never be eliminated.
                    return Err("a front skips rows");
                }
                if (row as usize) < parent.first + parent.width {
                    continue;
                }
                while candidates.get(next).is_some_and(|&c| c < row) {
                    next += 1;
                }
                if candidates.get(next) != Some(&row) {
                    return Err("a parent lacks a row of its child");
                }
            }
        }
        Ok(())
    }

    /// Returns the dimension of the matrix.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns the number of values the factor stores.
    pub fn stored_values(&self) -> usize {
        self.stored_values
    }

    /// Returns the number of multiplications and additions of the factorisation.
    pub fn operations(&self) -> f64 {
        self.roots().map(|root| self.layouts[root].flops).sum()
    }

    /// Iterates over the fronts: how many columns each has, and how many rows below them. For counts of operations and bytes.
    #[doc(hidden)]
    pub fn front_sizes(&self) -> impl Iterator<Item = [usize; 2]> {
        self.layouts.iter().map(|layout| [layout.width, layout.rows.len()])
    }

    /// Iterates over the fronts that are not in another front's subtree, ascending.
    pub(super) fn roots(&self) -> impl Iterator<Item = usize> {
        self.roots.iter().map(|&root| root as usize)
    }

    /// Returns the start of the values of a front's subtree.
    pub(super) fn values_start(&self, layout: &Layout) -> usize {
        self.layouts[layout.subtree].values.start
    }

    pub(super) fn layouts(&self) -> &[Layout] {
        &self.layouts
    }

    /// Returns the children of a front, ascending.
    pub(super) fn children(&self, s: usize) -> &[u32] {
        &self.children[self.child_starts[s] as usize..self.child_starts[s + 1] as usize]
    }

    pub(super) fn below(&self, layout: &Layout) -> &[u32] {
        &self.below[layout.rows.clone()]
    }
}

fn check(fronts: &[Front], dimension: usize) -> Result<(), &'static str> {
    let mut next = 0;
    for (s, front) in fronts.iter().enumerate() {
        if front.columns.start != next || front.columns.end <= next {
            return Err("the fronts are not consecutive");
        }
        if front.parent != ROOT && (front.parent as usize <= s || front.parent as usize >= fronts.len()) {
            return Err("a parent does not come after its child");
        }
        next = front.columns.end;
    }
    if next as usize == dimension { Ok(()) } else { Err("the fronts do not cover the matrix") }
}

/// Lists the children of all fronts: the starts of the lists, and the lists.
fn children(fronts: &[Front]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; fronts.len() + 1];
    let parents = || fronts.iter().enumerate().filter(|(_, f)| f.parent != ROOT);
    for (_, front) in parents() {
        starts[front.parent as usize + 1] += 1;
    }
    for s in 0..fronts.len() {
        starts[s + 1] += starts[s];
    }
    let mut children = vec![0; starts[fronts.len()] as usize];
    let mut next = starts.clone();
    for (s, front) in parents() {
        let place = &mut next[front.parent as usize];
        children[*place as usize] = s as u32;
        *place += 1;
    }
    (starts, children)
}

/// Operations of eliminating `w` columns with `b` rows below: `w³/3 + w² b + w b²`.
fn operations(w: usize, b: usize) -> f64 {
    let (w, b) = (w as f64, b as f64);
    w * w * w / 3.0 + w * w * b + w * b * b
}
