//! A smooth exact field under a constant body force, in one body.
//!
//! ```text
//!    ┌──────── t ────────┐ 1      left: both displacements;  bottom: u_y and the shear traction;
//!  u │                   │ t      right and top: tractions;  constant body force b;
//!    └───── u_y, t_x ────┘        inner nodes moved by up to 0.06, so that no triangle is like the next
//!    0                  1.5
//! ```
//! Units: any consistent set. Exact: the field of `φ = e^z`, `ψ = (½i) e^z` ([`crate::goursat`]) and the
//! quadratic displacements of the stress `−diag(b_x x, b_y y)`, which carries b.

use crate::goursat::{Goursat, Potentials, multiply};
use crate::model::{
    Body, BoundaryConditions, Hypothesis, LinearElastic, Made, ScalarData, SymTensor2, Vector, block,
};
use crate::shapes::moved;
use std::f64::consts::PI;

/// Young's modulus and Poisson's ratio.
pub const MATERIAL: (f64, f64) = (5.0, 0.3);
/// The body force.
pub const BODY_FORCE: Vector = Vector::new(0.9, -2.4);

fn potentials(x: Vector) -> Potentials {
    let phi = [x[0].exp() * x[1].cos(), x[0].exp() * x[1].sin()];
    let psi = multiply([0.0, 0.5], phi);
    [phi, phi, phi, psi, psi]
}

/// The exact field.
#[derive(Clone, Copy, Debug)]
pub struct Smooth {
    field: Goursat,
    /// In-plane modulus and ratio.
    plane: (f64, f64),
}

impl Smooth {
    /// The field under a plane hypothesis.
    pub fn new(hypothesis: Hypothesis) -> Self {
        let (e, nu) = MATERIAL;
        let plane = match hypothesis {
            Hypothesis::PlaneStrain => (e / (1.0 - nu * nu), nu / (1.0 - nu)),
            Hypothesis::PlaneStress => (e, nu),
        };
        Self { field: Goursat::new(MATERIAL, hypothesis, potentials), plane }
    }

    /// Computes the stress.
    pub fn stress(&self, x: Vector) -> SymTensor2 {
        let carried = SymTensor2::new(-BODY_FORCE[0] * x[0], -BODY_FORCE[1] * x[1], 0.0);
        self.field.stress(x).plus(carried)
    }

    /// Computes the displacement.
    pub fn displacement(&self, p: Vector) -> Vector {
        let ([x, y], [bx, by], (e, nu)) = (p.into(), BODY_FORCE.into(), self.plane);
        let carried = Vector::new(
            (-0.5 * bx * (x * x + nu * y * y) + nu * by * x * y) / e,
            (-0.5 * by * (y * y + nu * x * x) + nu * bx * x * y) / e,
        );
        self.field.displacement(p) + carried
    }
}

/// The body on `3n × 2n` cells.
///
/// # Errors
/// None for `n ≥ 1`.
pub fn body(hypothesis: Hypothesis, n: usize) -> Made<Body> {
    let exact = Smooth::new(hypothesis);
    let mesh = moved(&block([0.0, 0.0], [1.5, 1.0], [3 * n, 2 * n])?, |x| {
        let bubble = 0.06 * (PI * x[0] / 1.5).sin() * (PI * x[1]).sin();
        Vector::new(x[0] + bubble * (3.0 * x[1]).cos(), x[1] - bubble * (4.0 * x[0]).sin())
    })?;
    let displacement = |c: usize| Some(ScalarData::function(move |x| exact.displacement(x)[c]));
    let traction = |n: Vector| [0, 1].map(|c| ScalarData::function(move |x| exact.stress(x).apply(n)[c]));
    let [shear, _] = traction(Vector::new(0.0, -1.0));
    let conditions = BoundaryConditions::new()
        .displace("left", displacement(0), displacement(1))
        .displace("bottom", None, displacement(1))
        .traction("bottom", [shear, 0.0.into()])
        .traction("right", traction(Vector::new(1.0, 0.0)))
        .traction("top", traction(Vector::new(0.0, 1.0)))
        .body_force(BODY_FORCE);
    Ok(Body::new(mesh, LinearElastic::isotropic(MATERIAL.0, MATERIAL.1, hypothesis)?, &conditions)?)
}
