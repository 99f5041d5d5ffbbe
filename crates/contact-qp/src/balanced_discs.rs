//! Numbers in balance, some pairs of which may be in discs: in the axes of each disc a question with bounds, see [`crate::discs`].

use crate::balance::{BalanceRows, Balanced, LeastSquares, check, with_rest};
use crate::dense::norm;
use crate::disc::{Disc, Frame, check_discs, rotated_rows};
use crate::error::QpError;
use crate::interior_point;
use crate::problem::{MatrixView, check_values};
use crate::programme::BoxQp;
use crate::settings::QpSettings;
use crate::sparse::SparseRows;

/// Steps, at most.
const MOST_STEPS: usize = 60;

/// A pair beyond its circle by this fraction of the radius is on it.
const ROUND_OFF: f64 = 1e-14;

/// A pair is the nearest one of its disc to this fraction of the radius.
const NEAREST: f64 = 1e-10;

/// Clarabel's tolerance, and the fraction of a load that it leaves of one that is balanced.
const TOLERANCE: f64 = 1e-10;
const BALANCED: f64 = 1e-7;

/// Finds `min Σ w_i (p_i − t_i)²` subject to `l ≤ p ≤ u`, `C p = e`; `None` if no `p` within the bounds is in balance.
///
/// The solution is `p = min(u, max(l, x))` with `x = t + W⁻¹ Cᵀ a`; `a` minimises the convex `½ Σ w p (2x − p) − a·e`, by a semi-smooth
/// Newton method with a line search. Rows may depend on each other.
///
/// * `target`: t, n entries; `weights`: w > 0, n entries.
/// * `bounds`: l and u, n entries each; they may be infinite. `discs`: pairs of unknowns that are in discs as well, of equal weights.
/// * `rows`: C, m rows with n columns; `right_side`: e, m entries.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`], [`QpError::Disc`], and data that Clarabel rejects.
pub fn nearest_balanced(
    target: &[f64],
    weights: &[f64],
    bounds: [&[f64]; 2],
    discs: &[Disc],
    rows: &SparseRows,
    right_side: &[f64],
) -> Result<Option<Balanced>, QpError> {
    if !discs.is_empty() {
        check_values("target", target.len(), target)?;
        check_values("weights", target.len(), weights)?;
        check(target.len(), bounds, rows, right_side)?;
        return nearest(target, weights, bounds, discs, rows, right_side);
    }
    BalanceRows::new(rows.clone(), right_side.to_vec()).nearest(target, weights, bounds)
}

/// Solves `min |G x − e|` subject to `l ≤ x ≤ u`, and returns `x` and `e − G x`.
///
/// The residual is zero if and only if some `x` within the bounds has `G x = e`; otherwise no such `x` reduces the load `e` along it:
/// `(e − G x)·(e − G z) ≥ |e − G x|²` for every admissible `z` (Farkas). Each of a few programmes draws `x` to the answer of the one before.
/// A load of which little is left is balanced by the nearest `x` that does; otherwise the set of the last programme is solved exactly.
/// With discs a load of which less than 1e-7 is left counts as balanced.
///
/// * `rows`: G, m rows with n columns; `right_side`: e, m entries; `bounds`: l and u, n entries each; they may be infinite.
/// * `discs`: pairs of unknowns that are in discs as well.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`], [`QpError::Disc`], [`QpError::Library`].
pub fn unbalanced_load(
    rows: &SparseRows,
    right_side: &[f64],
    bounds: [&[f64]; 2],
    discs: &[Disc],
) -> Result<(Vec<f64>, Vec<f64>), QpError> {
    if !discs.is_empty() {
        check(rows.columns(), bounds, rows, right_side)?;
        return unbalanced(rows, right_side, bounds, discs);
    }
    BalanceRows::new(rows.clone(), right_side.to_vec()).unbalanced(bounds)
}

