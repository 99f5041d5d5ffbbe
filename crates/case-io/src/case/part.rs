//! Boxes along the axes: `part` of a side, `box` of a region.

use super::Dimension;
use crate::case_file::Reader;
use fem_core::mesh::Mesh;
use fem_core::space::Plane;
use serde::{Serialize, Serializer};

/// Tolerance of the limits of a box, in diagonals of the body.
const TOLERANCE: f64 = 1e-9;

/// The part of a side a condition applies to: facets all of whose corners lie in the closed box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Part<S: Dimension = Plane> {
    /// Limits along each axis; `None` leaves it free.
    pub limits: S::Axes<Option<[f64; 2]>>,
}

impl<S: Dimension> Default for Part<S> {
    fn default() -> Self {
        Self { limits: S::axes(|_| None) }
    }
}

impl<S: Dimension> Serialize for Part<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let limits = S::COORDINATES.iter().zip(self.limits).filter(|(_, limits)| limits.is_some());
        serializer.collect_map(limits)
    }
}

impl<S: Dimension> Part<S> {
    /// How far beyond its limits a point may be.
    pub(super) fn tolerance(mesh: &Mesh<S>) -> f64 {
        TOLERANCE * mesh.diagonal()
    }

    /// Returns the test whether a point lies in the closed box, to [`Self::tolerance`].
    pub(super) fn contains(self, mesh: &Mesh<S>) -> impl Fn(S::Vector) -> bool + use<S> {
        let tolerance = Self::tolerance(mesh);
        let within = move |x: f64, limits: Option<[f64; 2]>| {
            limits.is_none_or(|[low, high]| x >= low - tolerance && x <= high + tolerance)
        };
        move |point| (0..S::DIM).all(|c| within(point[c], self.limits[c]))
    }

    /// Returns its limits along each axis as numbers; `None` without limits.
    pub(super) fn axes(&self) -> Option<S::Axes<[f64; 2]>> {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        (!self.is_all()).then(|| S::axes(|c| self.limits[c].unwrap_or(free)))
    }

    /// Tells if the part has no limits.
    pub(super) fn is_all(&self) -> bool {
        *self == Self::default()
    }

    /// Shows how limits are written: `x = [low, high], y = [low, high]`.
    ///
    /// * `between`: what joins them.
    pub(super) fn written(between: &str) -> String {
        S::COORDINATES.iter().map(|c| format!("{c} = [low, high]")).collect::<Vec<_>>().join(between)
    }

    /// Reads a table of limits; without one there are no limits.
    ///
    /// * `name`: `part` or `box`.
    pub(super) fn read(r: &mut Reader<'_>, name: &'static str) -> Self {
        let Some(mut r) = r.table(name) else { return Self::default() };
        let part = Self { limits: S::axes(|c| r.pair(S::COORDINATES[c])) };
        for (key, limits) in S::COORDINATES.iter().zip(part.limits) {
            if limits.is_some_and(|[low, high]| low > high) {
                r.refuse(
                    key,
                    format!("the limits of the {name} are in the wrong order"),
                    "[smaller, larger]",
                    "exchange the two",
                );
            }
        }
        r.finish();
        part
    }
}
