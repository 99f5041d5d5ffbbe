//! Active sets: the solution on one of them, and the one that its signs ask for.

use super::kept::{DEPENDENT_COLUMN, Kept};
use super::programme::BoxQp;
use crate::cholesky::{Factor, eliminate};
use crate::dense::{SemiDefinite, dot, norm};
use crate::kkt::largest;
use crate::least_squares::{bounded_least_squares, nonnegative_least_squares};
use crate::narrow::Narrow;
use crate::place::Place;
use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::collections::HashSet;

/// A sign or a bound is wrong beyond this fraction of the scale of the data.
const WRONG: f64 = 1e-12;

/// Eigenvalues of the rows' Schur complement below this fraction of the largest one are zero.
const DEPENDENT: f64 = 1e-10;

/// Dependent rows contradict each other beyond this fraction of the right-hand side.
const CONTRADICTION: f64 = 1e-9;

/// Corrections of a solution on one set.
const REFINEMENTS: usize = 2;

/// Overwrites right-hand sides with the solutions on some rows.
type Solver<'a> = Box<dyn Fn(&[usize], &mut [f64]) + 'a>;

/// A programme with what all active sets share.
pub(super) struct System<'a> {
    qp: &'a BoxQp<'a>,
    /// `P + c GᵀG` with rows of length one; `P` alone, and `c = 0`, if it is narrow.
    matrix: Cow<'a, [f64]>,
    /// Set if most entries of a large `P` are zero: `GᵀG` would fill it.
    narrow: Option<Narrow>,
    /// The system with `c GᵀG`, used from the first block of a narrow `P` on that is singular.
    full: OnceCell<Box<Self>>,
    /// The block that was factorised last, unless the matrix is narrow.
    kept: RefCell<Option<Kept>>,
    /// `G` with rows of length one, and the lengths.
    rows: Vec<f64>,
    lengths: Vec<f64>,
    weight: f64,
    /// The sizes of `x` and `y` that the data have.
    size: [f64; 2],
}

/// The minimiser on one set, whatever the signs.
pub(super) struct Candidate {
    pub(super) x: Vec<f64>,
    pub(super) a: Vec<f64>,
    pub(super) places: Vec<Place>,
}

impl<'a> System<'a> {
    pub(super) fn new(qp: &'a BoxQp<'a>) -> Self {
        Self::with(qp, Narrow::new(qp.linear.len(), qp.matrix))
    }

    fn with(qp: &'a BoxQp<'a>, narrow: Option<Narrow>) -> Self {
        let n = qp.linear.len();
        // A row of zeros stays one.
        let lengths: Vec<f64> = qp
            .rows
            .chunks_exact(n.max(1))
            .map(|row| Some(norm(row)).filter(|l| *l > 0.0).unwrap_or(1.0))
            .collect();
        let mut rows = qp.rows.to_vec();
        for (row, length) in rows.chunks_exact_mut(n.max(1)).zip(&lengths) {
            row.iter_mut().for_each(|g| *g /= length);
        }
        let trace: f64 = (0..n).map(|i| qp.matrix[i * n + i]).sum();
        let added = narrow.is_none() && !lengths.is_empty();
        let weight = match added {
            true if trace > 0.0 => trace / lengths.len() as f64,
            true => 1.0,
            false => 0.0,
        };
        let mut matrix = Cow::Borrowed(qp.matrix);
        if added {
            let matrix = matrix.to_mut();
            for row in rows.chunks_exact(n.max(1)) {
                for (j, g) in row.iter().enumerate().filter(|(_, g)| **g != 0.0) {
                    let column = &mut matrix[j * n..(j + 1) * n];
                    column.iter_mut().zip(row).for_each(|(p, other)| *p += weight * g * other);
                }
            }
        }
        let finite = |v: &f64| if v.is_finite() { *v } else { 0.0 };
        let alone = |i: usize| qp.linear[i] / matrix[i * n + i].max(f64::MIN_POSITIVE);
        let x = largest((0..n).map(alone))
            .max(largest(qp.right_side.iter().zip(&lengths).map(|(e, length)| e / length)))
            .max(largest(qp.lower.iter().chain(qp.upper).map(finite)));
        let y = largest(qp.linear.iter().copied());
        Self {
            qp,
            matrix,
            narrow,
            full: OnceCell::new(),
            kept: RefCell::new(None),
            rows,
            lengths,
            weight,
            size: [x, y],
        }
    }

    /// Computes `P x + q − Gᵀ a`.
    fn gradient(&self, x: &[f64], a: &[f64]) -> Vec<f64> {
        let Some(narrow) = &self.narrow else { return self.qp.gradient(x, a) };
        let mut gradient = self.qp.linear.to_vec();
        narrow.add_product(self.qp.matrix, x, &mut gradient);
        self.qp.subtract_rows(a, &mut gradient);
        gradient
    }

