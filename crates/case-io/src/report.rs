//! `report.json`: what a run found, with the exact keys and their order. [`JSON_SCHEMA`] describes them for other programs.
//!
//! JSON has no NaN: serde_json would write `null` without a word. [`Report::to_json`] therefore refuses a number
//! that is not finite and names its place. If a value may be unknown its type is an [`Option`], written as `null`.

mod finite;
mod sweep;

pub(crate) use finite::{NotFinite, check as check_finite};
pub use sweep::{SWEEP_SCHEMA, SweepPanel, SweepReport, SweepRow};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

/// The version of report.json that this crate writes.
pub const SCHEMA: u32 = 1;

/// The JSON Schema (2020-12) of report.json, with the unit of each number as `x-unit`.
pub const JSON_SCHEMA: &str = include_str!("../report.schema.json");

/// The key of `run` under which the hash of the case is kept, see [`crate::Case::hash`].
pub const CASE_HASH: &str = "case_hash";

/// Why a report cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A number that is infinite or NaN: a defect of the program, never written.
    #[error("the report's {field} is {value}; only finite numbers are written")]
    NotFinite {
        /// Dotted path of the number.
        field: String,
        /// What was found.
        value: f64,
    },
    /// Not JSON, or not the keys of a report.
    #[error("this is not a report: {0}")]
    Json(#[from] serde_json::Error),
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// How the run ended.
    pub status: Status,
    /// Every setting with its value, see [`crate::Case::settings_json`].
    pub case: Value,
    /// The bodies in the file's order.
    pub bodies: Vec<BodySummary>,
    /// The contact interfaces.
    pub contact: Vec<ContactSummary>,
    /// One row per iteration.
    pub iterations: Vec<IterationRow>,
    /// The law that the run solved: `frictionless`, `tresca` or `coulomb`.
    #[serde(default)]
    pub problem: String,
    /// The bound of the last row; `None` with Coulomb friction, for which no bound is known.
    pub certificate: Option<Certificate>,
    /// What stands in its place with Coulomb friction; left out without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<Coulomb>,
    /// The numbers engineers ask for, of the last row.
    pub results: Results,
    /// One row per adaptive step; empty if the run was not adaptive.
    pub adaptive: Vec<AdaptiveRow>,
    /// The load steps that were solved, the last of which is the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepSummary>,
    /// What is worth knowing about how the case was read, such as cells that were split.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Wall times.
    pub timings: Timings,
    /// Host, threads, version, start, flags, the hash of the case; free of form.
    pub run: Map<String, Value>,
}

/// A load step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepSummary {
    /// Its number, from 1.
    pub step: usize,
    /// The factors of the named conditions at its end.
    pub factors: Map<String, Value>,
    /// How it ended.
    pub status: Status,
    /// The contact interfaces.
    pub contact: Vec<ContactSummary>,
    /// The numbers engineers ask for.
    pub results: Results,
    /// The bound of its increment; `None` with Coulomb friction.
    pub certificate: Option<Certificate>,
    /// What stands in its place with Coulomb friction; left out without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<Coulomb>,
}

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// One word, such as `converged`.
    pub word: String,
    /// The exit status.
    pub code: u8,
    /// Why, in a few words or as a comparison.
    pub reason: String,
}

/// The size of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodySummary {
    /// Its name.
    pub name: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Whether its supports leave a rigid motion free.
    #[serde(default)]
    pub floating: bool,
    /// Its part in the motions of the assembly that nothing resists and no load drives; they stay at zero.
    #[serde(default)]
    pub free_motions: Vec<FreeMotion>,
    /// Its rigid sides.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_sides: Vec<RigidSideSummary>,
}

/// The motion of a rigid side, and the force that moves it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RigidSideSummary {
    /// The edge group.
    pub on: String,
    /// `[ux, uy, rotation]`, m and radians, of the point `about`.
    pub motion: [f64; 3],
    /// Resultant on the body, N/m.
    pub force: [f64; 2],
    /// Moment about `about`, N.
    pub moment: f64,
    /// The point about which it rotates, m.
    pub about: [f64; 2],
}

/// The motion of one body: `u(x) = translation + rotation e_z × (x − centre)`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FreeMotion {
    /// Translation of the centre.
    pub translation: [f64; 2],
    /// Rotation, counter-clockwise, 1/m.
    pub rotation: f64,
    /// The centre, m.
    pub centre: [f64; 2],
}

