//! What acts inside bodies: changes of temperature, and the forces of a rotation and an acceleration.

use super::dimension::Keys;
use super::{BodyCase, Case, Dimension, Material, Value};
use crate::case_file::Reader;
use fem_core::body::{Body, ConditionList};
use fem_core::geometry::{Coordinates, shown};
use fem_core::interface::ContactProblem;
use fem_core::linear_field::LinearField;
use fem_core::space::{Plane, Space};
use serde::Serialize;
use serde_json::{Value as Json, json};

/// `[[body.temperature]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TemperatureCase {
    /// The name by which load steps scale it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The change of temperature.
    pub value: Value,
}

/// `model.rotation` and `model.acceleration`: forces per unit mass on all bodies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Inertia<S: Dimension = Plane> {
    /// `rotation`, if it is given.
    pub rotation: Option<Rotation<S>>,
    /// `acceleration`, such as that of gravity, m/s²: the force per unit mass.
    pub acceleration: S::Axes<f64>,
}

/// `rotation = { speed, point, axis }`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rotation<S: Dimension = Plane> {
    /// ω, radians per unit of time.
    pub speed: f64,
    /// A point on the axis, m.
    pub point: S::Axes<f64>,
    /// The direction of the axis, in space; not of unit length.
    pub axis: Option<S::Axes<f64>>,
}

impl<S: Dimension> Inertia<S> {
    /// Returns the force per unit mass, `ω² (x − p)` across the axis and the acceleration.
    pub(super) fn per_mass(&self) -> LinearField<S> {
        let value = S::vector(&self.acceleration);
        let Some(Rotation { speed, point, axis }) = &self.rotation else {
            return LinearField { point: S::Vector::ZERO, value, gradient: S::ZEROS };
        };
        let axis = axis.as_ref().map(S::vector).map(|axis| axis / axis.length());
        let across = |v: S::Vector| axis.map_or(v, |axis| v - axis * axis.times(&v));
        let gradient = S::axes(|j| across(S::AXES[j]) * (speed * speed));
        LinearField { point: S::vector(point), value, gradient }
    }

    /// Adds the keys to `[model]`.
    pub(super) fn json(&self, model: &mut Json) {
        if let Some(Rotation { speed, point, axis }) = &self.rotation {
            model["rotation"] = json!({ "speed": speed, "point": point.as_ref() });
            if let Some(axis) = axis {
                model["rotation"]["axis"] = json!(axis.as_ref());
            }
        }
        if self.acceleration.as_ref().iter().any(|a| *a != 0.0) {
            model["acceleration"] = json!(self.acceleration.as_ref());
        }
    }
}

/// Reads the keys of `[model]` that all cases have; `None` if no key is given.
pub(super) fn inertia<S: Keys>(r: &mut Reader<'_>) -> Option<Inertia<S>> {
    let acceleration = r.axes::<S>("acceleration");
    let rotation = r.table("rotation").and_then(rotation::<S>);
    if rotation.is_none() && acceleration.is_none() {
        return None;
    }
    Some(Inertia { rotation, acceleration: acceleration.unwrap_or_else(|| S::axes(|_| 0.0)) })
}

fn rotation<S: Keys>(mut r: Reader<'_>) -> Option<Rotation<S>> {
    let in_space = S::COORDINATES.len() == 3;
    r.require(if in_space { &["speed", "point", "axis"] } else { &["speed", "point"] });
    let (speed, point) = (r.number("speed"), r.axes::<S>("point"));
    let mut axis = None;
    if in_space {
        axis = direction::<S>(&mut r, "axis");
    } else if r.has("axis") {
        r.node("axis");
        let message = format!("`{}`: a plane body turns about a point", r.path_of("axis"));
        r.refuse("axis", message, "`speed` and `point` alone", "take `axis` out, or make all bodies solid");
    }
    r.finish();
    Some(Rotation { speed: speed?, point: point?, axis })
}

/// Reads a direction, of any length but zero.
pub(super) fn direction<S: Keys>(r: &mut Reader<'_>, key: &'static str) -> Option<S::Axes<f64>> {
    let axis = r.axes::<S>(key)?;
    let length = S::vector(&axis).length();
    if !(length > 1e-100 && length < 1e100) {
        let message = format!("`{}` has the length {}", r.path_of(key), shown(length));
        let last = S::axes(|c| if c + 1 == S::DIM { 1.0 } else { 0.0 });
        let fix = format!("write it as in `{key} = {:?}`", last.as_ref());
        r.refuse(key, message, "a direction", &fix);
    }
    Some(axis)
}

