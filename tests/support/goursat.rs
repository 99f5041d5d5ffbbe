//! Plane fields without body force from two analytic functions.
//!
//! `σ_xx + σ_yy = 4 Re φ'`, `σ_yy − σ_xx + 2i σ_xy = 2 (z̄ φ'' + ψ')`,
//! `2µ (u_x + i u_y) = κ φ − z φ̄' − ψ̄`, `z = x + iy`, κ = 3 − 4ν in plane strain and (3 − ν)/(1 + ν) in plane
//! stress. Source: Kolosov and Muskhelishvili; any φ, ψ satisfy equilibrium and compatibility exactly.

use crate::model::{Hypothesis, SymTensor2, Vector};

/// A complex number.
pub type Complex = [f64; 2];

/// `φ, φ', φ'', ψ, ψ'` at a point.
pub type Potentials = [Complex; 5];

/// Multiplies two complex numbers.
pub fn multiply(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// A field by its potentials, in a given material.
#[derive(Clone, Copy, Debug)]
pub struct Goursat {
    shear_modulus: f64,
    kappa: f64,
    potentials: fn(Vector) -> Potentials,
}

impl Goursat {
    /// Makes the field of the potentials in a material (E, ν).
    pub fn new(
        (young, poisson): (f64, f64),
        hypothesis: Hypothesis,
        potentials: fn(Vector) -> Potentials,
    ) -> Self {
        let kappa = match hypothesis {
            Hypothesis::PlaneStrain => 3.0 - 4.0 * poisson,
            Hypothesis::PlaneStress => (3.0 - poisson) / (1.0 + poisson),
        };
        Self { shear_modulus: young / (2.0 * (1.0 + poisson)), kappa, potentials }
    }

    /// Computes the stress.
    pub fn stress(&self, x: Vector) -> SymTensor2 {
        let [_, slope, curvature, _, psi_slope] = (self.potentials)(x);
        let product = multiply([x[0], -x[1]], curvature);
        let trace = 4.0 * slope[0];
        let difference = [2.0 * (product[0] + psi_slope[0]), 2.0 * (product[1] + psi_slope[1])];
        SymTensor2::new(0.5 * (trace - difference[0]), 0.5 * (trace + difference[0]), 0.5 * difference[1])
    }

    /// Computes the displacement.
    pub fn displacement(&self, x: Vector) -> Vector {
        let [phi, slope, _, psi, _] = (self.potentials)(x);
        let product = multiply(x.into(), [slope[0], -slope[1]]);
        Vector::new(
            (self.kappa * phi[0] - product[0] - psi[0]) / (2.0 * self.shear_modulus),
            (self.kappa * phi[1] - product[1] + psi[1]) / (2.0 * self.shear_modulus),
        )
    }
}