/// See [`nearest_balanced`]; the weights of both unknowns of a disc are those of the first. `None` also if no step ends in all discs.
pub(crate) fn nearest(
    target: &[f64],
    weights: &[f64],
    bounds: [&[f64]; 2],
    discs: &[Disc],
    rows: &SparseRows,
    right_side: &[f64],
) -> Result<Option<Balanced>, QpError> {
    check_discs(discs, target.len())?;
    let frame = |disc: &Disc, d: [f64; 2]| Frame::new(disc, d, 1.0 / weights[disc.unknowns[0]]);
    let mut frames: Vec<Frame> =
        discs.iter().map(|disc| frame(disc, disc.unknowns.map(|i| target[i]))).collect();
    let (mut steps, mut best) = (0, None);
    for _ in 0..MOST_STEPS {
        let (mut near, mut own) = (target.to_vec(), weights.to_vec());
        let [mut lower, mut upper] = bounds.map(<[f64]>::to_vec);
        for frame in &frames {
            frame.enter(&mut near);
            let (i, j) = (frame.along(), frame.across());
            own[j] = weights[i] + frame.curvature;
            near[j] *= weights[i] / own[j];
            let free = if frame.radius > 0.0 { f64::INFINITY } else { 0.0 };
            (lower[i], upper[i]) = (-free, frame.radius);
            (lower[j], upper[j]) = (-free, free);
        }
        let mut lines = BalanceRows::new(rotated_rows(rows, &frames), right_side.to_vec());
        let Some(found) = lines.nearest(&near, &own, [&lower, &upper])? else { return Ok(best) };
        steps += found.steps.max(1);
        let (mut x, a) = (found.values, found.row_multipliers);
        frames.iter().for_each(|frame| frame.leave(&mut x));
        // d = x − y/w = t + W⁻¹ Gᵀ a.
        let pulled = rows.transposed_times(&a);
        let at = |disc: &Disc| disc.unknowns.map(|i| target[i] + pulled[i] / weights[disc.unknowns[0]]);
        let (mut inside, mut nearest) = (true, true);
        for disc in discs {
            let ([i, j], to) = (disc.unknowns, within(at(disc), disc.radius));
            inside &= x[i].hypot(x[j]) <= disc.radius * (1.0 + ROUND_OFF);
            nearest &= (x[i] - to[0]).hypot(x[j] - to[1]) <= NEAREST * disc.radius;
        }
        frames = discs.iter().map(|disc| frame(disc, at(disc))).collect();
        if inside {
            for Disc { unknowns: [i, j], radius } in discs {
                [x[*i], x[*j]] = within([x[*i], x[*j]], *radius);
            }
            best = Some(Balanced { values: x, row_multipliers: a, steps });
            if nearest {
                break;
            }
        }
    }
    Ok(best)
}

/// Returns the point of a disc that is nearest to a given one.
fn within([a, b]: [f64; 2], radius: f64) -> [f64; 2] {
    let length = a.hypot(b);
    if length > radius { [a / length * radius, b / length * radius] } else { [a, b] }
}

/// See [`unbalanced_load`]; loads that are nearly balanced count as balanced.
pub(crate) fn unbalanced(
    rows: &SparseRows,
    right_side: &[f64],
    bounds: [&[f64]; 2],
    discs: &[Disc],
) -> Result<LeastSquares, QpError> {
    let (n, m) = (rows.columns(), rows.len());
    let defect = |x: &[f64]| -> Vec<f64> {
        rows.times(x).iter().zip(right_side).map(|(product, e)| e - product).collect()
    };
    if let Some(found) = nearest(&vec![0.0; n], &vec![1.0; n], bounds, discs, rows, right_side)? {
        let left = defect(&found.values);
        return Ok((found.values, left));
    }
    let (lines, lower, upper) = with_rest(rows, bounds);
    let starts: Vec<usize> = (0..=n + m).map(|j| j.saturating_sub(n)).collect();
    let places: Vec<usize> = (n..n + m).collect();
    let qp = BoxQp {
        matrix: MatrixView::SparseUpper {
            n: n + m,
            column_starts: &starts,
            row_indices: &places,
            values: &vec![1.0; m],
        },
        linear: &vec![0.0; n + m],
        lower: &lower,
        upper: &upper,
        rows: &lines,
        right_side,
    };
    let settings = QpSettings::default().with_tolerance(TOLERANCE);
    let point = interior_point::solve_boxed(&qp, discs, &settings)?;
    let mut x = point.x[..n].to_vec();
    for (i, x) in x.iter_mut().enumerate() {
        *x = x.clamp(lower[i], upper[i]);
    }
    let left = defect(&x);
    let is_balanced = norm(&left) <= BALANCED * norm(right_side);
    Ok((x, if is_balanced { vec![0.0; m] } else { left }))
}
