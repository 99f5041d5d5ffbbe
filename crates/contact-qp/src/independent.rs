//! Independent rows: those that say something, with length one.

use crate::dense::{dot, norm};

/// A row whose part outside the span of the others is below this fraction of the longest row depends on them.
const DEPENDENT: f64 = 1e-9;

/// Orthonormal combinations of the rows of `G x = e`, and the combinations `t` with `tᵀ G = 0`.
///
/// A row of round-off must not become a condition: in contact such a row is the motion of a body that no pair resists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IndependentRows {
    /// The combinations, row after row, orthonormal.
    pub rows: Vec<f64>,
    /// Their right-hand sides.
    pub right_side: Vec<f64>,
    /// The combinations in the given rows: `rows = T G`.
    combinations: Vec<Vec<f64>>,
    /// An orthonormal basis of all `t` with `tᵀ G = 0`.
    kernel: Vec<Vec<f64>>,
}

/// Entries below this fraction of the largest one are the rounding of others: they are zero.
const ROUNDING: f64 = 1e-14;

/// Sets entries of round-off to zero: a solution at a vertex must not have to satisfy them.
fn clear_rounding(row: &mut [f64]) {
    let largest = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    row.iter_mut().filter(|x| x.abs() <= ROUNDING * largest).for_each(|x| *x = 0.0);
}

impl IndependentRows {
    /// Finds independent combinations of rows, the longest row first.
    ///
    /// * `rows`: G, row after row, m·n entries; `right_side`: e, m entries, few.
    pub fn new(rows: &[f64], right_side: &[f64]) -> Self {
        let m = right_side.len();
        let n = rows.len().checked_div(m).unwrap_or(0);
        let unit = |k: usize| (0..m).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let mut left: Vec<(Vec<f64>, Vec<f64>)> =
            (0..m).map(|k| (rows[k * n..(k + 1) * n].to_vec(), unit(k))).collect();
        let mut lengths: Vec<f64> = left.iter().map(|(row, _)| norm(row)).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let mut found = Self { rows: Vec::with_capacity(rows.len()), ..Self::default() };
        while let Some(place) = (0..left.len()).max_by(|a, b| lengths[*a].total_cmp(&lengths[*b])) {
            if !(lengths[place] > DEPENDENT * longest) {
                break;
            }
            let length = lengths.swap_remove(place);
            let (mut row, mut combination) = left.swap_remove(place);
            row.iter_mut().chain(&mut combination).for_each(|x| *x /= length);
            clear_rounding(&mut row);
            // The entries of the motion of one body lie close together: zeros around them change no other row.
            let is_entry = |x: &f64| *x != 0.0;
            let first = row.iter().position(is_entry).unwrap_or(0);
            let entries = first..row.iter().rposition(is_entry).map_or(first, |last| last + 1);
            for ((other, of_other), length) in left.iter_mut().zip(&mut lengths) {
                // Twice, so that the rows stay orthogonal to round-off. Most motions of an assembly have no row in common.
                for _ in 0..2 {
                    let part = dot(&other[entries.clone()], &row[entries.clone()]);
                    if part != 0.0 {
                        subtract(&mut other[entries.clone()], part, &row[entries.clone()]);
                        subtract(of_other, part, &combination);
                        *length = norm(other);
                    }
                }
            }
            found.rows.extend(row);
            found.combinations.push(combination);
        }
        for (_, mut combination) in left {
            for _ in 0..2 {
                for known in &found.kernel {
                    let part = dot(&combination, known);
                    subtract(&mut combination, part, known);
                }
            }
            let length = norm(&combination);
            combination.iter_mut().for_each(|x| *x /= length);
            found.kernel.push(combination);
        }
        found.right_side = found.right_side_of(right_side);
        found
    }

    /// Computes the right-hand sides of [`Self::rows`] for other ones of the given rows.
    pub fn right_side_of(&self, right_side: &[f64]) -> Vec<f64> {
        let of = |combination: &Vec<f64>| {
            let terms = combination.iter().zip(right_side).map(|(a, b)| (a * b).abs()).sum::<f64>();
            let value = dot(combination, right_side);
            if value.abs() > ROUNDING * terms { value } else { 0.0 }
        };
        self.combinations.iter().map(of).collect()
    }

    /// Returns the multipliers of the given rows for multipliers of [`Self::rows`]: `Tᵀ a`, without a part in the kernel.
    pub fn expanded(&self, multipliers: &[f64]) -> Vec<f64> {
        let m = self.combinations.len() + self.kernel.len();
        let mut all = vec![0.0; m];
        for (a, combination) in multipliers.iter().zip(&self.combinations) {
            subtract(&mut all, -a, combination);
        }
        for t in &self.kernel {
            let part = dot(&all, t);
            subtract(&mut all, part, t);
        }
        all
    }
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= factor * b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_rows_and_rows_of_round_off_become_a_kernel() {
        let rows = [1.0, 2.0, 0.0, -1.0, 0.5, 1.0, 0.0, -0.5, 0.0, 0.0, 3.0, 0.0, 1e-17, 0.0, 0.0, 1e-17];
        let e = [2.0, 1.0, 6.0, 0.0];
        let found = IndependentRows::new(&rows, &e);
        assert_eq!((found.right_side.len(), found.kernel.len()), (2, 2));
        // Every solution of the given rows is one of the combinations.
        let x = [2.0, 0.0, 2.0, 0.0];
        for (row, e) in found.rows.chunks_exact(4).zip(&found.right_side) {
            assert!((dot(row, &x) - e).abs() < 1e-15 && (norm(row) - 1.0).abs() < 1e-15);
        }
        for t in &found.kernel {
            let sum = |j: usize| (0..4).map(|k| t[k] * rows[4 * k + j]).sum::<f64>();
            assert!((0..4).all(|j| sum(j).abs() < 1e-15));
        }
        // Multipliers give the same gradient.
        let all = found.expanded(&[3.0, -1.0]);
        for j in 0..4 {
            let given: f64 = (0..4).map(|k| all[k] * rows[4 * k + j]).sum();
            let combined = 3.0 * found.rows[j] - found.rows[4 + j];
            assert!((given - combined).abs() < 1e-14);
        }
    }

    #[test]
    fn a_beam_on_many_supports_is_held() {
        // Motions: along x, along y, and the rotation about the middle; supports below, from 0 to 2; a load at 1.33.
        let places: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
        let mut rows = vec![0.0; 21];
        rows.extend(places.iter().map(|_| -1.0));
        rows.extend(places.iter().map(|x| -(x - 1.0) / 2.1));
        let e = [0.0, -24.8, -24.8 * 0.33 / 2.1];
        let found = IndependentRows::new(&rows, &e);
        assert_eq!(found.kernel.len(), 1);
        let (_, rest) = crate::nonnegative_least_squares(&found.rows, &found.right_side).unwrap();
        assert!(norm(&rest) < 1e-12, "{rest:?}");
    }
}
