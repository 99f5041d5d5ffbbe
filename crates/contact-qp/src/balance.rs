//! Numbers within bounds and in balance that are nearest to given ones, and the part of a load that no numbers within bounds balance.
//!
//! Both are found by a semi-smooth Newton method on the multipliers of the rows, whose matrix `G_F W⁻¹ G_Fᵀ + ρ I` is sparse: rows of motions
//! meet only the forces on their own bodies.

use crate::bound_state::BoundState;
use crate::box_qp::{solve_box, solve_on_sets};
use crate::dense::{dot, norm};
use crate::error::QpError;
use crate::problem::{MatrixView, check_length, check_values};
use crate::programme::BoxQp;
use crate::settings::QpSettings;
use crate::sparse::{Normal, SparseRows};

/// The rows are in balance if they hold to this fraction of the largest terms.
const BALANCED: f64 = 1e-13;

/// A load of which more than this fraction is left is out of balance.
const FAR: f64 = 1e-9;

/// A load of which less than this fraction is left may be in balance.
const NEARLY_BALANCED: f64 = 1e-6;

/// Maximum number of Newton steps with one centre.
const MOST_STEPS: usize = 200;

/// Maximum number of centres.
const MOST_CENTRES: usize = 60;

/// A centre after which less than this fraction of the defect is gone is the last one.
const GAIN: f64 = 0.9;

/// The multipliers of [`crate::nearest_balanced`] are drawn to their centre by this fraction of the mean diagonal of the matrix: rows that depend on each other
/// need it.
const DRAWN: f64 = 1e-13;

/// The unknowns of [`crate::unbalanced_load`] are drawn to their centre by these fractions of the mean diagonal of the matrix, from first to last.
const SOFT: [f64; 2] = [1e-6, 1e-14];

/// A step is long enough if its slope has changed from the first one by at least this fraction, and not too long if it rises by at most the other one.
const FLAT: [f64; 2] = [0.1, 1e-3];

/// A gradient below the first of these fractions of the load is zero; one below the second is rounding if it is not halved in this many steps: near the
/// edge of the loads that can be balanced, steps are short.
const EXACT: f64 = 1e-16;
const NEARLY: f64 = 1e-8;
const IDLE: usize = 20;

/// A gradient below this fraction of the load that one step did not halve is rounding.
const ROUNDED: f64 = 1e-14;

/// A centre before the last one need not be found better than to this fraction of what is left: the next one begins there.
const INEXACT: f64 = 0.01;

/// The length of a step is found to this fraction of a whole one.
const SHORTEST: f64 = 1e-12;

/// The numbers in balance and within bounds that are nearest to given ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Balanced {
    /// `l ≤ p ≤ u`, with `C p = e`.
    pub values: Vec<f64>,
    /// The multipliers of the rows.
    pub row_multipliers: Vec<f64>,
    /// Newton steps, or active sets tried.
    pub steps: usize,
}

/// Rows of a balance for several questions: the structure of `C W⁻¹ Cᵀ` is found once.
#[derive(Debug)]
pub struct BalanceRows {
    rows: SparseRows,
    right_side: Vec<f64>,
    normal: Normal,
}

impl BalanceRows {
    /// * `rows`: C, m rows with n columns; `right_side`: e, m entries.
    #[must_use]
    pub fn new(rows: SparseRows, right_side: Vec<f64>) -> Self {
        let normal = Normal::new(&rows.transposed());
        Self { rows, right_side, normal }
    }

    /// Returns C.
    #[must_use]
    pub fn rows(&self) -> &SparseRows {
        &self.rows
    }

    /// Returns e.
    #[must_use]
    pub fn right_side(&self) -> &[f64] {
        &self.right_side
    }

    /// See [`crate::nearest_balanced`].
    ///
    /// # Errors
    /// See [`crate::nearest_balanced`].
    pub fn nearest(
        &mut self,
        target: &[f64],
        weights: &[f64],
        bounds: [&[f64]; 2],
    ) -> Result<Option<Balanced>, QpError> {
        let Self { rows, right_side, normal } = self;
        check_values("target", target.len(), target)?;
        check_values("weights", target.len(), weights)?;
        check(target.len(), bounds, rows, right_side)?;
        let mut problem = Projection::new(bounds, rows, right_side, normal);
        if let Some(found) = problem.nearest(target, weights)? {
            return Ok(Some(found));
        }
        if problem.is_out_of_balance()? {
            Ok(None)
        } else {
            on_its_active_set(target, weights, bounds, rows, right_side)
        }
    }

