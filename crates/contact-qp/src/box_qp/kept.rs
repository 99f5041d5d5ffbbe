//! The factor of one block of a full matrix, used for blocks that differ from it in few rows.
//!
//! Rows `A` join the factorised block `B`, and rows `R` leave it. The solution of `K x = r` on the new block is
//! ```math
//! x_B = K_BB⁻¹ (r_B − C w),   (D − Cᵀ K_BB⁻¹ C) w = (r_A, 0) − Cᵀ K_BB⁻¹ r_B,   C = [K_BA, E_R],   D = [K_AA, 0; 0, 0]
//! ```
//! with `r_R = 0` and `w` of `x_A` and the forces that hold `x_R = 0`. The columns of `K_BB⁻¹ C` are kept as well.

use super::weighted::Weighted;
use crate::cholesky::{Factor, PIVOT_FLOOR};
use crate::dense::dot;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use std::collections::HashMap;

/// Smaller blocks are always factorised.
const LARGE: usize = 512;

/// A block that differs in more than this part of its rows is factorised.
const DIFFERENT: usize = 32;

/// A column of which less than this fraction is left depends on others: rows of one node that are exactly dependent leave some ε.
pub(super) const DEPENDENT_COLUMN: f64 = 1e-12;

/// No row of the block.
const OUTSIDE: usize = usize::MAX;

/// A factorised block.
pub(super) struct Kept {
    rows: Vec<usize>,
    /// The place of each row of the matrix in the block.
    places: Vec<usize>,
    factor: Factor,
    /// The columns of `C` and `K_BB⁻¹ C` of the rows in which the last block differed.
    columns: HashMap<usize, (Vec<f64>, Vec<f64>)>,
}

/// The rows in which a block differs from the factorised one.
#[derive(Default)]
pub(super) struct Changes {
    /// Those that join first.
    rows: Vec<usize>,
    small: Option<LU<f64, Dyn, Dyn>>,
}

impl Kept {
    /// Factorises a block; `None` if it is not positive definite, or by round-off alone.
    pub(super) fn new(matrix: &Weighted<'_>, rows: &[usize]) -> Option<Self> {
        let factor = Factor::new(rows.len(), matrix.lower(rows)).ok()?;
        let depends = |(pivot, row): (f64, &usize)| pivot * pivot <= DEPENDENT_COLUMN * matrix.diagonal(*row);
        if factor.pivots().zip(rows).any(depends) {
            return None;
        }
        let mut places = vec![OUTSIDE; matrix.size()];
        rows.iter().enumerate().for_each(|(place, row)| places[*row] = place);
        Some(Self { rows: rows.to_vec(), places, factor, columns: HashMap::new() })
    }

    /// Prepares solutions on a block; `None` if it is better factorised.
    pub(super) fn changes(&mut self, matrix: &Weighted<'_>, block: &[usize]) -> Option<Changes> {
        let size = self.rows.len();
        let mut stays = vec![false; self.places.len()];
        block.iter().for_each(|row| stays[*row] = true);
        let mut rows: Vec<usize> = block.iter().copied().filter(|row| self.places[*row] == OUTSIDE).collect();
        let joined = rows.len();
        rows.extend(self.rows.iter().filter(|row| !stays[**row]));
        if rows.is_empty() {
            return Some(Changes::default());
        }
        if size < LARGE || DIFFERENT * rows.len() > size {
            return None;
        }
        self.columns.retain(|row, _| rows.contains(row));
        let new: Vec<usize> = rows.iter().copied().filter(|row| !self.columns.contains_key(row)).collect();
        let column = |row: &usize| -> Vec<f64> {
            match self.places[*row] {
                OUTSIDE => {
                    let column = matrix.column(*row);
                    self.rows.iter().map(|i| column[*i]).collect()
                }
                place => (0..size).map(|i| if i == place { 1.0 } else { 0.0 }).collect(),
            }
        };
        let columns: Vec<Vec<f64>> = new.iter().map(column).collect();
        let mut solved = columns.concat();
        self.factor.solve(&mut solved);
        let solved = solved.chunks_exact(size).map(<[f64]>::to_vec);
        self.columns.extend(new.iter().zip(columns.into_iter().zip(solved)).map(|(row, pair)| (*row, pair)));
        let joining: Vec<Vec<f64>> = rows[..joined].iter().map(|row| matrix.column(*row)).collect();
        let entry = |i: usize, j: usize| {
            let own = if i < joined && j < joined { joining[j][rows[i]] } else { 0.0 };
            own - dot(&self.columns[&rows[i]].0, &self.columns[&rows[j]].1)
        };
        let small = DMatrix::from_fn(rows.len(), rows.len(), entry);
        // Positive definite with the rows that join, and so without those that leave.
        let joining = small.view((0, 0), (joined, joined)).iter().copied().collect();
        let joining = Factor::new(joined, joining).ok()?;
        let round_off = |(pivot, row): (f64, &usize)| pivot * pivot <= PIVOT_FLOOR * matrix.diagonal(*row);
        if joining.pivots().zip(&rows).any(round_off) {
            return None;
        }
        let small = small.lu();
        small.is_invertible().then_some(Changes { rows, small: Some(small) })
    }

