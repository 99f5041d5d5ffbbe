//! Full matrices most of whose entries are zero, in an order that brings the others near the diagonal.

use dense_cholesky::Profile;
use std::ops::Range;

/// Smaller matrices are treated as full.
const LARGE: usize = 512;

/// The order of the rows of a symmetric matrix, and where its entries that are not zero are.
pub(crate) struct Narrow {
    order: Vec<usize>,
    /// One past the last row, in the order, of each column that is not zero.
    ends: Vec<usize>,
    /// The rows between the first and the last entry of each column, in the order of the matrix.
    rows: Vec<Range<usize>>,
}

impl Narrow {
    /// Orders a matrix by the reverse method of Cuthill and McKee; `None` if it is small, or if half of its entries would be within the
    /// profile.
    ///
    /// * `values`: both triangles, `n` rows and columns.
    pub(crate) fn new(n: usize, values: &[f64]) -> Option<Self> {
        if n < LARGE {
            return None;
        }
        let mut rows = Vec::with_capacity(n);
        let mut entries = 0;
        for column in values.chunks_exact(n) {
            let first = column.iter().position(|value| *value != 0.0).unwrap_or(0);
            let end = column.iter().rposition(|value| *value != 0.0).map_or(first, |last| last + 1);
            entries += column[first..end].iter().filter(|value| **value != 0.0).count();
            if 2 * entries > n * n {
                return None;
            }
            rows.push(first..end);
        }
        let neighbours = |column: usize| {
            let of_rows = rows[column].clone();
            of_rows.filter(move |row| values[column * n + row] != 0.0)
        };
        let mut order: Vec<usize> = Vec::with_capacity(n);
        let mut seen = vec![false; n];
        for start in 0..n {
            if seen[start] {
                continue;
            }
            // The last node that is reached is as far away as any, so the levels seen from there are small.
            let from = order.len();
            visit(start, &neighbours, &mut seen, &mut order);
            let farthest = order[order.len() - 1];
            order.drain(from..).for_each(|node| seen[node] = false);
            visit(farthest, &neighbours, &mut seen, &mut order);
        }
        // If the zeros are not symmetric, a node may not be reached from one that it reaches.
        if order.len() != n {
            return None;
        }
        order.reverse();
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(k, row)| place[*row] = k);
        let end = |column: &usize| neighbours(*column).map(|row| place[row] + 1).max().unwrap_or(0);
        let ends: Vec<usize> = order.iter().map(end).collect();
        let inside: usize =
            Profile::new(ends.iter().copied()).ends().iter().zip(0..).map(|(end, j)| end - j).sum();
        (4 * inside <= n * n).then_some(Self { order, ends, rows })
    }

    /// Returns the rows and columns of a block in the order, and its profile.
    pub(crate) fn block(&self, is_in: impl Fn(usize) -> bool) -> (Vec<usize>, Profile) {
        let mut before = Vec::with_capacity(self.order.len() + 1);
        before.push(0);
        before.extend(self.order.iter().scan(0, |count, row| {
            *count += usize::from(is_in(*row));
            Some(*count)
        }));
        let columns = self.order.iter().zip(&self.ends).filter(|(row, _)| is_in(**row));
        let (rows, ends): (Vec<usize>, Vec<usize>) = columns.map(|(row, end)| (*row, before[*end])).unzip();
        (rows, Profile::new(ends))
    }

    /// Adds `P x` to `y`.
    pub(crate) fn add_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        let columns = values.chunks_exact(x.len().max(1)).zip(x).zip(&self.rows);
        for ((column, x), rows) in columns.filter(|((_, x), _)| **x != 0.0) {
            y[rows.clone()].iter_mut().zip(&column[rows.clone()]).for_each(|(y, p)| *y += p * x);
        }
    }
}

/// Appends all nodes that can be reached from one, the nearest first.
fn visit<I: Iterator<Item = usize>>(
    start: usize,
    neighbours: &impl Fn(usize) -> I,
    seen: &mut [bool],
    order: &mut Vec<usize>,
) {
    let mut next = order.len();
    seen[start] = true;
    order.push(start);
    while let Some(node) = order.get(next).copied() {
        next += 1;
        for row in neighbours(node) {
            if !std::mem::replace(&mut seen[row], true) {
                order.push(row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoxQp, QpPath, QpSettings, QpStatus, solve_box};

    /// A chain of bodies whose rows are numbered without regard to it.
    fn chain(n: usize) -> Vec<f64> {
        let place = |i: usize| i * 7 % n;
        let mut values = vec![0.0; n * n];
        for i in 0..n {
            for j in i.saturating_sub(20)..n.min(i + 21) {
                let value = if i == j { 40.0 } else { (1.0 + (i + j) as f64).sin() };
                values[place(j) * n + place(i)] = value;
            }
        }
        values
    }

    #[test]
    fn a_chain_is_found_in_any_order() {
        let n = 600;
        let values = chain(n);
        let narrow = Narrow::new(n, &values).unwrap();
        let (rows, profile) = narrow.block(|row| row % 5 != 0);
        assert_eq!(rows.len(), n - n / 5);
        for (j, end) in profile.ends().iter().enumerate() {
            assert!(rows[*end..].iter().all(|row| values[rows[j] * n + row] == 0.0));
            assert!(end - j < 200, "{end} of column {j}");
        }
        assert!(Narrow::new(n, &vec![1.0; n * n]).is_none() && Narrow::new(100, &chain(100)).is_none());
    }

    #[test]
    fn narrow_programmes_are_solved_with_rows_that_couple_all_unknowns() {
        let n = 600;
        let mut values = chain(n);
        let linear: Vec<f64> = (0..n).map(|i| (3.0 * i as f64).cos()).collect();
        let rows: Vec<f64> = (0..2 * n).map(|k| if k < n { 1.0 } else { (k as f64).sin() }).collect();
        let lower: Vec<f64> = (0..n).map(|i| if i == 9 { f64::NEG_INFINITY } else { 0.0 }).collect();
        for singular in [false, true] {
            if singular {
                // Only the rows determine this unknown.
                (0..n).for_each(|i| (values[9 * n + i], values[i * n + 9]) = (0.0, 0.0));
            }
            let qp = BoxQp {
                matrix: &values,
                linear: &linear,
                lower: &lower,
                upper: &vec![f64::INFINITY; n],
                rows: &rows,
                right_side: &[2.0, 0.1],
            };
            let found = solve_box(&qp, None, &QpSettings::default()).unwrap();
            assert_eq!(found.status, QpStatus::Solved);
            assert!(singular || found.path == QpPath::ActiveSet);
            assert!(found.kkt.max() < 1e-13, "{:?}", found.kkt);
        }
    }
}
