//! `[[body.side]]`: sides by their place, for meshes without named edges, and sides made of others.

use super::dimension::{Keys, refuse_foreign};
use super::{Case, Dimension, Part};
use crate::case_file::Reader;
use crate::diagnostic::{CaseError, code, did_you_mean, excerpt, significant};
use fem_core::geometry::{Coordinates, norm};
use fem_core::mesh::Mesh;
use fem_core::mesh::id::FacetId;
use fem_core::space::Plane;
use mesh_io::words::listed;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;

/// Default of `within`, degrees.
const WITHIN: f64 = 30.0;
/// Nodes are on a circle, a sphere or a cylinder if they are closer to it than this fraction of its radius.
const ON_CIRCLE: f64 = 1e-3;
/// The key of a cylinder.
const CYLINDER: &str = "cylinder";

/// `[[body.side]]`: the boundary facets that satisfy all given conditions, or a single boundary node.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SideCase<S: Dimension = Plane> {
    /// Its name, for `on` and `surfaces`.
    pub name: String,
    /// The sides that it is made of; empty: the whole boundary.
    pub of: Vec<String>,
    /// `box`: all corners lie in it.
    pub part: Part<S>,
    /// The outward normal is within [`Self::within`] of this direction.
    pub facing: Option<S::Axes<f64>>,
    /// The largest angle between the two, degrees.
    pub within: Option<f64>,
    /// All corners lie on this circle, in space a sphere.
    pub circle: Option<Circle<S>>,
    /// All corners lie on this cylinder, in space.
    pub cylinder: Option<Cylinder<S>>,
    /// The boundary node at this place, m, and no facet: for a `[[body.displacement]]` with components or `fixed`.
    pub point: Option<S::Axes<f64>>,
}

/// `circle` of a side, in space `sphere`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<S: Dimension = Plane> {
    /// Its centre, m.
    pub centre: S::Axes<f64>,
    /// Its radius, m.
    pub radius: f64,
}

impl<S: Dimension> Serialize for Circle<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("centre", self.centre.as_ref())?;
        map.serialize_entry("radius", &self.radius)?;
        map.end()
    }
}

/// `cylinder` of a side in space, without ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder<S: Dimension = Plane> {
    /// A point of its axis, m.
    pub point: S::Axes<f64>,
    /// The direction of its axis, of any length but zero.
    pub axis: S::Axes<f64>,
    /// Its radius, m.
    pub radius: f64,
}

impl<S: Dimension> Serialize for Cylinder<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("point", self.point.as_ref())?;
        map.serialize_entry("axis", self.axis.as_ref())?;
        map.serialize_entry("radius", &self.radius)?;
        map.end()
    }
}

impl<S: Dimension> Serialize for SideCase<S> {
    fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", &self.name)?;
        if !self.of.is_empty() {
            map.serialize_entry("of", &self.of)?;
        }
        if !self.part.is_all() {
            map.serialize_entry("box", &self.part)?;
        }
        if let Some(facing) = &self.facing {
            map.serialize_entry("facing", facing.as_ref())?;
        }
        if let Some(within) = &self.within {
            map.serialize_entry("within", within)?;
        }
        if let Some(circle) = &self.circle {
            map.serialize_entry(S::CIRCLE, circle)?;
        }
        if let Some(cylinder) = &self.cylinder {
            map.serialize_entry(CYLINDER, cylinder)?;
        }
        if let Some(point) = &self.point {
            map.serialize_entry("point", point.as_ref())?;
        }
        map.end()
    }
}

impl<S: Dimension> SideCase<S> {
    /// Joins sides under one name.
    pub(super) fn union(names: Vec<String>) -> Self {
        let name = names.join(" + ");
        let part = Part::default();
        Self { name, of: names, part, facing: None, within: None, circle: None, cylinder: None, point: None }
    }
}

/// Tells if one of the names belongs to a single node.
pub(super) fn has_point<S: Dimension>(names: &[String], sides: &[SideCase<S>]) -> bool {
    names.iter().any(|name| sides.iter().any(|side| side.name == *name && side.point.is_some()))
}

/// Returns the name of the only side, or of a side that several make.
pub(super) fn joined<S: Dimension>(mut names: Vec<String>, sides: &mut Vec<SideCase<S>>) -> String {
    if names.len() < 2 {
        return names.pop().unwrap_or_default();
    }
    let union = SideCase::union(names);
    let name = union.name.clone();
    if !sides.contains(&union) {
        sides.push(union);
    }
    name
}