    /// Overwrites right-hand sides with the first part of the solutions on a block, `Q r` of `H⁻¹ = R Q`: `L⁻¹ r` on the factorised block, and
    /// all of `H⁻¹ r`, in the order of its rows, on another one.
    ///
    /// * `changes`: of [`Self::changes`] for this block.
    pub(super) fn forward(&self, block: &[usize], changes: &Changes, sides: &mut [f64]) {
        let Some(small) = &changes.small else { return self.factor.forward(sides) };
        let (size, count) = (self.rows.len(), block.len().max(1));
        let mut inside = vec![0.0; sides.len() / count * size];
        for (inside, side) in inside.chunks_exact_mut(size).zip(sides.chunks_exact(count)) {
            for (row, value) in block.iter().zip(side).filter(|(row, _)| self.places[**row] != OUTSIDE) {
                inside[self.places[*row]] = *value;
            }
        }
        self.factor.solve(&mut inside);
        for (inside, side) in inside.chunks_exact_mut(size).zip(sides.chunks_exact_mut(count)) {
            let joins = block.iter().zip(&*side).filter(|(row, _)| self.places[**row] == OUTSIDE);
            let mut forces = DVector::zeros(changes.rows.len());
            forces.iter_mut().zip(joins).for_each(|(force, (_, value))| *force = *value);
            for (row, force) in changes.rows.iter().zip(forces.iter_mut()) {
                *force -= dot(&self.columns[row].0, inside);
            }
            small.solve_mut(&mut forces);
            for (row, force) in changes.rows.iter().zip(forces.iter()) {
                inside.iter_mut().zip(&self.columns[row].1).for_each(|(x, y)| *x -= force * y);
            }
            let mut joins = forces.iter();
            for (row, value) in block.iter().zip(side) {
                *value = match self.places[*row] {
                    OUTSIDE => joins.next().copied().unwrap_or_default(),
                    place => inside[place],
                };
            }
        }
    }

    /// Overwrites right-hand sides with the second part of the solutions, `R q`.
    pub(super) fn backward(&self, changes: &Changes, sides: &mut [f64]) {
        if changes.is_none() {
            self.factor.backward(sides);
        }
    }
}

impl Changes {
    /// Tells whether the block is the factorised one.
    pub(super) fn is_none(&self) -> bool {
        self.small.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::SparseRows;

    #[test]
    fn a_block_that_differs_in_few_rows_needs_no_factor() {
        let n = 640;
        let entry = |i: usize, j: usize| if i == j { 3.0 } else { (1.0 + i.abs_diff(j) as f64).powi(-2) };
        let values: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n)).collect();
        let plain = |values| Weighted::new(n, values, SparseRows::new(n), 1.0);
        let matrix = plain(&values);
        let block = |without: &[usize]| -> Vec<usize> { (0..n).filter(|i| !without.contains(i)).collect() };
        let mut kept = Kept::new(&matrix, &block(&[3, 4, 600])).unwrap();
        for without in [vec![3, 4, 600], vec![4, 20, 21, 639], vec![4, 20, 300], vec![], vec![0, 3, 4, 600]] {
            let rows = block(&without);
            let changes = kept.changes(&matrix, &rows).unwrap();
            let sides: Vec<f64> = (0..2 * rows.len()).map(|k| (k as f64).sin()).collect();
            let [mut found, mut expected] = [sides.clone(), sides];
            kept.forward(&rows, &changes, &mut found);
            kept.backward(&changes, &mut found);
            Factor::of_block(n, &values, &rows).unwrap().solve(&mut expected);
            assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13), "{without:?}");
        }
        assert!(kept.changes(&matrix, &block(&(0..40).collect::<Vec<_>>())).is_none());
        // A row that is the double of another leaves a direction without stiffness.
        let mut singular = values.clone();
        let twice = |i: usize| if i == 4 { 2.0 } else { 1.0 };
        for k in 0..n * n {
            let (i, j) = (k % n, k / n);
            let source = |i: usize| if i == 4 { 5 } else { i };
            singular[k] = twice(i) * twice(j) * entry(source(i), source(j));
        }
        let mut kept = Kept::new(&plain(&singular), &block(&[4])).unwrap();
        assert!(
            kept.changes(&plain(&singular), &block(&[])).is_none()
                && kept.changes(&plain(&singular), &block(&[4, 7])).is_some()
        );
        assert!(Kept::new(&matrix, &[]).is_some());
        let small = Kept::new(&matrix, &[0, 1, 2]);
        assert!(small.is_some_and(|mut small| small.changes(&matrix, &[0, 1]).is_none()));
    }
}
