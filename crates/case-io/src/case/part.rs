//! Boxes along the axes: `part` of a side, `box` of a region.

use crate::case_file::Reader;

/// The part of an edge group a condition applies to: edges whose both ends lie in the closed box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Part {
    /// Limits in x; `None` leaves x free.
    pub x: Option<[f64; 2]>,
    /// Limits in y; `None` leaves y free.
    pub y: Option<[f64; 2]>,
}

impl Part {
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
