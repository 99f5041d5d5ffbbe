//! Boxes along the axes: `part` of a side, `box` of a region.

use crate::case_file::Reader;
use fem_core::geometry::Vector;
use fem_core::mesh::TriMesh;
use serde::Serialize;

/// Tolerance of the limits of a box, in diagonals of the body.
const TOLERANCE: f64 = 1e-9;

/// The part of an edge group a condition applies to: edges whose both ends lie in the closed box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Part {
    /// Limits in x; `None` leaves x free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 2]>,
    /// Limits in y; `None` leaves y free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<[f64; 2]>,
}

impl Part {
    /// How far beyond its limits a point may be.
    pub(super) fn tolerance(mesh: &TriMesh) -> f64 {
        TOLERANCE * mesh.diagonal()
    }

    /// Returns the test whether a point of the mesh's plane lies in the closed box, to [`Self::tolerance`].
    pub(super) fn contains(self, mesh: &TriMesh) -> impl Fn(Vector) -> bool {
        let tolerance = Self::tolerance(mesh);
        let within = move |x: f64, limits: Option<[f64; 2]>| {
            limits.is_none_or(|[low, high]| x >= low - tolerance && x <= high + tolerance)
        };
        move |point| within(point[0], self.x) && within(point[1], self.y)
    }

    /// Tells if the part has no limits.
    pub(super) fn is_all(&self) -> bool {
        *self == Self::default()
    }

    /// Reads a table of limits; without one there are no limits.
    ///
    /// * `name`: `part` or `box`.
    pub(super) fn read(r: &mut Reader<'_>, name: &'static str) -> Self {
        let Some(mut r) = r.table(name) else { return Self::default() };
        let part = Self { x: r.pair("x"), y: r.pair("y") };
        for (key, limits) in [("x", part.x), ("y", part.y)] {
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
