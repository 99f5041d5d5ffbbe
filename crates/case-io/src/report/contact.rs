//! The contact interfaces of a report.

use super::Spin;
use serde::{Deserialize, Serialize};

/// A contact interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactSummary {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// `unilateral`, or `bonded`.
    #[serde(default)]
    pub law: String,
    /// `bodies`, or `obstacle` for a body and an obstacle.
    #[serde(default)]
    pub kind: String,
    /// Names of the bodies, in the order of the pair.
    pub bodies: Vec<String>,
    /// Name of the body that carries λ; empty if that is an obstacle.
    pub imposed: String,
    /// Number of node pairs.
    pub pairs: usize,
    /// What a contact line has.
    #[serde(flatten)]
    pub line: Option<ContactLine>,
    /// What a contact surface has.
    #[serde(flatten)]
    pub surface: Option<ContactSurface>,
    /// The force of the contact on the first body, N/m, of solids N.
    #[serde(default)]
    pub resultant: Option<Vec<f64>>,
    /// Its moment about the origin of the coordinates, N, of solids N·m, in the plane positive counter-clockwise.
    #[serde(default)]
    pub moment: Option<Spin>,
    /// The mean of the contact nodes weighted by their forces, m. On a straight line or a plane the resultant acts there.
    #[serde(default)]
    pub centre: Option<Vec<f64>>,
    /// The node of the first body with the largest pressure, m.
    #[serde(default)]
    pub max_pressure_at: Option<Vec<f64>>,
    /// `Σ r²_i`, N/m, of solids N.
    #[serde(default)]
    pub contact_force: Option<f64>,
    /// Largest nodal pressure, Pa.
    #[serde(default)]
    pub max_pressure: Option<f64>,
    /// Largest pressure recovered over the cells of the coarser side, Pa; left out if the nodes of both sides matched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_pressure_recovered: Option<f64>,
    /// Node pairs with a positive force.
    #[serde(default)]
    pub active: Option<usize>,
    /// Smallest opening, m.
    #[serde(default)]
    pub min_opening: Option<f64>,
    /// The largest mean normal traction of a facet of a bond, Pa; left out if the pair is not bonded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_tension: Option<f64>,
    /// Results of friction; left out without friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSummary>,
}

/// What a contact line of the plane has alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactLine {
    /// Length, m.
    pub length: f64,
    /// Stretches in contact, by arc length, m.
    pub contact_intervals: Option<Vec<[f64; 2]>>,
    /// The sum of their lengths, m.
    pub width: Option<f64>,
}

/// What a contact surface of solids has alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactSurface {
    /// The area in contact from both sides.
    pub area: SurfaceArea,
    /// The connected parts in contact.
    pub patches: Option<Vec<SurfacePatch>>,
}

/// The area in contact: it lies between `certain` and `possible`, and the mesh decides their difference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceArea {
    /// Faces that are closed at every node, m².
    pub certain: Option<f64>,
    /// Faces that are closed at one node at least, m².
    pub possible: Option<f64>,
    /// All faces, m².
    pub total: f64,
}

/// A connected part of a contact surface: closed nodes that faces join.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfacePatch {
    /// Its faces that are closed at every node, m².
    pub area: f64,
    /// The mean of its nodes weighted by their forces, m.
    pub centre: Vec<f64>,
    /// The force on the first body, N.
    pub force: Vec<f64>,
}

/// Friction along a contact interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionSummary {
    /// `tresca` or `coulomb`.
    pub law: String,
    /// The coefficient of Coulomb's law; left out with Tresca's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mu: Option<f64>,
    /// The force on the second body: along the tangent `(−n_y, n_x)`, with the normal `n` out of the first body, N/m; of solids its components, N. That
    /// on the first body is opposite.
    pub tangential_force: Spin,
    /// What stretches of a contact line do.
    #[serde(flatten)]
    pub line: Option<FrictionLine>,
    /// What parts of a contact surface do.
    #[serde(flatten)]
    pub surface: Option<FrictionSurface>,
    /// Largest slip, m.
    pub max_slip: f64,
}

/// Where a contact line of the plane sticks and slips.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionLine {
    /// Stretches in contact that stick, by arc length, m.
    pub stick_intervals: Vec<[f64; 2]>,
    /// Stretches in contact that slip, by arc length, m.
    pub slip_intervals: Vec<[f64; 2]>,
}

/// How much of a contact surface of solids sticks and slips: the areas that belong to its nodes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionSurface {
    /// Of nodes in contact that stick, m².
    pub stick_area: f64,
    /// Of nodes in contact that slip, m².
    pub slip_area: f64,
}

/// One stretch of the contact line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactStretch {
    /// Arc length of its first and last pair, m.
    pub s: [f64; 2],
    /// Number of pairs.
    pub pairs: usize,
    /// Length, m.
    pub length: f64,
    /// `Σ r²_i` on it, N/m.
    pub contact_force: f64,
    /// The force on the first body, N/m.
    #[serde(default)]
    pub resultant: [f64; 2],
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    #[serde(default)]
    pub moment: f64,
    /// Largest nodal pressure, Pa.
    pub max_pressure: f64,
    /// Largest mean pressure of an edge, Pa.
    pub max_edge_pressure: f64,
    /// Smallest opening, m.
    pub min_opening: f64,
}
