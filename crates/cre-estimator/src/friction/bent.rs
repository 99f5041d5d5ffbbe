//! Friction on facets along which the normal changes: `q(x) = m × n(x)` with a constant `m` is linear and everywhere tangential.

use super::within;
use crate::recovery::Recovery;
use crate::size::length;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactPair};

/// Returns `m × n` at the corners of a bent facet, within the smallest limit at its corners, Pa.
///
/// * `turn`: `m`, by the directions of [`turns`], Pa.
pub(crate) fn on_bent_facet<S: Recovery>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
    turn: &[f64],
    limit: &S::Axes<f64>,
) -> S::Axes<S::Vector> {
    let along = within(turn, least(limit));
    let fields: Vec<S::Axes<S::Vector>> = turn_fields(pair, facet).collect();
    S::axes(|corner| fields.iter().zip(&along).map(|(field, m)| field[corner] * *m).sum())
}

/// Returns the smallest limit of friction at the corners of a facet, Pa.
pub(crate) fn least<T: AsRef<[f64]>>(limit: &T) -> f64 {
    limit.as_ref().iter().copied().fold(f64::INFINITY, f64::min)
}

/// Lists the fields `m × n` at the corners of a facet for each direction of [`turns`].
pub(crate) fn turn_fields<S: Recovery>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
) -> impl Iterator<Item = S::Axes<S::Vector>> {
    let normals = S::axes(|corner| pair.interface.corner_pair(facet, corner).normal);
    turns::<S>(normals).map(move |turn| S::axes(|corner| S::turned(turn, normals[corner])))
}

/// Lists directions of `m`, of length one: across the mean of the normals of a facet; in the plane one, out of it.
fn turns<S: Recovery>(normals: S::Axes<S::Vector>) -> impl Iterator<Item = S::Spin> {
    let mean: S::Vector = normals.as_ref().iter().copied().sum();
    let mean = mean / length(mean);
    let tangents = S::complement(&[mean]);
    (0..S::DIM - 1).map(move |k| S::moment(mean, tangents.as_ref()[k]))
}

/// Finds the mean of `m` on a bent facet, by the directions of [`turns`], from friction in the rows along tangents, Pa.
pub(crate) fn turns_of<S: Recovery>(
    pair: &ContactPair<S>,
    facet: &ContactFacet<S>,
    rows: &[f64],
) -> Vec<f64> {
    let pairs = pair.interface.pairs();
    let normals = S::axes(|corner| pair.interface.corner_pair(facet, corner).normal);
    let mean = |turn: S::Spin| -> f64 {
        let at = |k: &u32| {
            let k = *k as usize;
            let along = S::turned(turn, pairs[k].normal);
            pair.along_tangents(k, rows).times(&along) / along.times(&along)
        };
        let of_corner = |corner: usize| {
            let sources = pair.interface.sources(facet, corner);
            sources.iter().map(at).sum::<f64>() / sources.len().max(1) as f64
        };
        (0..S::DIM).map(of_corner).sum::<f64>() / S::DIM as f64
    };
    turns::<S>(normals).map(mean).collect()
}
