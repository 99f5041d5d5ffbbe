//! Linear functions on a facet, by their values at the corners, and their moments with the hat functions.

use crate::space::{Item, Space};
use std::ops::{Mul, Sub};

/// Computes the linear function on a facet, by its values at the corners, that has the given moments with the hat functions of the corners,
/// over the measure: in the plane `[2, 1; 1, 2] F / 6 = m`.
pub(super) fn linear_by_moments<S: Space, V: Item + Sub<Output = V> + Mul<f64, Output = V>>(
    moments: &S::Axes<V>,
) -> S::Axes<V> {
    let n = S::DIM as f64;
    S::axes(|k| {
        let others = (0..S::DIM).filter(|j| *j != k);
        others.fold(moments[k] * (n * n), |sum, j| sum - moments[j] * n)
    })
}

/// Computes `∫ f φ_k` of a linear function on a facet by its values at the corners.
pub fn moments<S: Space>(values: &S::Axes<S::Vector>, measure: f64) -> S::Axes<S::Vector> {
    // ∫ φ_j φ_k is the measure over d (d + 1) on a facet with d corners, twice that if j is k.
    let share = measure / (S::DIM * (S::DIM + 1)) as f64;
    S::axes(|k| {
        let others = (0..S::DIM).filter(|j| *j != k);
        others.fold(values[k] * 2.0, |sum, j| sum + values[j]) * share
    })
}

/// Computes the linear function on a facet, by its values at the corners, that has given moments `∫ f φ_k`.
pub fn tractions<S: Space>(moments: &S::Axes<S::Vector>, measure: f64) -> S::Axes<S::Vector> {
    let values = linear_by_moments::<S, S::Vector>(moments);
    S::axes(|k| values[k] / measure)
}
