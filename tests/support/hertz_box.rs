//! Hertz' contact of two bodies of any materials in finite boxes, solved exactly.
//!
//! ```text
//!   -3        0        3
//!    ┌─────────────────┐ 3     exact displacements on top and bottom, exact tractions on the lateral sides
//!    │       Ω₁        │
//!    ├ open ┬─────┬────┤ 0     Γ_C: y = 0, gap x²/(2R); contact for |x| < 1
//!    │       Ω₂        │
//!    └─────────────────┘ -3
//! ```
//! Westergaard form with `Z = −p₀ [√(1 − z²) + i z]`, `√(1 − z²) = −i √(z−1) √(z+1)`, mirrored in Ω₂: the half-planes under
//! `p = p₀ √(1 − x²)`, whose surfaces approach by `p₀ x²/E* = x²/(2R)` where they touch. Plane strain, a = p₀ = 1.
//!
//! Source: exact. [`ENERGY`] is the energy norm² of one body for E = 1, ν = 0.3, by an independent code.

use crate::model::{
    Body, ContactProblem, Gap, Made, ScalarData, SymTensor2, Vector, block, cut_out, isotropic, pair,
};

/// Energy norm² of one body for E = 1, ν = 0.3; it falls with 1/E.
pub const ENERGY: f64 = 2.29763557;

/// The exact solution in one body.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// Young's modulus and Poisson's ratio.
    pub material: (f64, f64),
    /// True if the body lies below the interface.
    pub below: bool,
}

fn times(a: Vector, b: Vector) -> Vector {
    Vector::new(a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0])
}

fn root(z: Vector) -> Vector {
    let (r, angle) = (z[0].hypot(z[1]).sqrt(), 0.5 * z[1].atan2(z[0]));
    Vector::new(r * angle.cos(), r * angle.sin())
}

/// `f = √(1 − z²) + i z`, its derivative and its integral, on the upper half-plane: `Re f` is `√(1 − x²)` on the real axis, and 0 outside of
/// the contact. At the ends of the contact the derivative is infinite; there it is given as 0.
pub(crate) fn unit(z: Vector) -> [Vector; 3] {
    let w = times(root(Vector::new(z[0] - 1.0, z[1])), root(Vector::new(z[0] + 1.0, z[1])));
    let w = Vector::new(w[1], -w[0]);
    let value = Vector::new(w[0] - z[1], w[1] + z[0]);
    // f' = i − z/w
    let size = w[0] * w[0] + w[1] * w[1];
    let slope = if size > 0.0 {
        let ratio = times(z, Vector::new(w[0] / size, -w[1] / size));
        Vector::new(-ratio[0], 1.0 - ratio[1])
    } else {
        Vector::zeros()
    };
    // asin z = −i ln(i z + w); F = ½ (z w + asin z + i z²)
    let arcsine = [value[1].atan2(value[0]), -value[0].hypot(value[1]).ln()];
    let (zw, zz) = (times(z, w), times(z, z));
    let integral = 0.5 * Vector::new(zw[0] + arcsine[0] - zz[1], zw[1] + arcsine[1] + zz[0]);
    [value, slope, integral]
}

impl Exact {
    fn mirrored(&self, x: Vector) -> (Vector, f64) {
        if self.below {
            (Vector::new(x[0], (-x[1]).max(0.0)), -1.0)
        } else {
            (Vector::new(x[0], x[1].max(0.0)), 1.0)
        }
    }

    /// The exact stress; at the ends of the contact, where its derivatives are infinite, along y = 0.
    pub fn stress(&self, x: Vector) -> SymTensor2 {
        let (z, mirror) = self.mirrored(x);
        let [value, slope, _] = unit(z).map(|part| -part);
        let y = z[1];
        SymTensor2::new(value[0] - y * slope[1], value[0] + y * slope[1], mirror * (-y * slope[0]))
    }

    /// The exact displacement.
    pub fn displacement(&self, x: Vector) -> Vector {
        let (z, mirror) = self.mirrored(x);
        let [value, _, integral] = unit(z).map(|part| -part);
        let (young, poisson) = self.material;
        let (kappa, mu) = (3.0 - 4.0 * poisson, young / (2.0 * (1.0 + poisson)));
        let ux = (0.5 * (kappa - 1.0) * integral[0] - z[1] * value[1]) / (2.0 * mu);
        let uy = (0.5 * (kappa + 1.0) * integral[1] - z[1] * value[0]) / (2.0 * mu);
        Vector::new(ux, mirror * uy)
    }
}

/// The exact solutions for two materials (E, ν).
pub fn exact(materials: [(f64, f64); 2]) -> [Exact; 2] {
    [Exact { material: materials[0], below: false }, Exact { material: materials[1], below: true }]
}

/// The problem with `6n × 3n` cells per body: nodes lie where contact ends.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(materials: [(f64, f64); 2], n: usize) -> Made<ContactProblem> {
    let body = |e: Exact| -> Made<Body> {
        let (y, far) = if e.below { (-3.0, "bottom") } else { (0.0, "top") };
        let (mesh, material) =
            (block([-3.0, y], [6.0, 3.0], [6 * n, 3 * n])?, isotropic(e.material.0, e.material.1)?);
        cut_out(mesh, material, far, move |x| e.displacement(x), move |x| e.stress(x))
    };
    let [first, second] = exact(materials);
    let bodies = [body(first)?, body(second)?];
    let compliance: f64 = materials.iter().map(|(e, nu)| (1.0 - nu * nu) / e).sum();
    let gap = Gap::Given(ScalarData::function(move |x| compliance * x[0] * x[0]));
    pair(bodies, ["bottom", "top"], &gap)
}
