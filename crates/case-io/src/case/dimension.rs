//! What cases of the plane and of solids have of their own: their words in the case file, generators, materials and pairing.
//!
//! All else is written once, for a [`Dimension`].

mod plane;
mod solid;

use super::{Case, CurveCase, RelaxUntil, Units};
use crate::case_file::{MatrixWords, Reader};
use crate::diagnostic::CaseError;
use crate::report;
use contact_geometry::{Contact, ContactNormal, Paired, PairingError};
use fem_core::body::{Body, BodyError, Difference};
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{LinearElastic, MaterialError};
use fem_core::mesh::{Mesh, MeshError};
use fem_core::space::Space;
use mesh_io::{MeshFile, MeshFileError, Region, RegionOptions};
use serde::Serialize;
use serde_json::Value as Json;
use std::fmt::Debug;

pub use plane::{Model, PlaneGenerator};
pub use solid::{SolidGenerator, SolidOrthotropic};

/// A stiffness by its rows.
pub type Rows<S> = <S as Space>::Components<<S as Space>::Components<f64>>;

/// The space of a case: [`fem_core::space::Plane`] or [`fem_core::space::Solid`].
pub trait Dimension: Space {
    /// `[model]`.
    type Model: Copy + Debug + PartialEq + Send + Sync;
    /// The meshes that need no file.
    type Generator: Clone + Debug + Default + PartialEq + Serialize + Send + Sync;
    /// The constants of an orthotropic material, angles in degrees.
    type Orthotropic: Copy + Debug + PartialEq + Send + Sync;
    /// The kinds of declared curves or surfaces.
    type Curve: Copy + Debug + PartialEq + Send + Sync + 'static;

    /// The table of a body that declares a curve or a surface.
    const CURVE_TABLE: &'static str;
    /// The kinds of declared curves or surfaces by their words.
    const CURVES: &'static [(&'static str, Self::Curve)];
    /// How far stresses are relaxed by default.
    const RELAX_UNTIL: RelaxUntil;
    /// The names of the coordinates.
    const COORDINATES: &'static [&'static str];
    /// The word for a corner of a facet.
    const CORNER: &'static str;
    /// The word for the measure of a facet.
    const EXTENT: &'static str;
    /// Where data are linear.
    const ALONG: &'static str;
    /// The word for the points at one distance from another.
    const CIRCLE: &'static str;
    /// Whether obstacles may be cylinders.
    const CYLINDERS: bool;

    /// Returns `[model]` as the case file has it.
    fn model_json(model: &Self::Model) -> Json;
    /// Makes an isotropic material.
    ///
    /// # Errors
    /// Constants that fem-core refuses.
    fn isotropic(young: f64, poisson: f64, model: &Self::Model)
    -> Result<LinearElastic<Self>, MaterialError>;
    /// Makes an orthotropic material.
    ///
    /// # Errors
    /// Constants that fem-core refuses.
    fn orthotropic(
        constants: &Self::Orthotropic,
        model: &Self::Model,
    ) -> Result<LinearElastic<Self>, MaterialError>;
    /// Makes a material of its stiffness, Pa.
    ///
    /// # Errors
    /// A matrix that fem-core refuses.
    fn of_stiffness(rows: &Rows<Self>, model: &Self::Model) -> Result<LinearElastic<Self>, MaterialError>;
    /// Returns the constants as the case file has them.
    fn orthotropic_json(constants: &Self::Orthotropic) -> Json;
    /// Returns the moduli along the axes 1, 2 and, in space, 3, Pa.
    fn moduli(constants: &Self::Orthotropic) -> Self::Axes<f64>;
    /// Describes constants or a stiffness in a few words.
    ///
    /// * `constants`: `None` of a stiffness.
    fn material_words(constants: Option<&Self::Orthotropic>) -> String;

    /// Makes the mesh of a generator.
    ///
    /// # Errors
    /// A shape that makes no mesh.
    fn generated(generator: &Self::Generator) -> Result<Mesh<Self>, MeshError>;
    /// Counts the nodes that the mesh will have.
    fn nodes(generator: &Self::Generator) -> u64;
    /// Takes a region of a mesh file.
    ///
    /// # Errors
    /// A file without such cells, groups that are not there.
    fn region(mesh: &MeshFile, names: &[&str], options: RegionOptions)
    -> Result<Region<Self>, MeshFileError>;
    /// Says that no side of a region has a name.
    fn without_sides(region: &Region<Self>) -> Option<MeshFileError>;
    /// Puts data along sides if a program gave data at nodes.
    ///
    /// # Errors
    /// Data with another number of values than there are nodes; in space all such data.
    fn evaluate_given(case: &mut Case<Self>) -> Result<(), CaseError>;
    /// Declares the curves or surfaces of a body.
    ///
    /// # Errors
    /// Sides that do not lie on one.
    fn curved(body: Body<Self>, sides: &[CurveCase<Self>]) -> Result<Body<Self>, BodyError>;

    /// Pairs the sides of bodies.
    ///
    /// # Errors
    /// Surfaces that cannot be paired.
    fn pair(bodies: Vec<Body<Self>>, contacts: &[Contact<Self>]) -> Result<Paired<Self>, PairingError>;
    /// Tells whether two sides can be paired.
    fn fits(bodies: [&Body<Self>; 2], sides: [&str; 2], gap: &Gap<Self>, normal: ContactNormal<Self>)
    -> bool;
    /// Says what the meshes make of boxes and contact surfaces.
    fn notes(case: &Case<Self>, paired: &Paired<Self>) -> Vec<String>;

    /// Says where stresses are not known.
    fn stress_notes(case: &Case<Self>) -> Vec<String>;
    /// Measures for each pair the difference between the initial gap and the one on the contact facets, relative to its largest value;
    /// `None` if the two are equal to round-off.
    fn interpolated_gaps(problem: &ContactProblem<Self>) -> Vec<Option<Difference>>;

    /// Returns the number of cells of a mesh as report.json has it.
    fn cells_written(count: usize) -> report::CellCount;

    /// Returns a rotation or a moment as report.json has it.
    fn spin_written(spin: Self::Spin) -> report::Spin;

    /// Returns the thickness of the bodies, m; `None` of solids, which have none.
    fn thickness(model: &Self::Model) -> Option<f64>;
    /// Names the unit of the measure of facets.
    fn extent_unit(units: &Units) -> String;
    /// Names the unit of forces, in the plane per unit thickness.
    fn force_unit(units: &Units) -> String;
    /// Names the unit of moments and energies, in the plane per unit thickness.
    fn moment_unit(units: &Units) -> String;

    /// Makes a vector of its components.
    fn vector(components: &Self::Axes<f64>) -> Self::Vector {
        use fem_core::geometry::Coordinates;
        Self::Vector::of(|c| components[c])
    }
}

