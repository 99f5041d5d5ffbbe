//! Shrinks a large programme for Clarabel, whose factorisation handles one number at a time and is slow on large dense
//! matrices.
//!
//! Some bounds `K` are kept, spread evenly over their order, and the others are dropped. All unknowns `F` outside `K`
//! are free then and are eliminated:
//!
//! ```math
//! S = P_KK − P_KF P_FF⁻¹ P_FK,   t = q_K − P_KF P_FF⁻¹ q_F,   x_F = −P_FF⁻¹ (q_F + P_FK x_K)
//! ```
//!
//! The solution violates dropped bounds between active ones and no others, except near the end of a contact zone. So its
//! active set, with the violated bounds, is a few primal-dual steps from the right one.

use crate::active_set::ActiveSet;
use crate::cholesky::{Factor, eliminate};
use crate::error::QpError;
use crate::interior_point;
use crate::kkt::CheckedMatrix;
use crate::polish::Prepared;
use crate::problem::MatrixView;
use crate::settings::QpSettings;

/// One in this many bounds is kept.
const BOUNDS_PER_KEPT: usize = 8;
/// At least this many bounds are kept, and programmes with fewer unknowns are not shrunk.
const FEWEST: usize = 48;
/// At most this many bounds are kept: Clarabel solves such a dense programme in a hundredth of a second.
const MOST: usize = 160;

/// A sparse programme is shrunk if at most one unknown in this many has a bound. Otherwise the shrunk matrix would have
/// more entries than the sparse one.
const UNKNOWNS_PER_BOUND: usize = 10;

/// What Clarabel finds for the shrunk programme.
pub(crate) struct Guess {
    /// Active set of the whole programme.
    pub(crate) active: ActiveSet,
    /// Interior-point iterations.
    pub(crate) iterations: usize,
}

/// Shrinks a programme and calls Clarabel; `None` if it need not be shrunk, or cannot be because `P_FF` is not positive
/// definite.
///
/// # Errors
/// [`QpError::Library`] when Clarabel rejects the data.
pub(crate) fn guess(problem: &Prepared<'_>, settings: &QpSettings) -> Result<Option<Guess>, QpError> {
    match Reduced::new(problem) {
        Some(reduced) => reduced.guess(problem, settings),
        None => Ok(None),
    }
}

struct Reduced {
    /// Places in `bounded` of the bounds that are kept.
    kept: Vec<usize>,
    /// Unknowns that are eliminated, `F`.
    free: Vec<usize>,
    /// `P_FF⁻¹ P_FK` column by column, then `P_FF⁻¹ q_F`.
    solved: Vec<f64>,
    /// `S`, column by column.
    matrix: Vec<f64>,
    /// `t`.
    linear: Vec<f64>,
    /// Bounds of `K`.
    lower: Vec<f64>,
}

impl Reduced {
    fn new(problem: &Prepared<'_>) -> Option<Self> {
        let qp = &problem.qp;
        let (n, bounds) = (qp.linear.len(), problem.bounds());
        let few_bounds = match qp.matrix {
            MatrixView::Dense { .. } => true,
            MatrixView::SparseUpper { .. } => UNKNOWNS_PER_BOUND * bounds <= n,
        };
        if n <= FEWEST || bounds == 0 || !few_bounds {
            return None;
        }
        let kept = spread(bounds, (bounds / BOUNDS_PER_KEPT).clamp(FEWEST, MOST));
        let size = kept.len();
        let mut place = vec![None; n];
        for (local, &k) in kept.iter().enumerate() {
            place[qp.bounded[k]] = Some(local);
        }
        let free: Vec<usize> = (0..n).filter(|&i| place[i].is_none()).collect();
        let mut row = vec![0; n];
        for (local, &i) in free.iter().enumerate() {
            row[i] = local;
        }

        let mut matrix = vec![0.0; size * size];
        let mut coupling = vec![0.0; size * free.len()];
        qp.matrix.for_each_upper(|i, j, value| match (place[i], place[j]) {
            (Some(a), Some(b)) => {
                matrix[b * size + a] = value;
                matrix[a * size + b] = value;
            }
            (Some(a), None) => coupling[a * free.len() + row[j]] = value,
            (None, Some(b)) => coupling[b * free.len() + row[i]] = value,
            (None, None) => {}
        });
        coupling.extend(free.iter().map(|&i| qp.linear[i]));

        let factor = Factor::of_block(&qp.matrix, &free).ok()?;
        let (solved, product) = eliminate(|rhs| factor.solve(rhs), &coupling, size + 1);
        for b in 0..size {
            for a in 0..=b {
                matrix[b * size + a] -= product[b * (size + 1) + a];
                matrix[a * size + b] = matrix[b * size + a];
            }
        }
        let linear =
            (0..size).map(|a| qp.linear[qp.bounded[kept[a]]] - product[size * (size + 1) + a]).collect();
        let lower = kept.iter().map(|&k| qp.lower[k]).collect();
        Some(Self { kept, free, solved, matrix, linear, lower })
    }

