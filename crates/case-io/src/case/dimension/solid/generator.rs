//! Generators of solids, and how they are read.

use crate::case::dimension::plane::{FACINGS, facing_name};
use crate::case_file::Reader;
use fem_core::mesh::generate::{BallPart, Facing};
use fem_core::space::Solid;
use serde::{Serialize, Serializer};

/// A mesh of tetrahedra that needs no file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum SolidGenerator {
    /// `generator = { kind = "box", … }`, see [`fem_core::mesh::generate::cuboid()`].
    Box {
        /// The corner with the smallest coordinates, m.
        origin: [f64; 3],
        /// Lengths along the axes, m.
        size: [f64; 3],
        /// Boxes along each axis; each is cut in six tetrahedra.
        cells: [usize; 3],
    },
    /// `generator = { kind = "cylinder", … }`: a cylinder along z or a sector of one, see [`fem_core::mesh::generate::tube()`].
    Cylinder {
        /// The middle of its bottom, m.
        origin: [f64; 3],
        /// Radius, m.
        radius: f64,
        /// Length along z, m.
        length: f64,
        /// Start and end, degrees.
        angles: [f64; 2],
        /// Cells around, from the axis outwards, and along the axis.
        cells: [usize; 3],
    },
    /// `generator = { kind = "tube", … }`: a tube along z or a sector of one, see [`fem_core::mesh::generate::tube()`].
    Tube {
        /// The middle of its bottom, m.
        origin: [f64; 3],
        /// Inner and outer radius, m.
        radii: [f64; 2],
        /// Length along z, m.
        length: f64,
        /// Start and end, degrees.
        angles: [f64; 2],
        /// Cells around, across the wall, and along the axis.
        cells: [usize; 3],
    },
    /// `generator = { kind = "ball", … }`: a ball or a part of one, fine near its poles, see [`fem_core::mesh::generate::ball()`].
    Ball {
        /// Centre, m.
        centre: [f64; 3],
        /// Radius, m.
        radius: f64,
        /// The part that is meshed.
        #[serde(serialize_with = "part_name")]
        part: BallPart,
        /// The side of the pole of a part.
        #[serde(serialize_with = "facing_name")]
        facing: Facing,
        /// The length of the longest cells over the one at the pole.
        growth: f64,
        /// Cells from the centre to the surface.
        cells: usize,
    },
}

/// The words for the parts of a ball.
const PARTS: &[(&str, BallPart)] = &[
    ("whole", BallPart::Whole),
    ("half", BallPart::Half),
    ("quarter", BallPart::Quarter),
    ("eighth", BallPart::Eighth),
];

/// Writes the name of a part.
fn part_name<W: Serializer>(part: &BallPart, to: W) -> Result<W::Ok, W::Error> {
    let name = PARTS.iter().find(|(_, known)| known == part);
    to.serialize_str(name.map_or("whole", |(name, _)| name))
}

impl Default for SolidGenerator {
    fn default() -> Self {
        Self::Box { origin: [0.0; 3], size: [1.0; 3], cells: [1; 3] }
    }
}

pub(super) fn cuboid(mut r: Reader<'_>) -> Option<SolidGenerator> {
    r.require(&["size", "cells"]);
    let origin = r.axes::<Solid>("origin").unwrap_or_default();
    let size = r.axes::<Solid>("size");
    if size.is_some_and(|s| s.iter().any(|&v| v <= 0.0)) {
        let fix = "write it as in `size = [2.0, 1.0, 1.0]`";
        r.refuse("size", "a box needs three lengths", "three numbers > 0", fix);
    }
    let cells = r.counts::<Solid>("cells");
    r.finish();
    Some(SolidGenerator::Box { origin, size: size?, cells: cells? })
}

pub(super) fn cylinder(mut r: Reader<'_>) -> Option<SolidGenerator> {
    r.require(&["radius", "length", "cells"]);
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let (origin, length, angles, cells) = around_axis(r);
    Some(SolidGenerator::Cylinder { origin, radius: radius?, length: length?, angles, cells: cells? })
}

pub(super) fn tube(mut r: Reader<'_>) -> Option<SolidGenerator> {
    r.require(&["radii", "length", "cells"]);
    let radii = r.pair("radii");
    if radii.is_some_and(|[inner, _]| inner <= 0.0) {
        let fix = "write `kind = \"cylinder\"` with a `radius` for a tube without a bore";
        r.refuse("radii", "a tube has a bore", "two numbers > 0, the inner radius first", fix);
    }
    let (origin, length, angles, cells) = around_axis(r);
    Some(SolidGenerator::Tube { origin, radii: radii?, length: length?, angles, cells: cells? })
}

pub(super) fn ball(mut r: Reader<'_>) -> Option<SolidGenerator> {
    r.require(&["radius", "cells"]);
    let centre = r.axes::<Solid>("centre").unwrap_or_default();
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let part = if r.has("part") { r.choice("part", PARTS) } else { Some(BallPart::Whole) };
    if part == Some(BallPart::Whole) && r.has("facing") {
        let fix = "take it out, or write `part = \"half\"`";
        r.refuse("facing", "a whole ball has a pole on either side", "a part of a ball", fix);
    }
    let facing = if r.has("facing") { r.choice("facing", FACINGS) } else { Some(Facing::Down) };
    let growth = |growth: f64| (1.0..=5.0).contains(&growth);
    let growth =
        if r.has("growth") { r.number_where("growth", growth, "a number from 1 to 5") } else { Some(2.0) };
    let cells = r.count("cells", 1);
    r.finish();
    Some(SolidGenerator::Ball {
        centre,
        radius: radius?,
        part: part?,
        facing: facing?,
        growth: growth?,
        cells: cells?,
    })
}

/// Reads what cylinders and tubes have in common: origin, length, angles and cells.
fn around_axis(mut r: Reader<'_>) -> ([f64; 3], Option<f64>, [f64; 2], Option<[usize; 3]>) {
    let origin = r.axes::<Solid>("origin").unwrap_or_default();
    let length = r.number_where("length", |length| length > 0.0, "a number > 0");
    let angles = r.pair("angles").unwrap_or([0.0, 360.0]);
    let cells = r.counts::<Solid>("cells");
    r.finish();
    (origin, length, angles, cells)
}