    /// See [`crate::unbalanced_load`].
    ///
    /// # Errors
    /// See [`crate::unbalanced_load`].
    pub fn unbalanced(&mut self, bounds: [&[f64]; 2]) -> Result<(Vec<f64>, Vec<f64>), QpError> {
        let Self { rows, right_side, normal } = self;
        check(rows.columns(), bounds, rows, right_side)?;
        Projection::new(bounds, rows, right_side, normal).least_squares()
    }
}

pub(crate) fn check(
    n: usize,
    [lower, upper]: [&[f64]; 2],
    rows: &SparseRows,
    right_side: &[f64],
) -> Result<(), QpError> {
    check_length("rows", n, rows.columns())?;
    check_length("right_side", rows.len(), right_side.len())?;
    check_values("rows", rows.values().len(), rows.values())?;
    check_values("right_side", rows.len(), right_side)?;
    check_length("lower", n, lower.len())?;
    check_length("upper", n, upper.len())?;
    match (0..n).find(|i| !(lower[*i] <= upper[*i])) {
        Some(place) => Err(QpError::Bounds { place, lower: lower[place], upper: upper[place] }),
        None => Ok(()),
    }
}

/// The data of `min ½ |r|²` subject to `G x + r = e` and bounds of `x`, in `x` and what is left, `r`.
pub(crate) struct WithRest {
    rows: SparseRows,
    lower: Vec<f64>,
    upper: Vec<f64>,
    starts: Vec<usize>,
    places: Vec<usize>,
    ones: Vec<f64>,
    zeros: Vec<f64>,
}

impl WithRest {
    pub(crate) fn new(rows: &SparseRows, [lower, upper]: [&[f64]; 2]) -> Self {
        let (n, m) = (rows.columns(), rows.len());
        let mut lines = SparseRows::new(n + m);
        rows.rows().enumerate().for_each(|(k, row)| lines.push(row.chain([(n + k, 1.0)])));
        Self {
            rows: lines,
            lower: [lower, &vec![f64::NEG_INFINITY; m]].concat(),
            upper: [upper, &vec![f64::INFINITY; m]].concat(),
            starts: (0..=n + m).map(|j| j.saturating_sub(n)).collect(),
            places: (n..n + m).collect(),
            ones: vec![1.0; m],
            zeros: vec![0.0; n + m],
        }
    }

    pub(crate) fn programme<'a>(&'a self, right_side: &'a [f64]) -> BoxQp<'a> {
        let matrix = MatrixView::SparseUpper {
            n: self.zeros.len(),
            column_starts: &self.starts,
            row_indices: &self.places,
            values: &self.ones,
        };
        let Self { rows, lower, upper, zeros, .. } = self;
        BoxQp { matrix, linear: zeros, lower, upper, rows, right_side }
    }
}

/// Solves it as a programme with bounds: if the solution is nearly a vertex, the multipliers grow, and the steps of Newton's method
/// are lost in rounding.
fn on_its_active_set(
    target: &[f64],
    weights: &[f64],
    [lower, upper]: [&[f64]; 2],
    rows: &SparseRows,
    right_side: &[f64],
) -> Result<Option<Balanced>, QpError> {
    let n = target.len();
    let (starts, places): (Vec<usize>, Vec<usize>) = ((0..=n).collect(), (0..n).collect());
    let matrix = MatrixView::SparseUpper { n, column_starts: &starts, row_indices: &places, values: weights };
    let linear: Vec<f64> = target.iter().zip(weights).map(|(t, w)| -w * t).collect();
    let qp = BoxQp { matrix, linear: &linear, lower, upper, rows, right_side };
    let found = solve_box(&qp, None, &QpSettings::default().active_sets_first())?;
    let balanced =
        Balanced { values: found.x, row_multipliers: found.row_multipliers, steps: found.iterations };
    Ok(found.status.is_solved().then_some(balanced))
}

