//! `[[body]]`: mesh, material, supports and loads of one body.

use super::{CutCase, Dimension, MaterialRegion, Part, Rigid, SideCase, SpringCase, TemperatureCase, Value};
use fem_core::space::Plane;
use serde::Serialize;
use serde_json::{Value as Json, json};

/// `[[body]]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyCase<S: Dimension = Plane> {
    /// Its name, which also names its output files.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// Parts of other materials, in the file's order.
    pub regions: Vec<MaterialRegion<S>>,
    /// The source of its mesh.
    pub mesh: MeshSource<S>,
    /// Force per unit volume, in the plane per unit area and thickness, N/m³.
    pub body_force: S::Data<Value>,
    /// Changes of temperature in the file's order.
    pub temperatures: Vec<TemperatureCase>,
    /// Imposed displacements in the file's order.
    pub displacements: Vec<Displacement<S>>,
    /// Loads in the file's order.
    pub tractions: Vec<Traction<S>>,
    /// Sides by their place, in the file's order; then those that lists of names make.
    pub sides: Vec<SideCase<S>>,
    /// Rigid sides in the file's order.
    pub rigid: Vec<RigidCase<S>>,
    /// Springs in the file's order.
    pub springs: Vec<SpringCase<S>>,
    /// Cuts in the file's order.
    pub cuts: Vec<CutCase<S>>,
    /// Curved sides in the file's order.
    pub curves: Vec<CurveCase<S>>,
}

impl<S: Dimension> BodyCase<S> {
    /// Returns its name as the stem of a file name: letters, digits, `-`, `_` and `.` stay, anything else becomes `_`.
    /// The bodies of a [`super::Case`] have two, not only in case.
    pub fn file_stem(&self) -> String {
        file_stem(&self.name)
    }

    /// Returns the names of its materials: its own, then the materials of its regions.
    pub(super) fn material_names(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.material).chain(self.regions.iter().map(|region| &region.material))
    }
}

pub(super) fn file_stem(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// The source of a body's mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshSource<S: Dimension = Plane> {
    /// `generator = { kind = …, … }`.
    Generator(S::Generator),
    /// `mesh = { file = …, region = … }`: a region of a mesh file, see [`crate::Case::read_mesh_files`].
    File {
        /// The file, relative to the case file.
        file: String,
        /// The groups of cells; all cells if no name is given.
        region: Vec<String>,
        /// True if nodes at one place become one node.
        merge: bool,
        /// True if two bodies of one file may share nodes: each gets its own copy.
        duplicate_interface: bool,
        /// A side: only the connected parts of the region that have a facet of it.
        connected_to: Option<String>,
    },
}

impl<S: Dimension> MeshSource<S> {
    /// Returns the key of the case file with its value.
    pub(super) fn json(&self) -> (&'static str, Json) {
        match self {
            Self::Generator(generator) => ("generator", json!(generator)),
            Self::File { file, region, merge, duplicate_interface, connected_to } => {
                let mut mesh = json!({ "file": file });
                match &region[..] {
                    [] => {}
                    [name] => mesh["region"] = json!(name),
                    names => mesh["region"] = json!(names),
                }
                mesh["merge"] = json!(merge);
                mesh["duplicate_interface"] = json!(duplicate_interface);
                if let Some(side) = connected_to {
                    mesh["connected_to"] = json!(side);
                }
                ("mesh", mesh)
            }
        }
    }
}

impl<S: Dimension> Default for MeshSource<S> {
    fn default() -> Self {
        Self::Generator(S::Generator::default())
    }
}

/// The displacements that a `[[body.displacement]]` imposes.
#[derive(Clone, Debug)]
pub enum Imposition<S: Dimension = Plane> {
    /// `ux`, `uy`, `uz`: at least one of them.
    Components(S::Data<Option<Value>>),
    /// `normal`: the component along the outward normal.
    Normal(Value),
    /// `fixed = true`: all components are zero.
    Fixed,
}

impl<S: Dimension> Imposition<S> {
    /// Lists its data.
    pub(super) fn values_mut(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Components(components) => components.as_mut().iter_mut().flatten().collect(),
            Self::Normal(value) => vec![value],
            Self::Fixed => Vec::new(),
        }
    }
}

impl<S: Dimension> PartialEq for Imposition<S> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Components(a), Self::Components(b)) => a.as_ref() == b.as_ref(),
            (Self::Normal(a), Self::Normal(b)) => a == b,
            (Self::Fixed, Self::Fixed) => true,
            _ => false,
        }
    }
}

impl<S: Dimension> Serialize for Imposition<S> {
    fn serialize<Z: serde::Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        match self {
            Self::Components(components) => {
                let given = S::MOTIONS.iter().zip(components.as_ref()).filter(|(_, value)| value.is_some());
                serializer.collect_map(given)
            }
            Self::Normal(value) => serializer.collect_map([("normal", value)]),
            Self::Fixed => serializer.collect_map([("fixed", true)]),
        }
    }
}

/// `[[body.displacement]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
#[serde(bound = "")]
pub struct Displacement<S: Dimension = Plane> {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The side.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part<S>,
    /// The imposed displacements, m.
    #[serde(flatten)]
    pub imposition: Imposition<S>,
}

/// `[[body.rigid]]`: a side that stays rigid.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
#[serde(bound = "")]
pub struct RigidCase<S: Dimension = Plane> {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The side.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part<S>,
    /// Its motion, and its load.
    #[serde(flatten)]
    pub rigid: Rigid<S>,
}

/// `[[body.curve]]`: a side whose new nodes on finer meshes lie on a curve. `[[body.surface]]` of a solid: a side on a plane, a cylinder or a sphere.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
#[serde(bound = "")]
pub struct CurveCase<S: Dimension = Plane> {
    /// The side.
    pub on: String,
    /// Which curve or surface.
    #[serde(serialize_with = "curve_name::<S, _>")]
    pub kind: S::Curve,
}

/// The load of a `[[body.traction]]`.
#[derive(Clone, Debug)]
pub enum Load<S: Dimension = Plane> {
    /// `vector`: Cartesian components, Pa.
    Vector(S::Data<Value>),
    /// `pressure`: pushes onto the body, Pa.
    Pressure(Value),
}

impl<S: Dimension> PartialEq for Load<S> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Vector(a), Self::Vector(b)) => a.as_ref() == b.as_ref(),
            (Self::Pressure(a), Self::Pressure(b)) => a == b,
            _ => false,
        }
    }
}

impl<S: Dimension> Serialize for Load<S> {
    fn serialize<Z: serde::Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
        match self {
            Self::Vector(components) => serializer.collect_map([("vector", components.as_ref())]),
            Self::Pressure(value) => serializer.collect_map([("pressure", value)]),
        }
    }
}

impl<S: Dimension> Load<S> {
    /// Lists its data.
    pub(super) fn values_mut(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Vector(components) => components.as_mut().iter_mut().collect(),
            Self::Pressure(value) => vec![value],
        }
    }
}

/// `[[body.traction]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
#[serde(bound = "")]
pub struct Traction<S: Dimension = Plane> {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The side.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part<S>,
    /// The load.
    #[serde(flatten)]
    pub load: Load<S>,
}

/// Writes the word of a curve or a surface.
fn curve_name<S: Dimension, Z: serde::Serializer>(kind: &S::Curve, serializer: Z) -> Result<Z::Ok, Z::Error> {
    serializer.serialize_str(S::CURVES.iter().find(|(_, k)| k == kind).map_or("", |(name, _)| name))
}
