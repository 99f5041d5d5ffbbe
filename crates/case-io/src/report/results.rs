//! The numbers engineers ask for.

use super::ContactStretch;
use serde::{Deserialize, Serialize};

/// The numbers engineers ask for. [`Results::default`] belongs to a run that ended before it had any: an empty list is a result, `null`
/// means that there is no result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// `a(u, u)` of each body; springs have no part in it.
    pub energy_norm_squared: Option<Vec<f64>>,
    /// `Σ r²_i`, N/m, of solids N.
    pub contact_force: Option<f64>,
    /// What contact lines have alone; left out of solids.
    #[serde(flatten)]
    pub lines: Option<LineResults>,
    /// Largest nodal pressure, Pa: the largest of contact.csv.
    pub max_pressure: Option<f64>,
    /// Largest pressure of all pairs, Pa: recovered over the cells of the coarser side on those whose nodes did not match; left out if all matched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_pressure_recovered: Option<f64>,
    /// Largest mean pressure of a facet of the interface, Pa.
    pub max_edge_pressure: Option<f64>,
    /// Smallest opening, m: the smallest of contact.csv.
    pub min_opening: Option<f64>,
    /// Reaction of each support.
    pub reactions: Option<Vec<Reaction>>,
    /// Force of the springs of each `[[body.spring]]` on its body; left out without springs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub springs: Option<Vec<Reaction>>,
    /// Force and shortening of each `[[body.cut]]`; left out without cuts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cuts: Option<Vec<CutResult>>,
    /// All forces on each body added up, in the file's order: their components in N/m, of solids N, and their moment about the body's
    /// centroid in N, of solids N·m; zero to round-off.
    pub balance: Option<Vec<Vec<f64>>>,
    /// Largest displacement, m.
    pub max_displacement: Option<f64>,
    /// Largest equivalent stress of a cell, from the displacements, Pa.
    pub max_von_mises: Option<f64>,
    /// Largest equivalent stress of the recovered stress.
    #[serde(default)]
    pub peak_stress: Option<PeakStress>,
    /// Extreme principal stresses of the recovered stress; in the plane those in the plane.
    #[serde(default)]
    pub principal_stress: Option<PrincipalStresses>,
    /// The largest recovered stress of each material with a limit, as far as it is known; left out without limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress_limits: Option<Vec<StressLimit>>,
}

/// The largest equivalent stress of a material beside its limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StressLimit {
    /// Name of the material.
    pub material: String,
    /// Its limit, Pa.
    pub limit: f64,
    /// The largest equivalent stress of its recovered stress, Pa.
    pub von_mises: f64,
    /// That stress over the limit.
    pub share: f64,
    /// Name of the body.
    pub body: String,
    /// First coordinate of the node, m.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate; left out in the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
}

/// The smallest and the largest principal stress of the recovered stress.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PrincipalStresses {
    /// The smallest one: the largest compression, if negative.
    pub smallest: PrincipalStress,
    /// The largest one: the largest tension, if positive.
    pub largest: PrincipalStress,
}

/// A principal stress, and its place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PrincipalStress {
    /// The stress, Pa, tension positive.
    pub value: f64,
    /// Name of the body.
    pub body: String,
    /// First coordinate of the node, m.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate; left out in the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
}

/// The results of contact lines.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LineResults {
    /// Stretches in contact, by arc length, m.
    pub contact_intervals: Option<Vec<[f64; 2]>>,
    /// Each stretch of the contact line.
    #[serde(default)]
    pub contact_stretches: Option<Vec<ContactStretch>>,
}

/// The largest equivalent stress of the recovered stress, and its place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PeakStress {
    /// The stress, Pa.
    pub von_mises: f64,
    /// Name of the body.
    pub body: String,
    /// First coordinate of the node, m.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate; left out in the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Its change from the mesh before to the last one, over the former; `None` if there is one mesh.
    pub change: Option<f64>,
}

/// The force and the shortening of a cut.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutResult {
    /// Its name.
    pub name: String,
    /// Its force, N/m, of solids N; it pulls if it is positive.
    pub force: f64,
    /// Its shortening, m.
    pub shortening: f64,
}

/// The reaction of one support, or the force of springs, N/m, of solids N.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Name of the body.
    pub body: String,
    /// The group of facets.
    pub on: String,
    /// First component.
    pub fx: f64,
    /// Second component.
    pub fy: f64,
    /// Third component; left out in the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fz: Option<f64>,
}