/// `x` and `e − G x`.
pub(crate) type LeastSquares = (Vec<f64>, Vec<f64>);

/// The rows and bounds of both problems.
struct Projection<'a> {
    rows: &'a SparseRows,
    right_side: &'a [f64],
    lower: &'a [f64],
    upper: &'a [f64],
    normal: &'a mut Normal,
    /// Newton steps so far.
    steps: usize,
}

/// `min Σ ½ w (p − t)² + |G p − e|²/2ρ`, but for a shift of `e` by `ρ a₀`: the multipliers minimise
/// `½ Σ w p (2x − p) − a·e + ½ρ |a − a₀|²`.
struct Centre<'a> {
    target: &'a [f64],
    weights: &'a [f64],
    softness: f64,
    multipliers: &'a [f64],
    /// The gradient may be this fraction of the multipliers.
    inexact: f64,
}

impl<'a> Projection<'a> {
    fn new(
        [lower, upper]: [&'a [f64]; 2],
        rows: &'a SparseRows,
        right_side: &'a [f64],
        normal: &'a mut Normal,
    ) -> Self {
        Self { rows, right_side, lower, upper, normal, steps: 0 }
    }

    /// `min(u, max(l, t + W⁻¹ Gᵀ a))`.
    fn values(&self, centre: &Centre<'_>, a: &[f64]) -> Vec<f64> {
        let shift = self.rows.transposed_times(a);
        let value = |i: usize| {
            (centre.target[i] + shift[i] / centre.weights[i]).max(self.lower[i]).min(self.upper[i])
        };
        (0..shift.len()).map(value).collect()
    }

    /// `G p − e`.
    fn defect(&self, p: &[f64]) -> Vec<f64> {
        self.rows.times(p).iter().zip(self.right_side).map(|(product, e)| product - e).collect()
    }

    /// The derivative by the multipliers, `G p − e + ρ (a − a₀)`.
    fn gradient(&self, centre: &Centre<'_>, p: &[f64], a: &[f64]) -> Vec<f64> {
        let drawn = a.iter().zip(centre.multipliers).map(|(a, from)| centre.softness * (a - from));
        self.defect(p).iter().zip(drawn).map(|(defect, drawn)| defect + drawn).collect()
    }

    /// Computes the sizes of the terms of each row.
    fn sizes(&self, p: &[f64]) -> Vec<f64> {
        let terms = self.rows.rows().map(|row| row.map(|(j, g)| (g * p[j]).abs()).sum::<f64>());
        terms.zip(self.right_side).map(|(size, e)| size + e.abs()).collect()
    }

    /// Tells whether no `p` within the bounds is in balance, by far.
    fn is_out_of_balance(&mut self) -> Result<bool, QpError> {
        let (_, left) = self.least_squares()?;
        Ok(norm(&left) > FAR * norm(self.right_side))
    }

    /// The nearest values in balance, with the centre of the multipliers at the answer before; `None` if that does not converge.
    fn nearest(&mut self, target: &[f64], weights: &[f64]) -> Result<Option<Balanced>, QpError> {
        let inverse: Vec<f64> = weights.iter().map(|w| 1.0 / w).collect();
        let softness = DRAWN * self.normal.mean_diagonal(&inverse).max(f64::MIN_POSITIVE);
        let mut a = vec![0.0; self.rows.len()];
        let mut best = None::<(f64, Vec<f64>, Vec<f64>)>;
        for _ in 0..MOST_CENTRES {
            let from = a.clone();
            let centre = Centre { target, weights, softness, multipliers: &from, inexact: 0.0 };
            let terms = norm(&self.sizes(&self.values(&centre, &a)));
            let Some(p) = self.newton(&centre, &mut a, terms)? else { break };
            let size = norm(&self.defect(&p));
            if best.as_ref().is_some_and(|(least, ..)| size >= GAIN * least) {
                break;
            }
            best = Some((size, p, a.clone()));
        }
        let Some((_, values, row_multipliers)) = best else { return Ok(None) };
        // Rows with small terms have the rounding of the others.
        let least = self.sizes(&values).into_iter().fold(0.0, f64::max);
        let balanced = self.defect(&values).iter().all(|d| d.abs() <= BALANCED * least);
        Ok(balanced.then_some(Balanced { values, row_multipliers, steps: self.steps }))
    }

    /// The least squares, and what is left: nearly, and then on the set found.
    fn least_squares(&mut self) -> Result<LeastSquares, QpError> {
        let (n, m) = (self.lower.len(), self.rows.len());
        let mut x = self.values_at_rest();
        let mut left: Vec<f64> = self.defect(&x).iter().map(|d| -d).collect();
        let mean = self.normal.mean_diagonal(&vec![1.0; n]).max(f64::MIN_POSITIVE);
        let size = norm(self.right_side);
        let (mut softness, origin) = (SOFT[0], vec![0.0; m]);
        // From what would balance the loads without bounds: from no forces, a load is handed on by one body in each step.
        let mut a = left.clone();
        self.normal.factorise(&vec![1.0 / (softness * mean); n], 1.0, 0.0)?.solve(&mut a);
        for _ in 0..MOST_CENTRES {
            let is_last = 0.1 * softness < SOFT[1];
            let (target, weights) = (x.clone(), vec![softness * mean; n]);
            let inexact = if is_last { 0.0 } else { INEXACT };
            let centre =
                Centre { target: &target, weights: &weights, softness: 1.0, multipliers: &origin, inexact };
            let Some(values) = self.newton(&centre, &mut a, 0.0)? else { break };
            let now: Vec<f64> = self.defect(&values).iter().map(|d| -d).collect();
            let gains = norm(&now) < GAIN * norm(&left);
            // If only rounding is left, it grows: the softness divides it.
            if norm(&now) < norm(&left) {
                (left, x) = (now, values);
            }
            if norm(&left) <= BALANCED * size {
                return Ok((x, left));
            }
            if is_last && !gains {
                break;
            }
            a.clone_from(&left);
            softness = if is_last { softness } else { 0.1 * softness };
        }
        if norm(&left) <= NEARLY_BALANCED * size
            && let Some(balanced) = self.balanced_near(&x, norm(&left))?
        {
            return Ok(balanced);
        }
        // A set that nearly leaves directions without a row is not solved better.
        let better = |(_, exact): &LeastSquares| norm(exact) <= (1.0 + FAR) * norm(&left);
        Ok(self.on_set(&x)?.filter(better).unwrap_or((x, left)))
    }

    /// Balances a load of which little is left by the nearest values that do; `None` if they leave no less.
    fn balanced_near(&mut self, x: &[f64], left: f64) -> Result<Option<LeastSquares>, QpError> {
        let ones = vec![1.0; x.len()];
        let bounds = [self.lower, self.upper];
        let found = match self.nearest(x, &ones)? {
            Some(found) => Some(found),
            None => on_its_active_set(x, &ones, bounds, self.rows, self.right_side)?,
        };
        let found = found.map(|found| {
            let left = self.defect(&found.values).iter().map(|d| -d).collect();
            (found.values, left)
        });
        Ok(found.filter(|(_, now): &LeastSquares| norm(now) < left))
    }

    /// The least squares as a programme in `x` and what is left, from the set of given values; `None` if its sets come back.
    fn on_set(&self, x: &[f64]) -> Result<Option<LeastSquares>, QpError> {
        let all = WithRest::new(self.rows, [self.lower, self.upper]);
        let qp = all.programme(self.right_side);
        let (lower, upper) = (qp.lower, qp.upper);
        let place = |i: usize| match x.get(i) {
            Some(x) if *x <= lower[i] => BoundState::Lower,
            Some(x) if *x >= upper[i] => BoundState::Upper,
            _ => BoundState::Free,
        };
        let start: Vec<BoundState> = (0..lower.len()).map(place).collect();
        Ok(solve_on_sets(&qp, start)?.map(|mut x| {
            let left = x.split_off(self.lower.len());
            (x, left)
        }))
    }

    /// The admissible numbers nearest to zero.
    fn values_at_rest(&self) -> Vec<f64> {
        self.lower.iter().zip(self.upper).map(|(l, u)| 0f64.max(*l).min(*u)).collect()
    }

    /// Minimises over the multipliers, from given ones; returns the values, `None` without convergence.
    ///
    /// * `terms`: the size of the terms of the rows; a gradient is measured against it.
    fn newton(
        &mut self,
        centre: &Centre<'_>,
        a: &mut Vec<f64>,
        terms: f64,
    ) -> Result<Option<Vec<f64>>, QpError> {
        let mut p = self.values(centre, a);
        let mut gradient = self.gradient(centre, &p, a);
        let scale = norm(self.right_side).max(norm(&gradient)).max(terms);
        let (mut best, mut idle) = (f64::INFINITY, 0);
        for _ in 0..MOST_STEPS {
            let between = |i: usize| p[i] > self.lower[i] && p[i] < self.upper[i];
            let weight = |i: usize| if between(i) { 1.0 / centre.weights[i] } else { 0.0 };
            let weights: Vec<f64> = (0..p.len()).map(weight).collect();
            let size = norm(&gradient);
            // Values at their bounds but for rounding may change states for ever.
            idle = if size < 0.5 * best { 0 } else { idle + 1 };
            best = best.min(size);
            let is_rounding = idle >= 1 && size <= ROUNDED * scale || idle >= IDLE && size <= NEARLY * scale;
            if size <= EXACT * scale || size <= centre.inexact * norm(a) || is_rounding {
                return Ok(Some(p));
            }
            self.steps += 1;
            let factor = self.normal.factorise(&weights, centre.softness, 0.0)?;
            let mut step = gradient.clone();
            factor.solve(&mut step);
            let slope = |gradient: &[f64]| -dot(gradient, &step);
            let first = slope(&gradient);
            let trial =
                |length: f64| -> Vec<f64> { a.iter().zip(&step).map(|(a, s)| a - length * s).collect() };
            let (mut range, mut length) = ([0.0, 1.0], 1.0);
            let (next, values, at) = loop {
                let next = trial(length);
                let values = self.values(centre, &next);
                let at = self.gradient(centre, &values, &next);
                let there = slope(&at);
                let [least, most] = [(1.0 - FLAT[0]) * first, -FLAT[1] * first];
                if there <= most && (length == 1.0 || there >= least) || range[1] - range[0] < SHORTEST {
                    break (next, values, at);
                }
                range[usize::from(there > 0.0)] = length;
                length = 0.5 * (range[0] + range[1]);
            };
            if !at.iter().all(|g| g.is_finite()) {
                return Ok(None);
            }
            if values == p && next == *a {
                return Ok(Some(p));
            }
            (*a, p, gradient) = (next, values, at);
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::random;
    use crate::unbalanced_load;

    /// The forces below and above each block of a pile are in balance with its load.
    #[test]
    fn a_load_goes_down_a_pile_in_few_steps() {
        for (blocks, held) in [(100, true), (100, false), (1000, true), (1000, false)] {
            let mut rows = SparseRows::new(blocks);
            (0..blocks).for_each(|k| {
                rows.push(std::iter::once((k, 1.0)).chain((k + 1 < blocks).then_some((k + 1, -1.0))));
            });
            // Nothing pulls the block on top back if its load is upwards.
            let load = if held { 1.0 } else { -1.0 };
            let loads: Vec<f64> = (0..blocks).map(|k| if k + 1 == blocks { load } else { 0.0 }).collect();
            let (lower, upper) = (vec![0.0; blocks], vec![f64::INFINITY; blocks]);
            let mut normal = Normal::new(&rows.transposed());
            let mut problem = Projection::new([&lower, &upper], &rows, &loads, &mut normal);
            let (forces, left) = problem.least_squares().unwrap();
            let wanted = if held { 1.0 } else { 0.0 };
            assert!(forces.iter().all(|p| (p - wanted).abs() < 1e-9), "{blocks}");
            assert!(left.iter().zip(&loads).all(|(l, e)| (l - (1.0 - wanted) * e).abs() < 1e-9));
            assert!(problem.steps < 40, "{} steps for {blocks} blocks", problem.steps);
        }
    }

    /// Draws forces on a pile of flat bodies, few of which are not zero: their loads lie on the edge of those that can be balanced.
    ///
    /// * `tilt`: of the normals of a face, at most; `pressed`: forces on each face that are not zero.
    fn edge_of_balance(
        random: &mut impl FnMut() -> f64,
        tilt: f64,
        pressed: usize,
    ) -> (SparseRows, Vec<f64>) {
        let (bodies, points) =
            (3 + (3.0 * (random() + 0.5)) as usize, 12 + (16.0 * (random() + 0.5)) as usize);
        let mut lines = vec![Vec::new(); 6 * bodies];
        for j in 0..bodies * points {
            let [x, y] = [2.0 * random(), 2.0 * random()];
            let [a, b] = [tilt * x, tilt * y];
            let wrench = [a, b, 1.0, y - b, a - x, x * b - y * a + 0.3 * tilt * x * y];
            let below = j / points;
            wrench.iter().enumerate().for_each(|(i, w)| {
                lines[6 * below + i].push((j, *w));
                if below > 0 {
                    lines[6 * (below - 1) + i].push((j, -w));
                }
            });
        }
        let mut rows = SparseRows::new(bodies * points);
        lines.into_iter().for_each(|line| rows.push(line));
        let forces: Vec<f64> =
            (0..bodies * points).map(|j| if j % points < pressed { 0.5 + random() } else { 0.0 }).collect();
        let loads = rows.times(&forces);
        (rows, loads)
    }

    #[test]
    fn loads_on_the_edge_of_what_can_be_balanced_are_balanced() {
        let mut random = random(11);
        for (tilt, pressed) in [(0.1, 1), (0.1, 2), (0.5, 1), (0.5, 2), (1.0, 1), (1.0, 2)] {
            for k in 0..200 {
                let (rows, loads) = edge_of_balance(&mut random, tilt, pressed);
                let (lower, upper) = (vec![0.0; rows.columns()], vec![f64::INFINITY; rows.columns()]);
                let (_, left) = unbalanced_load(&rows, &loads, [&lower, &upper], &[]).unwrap();
                let rest = norm(&left) / norm(&loads);
                assert!(rest < 1e-12, "{rest:e} of load {k} with tilt {tilt} and {pressed} forces");
            }
        }
    }

    /// A block on a row of points, or a box on a square of them, with a load on one point, and `beyond` of its width outside of the edge.
    fn beside_the_edge(cells: usize, solid: bool, beyond: f64) -> (SparseRows, Vec<f64>, f64) {
        let at = |k: usize| k as f64 / cells as f64 - 0.5;
        let points: Vec<[f64; 2]> = if solid {
            (0..(cells + 1) * (cells + 1)).map(|k| [at(k % (cells + 1)), at(k / (cells + 1))]).collect()
        } else {
            (0..=cells).map(|k| [at(k), 0.0]).collect()
        };
        let mut rows = SparseRows::new(points.len());
        rows.push((0..points.len()).map(|i| (i, 1.0)));
        rows.push((0..points.len()).map(|i| (i, points[i][0])));
        rows.push((0..points.len()).map(|i| (i, points[i][1])));
        let arm = 0.5 + beyond;
        (rows, vec![1.0, arm, 0.0], beyond / 1.25f64.sqrt())
    }

    #[test]
    fn what_is_left_beside_the_edge_of_what_can_be_balanced_is_right_to_its_digits() {
        for solid in [false, true] {
            for cells in [2, 4, 8] {
                for k in 0..=24 {
                    let beyond = 1e-12 * 10f64.powf(0.5 * f64::from(k));
                    let (rows, loads, wanted) = beside_the_edge(cells, solid, beyond);
                    let (lower, upper) = (vec![0.0; rows.columns()], vec![f64::INFINITY; rows.columns()]);
                    let (_, left) = unbalanced_load(&rows, &loads, [&lower, &upper], &[]).unwrap();
                    // The loads have the rounding of numbers of size 1.
                    let wrong = (norm(&left) - wanted).abs();
                    assert!(wrong <= 1e-15, "{wrong:e} {solid} {cells} {beyond:e}");
                }
            }
        }
    }
}
