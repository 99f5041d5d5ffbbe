//! `[[body]]`: mesh, material, supports and loads of one body.

use super::{MaterialRegion, Part, Rigid, SideCase, Value};
use fem_core::body::CurveKind;
use fem_core::mesh::generate::Facing;
use serde::Serialize;

/// `[[body]]`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BodyCase {
    /// Its name, which also names its output files.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// Parts of other materials, in the file's order.
    pub regions: Vec<MaterialRegion>,
    /// The source of its mesh.
    pub mesh: MeshSource,
    /// Force per unit area and thickness, N/m³.
    pub body_force: [f64; 2],
    /// Imposed displacements in the file's order.
    pub displacements: Vec<Displacement>,
    /// Loads in the file's order.
    pub tractions: Vec<Traction>,
    /// Sides by their place, in the file's order; then those that lists of names make.
    pub sides: Vec<SideCase>,
    /// Rigid sides in the file's order.
    pub rigid: Vec<RigidCase>,
    /// Curved sides in the file's order.
    pub curves: Vec<CurveCase>,
}

impl BodyCase {
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
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum MeshSource {
    /// `generator = { kind = "block", … }`: a structured rectangle.
    Block {
        /// Lower left corner, m.
        origin: [f64; 2],
        /// Width and height, m.
        size: [f64; 2],
        /// Rectangles in each direction; each is cut in two triangles.
        cells: [usize; 2],
    },
    /// `generator = { kind = "ring", … }`: a ring or a sector of one, see [`fem_core::mesh::generate::ring()`].
    Ring {
        /// Centre, m.
        centre: [f64; 2],
        /// Inner and outer radius, m.
        radii: [f64; 2],
        /// Start and end, degrees.
        angles: [f64; 2],
        /// Cells around and across.
        cells: [usize; 2],
    },
    /// `generator = { kind = "disc", … }`: a full disc, see [`fem_core::mesh::generate::disc()`].
    Disc {
        /// Centre, m.
        centre: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// Cells from the centre to the rim, which has six times as many edges.
        cells: usize,
        /// Direction of the first node of the rim, degrees.
        start: f64,
    },
    /// `generator = { kind = "half_disc", … }`: fine near its pole, see [`fem_core::mesh::generate::half_disc()`].
    HalfDisc {
        /// The middle of the arc, m.
        pole: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// The side of the disc on which its pole lies.
        #[serde(serialize_with = "super::read_body::facing_name")]
        facing: Facing,
        /// Half the width of the side `contact`, m.
        half_width: f64,
        /// Cells from the pole to the end of `contact`.
        cells: usize,
    },
    /// `mesh = { file = …, region = … }`: a region of a mesh file, see [`crate::Case::read_mesh_files`].
    File {
        /// The file, relative to the case file.
        file: String,
        /// The groups of cells; all cells if no name is given.
        #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "one_or_list")]
        region: Vec<String>,
        /// True if nodes at one place become one node.
        merge: bool,
        /// True if two bodies of one file may share nodes: each gets its own copy.
        duplicate_interface: bool,
    },
}

/// Writes one name as it is, several as a list.
fn one_or_list<S: serde::Serializer>(names: &[String], serializer: S) -> Result<S::Ok, S::Error> {
    match names {
        [name] => name.serialize(serializer),
        names => names.serialize(serializer),
    }
}

impl Default for MeshSource {
    fn default() -> Self {
        Self::Block { origin: [0.0; 2], size: [1.0; 2], cells: [1; 2] }
    }
}

/// The displacements that a `[[body.displacement]]` imposes.
#[derive(Clone, Debug, PartialEq)]
pub enum Imposition {
    /// `ux`, `uy`: at least one of the two.
    Components([Option<Value>; 2]),
    /// `normal`: the component along the outward normal.
    Normal(Value),
    /// `fixed = true`: both components are zero.
    Fixed,
}

impl Imposition {
    /// Lists its data.
    pub(super) fn values_mut(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Components(components) => components.iter_mut().flatten().collect(),
            Self::Normal(value) => vec![value],
            Self::Fixed => Vec::new(),
        }
    }
}

impl Serialize for Imposition {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Components(components) => {
                let given = ["ux", "uy"].into_iter().zip(components).filter(|(_, value)| value.is_some());
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
pub struct Displacement {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The edge group.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part,
    /// The imposed displacements, m.
    #[serde(flatten)]
    pub imposition: Imposition,
}

/// `[[body.rigid]]`: a side that stays rigid.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RigidCase {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The edge group.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part,
    /// Its motion, and its load.
    #[serde(flatten)]
    pub rigid: Rigid,
}

/// `[[body.curve]]`: a side whose new nodes on finer meshes lie on a curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CurveCase {
    /// The edge group.
    pub on: String,
    /// Which curve.
    #[serde(serialize_with = "super::read_body::curve_name")]
    pub kind: CurveKind,
}

/// The load of a `[[body.traction]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// `vector`: Cartesian components, Pa.
    Vector([Value; 2]),
    /// `pressure`: pushes onto the body, Pa.
    Pressure(Value),
}

impl Load {
    /// Lists its data.
    pub(super) fn values_mut(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Vector(components) => components.iter_mut().collect(),
            Self::Pressure(value) => vec![value],
        }
    }
}

/// `[[body.traction]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Traction {
    /// Its name for load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The edge group.
    pub on: String,
    /// The part of it.
    #[serde(skip_serializing_if = "Part::is_all")]
    pub part: Part,
    /// The load.
    #[serde(flatten)]
    pub load: Load,
}
