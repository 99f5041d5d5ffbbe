//! Least squares within bounds.

use crate::dense::{dot, least_squares, norm};
use crate::error::QpError;
use crate::problem::{check_length, check_values};

/// A gradient below this fraction of its terms is zero.
const ROUND_OFF: f64 = 1e-13;

/// Solves `min |G x − e|` subject to `x ≥ 0` by an active set (Lawson and Hanson 1974, chapter 23), and returns
/// `x` and `e − G x`.
///
/// The residual is the projection of `e` on the cone of all `a` with `Gᵀ a ≤ 0`: zero if and only if some `x ≥ 0` has
/// `G x = e`; otherwise `e·a > 0` (Farkas).
///
/// * `rows`: G, row after row, m·n entries; `right_side`: e, m entries, few.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`].
pub fn nonnegative_least_squares(rows: &[f64], right_side: &[f64]) -> Result<(Vec<f64>, Vec<f64>), QpError> {
    let n = rows.len().checked_div(right_side.len()).unwrap_or(0);
    bounded_least_squares(rows, right_side, [&vec![0.0; n], &vec![f64::INFINITY; n]])
}

/// Solves `min |G x − e|` subject to `l ≤ x ≤ u` by the active set of [`nonnegative_least_squares`], and returns `x` and `e − G x`.
///
/// The residual is zero if and only if some `x` within the bounds has `G x = e`; otherwise no such `x` reduces the load `e` along it:
/// `(e − G x)·(e − G z) ≥ |e − G x|²` for every admissible `z`.
///
/// * `bounds`: l, finite, and u, which may be infinite, n entries each.
///
/// # Errors
/// [`QpError::Length`], [`QpError::NotFinite`], [`QpError::Bounds`].
pub fn bounded_least_squares(
    rows: &[f64],
    right_side: &[f64],
    [lower, upper]: [&[f64]; 2],
) -> Result<(Vec<f64>, Vec<f64>), QpError> {
    let m = right_side.len();
    let n = rows.len().checked_div(m).unwrap_or(0);
    check_values("rows", n * m, rows)?;
    check_values("right_side", m, right_side)?;
    check_values("lower", n, lower)?;
    check_length("upper", n, upper.len())?;
    if let Some(place) = (0..n).find(|j| !(lower[*j] <= upper[*j])) {
        return Err(QpError::Bounds { place, lower: lower[place], upper: upper[place] });
    }
    let mut problem = LeastSquares::new(rows, right_side, [lower, upper]);
    problem.solve();
    Ok(problem.solution(lower, upper))
}

/// Bounded least squares, `0 ≤ x ≤ room`: each unknown is counted from the admissible number nearest to zero, by one column upwards and by
/// one downwards. Counted from far bounds the loads would be lost in rounding.
struct LeastSquares {
    /// The unknown of each column, and its sign.
    unknowns: Vec<(usize, f64)>,
    /// The number that each unknown is counted from.
    from: Vec<f64>,
    /// Columns of length one: their lengths are positive, so that signs do not change. Turned if counted from the upper bound.
    columns: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    /// What is left of `e` with all unknowns where they are counted from, and the size of its terms.
    target: Vec<f64>,
    size: f64,
    room: Vec<f64>,
    turned: Vec<bool>,
    x: Vec<f64>,
    residual: Vec<f64>,
}

impl LeastSquares {
    fn new(rows: &[f64], right_side: &[f64], [lower, upper]: [&[f64]; 2]) -> Self {
        let (m, n) = (right_side.len(), lower.len());
        let of_unknown: Vec<Vec<f64>> = (0..n).map(|j| (0..m).map(|k| rows[k * n + j]).collect()).collect();
        let from: Vec<f64> = lower.iter().zip(upper).map(|(l, u)| 0f64.max(*l).min(*u)).collect();
        let mut target = right_side.to_vec();
        let mut size = norm(right_side);
        for (column, from) in of_unknown.iter().zip(&from).filter(|(_, from)| **from != 0.0) {
            target.iter_mut().zip(column).for_each(|(t, g)| *t -= from * g);
            size = size.max(from.abs() * norm(column));
        }
        let has_room = |&(j, sign): &(usize, f64)| {
            if sign > 0.0 { upper[j] > from[j] } else { lower[j] < from[j] }
        };
        let unknowns: Vec<(usize, f64)> =
            (0..n).flat_map(|j| [(j, 1.0), (j, -1.0)]).filter(has_room).collect();
        let lengths: Vec<f64> = unknowns.iter().map(|(j, _)| norm(&of_unknown[*j])).collect();
        let unit = |(&(j, sign), length): (&(usize, f64), &f64)| {
            of_unknown[j].iter().map(|g| sign * g / length.max(f64::MIN_POSITIVE)).collect()
        };
        let room = |(&(j, sign), length): (&(usize, f64), &f64)| {
            length * if sign > 0.0 { upper[j] - from[j] } else { from[j] - lower[j] }
        };
        Self {
            columns: unknowns.iter().zip(&lengths).map(unit).collect(),
            room: unknowns.iter().zip(&lengths).map(room).collect(),
            residual: target.clone(),
            target,
            size,
            turned: vec![false; unknowns.len()],
            x: vec![0.0; unknowns.len()],
            unknowns,
            from,
            lengths,
        }
    }

