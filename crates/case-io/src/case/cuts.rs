//! `[[body.cut]]`: bolts that are tightened.

use super::dimension::Keys;
use super::names::Names;
use super::{Dimension, Part};
use crate::case_file::Reader;
use fem_core::boundary::{CutCondition, CutLoad};
use fem_core::space::Plane;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// `[[body.cut]]`: a cut along facets of the mesh, whose two sides are pulled together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CutCase<S: Dimension = Plane> {
    /// Its name, by which load steps scale it.
    pub name: String,
    /// A point of its plane, m.
    pub point: S::Axes<f64>,
    /// The normal of its plane, of any length but zero.
    pub normal: S::Axes<f64>,
    /// `box`: the part of the plane.
    pub part: Part<S>,
    /// The shortening or the force.
    pub load: CutLoad,
}

impl<S: Dimension> Serialize for CutCase<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let plane = serde_json::json!({ "point": self.point.as_ref(), "normal": self.normal.as_ref() });
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", &self.name)?;
        map.serialize_entry("plane", &plane)?;
        if !self.part.is_all() {
            map.serialize_entry("box", &self.part)?;
        }
        match self.load {
            CutLoad::Shortening(value) => map.serialize_entry("shortening", &value)?,
            CutLoad::Force(value) => map.serialize_entry("force", &value)?,
        }
        map.end()
    }
}

impl<S: Dimension> CutCase<S> {
    /// Returns the cut as fem-core has it.
    pub(super) fn condition(&self) -> CutCondition<S> {
        CutCondition {
            name: self.name.clone(),
            point: S::vector(&self.point),
            normal: S::vector(&self.normal),
            part: self.part.axes(),
            load: self.load,
        }
    }
}

/// Reads `[[body.cut]]`.
///
/// * `names`: of the cuts of all bodies before.
pub(super) fn cut<S: Keys>(mut r: Reader<'_>, names: &mut Names) -> Option<CutCase<S>> {
    r.require(&["name", "plane"]);
    let name = r.string("name").unwrap_or_default();
    if r.has("name") {
        names.check(&r, &name, "cut", "choose another name");
        names.take(&name);
    }
    let mut plane = None;
    if let Some(mut r) = r.table("plane") {
        r.require(&["point", "normal"]);
        let (point, normal) = (r.axes::<S>("point"), super::inside::direction::<S>(&mut r, "normal"));
        r.finish();
        plane = point.zip(normal);
    }
    let part = Part::read(&mut r, "box");
    let (shortening, force) = (r.number("shortening"), r.number("force"));
    let expected = "either `shortening` or `force`";
    match (r.has("shortening"), r.has("force")) {
        (true, true) => {
            r.refuse("force", "`shortening` and `force` exclude each other", expected, "take one of them out")
        }
        (false, false) => r.refuse(
            "",
            "nothing tightens this cut",
            expected,
            "write `force = 1.0`, which pulls if it is positive",
        ),
        _ => {}
    }
    r.finish();
    let load = shortening.map(CutLoad::Shortening).or(force.map(CutLoad::Force))?;
    let (point, normal) = plane?;
    Some(CutCase { name, point, normal, part, load })
}
