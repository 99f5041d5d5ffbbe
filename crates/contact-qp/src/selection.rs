//! Sparse rows that depend on others, and the rows that are left.

use crate::dense::norm;
use crate::error::QpError;
use crate::sparse::{Normal, SparseFactor, SparseRows};
use std::collections::HashMap;

/// A row whose part outside the span of the others is below this fraction of the longest row depends on them.
const DEPENDENT: f64 = 1e-9;

/// Rows of which less than this fraction of the longest one of their group is left are examined on their own.
const NEAR: f64 = 0.1;

/// Corrections of a combination.
const REFINEMENTS: usize = 2;

/// A combination of rows: their numbers, ascending, with factors.
pub type Combination = Vec<(usize, f64)>;

/// Which of the rows `G` are independent, and the combinations `t` with `tᵀ G = 0`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowSelection {
    /// Numbers of the independent rows, ascending.
    pub rows: Vec<usize>,
    /// An orthonormal basis of all `t` with `tᵀ G = 0`.
    pub kernel: Vec<Combination>,
    /// Combinations of length one that give nearly zero, and whose right-hand side is nearly zero too: in contact, motions that only the
    /// error of the normals resists and no load of its own drives.
    pub weak: Vec<Combination>,
    /// Number of given rows.
    count: usize,
}

impl RowSelection {
    /// Selects rows by a sparse Cholesky factor of `G Gᵀ`: those whose part outside the span of the rows before is small are examined on their own, the
    /// one with the largest part first. Each row is measured against the longest one of its group.
    ///
    /// * `groups`: of each row, such as the body whose motion it is; `weak`: a combination is weak if less than this fraction of the longest row
    ///   and of the right-hand side is left.
    ///
    /// # Errors
    /// [`QpError::Library`].
    pub fn new(rows: &SparseRows, right_side: &[f64], groups: &[usize], weak: f64) -> Result<Self, QpError> {
        let count = rows.len();
        let mut found = Self { count, ..Self::default() };
        let lengths: Vec<f64> = rows.rows().map(|row| row.map(|(_, g)| g * g).sum::<f64>().sqrt()).collect();
        let mut longest: HashMap<usize, f64> = HashMap::new();
        for (group, length) in groups.iter().zip(&lengths) {
            let longest = longest.entry(*group).or_default();
            *longest = length.max(*longest);
        }
        let scales: Vec<f64> =
            groups.iter().map(|g| longest[g]).map(|l| if l > 0.0 { 1.0 / l } else { 1.0 }).collect();
        let rows = &rows.clone().with_scaled_rows(&scales);
        let right_side: &Vec<f64> = &right_side.iter().zip(&scales).map(|(e, scale)| e * scale).collect();
        let mut normal = Normal::new(&rows.transposed());
        let factor = normal.factorise(&vec![1.0; rows.columns()], 0.0, NEAR * NEAR)?;
        let left_out = factor.left_out();
        let mut is_kept = vec![true; count];
        left_out.iter().for_each(|k| is_kept[*k] = false);
        let combinations = left_out.iter().map(|k| remainder(rows, &factor, &is_kept, *k));
        let mut rest: Vec<(Vec<f64>, Vec<f64>)> =
            combinations.map(|t| (rows.transposed_times(&t), t)).collect();
        let loads = norm(right_side);
        while let Some(place) = (0..rest.len()).max_by(|a, b| norm(&rest[*a].0).total_cmp(&norm(&rest[*b].0)))
        {
            let (length, size) = (norm(&rest[place].0), norm(&rest[place].1));
            if length <= DEPENDENT * size {
                break;
            }
            let (row, mut combination) = rest.swap_remove(place);
            let value = dot(&combination, right_side);
            if length <= weak * size && value.abs() <= weak * loads * size {
                found.weak.push(unscaled(&mut combination, &scales));
                continue;
            }
            // It counts, so the others are taken without their part along it.
            for (other, of_other) in &mut rest {
                let part = dot(other, &row) / (length * length);
                subtract(other, part, &row);
                subtract(of_other, part, &combination);
            }
        }
        for (_, mut combination) in rest {
            unscaled(&mut combination, &scales);
            for _ in 0..2 {
                found.without_kernel(&mut combination);
            }
            found.kernel.push(unscaled(&mut combination, &vec![1.0; count]));
        }
        found.leave_out(count);
        Ok(found)
    }

    /// Leaves one row out for each combination: the one that is the largest part of it, such as the spin of a roller.
    fn leave_out(&mut self, count: usize) {
        let dense = |combination: &Combination| {
            let mut values = vec![0.0; count];
            combination.iter().for_each(|(k, t)| values[*k] = *t);
            values
        };
        let mut combinations: Vec<Vec<f64>> = self.kernel.iter().chain(&self.weak).map(dense).collect();
        let mut is_kept = vec![true; count];
        for i in 0..combinations.len() {
            let (done, others) = combinations.split_at_mut(i + 1);
            let own = &done[i];
            let Some(k) = (0..count).max_by(|a, b| own[*a].abs().total_cmp(&own[*b].abs())) else { continue };
            is_kept[k] = false;
            for other in others.iter_mut().filter(|other| other[k] != 0.0) {
                let part = other[k] / own[k];
                subtract(other, part, own);
            }
        }
        self.rows = (0..count).filter(|k| is_kept[*k]).collect();
    }

    /// Returns the multipliers of all rows for those of the independent ones, without a part in the kernel.
    pub fn expanded(&self, multipliers: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.count];
        self.rows.iter().zip(multipliers).for_each(|(k, a)| all[*k] = *a);
        self.without_kernel(&mut all);
        all
    }

    /// Returns the part of a right-hand side in the kernel, which no `x` can balance.
    pub fn unbalanced(&self, right_side: &[f64]) -> Vec<f64> {
        // Summed up, not left by a difference: next to large entries that would be rounding.
        let mut sum = vec![0.0; right_side.len()];
        for combination in &self.kernel {
            let part: f64 = combination.iter().map(|(k, t)| t * right_side[*k]).sum();
            combination.iter().for_each(|(k, t)| sum[*k] += part * t);
        }
        sum
    }

    fn without_kernel(&self, values: &mut [f64]) {
        for combination in &self.kernel {
            let part: f64 = combination.iter().map(|(k, t)| t * values[*k]).sum();
            combination.iter().for_each(|(k, t)| values[*k] -= part * t);
        }
    }
}

/// Computes the combination of a row with the kept ones that is orthogonal to these.
fn remainder(rows: &SparseRows, factor: &SparseFactor, is_kept: &[bool], row: usize) -> Vec<f64> {
    let mut combination = vec![0.0; rows.len()];
    combination[row] = 1.0;
    for _ in 0..=REFINEMENTS {
        let mut product = rows.times(&rows.transposed_times(&combination));
        product.iter_mut().zip(is_kept).filter(|(_, kept)| !**kept).for_each(|(value, _)| *value = 0.0);
        factor.solve(&mut product);
        combination.iter_mut().zip(&product).for_each(|(t, part)| *t -= part);
    }
    combination
}

/// Multiplies a combination by the scales of its rows, and gives it length one.
fn unscaled(values: &mut [f64], scales: &[f64]) -> Combination {
    values.iter_mut().zip(scales).for_each(|(t, scale)| *t *= scale);
    let size = norm(values);
    values.iter_mut().for_each(|t| *t /= size);
    values.iter().copied().enumerate().filter(|(_, t)| *t != 0.0).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= factor * b);
}