/// Reads `[[body.side]]`.
pub(super) fn sides<S: Keys>(r: &mut Reader<'_>) -> Vec<SideCase<S>> {
    let mut found: Vec<SideCase<S>> = Vec::new();
    for mut r in r.tables("side").unwrap_or_default() {
        let side = side::<S>(&mut r);
        if found.iter().any(|other| other.name == side.name) {
            let message = format!("two sides are called {}", excerpt(&side.name));
            r.refuse("name", message, "names that differ", "rename one of the two");
        }
        r.finish();
        found.push(side);
    }
    found
}

fn side<S: Keys>(r: &mut Reader<'_>) -> SideCase<S> {
    refuse_foreign::<S>(r, "side");
    r.require(&["name"]);
    let name = r.string("name").unwrap_or_default();
    let part = Part::read(r, "box");
    let facing = r.axes::<S>("facing");
    let up = format!("facing = {}", up::<S>());
    if facing == Some(S::axes(|_| 0.0)) {
        let message = format!("`{}` has no direction", r.path_of("facing"));
        r.refuse("facing", message, "a direction", &format!("write it as in `{up}`"));
    }
    let within =
        r.number_where("within", |angle| angle > 0.0 && angle <= 90.0, "degrees, above 0 and at most 90");
    if within.is_some() && facing.is_none() {
        let expected = "`facing` beside it";
        let fix = format!("add `{up}`");
        r.refuse("within", "`within` is the angle about `facing`", expected, &fix);
    }
    let circle = r.table(S::CIRCLE).and_then(circle);
    let cylinder = if S::CYLINDERS { r.table(CYLINDER).and_then(cylinder) } else { None };
    let point = r.axes::<S>("point");
    let of_edges: Vec<&str> =
        ["box", "facing", S::CIRCLE, CYLINDER].into_iter().filter(|key| r.has(key)).collect();
    if of_edges.is_empty() && !r.has("point") {
        let (round, axes) = (S::CIRCLE, S::COORDINATES.join(", "));
        let expected = format!(
            "`box = {{ x = [low, high] }}`, `{up}`, `{round} = {{ centre, radius }}`, or `point = [{axes}]`"
        );
        let message = format!("this side takes no {}", S::WORDS.facets);
        r.refuse("", message, &expected, &format!("write `{up}`"));
    }
    if let Some(key) = of_edges.first().filter(|_| r.has("point")) {
        let message = format!("`point` is a single node, and `{key}` takes {}", S::WORDS.facets);
        r.refuse("point", message, "one of the two", &format!("take `{key}` out"));
    }
    SideCase { name, of: Vec::new(), part, facing, within, circle, cylinder, point }
}

/// Writes the direction along the last axis.
pub(super) fn up<S: Dimension>() -> String {
    let entries: Vec<&str> = (1..S::DIM).map(|_| "0.0").chain(["1.0"]).collect();
    format!("[{}]", entries.join(", "))
}

fn circle<S: Keys>(mut r: Reader<'_>) -> Option<Circle<S>> {
    r.require(&["centre", "radius"]);
    let centre = r.axes::<S>("centre");
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    r.finish();
    Some(Circle { centre: centre?, radius: radius? })
}

fn cylinder<S: Keys>(mut r: Reader<'_>) -> Option<Cylinder<S>> {
    let read = cylinder_keys::<S>(&mut r);
    r.finish();
    read
}

/// Reads point, axis and radius of a cylinder.
pub(super) fn cylinder_keys<S: Keys>(r: &mut Reader<'_>) -> Option<Cylinder<S>> {
    r.require(&["point", "axis", "radius"]);
    let (point, axis) = (r.axes::<S>("point"), r.axes::<S>("axis"));
    if axis == Some(S::axes(|_| 0.0)) {
        let message = format!("`{}` has no direction", r.path_of("axis"));
        let fix = format!("write it as in `axis = {}`", up::<S>());
        r.refuse("axis", message, "a direction along the axis of the cylinder", &fix);
    }
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    Some(Cylinder { point: point?, axis: axis?, radius: radius? })
}

