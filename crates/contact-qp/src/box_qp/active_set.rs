//! Active sets: the solution on one of them, and the one that its signs ask for.

use super::augmented::Augmented;
use super::full::{CONTRADICTION, Full};
use crate::bound_state::BoundState;
use crate::dense::{largest, norm};
use crate::error::QpError;
use crate::least_squares::nonnegative_least_squares;
use crate::problem::MatrixView;
use crate::programme::BoxQp;
use std::collections::HashSet;

/// A sign or a bound is wrong beyond this fraction of the scale of the data.
const WRONG: f64 = 1e-12;

/// A programme with what all active sets share.
pub(super) struct System<'a> {
    qp: &'a BoxQp<'a>,
    algebra: Algebra<'a>,
    /// The lengths of the rows.
    lengths: Vec<f64>,
    /// The sizes of `x` and `y` that the data have.
    size: [f64; 2],
    /// The size of `x` that the rows have. Gaps much larger than what the loads move ask for a much larger one.
    in_rows: f64,
}

/// How the equations of a set are solved.
enum Algebra<'a> {
    /// With a factor of a block of a full matrix.
    Full(Box<Full<'a>>),
    /// With a sparse factor of all equations.
    Sparse(Augmented<'a>),
}

/// The minimiser on one set, whatever the signs.
pub(crate) struct ActiveSetPoint {
    pub(crate) x: Vec<f64>,
    pub(crate) a: Vec<f64>,
    pub(crate) states: Vec<BoundState>,
}

impl<'a> System<'a> {
    /// * `near`: the programme without far bounds.
    pub(super) fn new(qp: &'a BoxQp<'a>, near: &BoxQp<'_>) -> Self {
        let n = qp.linear.len();
        // A row of zeros stays one.
        let length = |length: f64| if length > 0.0 { length } else { 1.0 };
        let lengths: Vec<f64> =
            qp.rows.rows().map(|row| length(row.map(|(_, g)| g * g).sum::<f64>().sqrt())).collect();
        let trace: f64 = (0..n).map(|i| qp.matrix.diagonal(i)).sum();
        let algebra = match qp.matrix {
            MatrixView::Dense { values, .. } => {
                Algebra::Full(Box::new(Full::new(qp, values, trace, &lengths)))
            }
            MatrixView::SparseUpper { .. } => Algebra::Sparse(Augmented::new(qp, trace / n.max(1) as f64)),
        };
        let finite = |v: &f64| if v.is_finite() { *v } else { 0.0 };
        let diagonal = |i: usize| match &algebra {
            Algebra::Full(full) => full.matrix.diagonal(i),
            Algebra::Sparse(_) => qp.matrix.diagonal(i),
        };
        let alone = |i: usize| qp.linear[i] / diagonal(i).max(f64::MIN_POSITIVE);
        let in_rows = largest(qp.right_side.iter().zip(&lengths).map(|(e, length)| e / length));
        // Of a fixed unknown the stiffness may be rounding.
        let x = largest((0..n).filter(|i| qp.lower[*i] < qp.upper[*i]).map(alone))
            .max(in_rows)
            .max(largest(near.lower.iter().chain(near.upper).map(finite)));
        let y = largest(qp.linear.iter().copied());
        Self { qp, algebra, lengths, size: [x, y], in_rows }
    }

    /// Computes `P x + q − Gᵀ a`.
    fn gradient(&self, x: &[f64], a: &[f64]) -> Vec<f64> {
        self.qp.gradient(x, a)
    }

    /// Tries at most `limit` sets, each the one that the signs of the one before ask for: semi-smooth Newton steps for the KKT conditions
    /// (Hintermüller, Ito and Kunisch 2002). They end on M-matrices and, in practice, on operators of elastic bodies, but sets may come back
    /// on other matrices. Returns the solution, if it was found, and the number of sets tried.
    ///
    /// * `from`: a point, see [`Self::candidate`].
    pub(super) fn active_set(
        &self,
        mut states: Vec<BoundState>,
        from: &[f64],
        limit: usize,
    ) -> (Option<ActiveSetPoint>, usize) {
        let mut visited = HashSet::new();
        for step in 1..=limit {
            let Some(candidate) = self.candidate(&states, from) else { return (None, step) };
            let next = self.next(&candidate);
            if next == states {
                return (Some(self.released(candidate, from)), step);
            }
            if !visited.insert(std::mem::replace(&mut states, next)) {
                return (None, step);
            }
        }
        (None, limit)
    }

    /// Puts free unknowns that are at a bound, to round-off, at that bound, if the signs stay right: rows that only they would determine
    /// then have the multipliers of least norm.
    fn released(&self, candidate: ActiveSetPoint, from: &[f64]) -> ActiveSetPoint {
        let states = self.at_bounds(&candidate);
        if states == candidate.states {
            return candidate;
        }
        self.candidate(&states, from).filter(|other| self.next(other) == states).unwrap_or(candidate)
    }

    /// Descends from a point, moved within the bounds and on a set: the unknown that blocks a step stays at its bound, and the one whose multiplier is
    /// most wrong leaves it. Every step lowers the objective, so that no set comes back; the limit is for round-off.
    ///
    /// Returns the solution, if it was found, and the number of steps.
    pub(super) fn descend(
        &self,
        start: &[f64],
        mut states: Vec<BoundState>,
        limit: usize,
    ) -> (Option<ActiveSetPoint>, usize) {
        let (lower, upper) = (self.qp.lower, self.qp.upper);
        let place = |i: usize| match states[i] {
            BoundState::Free => start[i].clamp(lower[i], upper[i]),
            place => self.qp.bound(i, place),
        };
        let mut x: Vec<f64> = (0..start.len()).map(place).collect();
        for step in 1..=limit {
            let Some(candidate) = self.candidate(&states, &x) else { return (None, step) };
            let least = WRONG * largest(candidate.x.iter().copied()).max(self.size[0]);
            let blocks = |i: usize| {
                let (from, to) = (x[i], candidate.x[i]);
                match states[i] {
                    BoundState::Free if to < lower[i] - least => {
                        Some(((from - lower[i]) / (from - to), i, BoundState::Lower))
                    }
                    BoundState::Free if to > upper[i] + least => {
                        Some(((upper[i] - from) / (to - from), i, BoundState::Upper))
                    }
                    _ => None,
                }
            };
            let blocking = (0..x.len()).filter_map(blocks).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((ratio, i, place)) = blocking {
                let ratio = ratio.clamp(0.0, 1.0);
                x.iter_mut().zip(&candidate.x).for_each(|(x, to)| *x += ratio * (to - *x));
                states[i] = place;
                x[i] = self.qp.bound(i, place);
                continue;
            }
            let y = self.gradient(&candidate.x, &candidate.a);
            let slack = WRONG * self.size[1].max(largest(y.iter().copied()));
            let wrong = |i: usize| match states[i] {
                _ if lower[i] == upper[i] => 0.0,
                BoundState::Lower => -y[i],
                BoundState::Upper => y[i],
                BoundState::Free => 0.0,
            };
            let worst = (0..x.len()).max_by(|a, b| wrong(*a).total_cmp(&wrong(*b)));
            match worst.filter(|i| wrong(*i) > slack) {
                None => return (Some(self.released(candidate, &x)), step),
                Some(i) => {
                    states[i] = BoundState::Free;
                    x = candidate.x;
                }
            }
        }
        (None, limit)
    }

    /// Finds a point within the bounds in which the rows hold, few unknowns away from their bounds; `None` if no such point has the given values of the
    /// unknowns that have two bounds.
    ///
    /// * `from`: these values.
    pub(super) fn feasible(&self, from: &[f64]) -> Option<Vec<f64>> {
        let (n, m) = (from.len(), self.lengths.len());
        let (lower, upper) = (self.qp.lower, self.qp.upper);
        // A value to begin with, and the signs of its change.
        let change = |i: usize| match (lower[i].is_finite(), upper[i].is_finite()) {
            (true, true) => (from[i].clamp(lower[i], upper[i]), [].as_slice()),
            (true, false) => (lower[i], [1.0].as_slice()),
            (false, true) => (upper[i], [-1.0].as_slice()),
            (false, false) => (0.0, [-1.0, 1.0].as_slice()),
        };
        let mut x: Vec<f64> = (0..n).map(|i| change(i).0).collect();
        let columns: Vec<(usize, f64)> =
            (0..n).flat_map(|i| change(i).1.iter().map(move |s| (i, *s))).collect();
        let rows = &self.unit_rows();
        let matrix: Vec<f64> =
            (0..m).flat_map(|k| columns.iter().map(move |(i, s)| s * rows[k * n + i])).collect();
        let right_side = self.scaled_defect(&x);
        let (moved, left) = nonnegative_least_squares(&matrix, &right_side).ok()?;
        columns.iter().zip(moved).for_each(|((i, s), y)| x[*i] += s * y);
        (norm(&left) <= CONTRADICTION * norm(&right_side)).then_some(x)
    }

    /// Returns `G` with rows of length one, row after row.
    fn unit_rows(&self) -> Vec<f64> {
        let n = self.qp.linear.len();
        let mut rows = self.qp.rows.dense();
        for (row, length) in rows.chunks_exact_mut(n.max(1)).zip(&self.lengths) {
            row.iter_mut().for_each(|g| *g /= length);
        }
        rows
    }

    /// Checks that the matrix has no negative direction, on which a programme has no solution.
    ///
    /// # Errors
    /// [`QpError::NotPositiveDefinite`].
    pub(super) fn check_semi_definite(&self) -> Result<(), QpError> {
        match &self.algebra {
            Algebra::Full(full) => full.check_semi_definite(),
            Algebra::Sparse(_) => Ok(()),
        }
    }

    /// Tells whether the equations are sparse.
    pub(super) fn is_sparse(&self) -> bool {
        matches!(self.algebra, Algebra::Sparse(_))
    }

    /// Solves on one set; `None` if the rows cannot hold on it. If unknowns between their bounds depend on each other, the solution is
    /// one of many, and some of them keep their values.
    ///
    /// * `from`: a point whose values they keep, within the bounds.
    fn candidate(&self, states: &[BoundState], from: &[f64]) -> Option<ActiveSetPoint> {
        let mut x: Vec<f64> = (0..states.len()).map(|i| self.qp.bound(i, states[i])).collect();
        if x.iter().any(|x| x.is_infinite()) {
            return None;
        }
        let mut a = vec![0.0; self.lengths.len()];
        let free: Vec<usize> = (0..states.len()).filter(|i| states[*i] == BoundState::Free).collect();
        match &self.algebra {
            Algebra::Full(full) => {
                full.solve((&self.lengths, self.in_rows), (free, from), (&mut x, &mut a))?
            }
            Algebra::Sparse(augmented) => augmented.solve(&self.lengths, &free, (&mut x, &mut a))?,
        }
        let contradiction = self.scaled_defect(&x).iter().fold(0.0f64, |m, d| m.max(d.abs()));
        if contradiction > CONTRADICTION * self.in_rows.max(largest(x.iter().copied())) {
            return None;
        }
        x.iter().chain(&a).all(|v| v.is_finite()).then(|| ActiveSetPoint { x, a, states: states.to_vec() })
    }

    /// Computes `e − G x` of rows of length one.
    fn scaled_defect(&self, x: &[f64]) -> Vec<f64> {
        self.qp.defect(x).iter().zip(&self.lengths).map(|(d, length)| d / length).collect()
    }

    /// Solves on one set, with multipliers of the rows for which all signs are right; `None` if no multipliers fit. These are not
    /// unique if the set determines `x` alone, as in a vertex, and then the ones of [`Self::candidate`] may have wrong signs.
    pub(super) fn with_fitting_multipliers(
        &self,
        states: &[BoundState],
        from: &[f64],
    ) -> Option<ActiveSetPoint> {
        let mut candidate = self.candidate(states, from)?;
        // An unknown at its bound that is counted as free would ask for a multiplier of exactly zero.
        candidate.states = self.at_bounds(&candidate);
        if candidate.states != states {
            candidate = self.candidate(&candidate.states, from)?;
        }
        candidate.a = self.fitting_multipliers(&candidate)?;
        Some(candidate)
    }

    /// Finds the multipliers of least norm, with rows of length one, for which `P x + q − Gᵀ a` has the right signs: the least
    /// distance programme of Lawson and Hanson 1974, chapter 23.
    fn fitting_multipliers(&self, candidate: &ActiveSetPoint) -> Option<Vec<f64>> {
        let (n, m) = (candidate.x.len(), self.lengths.len());
        let gradient = self.gradient(&candidate.x, &vec![0.0; m]);
        let known: Vec<f64> = candidate.a.iter().zip(&self.lengths).map(|(a, length)| a * length).collect();
        let scale = largest(gradient.iter().copied()).max(norm(&known)).max(f64::MIN_POSITIVE);
        // s (Gᵀ a)_i ≥ s (P x + q)_i, one column for each s.
        let signs = |i: usize| match candidate.states[i] {
            _ if self.qp.lower[i] == self.qp.upper[i] => [].as_slice(),
            BoundState::Lower => &[-1.0],
            BoundState::Upper => &[1.0],
            BoundState::Free => &[-1.0, 1.0],
        };
        let columns: Vec<(usize, f64)> = (0..n).flat_map(|i| signs(i).iter().map(move |s| (i, *s))).collect();
        let rows = self.unit_rows();
        let rows = &rows;
        let of_rows = (0..m).flat_map(|k| columns.iter().map(move |(i, s)| s * rows[k * n + i]));
        let of_gradient = columns.iter().map(|(i, s)| s * gradient[*i] / scale);
        let matrix: Vec<f64> = of_rows.chain(of_gradient).collect();
        let mut right_side = vec![0.0; m + 1];
        right_side[m] = 1.0;
        let (_, residual) = nonnegative_least_squares(&matrix, &right_side).ok()?;
        let a = residual[..m].iter().zip(&self.lengths);
        let a: Vec<f64> = a.map(|(r, length)| -r / residual[m] * scale / length).collect();
        a.iter().all(|a| a.is_finite()).then_some(a)
    }

    /// Returns the states of a candidate whose free unknowns at a bound, to round-off, are at that bound.
    fn at_bounds(&self, candidate: &ActiveSetPoint) -> Vec<BoundState> {
        let ActiveSetPoint { x, states, .. } = candidate;
        let least = WRONG * largest(x.iter().copied()).max(self.size[0]);
        let place = |i: usize| match states[i] {
            BoundState::Free if x[i] <= self.qp.lower[i] + least => BoundState::Lower,
            BoundState::Free if x[i] >= self.qp.upper[i] - least => BoundState::Upper,
            same => same,
        };
        (0..x.len()).map(place).collect()
    }

    /// Returns the set that the signs of a candidate ask for.
    fn next(&self, candidate: &ActiveSetPoint) -> Vec<BoundState> {
        let ActiveSetPoint { x, a, states } = candidate;
        let y = self.gradient(x, a);
        let least = WRONG * largest(x.iter().copied()).max(self.size[0]);
        let slack = WRONG * self.size[1].max(largest(y.iter().copied()));
        let place = |i: usize| match states[i] {
            BoundState::Free if x[i] < self.qp.lower[i] - least => BoundState::Lower,
            BoundState::Free if x[i] > self.qp.upper[i] + least => BoundState::Upper,
            BoundState::Lower if y[i] < -slack && self.qp.lower[i] < self.qp.upper[i] => BoundState::Free,
            BoundState::Upper if y[i] > slack && self.qp.lower[i] < self.qp.upper[i] => BoundState::Free,
            same => same,
        };
        (0..x.len()).map(place).collect()
    }
}