    /// Tries at most `limit` sets. Returns the solution, if it was found, and the number of sets tried.
    ///
    /// * `from`: a point, see [`Self::candidate`].
    pub(super) fn active_set(
        &self,
        mut places: Vec<Place>,
        from: &[f64],
        limit: usize,
    ) -> (Option<Candidate>, usize) {
        let mut visited = HashSet::new();
        for step in 1..=limit {
            let Some(candidate) = self.candidate(&places, from) else { return (None, step) };
            let next = self.next(&candidate);
            if next == places {
                return (Some(self.released(candidate, from)), step);
            }
            if !visited.insert(std::mem::replace(&mut places, next)) {
                return (None, step);
            }
        }
        (None, limit)
    }

    /// Puts free unknowns that are at a bound, to round-off, at that bound, if the signs stay right: rows that only they would determine
    /// then have the multipliers of least norm.
    fn released(&self, candidate: Candidate, from: &[f64]) -> Candidate {
        let places = self.at_bounds(&candidate);
        if places == candidate.places {
            return candidate;
        }
        self.candidate(&places, from).filter(|other| self.next(other) == places).unwrap_or(candidate)
    }

    /// Descends from a point within the bounds: the unknown that blocks a step stays at its bound, and the one whose multiplier is
    /// most wrong leaves it. Every step lowers the objective, so that no set comes back; the limit is for round-off.
    pub(super) fn descend(&self, start: &[f64], places: &[Place], limit: usize) -> Option<Candidate> {
        let (lower, upper) = (self.qp.lower, self.qp.upper);
        let mut places = places.to_vec();
        let mut x: Vec<f64> = (0..start.len())
            .map(|i| match places[i] {
                Place::Free => start[i].clamp(lower[i], upper[i]),
                place => self.qp.bound(i, place),
            })
            .collect();
        for _ in 0..limit {
            let candidate = self.candidate(&places, &x)?;
            let least = WRONG * largest(candidate.x.iter().copied()).max(self.size[0]);
            let blocks = |i: usize| {
                let (from, to) = (x[i], candidate.x[i]);
                match places[i] {
                    Place::Free if to < lower[i] - least => {
                        Some(((from - lower[i]) / (from - to), i, Place::Lower))
                    }
                    Place::Free if to > upper[i] + least => {
                        Some(((upper[i] - from) / (to - from), i, Place::Upper))
                    }
                    _ => None,
                }
            };
            let blocking = (0..x.len()).filter_map(blocks).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((ratio, i, place)) = blocking {
                let ratio = ratio.clamp(0.0, 1.0);
                x.iter_mut().zip(&candidate.x).for_each(|(x, to)| *x += ratio * (to - *x));
                places[i] = place;
                x[i] = self.qp.bound(i, place);
                continue;
            }
            let y = self.gradient(&candidate.x, &candidate.a);
            let slack = WRONG * self.size[1].max(largest(y.iter().copied()));
            let wrong = |i: usize| match places[i] {
                _ if lower[i] == upper[i] => 0.0,
                Place::Lower => -y[i],
                Place::Upper => y[i],
                Place::Free => 0.0,
            };
            let worst = (0..x.len()).max_by(|a, b| wrong(*a).total_cmp(&wrong(*b)));
            match worst.filter(|i| wrong(*i) > slack) {
                None => return Some(self.released(candidate, &x)),
                Some(i) => {
                    places[i] = Place::Free;
                    x = candidate.x;
                }
            }
        }
        None
    }

    /// [`Self::descend`] from a vertex: a point within the bounds at which the rows hold, with at most as many unknowns between their
    /// bounds as rows. `None` if the rows do not hold within the bounds, or if an unknown has no lower bound.
    pub(super) fn descend_from_vertex(&self, limit: usize) -> Option<Candidate> {
        let Self { qp, rows, lengths, .. } = self;
        let right_side: Vec<f64> = qp.right_side.iter().zip(lengths).map(|(e, length)| e / length).collect();
        let (x, _) = bounded_least_squares(rows, &right_side, [qp.lower, qp.upper]).ok()?;
        let place = |i: usize| match x[i] {
            x if x <= qp.lower[i] => Place::Lower,
            x if x >= qp.upper[i] => Place::Upper,
            _ => Place::Free,
        };
        let places: Vec<Place> = (0..x.len()).map(place).collect();
        self.descend(&x, &places, limit)
    }

