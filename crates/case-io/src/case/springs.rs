//! `[[body.spring]]`: springs between a side and the ground.

use super::{Dimension, Part, Value};
use crate::case_file::Reader;
use fem_core::boundary::{SpringDirection, SpringRest};
use fem_core::geometry::norm;
use fem_core::space::Plane;
use serde::Serialize;

/// The directions in which springs act.
#[derive(Clone, Debug, PartialEq)]
pub enum Along<S: Dimension = Plane> {
    /// `along = "normal"`: the outward normal.
    Normal,
    /// `along = "all"`.
    All,
    /// A vector.
    Vector(S::Axes<f64>),
}

/// The displacement at which springs are relaxed.
#[derive(Clone, Debug)]
pub enum Rest<S: Dimension = Plane> {
    /// The component along the springs, m.
    Component(Value),
    /// By Cartesian components, m.
    Vector(S::Data<Value>),
}

impl<S: Dimension> Rest<S> {
    /// Lists its data.
    pub(super) fn values_mut(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Component(value) => vec![value],
            Self::Vector(values) => values.as_mut().iter_mut().collect(),
        }
    }
}

impl<S: Dimension> PartialEq for Rest<S> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Component(a), Self::Component(b)) => a == b,
            (Self::Vector(a), Self::Vector(b)) => a.as_ref() == b.as_ref(),
            _ => false,
        }
    }
}

/// `[[body.spring]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
#[serde(bound = "")]
pub struct SpringCase<S: Dimension = Plane> {
    /// Its name for load steps, which scale `rest`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The side.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part<S>,
    /// Traction per displacement, Pa/m.
    pub stiffness: Value,
    /// The directions.
    #[serde(serialize_with = "along")]
    pub along: Along<S>,
    /// The displacement at which they are relaxed; `None`: zero.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "rest")]
    pub rest: Option<Rest<S>>,
}

fn along<S: Dimension, Z: serde::Serializer>(along: &Along<S>, serializer: Z) -> Result<Z::Ok, Z::Error> {
    match along {
        Along::Normal => serializer.serialize_str("normal"),
        Along::All => serializer.serialize_str("all"),
        Along::Vector(vector) => vector.as_ref().serialize(serializer),
    }
}

fn rest<S: Dimension, Z: serde::Serializer>(
    rest: &Option<Rest<S>>,
    serializer: Z,
) -> Result<Z::Ok, Z::Error> {
    match rest {
        Some(Rest::Component(value)) => value.serialize(serializer),
        Some(Rest::Vector(values)) => values.as_ref().serialize(serializer),
        None => serializer.serialize_none(),
    }
}

impl<S: Dimension> SpringCase<S> {
    /// Returns the directions as fem-core has them.
    pub(super) fn direction(&self) -> SpringDirection<S> {
        match &self.along {
            Along::Normal => SpringDirection::Normal,
            Along::All => SpringDirection::All,
            Along::Vector(vector) => SpringDirection::Vector(S::vector(vector)),
        }
    }

    /// Returns the displacement at rest as fem-core has it.
    pub(super) fn at_rest(&self) -> SpringRest<S> {
        match &self.rest {
            None => SpringRest::Vector(S::data(|_| 0.0.into())),
            Some(Rest::Component(value)) => SpringRest::Component(value.scalar()),
            Some(Rest::Vector(values)) => SpringRest::Vector(S::data(|c| values[c].scalar())),
        }
    }
}

/// Reads springs, of which name, side and part are known.
pub(super) fn spring<S: Dimension>(
    mut r: Reader<'_>,
    name: Option<String>,
    on: String,
    part: Part<S>,
) -> SpringCase<S> {
    r.require(&["stiffness"]);
    let stiffness = r.value("stiffness").unwrap_or_default();
    if let Value::Number(k) = &stiffness
        && !(*k > 0.0)
    {
        let message = format!("`{}` is {k}", r.path_of("stiffness"));
        let expected = "a traction per displacement, greater than 0";
        r.refuse("stiffness", message, expected, "write such a number, or take the springs out");
    }
    let along = direction::<S>(&mut r);
    let rest = match r.is_array("rest") {
        true => r.values::<S>("rest").map(Rest::Vector),
        false => r.value("rest").map(Rest::Component),
    };
    if along == Along::All && matches!(rest, Some(Rest::Component(_))) {
        let message = "`rest` is one number, but the springs act in all directions";
        let zeros = vec!["0.0"; S::DIM].join(", ");
        r.refuse("rest", message, "a vector", &format!("write `rest = [{zeros}]` with its components"));
    }
    r.finish();
    SpringCase { name, on, part, stiffness, along, rest }
}

fn direction<S: Dimension>(r: &mut Reader<'_>) -> Along<S> {
    if !r.is_array("along") {
        let words = [("normal", Along::<S>::Normal), ("all", Along::All)];
        let number = r.choice("along", &[(words[0].0, 0), (words[1].0, 1)]).unwrap_or(0);
        return if number == 0 { Along::Normal } else { Along::All };
    }
    let Some(vector) = r.axes::<S>("along") else { return Along::Normal };
    if !(norm(S::vector(&vector)) > 0.0) {
        let message = format!("`{}` has no direction", r.path_of("along"));
        r.refuse("along", message, "\"normal\", \"all\", or a vector", "write `along = \"normal\"`");
    }
    Along::Vector(vector)
}