/// A contact interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactSummary {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// `bodies`, or `obstacle` for a body and an obstacle.
    #[serde(default)]
    pub kind: String,
    /// Names of the bodies, in the order of the pair.
    pub bodies: Vec<String>,
    /// Name of the body that carries λ; empty if that is an obstacle.
    pub imposed: String,
    /// Number of node pairs.
    pub pairs: usize,
    /// Length, m.
    pub length: f64,
    /// The force of the contact on the first body, N/m.
    #[serde(default)]
    pub resultant: Option<[f64; 2]>,
    /// Its moment about the origin of the coordinates, N, positive counter-clockwise.
    #[serde(default)]
    pub moment: Option<f64>,
    /// The mean of the contact nodes weighted by their forces, m. On a straight line the resultant acts there.
    #[serde(default)]
    pub centre: Option<[f64; 2]>,
    /// The node of the first body with the largest pressure, m.
    #[serde(default)]
    pub max_pressure_at: Option<[f64; 2]>,
    /// `Σ r²_i`, N/m.
    #[serde(default)]
    pub contact_force: Option<f64>,
    /// Stretches in contact, by arc length, m.
    #[serde(default)]
    pub contact_intervals: Option<Vec<[f64; 2]>>,
    /// Largest nodal pressure, Pa.
    #[serde(default)]
    pub max_pressure: Option<f64>,
    /// Node pairs with a positive force.
    #[serde(default)]
    pub active: Option<usize>,
    /// Smallest opening, m.
    #[serde(default)]
    pub min_opening: Option<f64>,
    /// What friction does; left out without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSummary>,
}

/// Friction along a contact interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionSummary {
    /// `tresca` or `coulomb`.
    pub law: String,
    /// The coefficient of Coulomb's law; left out with Tresca's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mu: Option<f64>,
    /// The force along the tangent `(−n_y, n_x)`, with the normal `n` out of the first body: on the second body, N/m. That on the
    /// first one is opposite.
    pub tangential_force: f64,
    /// Stretches in contact that stick, by arc length, m.
    pub stick_intervals: Vec<[f64; 2]>,
    /// Stretches in contact that slip, by arc length, m.
    pub slip_intervals: Vec<[f64; 2]>,
    /// Largest slip, m.
    pub max_slip: f64,
}

/// One iteration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IterationRow {
    /// From 1.
    pub iteration: usize,
    /// θ of the update that follows; `None` for a method without θ.
    pub theta: Option<f64>,
    /// ε_t.
    pub precision: Option<f64>,
    /// η_NNDD.
    pub eta_nndd: Option<f64>,
    /// η_dis, if it was estimated.
    pub eta_dis: Option<f64>,
    /// The bound of the energy error, if it was estimated.
    pub e_cre: Option<f64>,
    /// Pairs with a positive force.
    pub contact_nodes: usize,
    /// `Σ r²_i`, N/m, if it is finite.
    pub contact_force: Option<f64>,
    /// The contact forces of both bodies in the file's order, N/m, positive in compression, if they are finite:
    /// equal at the discrete solution.
    pub contact_forces: [Option<f64>; 2],
    /// How the contact problem was solved.
    pub qp_path: Option<String>,
    /// Iterations of the contact problem.
    pub qp_iterations: usize,
}

/// A certified bound; [`Certificate::default`] is the one of a run that ended before there was any.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// Whether all checks hold.
    pub valid: bool,
    /// The problem that the bound is about: `frictionless` or `tresca`.
    #[serde(default)]
    pub problem: String,
    /// The bound of the energy error.
    pub e_cre: Option<f64>,
    /// Relative to the energy norm of the computed solution; `None` if the bodies hold no strain energy.
    pub relative: Option<f64>,
    /// A bound relative to the energy norm of the exact solution, if there is one.
    pub relative_guaranteed: Option<f64>,
    /// η_dis.
    pub eta_dis: Option<f64>,
    /// η_NNDD.
    pub eta_nndd: Option<f64>,
    /// The exact split of `e_cre`.
    pub split: Split,
    /// What `e_cre` is made of.
    pub parts: Parts,
    /// By how much the pressure of the bound differs from that of the nodal forces, relative: what the balance of the floating
    /// bodies takes.
    #[serde(default)]
    pub pressure_shift: Option<f64>,
    /// What makes the bound valid.
    pub checks: Checks,
    /// What the bound says about the exact solution, if it is valid.
    pub bounds: Bounds,
}