    /// Solves on one set; `None` if the rows cannot hold on it. If unknowns between their bounds depend on each other, the solution is
    /// one of many, and some of them keep their values.
    ///
    /// * `from`: a point whose values they keep, within the bounds.
    fn candidate(&self, places: &[Place], from: &[f64]) -> Option<Candidate> {
        if let Some(full) = self.full.get() {
            return full.candidate(places, from);
        }
        let (qp, n, m) = (self.qp, places.len(), self.lengths.len());
        let mut x: Vec<f64> = (0..n).map(|i| qp.bound(i, places[i])).collect();
        if x.iter().any(|x| x.is_infinite()) {
            return None;
        }
        let mut a = vec![0.0; m];
        let is_free = |i: usize| places[i] == Place::Free;
        let mut kept = self.kept.borrow_mut();
        let (free, solve): (Vec<usize>, Solver<'_>) = if let Some(narrow) = &self.narrow {
            let (free, profile) = narrow.block(is_free);
            let Ok(factor) = Factor::of_profile(n, &self.matrix, &free, profile) else {
                return self.full.get_or_init(|| Box::new(Self::with(qp, None))).candidate(places, from);
            };
            (free, Box::new(move |_, rhs| factor.solve(rhs)))
        } else {
            let mut free: Vec<usize> = (0..n).filter(|i| is_free(*i)).collect();
            let changes = kept.as_mut().and_then(|kept| kept.changes(&self.matrix, &free));
            if changes.is_none() {
                *kept = Kept::new(n, &self.matrix, &free);
            }
            if kept.is_none() {
                for i in self.dependent(&free) {
                    x[i] = from[i].max(qp.lower[i]).min(qp.upper[i]);
                    free.retain(|j| *j != i);
                }
                *kept = Kept::new(n, &self.matrix, &free);
            }
            let (kept, changes) = (kept.as_ref()?, changes.unwrap_or_default());
            (free, Box::new(move |free, rhs| kept.solve(free, &changes, rhs)))
        };
        let solve = |rhs: &mut [f64]| solve(&free, rhs);
        let row = |k: usize| -> Vec<f64> { free.iter().map(|i| self.rows[k * n + i]).collect() };
        let rows: Vec<Vec<f64>> = (0..m).map(row).collect();
        // H⁻¹ G_Fᵀ and G_F H⁻¹ G_Fᵀ.
        let (solved, product) = if m > 0 && !free.is_empty() {
            eliminate(solve, &rows.concat(), m)
        } else {
            (Vec::new(), vec![0.0; m * m])
        };
        let entry = |i: usize, j: usize| 0.5 * (product[j * m + i] + product[i * m + j]);
        let complement = SemiDefinite::new(m, entry, DEPENDENT)?;
        for _ in 0..=REFINEMENTS {
            let scaled: Vec<f64> = a.iter().zip(&self.lengths).map(|(a, length)| a / length).collect();
            let gradient = self.gradient(&x, &scaled);
            let defect: Vec<f64> =
                qp.defect(&x).iter().zip(&self.lengths).map(|(d, length)| d / length).collect();
            let mut step: Vec<f64> = free.iter().map(|&i| -gradient[i]).collect();
            for (row, d) in rows.iter().zip(&defect) {
                step.iter_mut().zip(row).for_each(|(s, g)| *s += self.weight * g * d);
            }
            solve(&mut step);
            let rest: Vec<f64> = rows.iter().zip(&defect).map(|(row, d)| d - dot(row, &step)).collect();
            let scale = self.size[0].max(largest(x.iter().copied())).max(largest(step.iter().copied()));
            let (change, contradiction) = complement.solve(&rest);
            if contradiction > CONTRADICTION * scale {
                return None;
            }
            for (solved, change) in solved.chunks_exact(free.len().max(1)).zip(&change) {
                step.iter_mut().zip(solved).for_each(|(s, v)| *s += v * change);
            }
            a.iter_mut().zip(&change).for_each(|(a, change)| *a += change);
            free.iter().zip(&step).for_each(|(&i, s)| x[i] += s);
        }
        if !x.iter().chain(&a).all(|v| v.is_finite()) {
            return None;
        }
        a.iter_mut().zip(&self.lengths).for_each(|(a, length)| *a /= length);
        Some(Candidate { x, a, places: places.to_vec() })
    }

    /// Finds unknowns whose columns depend on those of others among some, by an elimination that skips them. In contact: at a corner
    /// friction on one side acts along the normal of the other. Unknowns with two bounds come last, so that a pressure is determined
    /// before a friction.
    fn dependent(&self, free: &[usize]) -> Vec<usize> {
        let n = self.qp.linear.len();
        let (first, last): (Vec<usize>, Vec<usize>) =
            free.iter().partition(|i| self.qp.upper[**i].is_infinite() || self.qp.lower[**i].is_infinite());
        let order = [first, last].concat();
        let (mut kept, mut skipped): (Vec<(usize, Vec<f64>)>, Vec<usize>) = (Vec::new(), Vec::new());
        for (k, &i) in order.iter().enumerate() {
            // The column of L below its pivot, in the order.
            let mut column: Vec<f64> = order[k..].iter().map(|j| self.matrix[i * n + j]).collect();
            for (start, earlier) in &kept {
                let part = &earlier[k - start..];
                let factor = part[0];
                column.iter_mut().zip(part).for_each(|(c, l)| *c -= factor * l);
            }
            if column[0] <= DEPENDENT_COLUMN * self.matrix[i * (n + 1)] {
                skipped.push(i);
                continue;
            }
            let pivot = column[0].sqrt();
            column.iter_mut().for_each(|c| *c /= pivot);
            kept.push((k, column));
        }
        skipped
    }

