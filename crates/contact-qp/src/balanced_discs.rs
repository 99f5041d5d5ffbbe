//! Numbers in balance, some pairs of which may be in discs: in the axes of each disc a question with bounds, see [`crate::discs`].

use crate::balance::{BalanceRows, Balanced, WithRest, check};
use crate::dense::norm;
use crate::disc::{Disc, Frame, check_discs, rotated_rows, within};
use crate::error::QpError;
use crate::interior_point;
use crate::problem::check_values;
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

/// Finds `min Σ w_i (p_i − t_i)²` subject to `l ≤ p ≤ u`, `C p = e`; `None` if no `p` within the bounds is in balance. With
/// discs also if no step ends in all of them.
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
    if discs.is_empty() {
        return BalanceRows::new(rows.clone(), right_side.to_vec()).nearest(target, weights, bounds);
    }
    check_values("target", target.len(), target)?;
    check_values("weights", target.len(), weights)?;
    check(target.len(), bounds, rows, right_side)?;
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
            frame.bound(&mut lower, &mut upper);
            let [i, j] = frame.unknowns;
            own[j] = weights[i] + frame.curvature;
            near[j] *= weights[i] / own[j];
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
    if discs.is_empty() {
        return BalanceRows::new(rows.clone(), right_side.to_vec()).unbalanced(bounds);
    }
    check(rows.columns(), bounds, rows, right_side)?;
    let (n, m) = (rows.columns(), rows.len());
    let defect = |x: &[f64]| -> Vec<f64> {
        rows.times(x).iter().zip(right_side).map(|(product, e)| e - product).collect()
    };
    if let Some(found) = nearest_balanced(&vec![0.0; n], &vec![1.0; n], bounds, discs, rows, right_side)? {
        let left = defect(&found.values);
        return Ok((found.values, left));
    }
    let all = WithRest::new(rows, bounds);
    let qp = all.programme(right_side);
    let settings = QpSettings::default().with_tolerance(TOLERANCE);
    let point = interior_point::solve_boxed(&qp, discs, &settings)?;
    let mut x = point.x[..n].to_vec();
    for (i, x) in x.iter_mut().enumerate() {
        *x = x.clamp(qp.lower[i], qp.upper[i]);
    }
    let left = defect(&x);
    let is_balanced = norm(&left) <= BALANCED * norm(right_side);
    Ok((x, if is_balanced { vec![0.0; m] } else { left }))
}