/// The residual of one solution with Coulomb friction: an indicator, and no bound of the error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coulomb {
    /// The residual; `None` if a check of its stresses failed.
    pub e_b: Option<f64>,
    /// Relative to the energy norm of the computed solution; `None` if the bodies hold no strain energy.
    pub relative: Option<f64>,
    /// The coupling between pressure and slip on the last mesh, without the coefficients of friction; `None` unless [`Self::one_sign`].
    pub kappa: Option<f64>,
    /// Whether all slips of each pair with Coulomb friction have one sign.
    pub one_sign: bool,
    /// `e_b/√(1 − c²)`: an estimate of the error if the exact slip has the same sign; `None` unless [`Self::one_sign`], and if `c ≥ 0.9`.
    pub estimate: Option<f64>,
    /// That estimate relative to the energy norm of the computed solution.
    pub relative_estimate: Option<f64>,
    /// The same number as a bound of the distance to the solution with the friction of Tresca whose limit is that of contact.csv; `None` on
    /// bent contact lines.
    pub frozen_bound: Option<f64>,
    /// The coupling `c` with the coefficients of friction: `c = μ κ` if they are equal.
    pub coupling: Option<f64>,
    /// Steps of the fixed point.
    pub steps: usize,
    /// The relative change of the limit of friction in the last step; `None` if there was one step.
    pub change: Option<f64>,
    /// How often limits that were too small were doubled.
    pub restarts: usize,
    /// What the stresses of the residual satisfy.
    pub checks: Checks,
}

/// Lower and upper bounds of quantities of the exact solution, both bodies together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// `√a(u, u)`, the energy norm.
    pub energy_norm: Option<[f64; 2]>,
    /// `½ a(u, u)` less the work of the loads, J/m.
    pub potential_energy: Option<[f64; 2]>,
    /// The whole contact force, N/m; `None` on an interface that bends.
    pub contact_force: Option<[f64; 2]>,
}

/// `discretisation² + algebraic² = e_cre²`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// The part of the mesh.
    pub discretisation: Option<f64>,
    /// The part of the iteration.
    pub algebraic: Option<f64>,
}

/// What `e_cre` is made of: the squares of all but `round_off` add up to `(e_cre − round_off)²`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parts {
    /// Of the mesh: `split.discretisation`.
    pub mesh: Option<f64>,
    /// Of the iteration, at most `eta_nndd`.
    pub iteration: Option<f64>,
    /// Of the contact law, which holds at the nodes only: what remains at the exact discrete solution.
    pub contact: Option<f64>,
    /// Of the lift on bent contact lines.
    pub lift: Option<f64>,
    /// Of gaps that bent edges cannot represent.
    pub gap_data: Option<f64>,
    /// Of friction.
    pub friction: Option<f64>,
    /// The allowance for round-off.
    pub round_off: Option<f64>,
}

/// Residuals of admissibility, relative to the largest force.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checks {
    /// Equilibrium in the triangles.
    pub equilibrium: Option<f64>,
    /// Tractions across edges.
    pub traction_jump: Option<f64>,
    /// Tractions on the boundary.
    pub boundary_traction: Option<f64>,
    /// Penetration.
    pub penetration: Option<f64>,
    /// Tension in the contact pressure.
    pub pressure_sign: Option<f64>,
    /// Rollers on curved sides, which the displacements violate between the nodes.
    #[serde(default)]
    pub supports: Option<f64>,
    /// Imposed displacements that the displacements miss, relative to the largest displacement of the body.
    #[serde(default)]
    pub imposed_displacement: Option<f64>,
    /// Forces and moments of the pressure and the loads on floating bodies, relative to the forces on them.
    #[serde(default)]
    pub rigid_balance: Option<f64>,
    /// The largest rigid rotation of a floating body, radians; up to 0.1 displacements are small.
    #[serde(default)]
    pub rotation: Option<f64>,
    /// Friction beyond its limit, relative to the largest limit.
    #[serde(default)]
    pub friction_cone: Option<f64>,
}

