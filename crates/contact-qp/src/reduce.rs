//! Shrinks a large programme for Clarabel, whose factorisation handles one number at a time and is slow on large dense
//! matrices.
//!
//! Some bounded unknowns `K` are kept, spread evenly over their order, and the bounds of the others are dropped. All unknowns `F` outside
//! `K` are free then and are eliminated:
//!
//! ```math
//! S = P_KK − P_KF P_FF⁻¹ P_FK,   t = q_K − P_KF P_FF⁻¹ q_F,   x_F = −P_FF⁻¹ (q_F + P_FK x_K)
//! ```
//!
//! The solution violates dropped bounds between active ones and no others, except near the end of a contact zone. So its
//! active set, with the violated bounds, is a few primal-dual steps from the right one.

use crate::bound_state::BoundState;
use crate::cholesky::{Factor, products};
use crate::error::QpError;
use crate::interior_point;
use crate::problem::MatrixView;
use crate::programme::BoxQp;
use crate::settings::QpSettings;
use crate::sparse::SparseRows;

/// One in this many bounded unknowns is kept.
const BOUNDS_PER_KEPT: usize = 8;
/// At least this many are kept, and programmes with fewer unknowns are not shrunk.
const FEWEST: usize = 48;
/// At most this many are kept: Clarabel solves such a dense programme in a hundredth of a second.
const MOST: usize = 160;

/// Shrinks a programme, calls Clarabel, and returns the set of the whole programme and the iterations; `None` if it need not be shrunk, or
/// cannot be: its matrix is sparse, it has rows, or `P_FF` is not positive definite.
///
/// # Errors
/// [`QpError::Library`] when Clarabel rejects the data.
pub(crate) fn guess(
    qp: &BoxQp<'_>,
    settings: &QpSettings,
) -> Result<Option<(Vec<BoundState>, usize)>, QpError> {
    let MatrixView::Dense { n, values } = qp.matrix else { return Ok(None) };
    let is_bounded = |i: &usize| qp.lower[*i].is_finite() || qp.upper[*i].is_finite();
    let bounded: Vec<usize> = (0..n).filter(is_bounded).collect();
    if n <= FEWEST || bounded.is_empty() || !qp.rows.is_empty() {
        return Ok(None);
    }
    let kept = spread(&bounded, (bounded.len() / BOUNDS_PER_KEPT).clamp(FEWEST, MOST));
    let rest: Vec<usize> = (0..n).filter(|i| kept.binary_search(i).is_err()).collect();
    let Ok(factor) = Factor::of_block(n, values, &rest) else { return Ok(None) };
    let mut coupling: Vec<f64> =
        kept.iter().flat_map(|k| rest.iter().map(move |i| values[k * n + i])).collect();
    coupling.extend(rest.iter().map(|i| qp.linear[*i]));
    let size = kept.len();
    let mut solved = coupling.clone();
    factor.solve(&mut solved);
    let product = products(&coupling, &solved, size + 1);
    let mut matrix = vec![0.0; size * size];
    for b in 0..size {
        for a in 0..=b {
            matrix[b * size + a] = values[kept[b] * n + kept[a]] - product[b * (size + 1) + a];
            matrix[a * size + b] = matrix[b * size + a];
        }
    }
    let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
    let mut linear = of_kept(qp.linear);
    linear.iter_mut().zip(&product[size * (size + 1)..]).for_each(|(t, part)| *t -= part);
    let small = BoxQp {
        matrix: MatrixView::Dense { n: size, values: &matrix },
        linear: &linear,
        lower: &of_kept(qp.lower),
        upper: &of_kept(qp.upper),
        rows: &SparseRows::new(size),
        right_side: &[],
    };
    let found = interior_point::solve_boxed(&small, &[], settings)?;

    let mut states = vec![BoundState::Free; n];
    kept.iter().zip(&found.states).for_each(|(k, place)| states[*k] = *place);
    let mut x = vec![0.0; rest.len()];
    for (column, weight) in solved.chunks_exact(rest.len().max(1)).zip(found.x.iter().chain([&1.0])) {
        x.iter_mut().zip(column).for_each(|(x, value)| *x -= weight * value);
    }
    for (&i, x) in rest.iter().zip(x) {
        states[i] = match x {
            x if x < qp.lower[i] => BoundState::Lower,
            x if x > qp.upper[i] => BoundState::Upper,
            _ => BoundState::Free,
        };
    }
    Ok(Some((states, found.iterations)))
}

/// Chooses at most `most` of some numbers, evenly spread, with the first and the last.
fn spread(all: &[usize], most: usize) -> Vec<usize> {
    if all.len() <= most {
        return all.to_vec();
    }
    (0..most).map(|k| all[k * (all.len() - 1) / (most - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_bounds_are_spread_evenly() {
        let numbers = |count: usize| (0..count).collect::<Vec<usize>>();
        assert_eq!(spread(&numbers(3), 5), [0, 1, 2]);
        assert_eq!(spread(&numbers(9), 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread(&numbers(8), 5), [0, 1, 3, 5, 7]);
    }

    #[test]
    fn few_bounds_determine_the_set_of_all() {
        // A string of masses, the first and last held by springs, pulled down by 1 each. Sag at mass i: −(i + 1)(n − i)/2.
        let n = 320;
        let mut values = vec![0.0; n * n];
        for i in 0..n {
            values[i * (n + 1)] = 2.0;
            if i > 0 {
                (values[i * n + i - 1], values[(i - 1) * n + i]) = (-1.0, -1.0);
            }
        }
        let matrix = MatrixView::Dense { n, values: &values };
        let sag = |i: usize| -((i + 1) as f64) * (n - i) as f64 / 2.0;
        let (rows, upper) = (SparseRows::new(n), vec![f64::INFINITY; n]);
        for (allowed, wanted) in [(1.01, BoundState::Free), (0.5, BoundState::Lower)] {
            let mut lower = vec![f64::NEG_INFINITY; n];
            [40, 200].into_iter().for_each(|i| lower[i] = allowed * sag(i));
            let linear = vec![1.0; n];
            let qp =
                BoxQp { matrix, linear: &linear, lower: &lower, upper: &upper, rows: &rows, right_side: &[] };
            let (states, iterations) = guess(&qp, &QpSettings::default()).unwrap().unwrap();
            assert!(iterations > 0);
            for (i, place) in states.into_iter().enumerate() {
                assert_eq!(place, if [40, 200].contains(&i) { wanted } else { BoundState::Free }, "{i}");
            }
        }
    }

    #[test]
    fn small_programmes_and_those_with_rows_are_left_alone() {
        let (n, values) = (60, [vec![1.0], vec![0.0; 60]].concat().repeat(60)[..3600].to_vec());
        let matrix = MatrixView::Dense { n, values: &values };
        let (zero, upper, none) = (vec![0.0; n], vec![1.0; n], SparseRows::new(n));
        let row = SparseRows::from_dense(n, &vec![1.0; n]);
        let guessed = |qp: &BoxQp<'_>| guess(qp, &QpSettings::default()).unwrap().is_some();
        let whole =
            BoxQp { matrix, linear: &zero, lower: &zero, upper: &upper, rows: &none, right_side: &[] };
        assert!(guessed(&whole));
        assert!(!guessed(&BoxQp { rows: &row, right_side: &[1.0], ..whole }));
        let (one, small) = (SparseRows::new(1), MatrixView::Dense { n: 1, values: &[1.0] });
        assert!(!guessed(&BoxQp {
            matrix: small,
            linear: &[0.0],
            lower: &[0.0],
            upper: &[1.0],
            rows: &one,
            right_side: &[]
        }));
    }
}
