//! The certified bound, or with Coulomb friction the residual.

use serde::{Deserialize, Serialize};

/// A certified bound; [`Certificate::default`] is the one of a run that ended before there was any.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// True if all checks hold.
    pub valid: bool,
    /// Why it is not valid: `lift`, `pressure`, `rotation`, or the name of a check; `None` if it is, and without an estimate.
    #[serde(default)]
    pub reason: Option<String>,
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
    /// All parts of `e_cre`.
    pub parts: Parts,
    /// Relative difference between the pressure of the bound and the pressure of the nodal forces: the least change that balances the
    /// floating bodies.
    #[serde(default)]
    pub pressure_shift: Option<f64>,
    /// Loads that were left out: the bound is for the problem without them.
    #[serde(default)]
    pub projected_load: Vec<ProjectedLoad>,
    /// The mesh of this bound, from 1, if an adaptive run ended because its bound rose: it is the smallest. Else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallest_mesh: Option<usize>,
    /// The checks that make the bound valid.
    pub checks: Checks,
    /// Bounds of quantities of the exact solution, if the certificate is valid.
    pub bounds: Bounds,
}

/// A part of a load that turns a body along its contact, which resists only by the error of the polygon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProjectedLoad {
    /// The body's name.
    pub body: String,
    /// The motion in words.
    pub motion: String,
    /// The load along the motion, whose largest displacement is 1.
    pub load: f64,
    /// Over the sum of the sizes of its terms.
    pub share: f64,
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
    /// True if, in each pair with Coulomb friction, all slips have one sign.
    pub one_sign: bool,
    /// `e_b/√(1 − c²)`: an estimate of the error if the exact slip has the same sign; `None` unless [`Self::one_sign`], and if `c ≥ 0.9`.
    pub estimate: Option<f64>,
    /// That estimate relative to the energy norm of the computed solution.
    pub relative_estimate: Option<f64>,
    /// The same number as a bound of the distance to the solution with Tresca friction whose limit is the one in contact.csv; `None` on
    /// bent contact lines.
    pub frozen_bound: Option<f64>,
    /// The coupling `c` with the coefficients of friction: `c = μ κ` if they are equal.
    pub coupling: Option<f64>,
    /// Steps of the fixed point.
    pub steps: usize,
    /// The relative change of the limit of friction in the last step; `None` if there was one step.
    pub change: Option<f64>,
    /// How often limits that were too small were replaced by larger ones.
    pub restarts: usize,
    /// The checks of the stresses of the residual.
    pub checks: Checks,
}

/// Lower and upper bounds of quantities of the exact solution, both bodies together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// `√a(u, u)`, the energy norm.
    pub energy_norm: Option<[f64; 2]>,
    /// `½ a(u, u)` less the work of the loads, J/m.
    pub potential_energy: Option<[f64; 2]>,
    /// `∫ p ds` of all pairs, N/m.
    pub contact_force: Option<[f64; 2]>,
    /// Why there are no bounds of the contact force.
    #[serde(default)]
    pub contact_force_reason: Option<String>,
}

/// `discretisation² + algebraic² = e_cre²`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// The part of the mesh.
    pub discretisation: Option<f64>,
    /// The part of the iteration.
    pub algebraic: Option<f64>,
}

/// All parts of `e_cre`: the squares of all but `round_off` add up to `(e_cre − round_off)²`.
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