impl Checks {
    /// Lists the residuals by their keys, in their order.
    pub fn named(&self) -> [(&'static str, Option<f64>); 10] {
        [
            ("equilibrium", self.equilibrium),
            ("traction_jump", self.traction_jump),
            ("boundary_traction", self.boundary_traction),
            ("penetration", self.penetration),
            ("pressure_sign", self.pressure_sign),
            ("supports", self.supports),
            ("imposed_displacement", self.imposed_displacement),
            ("rigid_balance", self.rigid_balance),
            ("rotation", self.rotation),
            ("friction_cone", self.friction_cone),
        ]
    }
}

/// The numbers engineers ask for; [`Results::default`] is those of a run that ended before there were any: an
/// empty list is a result, `null` means that there is no result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// `a(u, u)` of each body.
    pub energy_norm_squared: Option<Vec<f64>>,
    /// `Σ r²_i`, N/m.
    pub contact_force: Option<f64>,
    /// Stretches in contact, by arc length, m.
    pub contact_intervals: Option<Vec<[f64; 2]>>,
    /// Each stretch of the contact line.
    #[serde(default)]
    pub contact_stretches: Option<Vec<ContactStretch>>,
    /// Largest nodal pressure, Pa: the largest of contact.csv.
    pub max_pressure: Option<f64>,
    /// Largest mean pressure of an interface edge, Pa.
    pub max_edge_pressure: Option<f64>,
    /// Smallest opening, m: the smallest of contact.csv.
    pub min_opening: Option<f64>,
    /// Reaction of each support.
    pub reactions: Option<Vec<Reaction>>,
    /// All forces on each body added up, in the file's order: fx, fy in N/m and their moment about the body's centroid
    /// in N; zero to round-off.
    pub balance: Option<Vec<[f64; 3]>>,
    /// Largest displacement, m.
    pub max_displacement: Option<f64>,
    /// Largest equivalent stress of a cell, Pa: that of the displacements.
    pub max_von_mises: Option<f64>,
    /// Largest equivalent stress of the recovered stress.
    #[serde(default)]
    pub peak_stress: Option<PeakStress>,
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
    /// Its change from the mesh before to the last one, over the former; `None` if there is one mesh.
    pub change: Option<f64>,
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

/// The reaction of one support, N/m.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Name of the body.
    pub body: String,
    /// The edge group.
    pub on: String,
    /// First component.
    pub fx: f64,
    /// Second component.
    pub fy: f64,
}

/// One adaptive step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveRow {
    /// From 1.
    pub step: usize,
    /// Nodes of both bodies.
    pub nodes: usize,
    /// Node pairs on the interface.
    pub pairs: usize,
    /// The bound; `None` with Coulomb friction.
    pub e_cre: Option<f64>,
    /// The bound relative to the energy norm.
    pub relative: Option<f64>,
    /// With Coulomb friction the residual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_b: Option<f64>,
    /// The residual relative to the energy norm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_residual: Option<f64>,
    /// Iterations of this step; with Coulomb friction the steps of the fixed point.
    pub iterations: usize,
    /// `a(u, u)` of both bodies.
    pub energy_norm_squared: f64,
    /// Largest equivalent stress of the recovered stress, Pa.
    #[serde(default)]
    pub peak_stress: Option<f64>,
}

/// Disjoint wall times that add up to `total`, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    /// Reading or generating meshes.
    pub mesh: f64,
    /// Pattern, stiffness and loads.
    pub assembly: f64,
    /// Ordering, symbolic and numeric factorisation, interface operators.
    pub factorisation: f64,
    /// The loop, contact problems, recovery of displacements.
    pub iterations: f64,
    /// Everything for certificates.
    pub estimate: f64,
    /// Writing files.
    pub write: f64,
    /// All of it.
    pub total: f64,
}

impl Report {
    /// Writes the report as JSON, indented, with a line break at its end.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<String, ReportError> {
        to_json(self)
    }

    /// Reads a report.
    ///
    /// # Errors
    /// Not JSON, or not a report.
    pub fn from_json(text: &str) -> Result<Self, ReportError> {
        Ok(serde_json::from_str(text)?)
    }

    /// Returns the certificate, if there is one and its checks hold.
    pub fn valid_certificate(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|certificate| certificate.valid)
    }

    /// Returns the hash of the case, if the report carries one.
    pub fn case_hash(&self) -> Option<&str> {
        self.run.get(CASE_HASH)?.as_str()
    }
}

/// Writes JSON whose numbers are all finite, indented, with a line break at its end.
fn to_json<T: Serialize>(value: &T) -> Result<String, ReportError> {
    check_finite(value).map_err(|fault| ReportError::NotFinite { field: fault.field, value: fault.value })?;
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    Ok(text)
}

#[cfg(test)]
pub(crate) mod tests;