/// The reader of a generator.
pub(crate) type GeneratorReader<S> = fn(Reader<'_>) -> Option<<S as Dimension>::Generator>;

/// A key, or a word of it, that cases of one space do not have.
pub(crate) struct Refused {
    /// The table and the key: `body.curve`.
    pub(super) key: &'static str,
    /// The word that is refused; `None`: the key is, whatever its value.
    pub(super) word: Option<&'static str>,
    /// Why.
    pub(super) why: &'static str,
    /// What is there instead.
    pub(super) expected: &'static str,
    /// What helps.
    pub(super) fix: &'static str,
}

/// The keys of the case file in one space.
pub(crate) trait Keys: Dimension {
    /// The generators by their kinds.
    const GENERATORS: &'static [(&'static str, GeneratorReader<Self>)];
    /// What a body without a mesh should have, and a generator to begin with.
    const MESH: [&'static str; 2];
    /// The keys of orthotropic constants.
    const CONSTANTS: &'static [&'static str];
    /// The kinds of materials.
    const MATERIALS: &'static str;
    /// The words for a stiffness.
    const STIFFNESS: MatrixWords;
    /// The key of the direction of contact: of normals in the plane, along which surfaces are laid over each other in space.
    const DIRECTION: &'static str;
    /// What is refused.
    const REFUSED: &'static [Refused];

    /// Reads `[model]`.
    fn model(reader: Option<&mut Reader<'_>>) -> Self::Model;
    /// Reads orthotropic constants.
    fn constants(r: &mut Reader<'_>, model: &Self::Model) -> Option<Self::Orthotropic>;
    /// Reads a rotation or a moment.
    fn spin(r: &mut Reader<'_>, key: &'static str) -> Option<Self::Spin>;
}

/// Refuses the keys and words of a table that cases of this space do not have; true if there are any.
///
/// * `table`: the kind of table, `body` or `obstacle`.
pub(super) fn refuse_foreign<S: Keys>(r: &mut Reader<'_>, table: &str) -> bool {
    let mut any = false;
    for refused in S::REFUSED {
        let Some(key) = refused.key.strip_prefix(table).and_then(|key| key.strip_prefix('.')) else {
            continue;
        };
        let is_there = match refused.word {
            Some(word) => r.word(key) == Some(word),
            None => r.has(key),
        };
        if is_there {
            r.node(key);
            r.refuse(key, format!("`{}`: {}", r.path_of(key), refused.why), refused.expected, refused.fix);
            any = true;
        }
    }
    any
}