    fn guess(&self, problem: &Prepared<'_>, settings: &QpSettings) -> Result<Option<Guess>, QpError> {
        let n = self.kept.len();
        let bounded: Vec<usize> = (0..n).collect();
        // Without a correct digit of S its diagonal can be negative.
        let Ok(matrix) = CheckedMatrix::new(MatrixView::Dense { n, values: &self.matrix }) else {
            return Ok(None);
        };
        let small = Prepared::new(&matrix, &self.linear, &bounded, &self.lower)?;
        let found = interior_point::solve(&small, settings)?;

        let qp = &problem.qp;
        let mut x = vec![0.0; qp.linear.len()];
        for (local, &k) in self.kept.iter().enumerate() {
            x[qp.bounded[k]] = found.iterate.x[local];
        }
        let weights = found.iterate.x.iter().chain([&1.0]);
        for (column, weight) in self.solved.chunks_exact(self.free.len()).zip(weights) {
            for (&i, value) in self.free.iter().zip(column) {
                x[i] -= weight * value;
            }
        }
        let mut flags: Vec<bool> = qp.bounded.iter().zip(qp.lower).map(|(&i, &lower)| x[i] < lower).collect();
        for (local, &k) in self.kept.iter().enumerate() {
            flags[k] = found.iterate.active.is_active(local);
        }
        Ok(Some(Guess { active: ActiveSet::new(flags), iterations: found.iterations }))
    }
}

/// Chooses at most `most` of the numbers below `count`, evenly spread, with the first and the last.
fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| k * (count - 1) / (most - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::BoundQp;

    #[test]
    fn kept_bounds_are_spread_evenly() {
        assert_eq!(spread(3, 5), [0, 1, 2]);
        assert_eq!(spread(9, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread(8, 5), [0, 1, 3, 5, 7]);
    }

    /// A string of `n` masses, the first and last held by springs, pulled down by 1 each; upper triangle in columns.
    fn string(n: usize) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut starts, mut rows, mut values) = (vec![0], vec![], vec![]);
        for j in 0..n {
            if j > 0 {
                rows.push(j - 1);
                values.push(-1.0);
            }
            rows.push(j);
            values.push(2.0);
            starts.push(rows.len());
        }
        (starts, rows, values)
    }

    #[test]
    fn without_contact_the_eliminated_unknowns_are_those_of_the_whole() {
        let n = 320;
        let (starts, rows, values) = string(n);
        let matrix =
            MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &rows, values: &values };
        // Sag at mass i: −(i + 1)(n − i)/2.
        let sag = |i: usize| -((i + 1) as f64) * (n - i) as f64 / 2.0;
        for (bounded, allowed, wanted) in [([40, 200], 1.01, [false; 2]), ([40, 200], 0.5, [true; 2])] {
            let lower = bounded.map(|i| allowed * sag(i));
            let qp = BoundQp { matrix, linear: &vec![1.0; n], bounded: &bounded, lower: &lower };
            let found = guess(&Prepared::of(&qp).unwrap(), &QpSettings::default()).unwrap().unwrap();
            assert_eq!(found.active.as_slice(), wanted);
        }
    }

    #[test]
    fn small_programmes_are_left_alone() {
        let matrix = MatrixView::Dense { n: 1, values: &[1.0] };
        let qp = BoundQp { matrix, linear: &[1.0], bounded: &[0], lower: &[0.0] };
        assert!(guess(&Prepared::of(&qp).unwrap(), &QpSettings::default()).unwrap().is_none());
    }
}
