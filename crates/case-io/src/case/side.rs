//! `[[body.side]]`: sides by their place, for meshes without named edges, and sides made of others.

use super::{Case, Part};
use crate::case_file::Reader;
use crate::diagnostic::{CaseError, code, did_you_mean, excerpt, significant};
use fem_core::geometry::{Vector, norm};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::FacetId;
use mesh_io::words::listed;
use serde::Serialize;
use std::collections::BTreeSet;

/// Default of `within`, degrees.
const WITHIN: f64 = 30.0;
/// Nodes are on a circle if they are closer to it than this fraction of its radius.
const ON_CIRCLE: f64 = 1e-3;

/// `[[body.side]]`: the boundary edges that satisfy all given conditions, or a single boundary node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SideCase {
    /// Its name, for `on` and `surfaces`.
    pub name: String,
    /// The sides that it is made of; empty: the whole boundary.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// `box`: both ends lie in it.
    #[serde(rename = "box", skip_serializing_if = "Part::is_all")]
    pub part: Part,
    /// The outward normal is within [`Self::within`] of this direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub facing: Option<[f64; 2]>,
    /// The largest angle between the two, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
    /// Both ends lie on this circle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circle: Option<Circle>,
    /// The boundary node at this place, m, and no edge: for a `[[body.displacement]]` with `ux`, `uy` or `fixed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 2]>,
}

/// `circle` of a side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Circle {
    /// Its centre, m.
    pub centre: [f64; 2],
    /// Its radius, m.
    pub radius: f64,
}

impl SideCase {
    /// Joins sides under one name.
    pub(super) fn union(names: Vec<String>) -> Self {
        Self { name: names.join(" + "), of: names, ..Self::default() }
    }
}

/// Tells if one of the names belongs to a single node.
pub(super) fn has_point(names: &[String], sides: &[SideCase]) -> bool {
    names.iter().any(|name| sides.iter().any(|side| side.name == *name && side.point.is_some()))
}

/// Returns the name of the only side, or of a side that several make.
pub(super) fn joined(mut names: Vec<String>, sides: &mut Vec<SideCase>) -> String {
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
pub(super) fn sides(r: &mut Reader<'_>) -> Vec<SideCase> {
    let mut found: Vec<SideCase> = Vec::new();
    for mut r in r.tables("side").unwrap_or_default() {
        let side = side(&mut r);
        if found.iter().any(|other| other.name == side.name) {
            let message = format!("two sides are called {}", excerpt(&side.name));
            r.refuse("name", message, "names that differ", "rename one of the two");
        }
        r.finish();
        found.push(side);
    }
    found
}

fn side(r: &mut Reader<'_>) -> SideCase {
    r.require(&["name"]);
    let name = r.string("name").unwrap_or_default();
    let part = Part::read(r, "box");
    let facing = r.pair("facing");
    if facing == Some([0.0; 2]) {
        let message = format!("`{}` has no direction", r.path_of("facing"));
        r.refuse("facing", message, "a direction", "write it as in `facing = [0.0, 1.0]`");
    }
    let within =
        r.number_where("within", |angle| angle > 0.0 && angle <= 90.0, "degrees, above 0 and at most 90");
    if within.is_some() && facing.is_none() {
        let expected = "`facing` beside it";
        r.refuse("within", "`within` is the angle about `facing`", expected, "add `facing = [0.0, 1.0]`");
    }
    let circle = r.table("circle").and_then(circle);
    let point = r.pair("point");
    let of_edges: Vec<&str> = ["box", "facing", "circle"].into_iter().filter(|key| r.has(key)).collect();
    if of_edges.is_empty() && !r.has("point") {
        let expected = "`box = { x = [low, high] }`, `facing = [0.0, 1.0]`, `circle = { centre, radius }`, or `point = [x, y]`";
        r.refuse("", "this side takes no edges", expected, "write `facing = [0.0, 1.0]`");
    }
    if let Some(key) = of_edges.first().filter(|_| r.has("point")) {
        let message = format!("`point` is a single node, and `{key}` takes edges");
        r.refuse("point", message, "one of the two", &format!("take `{key}` out"));
    }
    SideCase { name, of: Vec::new(), part, facing, within, circle, point }
}

fn circle(mut r: Reader<'_>) -> Option<Circle> {
    r.require(&["centre", "radius"]);
    let centre = r.pair("centre");
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    r.finish();
    Some(Circle { centre: centre?, radius: radius? })
}

impl Case {
    /// Adds the selected sides of a body to its mesh.
    ///
    /// # Errors
    /// Sides without edges, or with the name of another side of the mesh.
    pub(super) fn add_sides(&self, body: usize, mesh: &mut TriMesh) -> Result<(), CaseError> {
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
                    "body \"{}\": no boundary edge belongs to the side \"{}\"",
                    given.name, side.name
                );
                let fault = self.diagnostic(code::CONDITION, &path, message);
                let fault = fault.expected("a box, a direction or a circle with boundary edges");
                return Err(fault.help(nearest_to_circle(mesh, side)).fix("widen it").into());
            }
            mesh.add_group(&side.name, edges);
        }
        Ok(())
    }

    /// Joins the edges of sides.
    fn union(&self, body: usize, mesh: &TriMesh, side: &SideCase) -> Result<Vec<FacetId>, CaseError> {
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
fn select(mesh: &TriMesh, side: &SideCase) -> Vec<FacetId> {
    let inside = side.part.contains(mesh);
    let cosine = side.within.unwrap_or(WITHIN).to_radians().cos();
    let direction = side.facing.map(|d| {
        let d = Vector::from(d);
        1.0 / norm(d) * d
    });
    let on_circle = |point: Vector| {
        side.circle.is_none_or(|circle| off_circle(point, &circle) <= ON_CIRCLE * circle.radius)
    };
    let belongs = |edge: &FacetId| {
        let ends = mesh.facet_corners(*edge);
        ends.into_iter().all(|point| inside(point) && on_circle(point))
            && direction.is_none_or(|d| d.dot(&mesh.facet_normal(*edge)) >= cosine)
    };
    mesh.topology().boundary_facets().iter().copied().filter(belongs).collect()
}

/// Computes the distance of a point from a circle, m.
fn off_circle(point: Vector, circle: &Circle) -> f64 {
    (norm(point - Vector::from(circle.centre)) - circle.radius).abs()
}

/// Says how far the nearest boundary edge is from the circle of a side.
fn nearest_to_circle(mesh: &TriMesh, side: &SideCase) -> Option<String> {
    let circle = side.circle?;
    let farther = |edge: &FacetId| {
        mesh.facet_corners(*edge).map(|p| off_circle(p, &circle)).into_iter().fold(0.0, f64::max)
    };
    let nearest = mesh.topology().boundary_facets().iter().map(farther).fold(f64::INFINITY, f64::min);
    Some(format!("the nearest boundary edge has an end {} off the circle", significant(nearest)))
}
