//! A case: everything a run is asked to do, typed, checked and with every default filled in.
//!
//! ```
//! use case_io::case::{Case, Method};
//! let text = case_io::template::PAPER;
//! let case = Case::parse(text, "paper.toml", &[("solver.method".into(), "newton".into())])?;
//! assert_eq!(case.solver.method, Method::Newton);
//! let (problem, _) = case.build()?;
//! assert_eq!((problem.nodes(), problem.node_pairs()), (380, 19));
//! # Ok::<(), case_io::CaseError>(())
//! ```

mod any;
mod body;
mod box_notes;
mod build;
mod choices;
mod conditions;
mod contact;
mod cuts;
mod data;
mod dimension;
mod fixes;
mod given;
mod inside;
mod matching;
mod materials;
mod mesh_files;
mod names;
mod pair_notes;
mod part;
mod path;
mod read;
mod read_adapt;
mod read_body;
mod read_contact;
mod regions;
mod settings;
mod side;
mod springs;
mod steps;
mod units;
mod warnings;

#[cfg(test)]
mod tests;

pub use crate::expression::Value;
pub use any::AnyCase;
pub use body::{BodyCase, CurveCase, Displacement, Imposition, Load, MeshSource, RigidCase, Traction};
pub use choices::{Acceleration, Criterion, Imposed, Method, QpChoice, Weights};
pub use contact::{CircleSide, Contact, Friction, Obstacle, Rigid, Shape};
pub use cuts::CutCase;
pub use dimension::{Dimension, Model, PlaneGenerator, Rows, SolidGenerator, SolidOrthotropic};
pub use given::{is_solid_generator, mesh_of_generator, solid_mesh_of_generator};
pub use inside::{Inertia, Rotation, TemperatureCase};
pub use matching::Notes;
pub use materials::{Material, MaterialLaw};
pub use part::Part;
pub use path::{Course, OutputPath};
pub use regions::{CellSelection, MaterialRegion};
pub use side::{Circle, Cylinder, SideCase};
pub use springs::{Along, Rest, SpringCase};
pub use steps::{Factors, StepCase};
pub use units::Units;

use crate::case_file::{self, At};
use crate::diagnostic::{CaseError, Diagnostic, SourcePosition, code, excerpt};
use fem_core::space::Plane;
use serde::Serialize;
use std::collections::BTreeMap;

/// The version of the case file that this crate reads.
pub const SCHEMA: u32 = 1;

/// A case as one case file and its overrides describe it, of the plane or of solids.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Case<S: Dimension = Plane> {
    /// The title that the user gives; empty by default.
    pub title: String,
    /// `[units]`, if the labels of results shall name them.
    pub units: Option<Units>,
    /// `[model]`.
    pub model: S::Model,
    /// `model.rotation` and `model.acceleration`, if there is one of them.
    pub inertia: Option<Inertia<S>>,
    /// `[materials.*]` in the file's order.
    pub materials: Vec<Material<S>>,
    /// `[[body]]` in the file's order, whichever body carries λ.
    pub bodies: Vec<BodyCase<S>>,
    /// `[[contact]]` in the file's order.
    pub contacts: Vec<Contact<S>>,
    /// `[solver]`.
    pub solver: Solver,
    /// `[estimator]`.
    pub estimator: Estimator,
    /// `[adapt]`, if an adaptive run is wanted.
    pub adapt: Option<Adapt>,
    /// `[[step]]` in the file's order; none: one step from rest.
    pub steps: Vec<StepCase>,
    /// `[output]`.
    pub output: Output,
    /// `[[output.path]]` in the file's order.
    pub paths: Vec<OutputPath<S>>,
    /// `[limits]`.
    pub limits: Limits,
    meshes: mesh_files::MeshFiles<S>,
    file_name: String,
    places: BTreeMap<String, At>,
}

/// `theta`: the relaxation parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Theta {
    /// Chosen by the solver.
    #[default]
    Auto,
    /// Given, > 0.
    #[serde(untagged)]
    Value(f64),
}

