//! The structure of the matrix of the coarse space: the order of elimination of its columns.

use fem_core::cholesky::{Front, SymbolicCholesky};
use fem_core::ordering::ROOT;
use fem_core::sparse::SymmetricCsc;
use std::sync::Arc;

/// A factor with more than this many values per entry of `C` has a bad order: bodies are not numbered as they lie.
const FILL: usize = 30;

/// Columns that are not cut further.
const FRONT: usize = 96;

/// The order of the columns of `C`, the places of its entries, and the structure of its factor.
pub(crate) struct Structure {
    /// The column of each unknown, and the unknown of each column.
    pub(crate) order: Vec<u32>,
    places: Vec<u32>,
    /// The rows of the entries, column after column.
    starts: Vec<u32>,
    rows: Vec<u32>,
    pub(crate) symbolic: Arc<SymbolicCholesky>,
}

impl Structure {
    /// Analyses a matrix; `None` if its columns have a bad order.
    ///
    /// * `entries`: of one triangle, each place once.
    pub(crate) fn new(size: usize, entries: &[(usize, usize, f64)]) -> Option<(Arc<Self>, SymmetricCsc)> {
        let (order, fronts) = dissection(size, entries);
        let mut places = vec![0u32; size];
        (0..).zip(&order).for_each(|(place, column)| places[*column as usize] = place);
        let matrix = reordered(&places, entries);
        let symbolic = SymbolicCholesky::analyse(&matrix, &fronts).ok()?;
        if symbolic.stored_values() > FILL * entries.len() {
            return None;
        }
        let (starts, rows) = (matrix.starts.clone(), matrix.rows.clone());
        Some((Arc::new(Self { order, places, starts, rows, symbolic: Arc::new(symbolic) }), matrix))
    }

    /// Writes a matrix in this order; `None` if one of its entries has no place.
    pub(crate) fn matrix(&self, size: usize, entries: &[(usize, usize, f64)]) -> Option<SymmetricCsc> {
        if size != self.order.len() {
            return None;
        }
        let mut values = vec![0.0; self.rows.len()];
        for (i, j, entry) in entries {
            let (column, row) = lower(&self.places, *i, *j);
            let start = self.starts[column as usize] as usize;
            let rows = &self.rows[start..self.starts[column as usize + 1] as usize];
            values[start + rows.binary_search(&row).ok()?] = *entry;
        }
        Some(SymmetricCsc { starts: self.starts.clone(), rows: self.rows.clone(), values })
    }
}

/// Returns the column and the row of an entry in the lower triangle.
fn lower(places: &[u32], i: usize, j: usize) -> (u32, u32) {
    let [a, b] = [places[i], places[j]];
    (a.min(b), a.max(b))
}

/// Orders the columns of `C` by nested dissection. Subdomains are numbered as their body was halved, so that columns are halved by their numbers.
fn dissection(size: usize, entries: &[(usize, usize, f64)]) -> (Vec<u32>, Vec<Front>) {
    let mut neighbours = vec![Vec::new(); size];
    for (i, j, _) in entries.iter().filter(|(i, j, _)| i != j) {
        neighbours[*i].push(*j as u32);
        neighbours[*j].push(*i as u32);
    }
    let mut found =
        Dissection { neighbours, side: vec![0; size], cuts: 0, order: Vec::new(), fronts: Vec::new() };
    found.cut(&(0..size as u32).collect::<Vec<_>>());
    (found.order, found.fronts)
}

/// A dissection under way.
struct Dissection {
    neighbours: Vec<Vec<u32>>,
    /// The last cut with each column in its second half.
    side: Vec<u32>,
    cuts: u32,
    order: Vec<u32>,
    fronts: Vec<Front>,
}

impl Dissection {
    /// Orders some columns; returns the fronts without a parent.
    fn cut(&mut self, columns: &[u32]) -> Vec<u32> {
        let (first, second) = columns.split_at(columns.len() / 2);
        self.cuts += 1;
        second.iter().for_each(|column| self.side[*column as usize] = self.cuts);
        let meets = |column: &u32| {
            self.neighbours[*column as usize].iter().any(|other| self.side[*other as usize] == self.cuts)
        };
        let (separator, rest): (Vec<u32>, Vec<u32>) = first.iter().partition(|column| meets(column));
        if columns.len() <= FRONT || rest.is_empty() {
            return self.front(columns, Vec::new());
        }
        let mut below = self.cut(&rest);
        below.extend(self.cut(second));
        if separator.is_empty() { below } else { self.front(&separator, below) }
    }

    /// Adds a front above others.
    fn front(&mut self, columns: &[u32], below: Vec<u32>) -> Vec<u32> {
        let (start, number) = (self.order.len() as u32, self.fronts.len() as u32);
        self.order.extend_from_slice(columns);
        self.fronts.push(Front { columns: start..self.order.len() as u32, parent: ROOT });
        below.into_iter().for_each(|front| self.fronts[front as usize].parent = number);
        vec![number]
    }
}

/// Writes a matrix in another order.
///
/// * `entries`: of one triangle, each place once.
fn reordered(places: &[u32], entries: &[(usize, usize, f64)]) -> SymmetricCsc {
    let place = |(i, j, entry): &(usize, usize, f64)| (lower(places, *i, *j), *entry);
    let mut lower: Vec<((u32, u32), f64)> = entries.iter().map(place).collect();
    lower.sort_unstable_by_key(|(place, _)| *place);
    let mut starts = vec![0u32; places.len() + 1];
    lower.iter().for_each(|((column, _), _)| starts[*column as usize + 1] += 1);
    (0..places.len()).for_each(|column| starts[column + 1] += starts[column]);
    let (rows, values) = lower.into_iter().map(|((_, row), entry)| (row, entry)).unzip();
    SymmetricCsc { starts, rows, values }
}