impl<S: Dimension> Case<S> {
    /// Adds the selected sides of a body to its mesh.
    ///
    /// # Errors
    /// Sides without edges, or with the name of another side of the mesh.
    pub(super) fn add_sides(&self, body: usize, mesh: &mut Mesh<S>) -> Result<(), CaseError> {
        let given = &self.bodies[body];
        for (k, side) in given.sides.iter().enumerate() {
            let path = format!("body.{body}.side.{k}");
            if side.of.is_empty() && mesh.group(&side.name).is_some() {
                let message = format!("body \"{}\": its mesh has a side \"{}\"", given.name, side.name);
                let fault = self.diagnostic(code::DUPLICATE, &format!("{path}.name"), message);
                return Err(fault.expected("another name").fix("rename this side").into());
            }
            if side.point.is_some() {
                continue;
            }
            let edges = if side.of.is_empty() { select(mesh, side) } else { self.union(body, mesh, side)? };
            if edges.is_empty() {
                let message = format!(
                    "body \"{}\": no boundary {} belongs to the side \"{}\"",
                    given.name,
                    S::WORDS.facet,
                    side.name
                );
                let fault = self.diagnostic(code::CONDITION, &path, message);
                let (round, facets) = (S::CIRCLE, S::WORDS.facets);
                let fault = fault.expected(format!("a box, a direction or a {round} with boundary {facets}"));
                return Err(fault.help(nearest_to_round(mesh, side)).fix("widen it").into());
            }
            mesh.add_group(&side.name, edges);
        }
        Ok(())
    }

    /// Joins the edges of sides.
    fn union(&self, body: usize, mesh: &Mesh<S>, side: &SideCase<S>) -> Result<Vec<FacetId>, CaseError> {
        let mut all = BTreeSet::new();
        for name in &side.of {
            let Some(edges) = mesh.group(name) else {
                let known: Vec<&str> = mesh.groups().keys().map(String::as_str).collect();
                let given = &self.bodies[body].name;
                let message = format!("body \"{given}\": there is no side {}", excerpt(name));
                let fault = self.diagnostic(code::REFERENCE, &format!("body.{body}"), message);
                let fault = fault.expected(format!("sides of its mesh: {}", listed(&known)));
                let help = did_you_mean(name, known.iter().copied(), '"');
                return Err(fault.help(help).fix("write the names of sides of this body").into());
            };
            all.extend(edges.iter().copied());
        }
        Ok(all.into_iter().collect())
    }
}

/// Lists the boundary edges that satisfy all conditions of a side.
fn select<S: Dimension>(mesh: &Mesh<S>, side: &SideCase<S>) -> Vec<FacetId> {
    let inside = side.part.contains(mesh);
    let cosine = side.within.unwrap_or(WITHIN).to_radians().cos();
    let direction = side.facing.map(|d| {
        let d = S::vector(&d);
        d * (1.0 / norm(d))
    });
    let on_round = |point: S::Vector| {
        side.circle.is_none_or(|circle| off_circle(point, &circle) <= ON_CIRCLE * circle.radius)
            && side.cylinder.is_none_or(|of| off_cylinder(point, &of) <= ON_CIRCLE * of.radius)
    };
    let belongs = |edge: &FacetId| {
        let ends = mesh.facet_corners(*edge);
        ends.into_iter().all(|point| inside(point) && on_round(point))
            && direction.is_none_or(|d| d.times(&mesh.facet_normal(*edge)) >= cosine)
    };
    mesh.topology().boundary_facets().iter().copied().filter(belongs).collect()
}

/// Computes the distance of a point from a circle or a sphere, m.
fn off_circle<S: Dimension>(point: S::Vector, circle: &Circle<S>) -> f64 {
    (norm(point - S::vector(&circle.centre)) - circle.radius).abs()
}

/// Computes the distance of a point from a cylinder, m.
fn off_cylinder<S: Dimension>(point: S::Vector, cylinder: &Cylinder<S>) -> f64 {
    let (arm, axis) = (point - S::vector(&cylinder.point), S::vector(&cylinder.axis));
    let axis = axis * (1.0 / norm(axis));
    (norm(arm - axis * arm.times(&axis)) - cylinder.radius).abs()
}

/// Says how far the nearest boundary facet is from the circle, sphere or cylinder of a side.
fn nearest_to_round<S: Dimension>(mesh: &Mesh<S>, side: &SideCase<S>) -> Option<String> {
    let (round, off): (_, Box<dyn Fn(S::Vector) -> f64>) = match (side.circle, side.cylinder) {
        (Some(circle), _) => (S::CIRCLE, Box::new(move |p| off_circle::<S>(p, &circle))),
        (None, Some(cylinder)) => (CYLINDER, Box::new(move |p| off_cylinder::<S>(p, &cylinder))),
        (None, None) => return None,
    };
    let farther = |facet: &FacetId| mesh.facet_corners(*facet).into_iter().map(&off).fold(0.0, f64::max);
    let nearest = mesh.topology().boundary_facets().iter().map(farther).fold(f64::INFINITY, f64::min);
    let facet = S::WORDS.facet;
    Some(format!("the nearest boundary {facet} has {} {} off the {round}", S::CORNER, significant(nearest)))
}