/// `subdomains`: into how many subdomains each body is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Subdomains {
    /// Chosen by the program: 1 if the factors of the bodies in one piece fit into memory.
    #[default]
    Auto,
    /// Given, ≥ 1.
    #[serde(untagged)]
    Count(usize),
}

impl Subdomains {
    /// Tells whether the program chooses.
    pub fn is_auto(&self) -> bool {
        *self == Self::Auto
    }
}

/// `[solver]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Solver {
    /// Which algorithm.
    pub method: Method,
    /// Into how many subdomains bodies are cut.
    #[serde(skip_serializing_if = "Subdomains::is_auto")]
    pub subdomains: Subdomains,
    /// Which body carries λ.
    pub imposed: Imposed,
    /// How the contact problem is solved.
    pub qp: QpChoice,
    /// Relaxation parameter.
    pub theta: Theta,
    /// Weights of the two corrections.
    pub weights: Weights,
    /// Convergence acceleration.
    pub acceleration: Acceleration,
    /// True if the iteration uses a coarse space for the floating bodies.
    pub coarse: bool,
    /// Initial normal displacement, m.
    pub lambda: Value,
    /// Iterations at most; 0 is allowed.
    pub max_iterations: usize,
    /// The fixed point of Coulomb friction ends if its limit changes by at most this part.
    pub friction_tolerance: f64,
    /// Steps of the fixed point at most.
    pub friction_steps: usize,
    /// `[solver.stop]`.
    pub stop: Stop,
}

/// `[solver.stop]`: when the iteration ends.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Stop {
    /// The quantity that is compared.
    pub criterion: Criterion,
    /// `η_NNDD ≤ ratio · η_dis`.
    pub ratio: f64,
    /// Also `|F₁ − F₂| ≤ force_balance · max(|F₁|, |F₂|)`, with the contact forces of the two bodies; `None`: only the ratio
    /// counts, the default if `ratio` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_balance: Option<f64>,
    /// Tolerance of the other criteria.
    pub tolerance: f64,
}

impl Default for Stop {
    fn default() -> Self {
        Self { criterion: Criterion::default(), ratio: 0.01, force_balance: Some(1e-3), tolerance: 1e-8 }
    }
}

/// `[estimator]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Estimator {
    /// Steps of star-patch relaxation after the equilibration, without [`Self::until`]; 0 is the equilibration alone.
    pub relaxation: usize,
    /// Instead of a fixed number of steps: relax until little is left to gain. The default.
    pub until: Option<RelaxUntil>,
    /// Iterations from one estimate to the next; 0: only when needed.
    pub every: usize,
}

/// `estimator.tolerance`, `estimator.max_steps`: relaxation as long as it is worthwhile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RelaxUntil {
    /// The smallest gain, relative, that further steps must still promise, in (0, 1).
    pub tolerance: f64,
    /// Steps at most.
    pub max_steps: usize,
}

/// `[adapt]`: an adaptive run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Adapt {
    /// The goal of the run.
    #[serde(flatten)]
    pub target: Target,
    /// Meshes at most.
    pub max_steps: usize,
    /// Nodes at most.
    pub max_nodes: usize,
    /// Share of the squared error that is refined, in (0, 1].
    pub fraction: f64,
}

/// The goal of an adaptive run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Target {
    /// `target_relative_error`: a certified relative error.
    #[serde(rename = "target_relative_error")]
    RelativeError(f64),
    /// `target_coulomb_residual`: with Coulomb friction a relative residual, which bounds no error.
    #[serde(rename = "target_coulomb_residual")]
    CoulombResidual(f64),
}

impl Target {
    /// Returns the number.
    pub fn value(self) -> f64 {
        match self {
            Self::RelativeError(value) | Self::CoulombResidual(value) => value,
        }
    }

    /// Returns the key of the case file.
    pub fn key(self) -> &'static str {
        match self {
            Self::RelativeError(_) => "target_relative_error",
            Self::CoulombResidual(_) => "target_coulomb_residual",
        }
    }
}

/// `[output]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Output {
    /// The directory of the results, relative to the working directory; see [`Case::output_directory`].
    pub directory: Option<String>,
    /// True if ParaView files are written.
    pub vtu: bool,
}