/// Reads `[[body.temperature]]`.
pub(super) fn temperature(mut r: Reader<'_>) -> TemperatureCase {
    r.require(&["value"]);
    let name = r.string("name");
    let value = value_inside(r.value("value"), &r, "value");
    r.finish();
    TemperatureCase { name, value }
}

/// Refuses values at nodes, which are along sides.
pub(super) fn value_inside(value: Option<Value>, r: &Reader<'_>, key: &str) -> Value {
    if let Some(Value::Given(_)) = value {
        let message = format!("`{}` takes no values at nodes", r.path_of(key));
        r.refuse(key, message, &r.findings().expression(), "write an expression there");
        return Value::default();
    }
    value.unwrap_or_default()
}

/// Refuses temperatures of bodies that do not expand, and forces per unit mass on bodies without a density.
pub(super) fn check<S: Dimension>(
    root: &Reader<'_>,
    (materials, bodies): (&[Material<S>], &[BodyCase<S>]),
    inertia: Option<&Inertia<S>>,
) {
    let of = |body: &BodyCase<S>, lacks: &dyn Fn(&Material<S>) -> bool| -> Vec<String> {
        let names = body.material_names();
        let found = names.filter_map(|name| materials.iter().find(|material| material.name == *name));
        found.filter(|material| lacks(material)).map(|material| material.name.clone()).collect()
    };
    for (k, body) in bodies.iter().enumerate() {
        let named = body.material_names().count();
        let rigid = of(body, &|material| material.expansion == 0.0);
        if !body.temperatures.is_empty() && rigid.len() == named {
            let message = format!(
                "body \"{}\" has a change of temperature, and its material \"{}\" does not expand",
                body.name, body.material
            );
            let fix = format!("write `expansion = 1.2e-5` into [materials.{}]", body.material);
            root.refuse(&format!("body.{k}.temperature.0"), message, "a material with `expansion`", &fix);
        }
        let Some(name) = of(body, &|material| material.density.is_none()).into_iter().next() else {
            continue;
        };
        if inertia.is_some() {
            let message = format!(
                "`model.rotation` and `model.acceleration` act on masses, and the material \"{name}\" of body \"{}\" has no density",
                body.name
            );
            let key = if root.has("model") { "model" } else { "" };
            let fix = format!("write `density` into [materials.{name}]");
            root.refuse(key, message, "a `density` of each material", &fix);
        }
    }
}

impl<S: Dimension> Case<S> {
    /// Says how far temperatures and body forces are from linear ones in the cells.
    pub(super) fn notes_inside(&self, problem: &ContactProblem<S>) -> Vec<String> {
        let of_body = |(given, body): (&BodyCase<S>, &Body<S>)| -> Vec<String> {
            let found = body.interpolated_inside();
            let note = |found: &fem_core::body::InsideDifference| {
                let (key, value) = match (found.place.list, found.component) {
                    (ConditionList::Temperature, _) => {
                        let value = given.temperatures.get(found.place.index).map(|given| &given.value);
                        ("temperature".to_owned(), value)
                    }
                    (_, Some(c)) => {
                        (format!("body force {}", S::COORDINATES[c]), given.body_force.as_ref().get(c))
                    }
                    _ => ("body force".to_owned(), None),
                };
                let value = super::data::quoted(value);
                let mut note = format!(
                    "body \"{}\", {key} = {value}: not linear in the {}, so the bound is for interpolated data; at the points \
                     checked they differ from the expression by at most {:.1e} of its largest value ({:.1e} in the mean)",
                    given.name,
                    <S as Space>::WORDS.cells,
                    found.difference.largest,
                    found.difference.mean
                );
                if let Some(energy) = found.energy {
                    note += &format!(
                        "; the solutions of the two problems differ by {energy:.1e} in the energy norm at most, by quadrature"
                    );
                }
                note
            };
            found.iter().map(note).collect()
        };
        self.bodies.iter().zip(&problem.bodies).flat_map(of_body).collect()
    }
}