    /// Solves on one set, with multipliers of the rows for which all signs are right; `None` if no multipliers fit. These are not
    /// unique if the set determines `x` alone, as in a vertex, and then the ones of [`Self::candidate`] may have wrong signs.
    pub(super) fn with_fitting_multipliers(&self, places: &[Place], from: &[f64]) -> Option<Candidate> {
        let mut candidate = self.candidate(places, from)?;
        // An unknown at its bound that is counted as free would ask for a multiplier of exactly zero.
        candidate.places = self.at_bounds(&candidate);
        if candidate.places != places {
            candidate = self.candidate(&candidate.places, from)?;
        }
        candidate.a = self.fitting_multipliers(&candidate)?;
        Some(candidate)
    }

    /// Finds the multipliers of least norm, with rows of length one, for which `P x + q − Gᵀ a` has the right signs: the least
    /// distance programme of Lawson and Hanson 1974, chapter 23.
    fn fitting_multipliers(&self, candidate: &Candidate) -> Option<Vec<f64>> {
        let (n, m) = (candidate.x.len(), self.lengths.len());
        let gradient = self.gradient(&candidate.x, &vec![0.0; m]);
        let known: Vec<f64> = candidate.a.iter().zip(&self.lengths).map(|(a, length)| a * length).collect();
        let scale = largest(gradient.iter().copied()).max(norm(&known)).max(f64::MIN_POSITIVE);
        // s (Gᵀ a)_i ≥ s (P x + q)_i, one column for each s.
        let signs = |i: usize| match candidate.places[i] {
            _ if self.qp.lower[i] == self.qp.upper[i] => [].as_slice(),
            Place::Lower => &[-1.0],
            Place::Upper => &[1.0],
            Place::Free => &[-1.0, 1.0],
        };
        let columns: Vec<(usize, f64)> = (0..n).flat_map(|i| signs(i).iter().map(move |s| (i, *s))).collect();
        let of_rows = (0..m).flat_map(|k| columns.iter().map(move |(i, s)| s * self.rows[k * n + i]));
        let of_gradient = columns.iter().map(|(i, s)| s * gradient[*i] / scale);
        let matrix: Vec<f64> = of_rows.chain(of_gradient).collect();
        let mut right_side = vec![0.0; m + 1];
        right_side[m] = 1.0;
        let (_, residual) = nonnegative_least_squares(&matrix, &right_side).ok()?;
        let a = residual[..m].iter().zip(&self.lengths);
        let a: Vec<f64> = a.map(|(r, length)| -r / residual[m] * scale / length).collect();
        a.iter().all(|a| a.is_finite()).then_some(a)
    }

    /// Returns the places of a candidate whose free unknowns at a bound, to round-off, are at that bound.
    fn at_bounds(&self, candidate: &Candidate) -> Vec<Place> {
        let Candidate { x, places, .. } = candidate;
        let least = WRONG * largest(x.iter().copied()).max(self.size[0]);
        let place = |i: usize| match places[i] {
            Place::Free if x[i] <= self.qp.lower[i] + least => Place::Lower,
            Place::Free if x[i] >= self.qp.upper[i] - least => Place::Upper,
            same => same,
        };
        (0..x.len()).map(place).collect()
    }

    /// Returns the set that the signs of a candidate ask for.
    fn next(&self, candidate: &Candidate) -> Vec<Place> {
        let Candidate { x, a, places } = candidate;
        let y = self.gradient(x, a);
        let least = WRONG * largest(x.iter().copied()).max(self.size[0]);
        let slack = WRONG * self.size[1].max(largest(y.iter().copied()));
        let place = |i: usize| match places[i] {
            Place::Free if x[i] < self.qp.lower[i] - least => Place::Lower,
            Place::Free if x[i] > self.qp.upper[i] + least => Place::Upper,
            Place::Lower if y[i] < -slack && self.qp.lower[i] < self.qp.upper[i] => Place::Free,
            Place::Upper if y[i] > slack && self.qp.lower[i] < self.qp.upper[i] => Place::Free,
            same => same,
        };
        (0..x.len()).map(place).collect()
    }
}