/// A limit as the user wrote it and as a number.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Limit<T> {
    /// As written, such as `4GiB`.
    pub written: String,
    /// In bytes or seconds.
    pub value: T,
}

/// `[limits]`: what a run may use; nothing is limited by default.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Limits {
    /// Memory, bytes.
    pub memory: Option<Limit<u64>>,
    /// Wall time, seconds.
    pub time: Option<Limit<f64>>,
}

impl Case {
    /// Reads a case file of the plane with the overrides of the command line, applied in their order; see [`AnyCase::parse`] for all
    /// cases.
    ///
    /// * `text`: the case file; a byte order mark and CRLF are accepted.
    /// * `file_name`: what messages call it.
    /// * `overrides`: dotted keys and TOML values, see [`case_file::split_override`].
    ///
    /// # Errors
    /// All independent faults together, each with its place; a case of solids.
    pub fn parse(text: &str, file_name: &str, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        AnyCase::parse(text, file_name, overrides)?.into_plane()
    }

    /// Reads a case file from its bytes, see [`Case::parse`].
    ///
    /// # Errors
    /// Bytes that are not UTF-8, and what [`Case::parse`] refuses.
    pub fn parse_bytes(
        bytes: &[u8],
        file_name: &str,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        Self::parse(case_file::decode(bytes, file_name)?, file_name, overrides)
    }
}

impl<S: Dimension> Case<S> {
    /// Returns the place of a key by its dotted path, `body.0.displacement.1.on`, or of the nearest table above it
    /// that is in the file.
    pub fn place(&self, path: &str) -> Option<SourcePosition> {
        let mut path = path;
        loop {
            if let Some(at) = self.places.get(path) {
                return Some(at.place());
            }
            path = path.rsplit_once('.').map_or("", |(above, _)| above);
            if path.is_empty() {
                return self.places.get("").map(At::place);
            }
        }
    }

    /// Says whether a key is in the file or in an override, rather than having its default.
    pub(crate) fn is_given(&self, path: &str) -> bool {
        self.places.contains_key(path)
    }

    /// Returns the number of the first pair with Coulomb friction.
    pub fn coulomb_pair(&self) -> Option<usize> {
        let is_coulomb = |contact: &Contact<S>| matches!(contact.friction, Some(Friction::Coulomb { .. }));
        self.contacts.iter().position(is_coulomb)
    }

    /// Refuses Coulomb friction, at the law of the pair that has it.
    ///
    /// * `what`: why; `fix`: what helps.
    ///
    /// # Errors
    /// A case with Coulomb friction.
    pub fn refuse_coulomb(&self, what: &str, fix: &str) -> Result<(), CaseError> {
        let Some(pair) = self.coulomb_pair().map(|pair| &self.contacts[pair]) else { return Ok(()) };
        let message = format!("{what}, and the pair {} has it", excerpt(&pair.name));
        let diagnostic = self.diagnostic(code::VALUE, &format!("{}.friction.law", pair.path), message);
        Err(diagnostic.expected("no pair with `law = \"coulomb\"`").fix(fix).into())
    }

    /// Returns the name that messages use for the case file.
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// Returns where results go: `output.directory`, or `runs/` and the name of the case file without its ending.
    pub fn output_directory(&self) -> String {
        let stem = || {
            let stem = std::path::Path::new(&self.file_name).file_stem();
            stem.map_or_else(|| "case".into(), |s| s.to_string_lossy().into_owned())
        };
        self.output.directory.clone().unwrap_or_else(|| format!("runs/{}", stem()))
    }

    /// Counts the nodes that the bodies' meshes will have, without making them; 0 for files that were not read.
    pub fn node_counts(&self) -> Vec<u64> {
        let count = |(k, body): (usize, &BodyCase<S>)| match &body.mesh {
            MeshSource::File { .. } => self.meshes.region(k).map_or(0, |r| r.node_numbers().len() as u64),
            MeshSource::Generator(generator) => S::nodes(generator),
        };
        self.bodies.iter().enumerate().map(count).collect()
    }

    fn diagnostic(&self, code: &'static str, path: &str, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(code, self.place(path), message)
    }
}
