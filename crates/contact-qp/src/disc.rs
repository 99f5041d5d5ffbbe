//! Pairs of unknowns in discs, and their axes along and across a direction.

use crate::bound_state::BoundState;
use crate::error::QpError;
use crate::sparse::SparseRows;
use std::collections::BTreeMap;

/// Two unknowns in a disc around zero, `x_i² + x_j² ≤ r²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// `i` and `j`. Their own bounds do not count.
    pub unknowns: [usize; 2],
    /// `r ≥ 0`.
    pub radius: f64,
}

/// Returns the point of a disc that is nearest to a given one.
pub(crate) fn within([a, b]: [f64; 2], radius: f64) -> [f64; 2] {
    let length = a.hypot(b);
    if length > radius { [a / length * radius, b / length * radius] } else { [a, b] }
}

pub(crate) fn check_discs(discs: &[Disc], n: usize) -> Result<(), QpError> {
    let mut used = vec![false; n];
    for Disc { unknowns, radius } in discs {
        for &i in unknowns {
            let free = used.get_mut(i).is_some_and(|used| !std::mem::replace(used, true));
            if !free {
                return Err(QpError::Disc { place: i, unknowns: n });
            }
        }
        if !(*radius >= 0.0 && radius.is_finite()) {
            return Err(QpError::Bounds { place: unknowns[0], lower: -radius, upper: *radius });
        }
    }
    Ok(())
}

/// The axes of a disc: the first unknown is along `d`, the second across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) unknowns: [usize; 2],
    pub(crate) radius: f64,
    pub(crate) along: [f64; 2],
    /// `κ`.
    pub(crate) curvature: f64,
}

impl Frame {
    /// Takes the axes of `d = x − c y`; without one those of the unknowns themselves.
    pub(crate) fn new(disc: &Disc, d: [f64; 2], c: f64) -> Self {
        let Disc { unknowns, radius } = *disc;
        let length = d[0].hypot(d[1]);
        let along = if length > 0.0 && length.is_finite() { d.map(|d| d / length) } else { [1.0, 0.0] };
        let curvature = if length > radius && radius > 0.0 { (length - radius) / (c * radius) } else { 0.0 };
        Self { unknowns, radius, along, curvature }
    }

    pub(crate) fn is_on_circle(&self) -> bool {
        self.curvature > 0.0
    }

    pub(crate) fn across(&self) -> usize {
        self.unknowns[1]
    }

    /// Writes the bounds of the unknowns along and across.
    pub(crate) fn bound(&self, lower: &mut [f64], upper: &mut [f64]) {
        let [i, j] = self.unknowns;
        let free = if self.radius > 0.0 { f64::INFINITY } else { 0.0 };
        (lower[i], upper[i]) = (-free, self.radius);
        (lower[j], upper[j]) = (-free, free);
    }

    /// Writes the states of the unknowns along and across.
    pub(crate) fn place(&self, states: &mut [BoundState]) {
        let [i, j] = self.unknowns;
        (states[i], states[j]) = match self.radius > 0.0 {
            true if self.is_on_circle() => (BoundState::Upper, BoundState::Free),
            true => (BoundState::Free, BoundState::Free),
            false => (BoundState::Lower, BoundState::Lower),
        };
    }

    /// Takes values of the unknowns to those along and across.
    pub(crate) fn enter(&self, values: &mut [f64]) {
        let ([i, j], [a, b]) = (self.unknowns, self.along);
        (values[i], values[j]) = (a * values[i] + b * values[j], a * values[j] - b * values[i]);
    }

    /// Takes values along and across to those of the unknowns.
    pub(crate) fn leave(&self, values: &mut [f64]) {
        let ([i, j], [a, b]) = (self.unknowns, self.along);
        (values[i], values[j]) = (a * values[i] - b * values[j], b * values[i] + a * values[j]);
    }

    /// Returns an unknown as a combination of those along and across.
    fn parts(&self, unknown: usize) -> [(usize, f64); 2] {
        let ([i, j], [a, b]) = (self.unknowns, self.along);
        if unknown == i { [(i, a), (j, -b)] } else { [(i, b), (j, a)] }
    }
}

/// Rows of given unknowns, in those along and across.
pub(crate) fn rotated_rows(rows: &SparseRows, frames: &[Frame]) -> SparseRows {
    let places = places(rows.columns(), frames);
    let mut rotated = SparseRows::new(rows.columns());
    for row in rows.rows() {
        let mut entries: BTreeMap<usize, f64> = BTreeMap::new();
        for (j, g) in row {
            for (place, part) in parts(&places, frames, j) {
                *entries.entry(place).or_default() += part * g;
            }
        }
        rotated.push(entries);
    }
    rotated
}

/// Lists the frame of each unknown.
pub(crate) fn places(n: usize, frames: &[Frame]) -> Vec<Option<usize>> {
    let mut places = vec![None; n];
    for (k, frame) in frames.iter().enumerate() {
        frame.unknowns.iter().for_each(|i| places[*i] = Some(k));
    }
    places
}

/// Returns an unknown in those along and across.
pub(crate) fn parts(
    places: &[Option<usize>],
    frames: &[Frame],
    unknown: usize,
) -> impl Iterator<Item = (usize, f64)> {
    let of_frame = places[unknown].map(|k| frames[k].parts(unknown));
    let alone = if of_frame.is_none() { Some((unknown, 1.0)) } else { None };
    of_frame.into_iter().flatten().chain(alone)
}