    fn solve(&mut self) {
        let (n, m) = (self.x.len(), self.target.len());
        let mut passive: Vec<usize> = Vec::new();
        // Columns that depend on the passive ones, to rounding.
        let mut dependent: Vec<usize> = Vec::new();
        // Every step lowers the residual; the limit is only for round-off.
        for _ in 0..3 * n.max(m) + 10 {
            let gradient = |j: usize| dot(&self.columns[j], &self.residual);
            // An unknown that is not where it is counted from moves by one of its two columns only.
            let moved = |j: usize| self.turned[j] || passive.contains(&j);
            let taken = |j: &usize| {
                passive.contains(j) || dependent.contains(j) || self.mirror(*j).is_some_and(moved)
            };
            let open = (0..n).filter(|j| self.lengths[*j] > 0.0 && self.room[*j] > 0.0 && !taken(j));
            let Some(best) = open.max_by(|i, j| gradient(*i).total_cmp(&gradient(*j))) else { break };
            // As many columns as rows leave nothing but round-off.
            if gradient(best) <= ROUND_OFF * self.size || passive.len() >= m {
                break;
            }
            passive.push(best);
            let settled = self.settle(&mut passive, best);
            self.residual.clone_from(&self.target);
            for &j in &passive {
                let x = self.x[j];
                self.residual.iter_mut().zip(&self.columns[j]).for_each(|(r, g)| *r -= x * g);
            }
            if settled {
                dependent.clear();
            } else {
                dependent.push(best);
            }
        }
    }

    /// Moves the passive unknowns to the least squares on them; those that meet a bound on the way stay there. Returns false if the
    /// newest depends on the others.
    fn settle(&mut self, passive: &mut Vec<usize>, newest: usize) -> bool {
        loop {
            let used: Vec<&[f64]> = passive.iter().map(|j| self.columns[*j].as_slice()).collect();
            let trial = least_squares(&used, &self.target);
            let no_better = passive.last() == Some(&newest) && trial.last().is_some_and(|t| *t <= 0.0);
            if no_better && self.x[newest] == 0.0 {
                // By round-off: the column depends on the others.
                passive.pop();
                return false;
            }
            let ratio = |(j, t): (&usize, &f64)| {
                let (x, room) = (self.x[*j], self.room[*j]);
                // 0/0 if it is at its bound already: then the step has no length, and takes it out.
                match *t {
                    t if t <= 0.0 => Some((x / (x - t)).max(0.0)),
                    t if t >= room => Some(((room - x) / (t - x)).max(0.0)),
                    _ => None,
                }
            };
            let Some(step) = passive.iter().zip(&trial).filter_map(ratio).reduce(f64::min) else {
                self.x.fill(0.0);
                passive.iter().zip(&trial).for_each(|(j, t)| self.x[*j] = *t);
                return true;
            };
            let full =
                passive.iter().zip(&trial).find(|of| *of.1 >= self.room[*of.0] && ratio(*of) == Some(step));
            let full = full.map(|(j, _)| *j);
            for (j, t) in passive.iter().zip(&trial) {
                self.x[*j] += step * (t - self.x[*j]);
            }
            if let Some(j) = full {
                self.turn(j);
                passive.retain(|k| *k != j);
                continue;
            }
            let least = passive.iter().zip(&trial).filter(|(_, t)| **t <= 0.0).map(|(j, _)| self.x[*j]);
            let least = least.fold(f64::INFINITY, f64::min).max(0.0);
            let gone: Vec<usize> = passive.iter().copied().filter(|j| self.x[*j] <= least).collect();
            gone.iter().for_each(|j| self.x[*j] = 0.0);
            passive.retain(|j| !gone.contains(j));
        }
    }

    /// Returns the other column of the unknown of a column, if it has two.
    fn mirror(&self, j: usize) -> Option<usize> {
        let same = |k: &usize| self.unknowns.get(*k).is_some_and(|of| of.0 == self.unknowns[j].0);
        [j.wrapping_sub(1), j + 1].into_iter().find(same)
    }

    /// Counts an unknown that is at its other bound from there.
    fn turn(&mut self, j: usize) {
        let room = self.room[j];
        self.target.iter_mut().zip(&self.columns[j]).for_each(|(t, g)| *t -= room * g);
        self.columns[j].iter_mut().for_each(|g| *g = -*g);
        (self.turned[j], self.x[j]) = (!self.turned[j], 0.0);
    }

    /// Returns `x` and `e − G x`.
    fn solution(self, lower: &[f64], upper: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut x = self.from;
        for (c, &(j, sign)) in self.unknowns.iter().enumerate() {
            let part = if self.x[c] > 0.0 { self.x[c] / self.lengths[c] } else { 0.0 };
            x[j] = match (self.turned[c], sign > 0.0) {
                (true, true) => upper[j] - part,
                (true, false) => lower[j] + part,
                (false, _) => x[j] + sign * part,
            };
            x[j] = x[j].max(lower[j]).min(upper[j]);
        }
        (x, self.residual)
    }
}
