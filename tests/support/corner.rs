//! A re-entrant corner with its exact singular field.
//!
//! ```text
//!         ┌─────╲           L-shape turned so that the bisector of its material is the x axis;
//!        ╱       ╲          exact displacement on the outer boundary, the two faces free
//!        ╲  O     ╲
//!          ╳──── x ╱
//!        ╱        ╱
//!        ╲      ╱
//! ```
//! Units: any consistent set. Exact (Williams 1952): `φ = z^λ`, `ψ = c z^λ` leave the faces at ±3π/4 free if
//! `e^{2iλα} + λ e^{2iα} + c = 0` with α = 3π/4, that is `sin(3πλ/2) = λ` and `c = −cos(3πλ/2)`. The stress is
//! of order `r^{λ−1}`: uniform meshes converge with the rate λ in energy.

use crate::goursat::{Goursat, Potentials};
use crate::model::{Body, BoundaryConditions, Hypothesis, Made, Vector, components, isotropic};
use crate::shapes::{l_shape, turned};
use std::f64::consts::PI;

/// The root of `sin(3πλ/2) = λ` between ½ and 1.
pub const EXPONENT: f64 = 0.544_483_736_782_464;
/// Young's modulus and Poisson's ratio.
pub const MATERIAL: (f64, f64) = (3.0, 0.25);

fn potentials(x: Vector) -> Potentials {
    let (r, angle) = (x[0].hypot(x[1]), x[1].atan2(x[0]));
    if r == 0.0 {
        return [[0.0; 2]; 5];
    }
    let power = |factor: f64, p: f64| {
        let size = factor * r.powf(p);
        [size * (p * angle).cos(), size * (p * angle).sin()]
    };
    let (a, c) = (EXPONENT, -(1.5 * PI * EXPONENT).cos());
    [power(1.0, a), power(a, a - 1.0), power(a * (a - 1.0), a - 2.0), power(c, a), power(c * a, a - 1.0)]
}

/// The exact field, in plane strain.
pub fn exact() -> Goursat {
    Goursat::new(MATERIAL, Hypothesis::PlaneStrain, potentials)
}

/// The body, with `2n × 2n` cells less a quarter.
///
/// # Errors
/// None for `n ≥ 1`.
pub fn body(n: usize) -> Made<Body> {
    let field = exact();
    let [x, y] = components(move |x| field.displacement(x)).map(Some);
    let material = isotropic(MATERIAL.0, MATERIAL.1)?;
    let conditions = BoundaryConditions::new().displace("outer", x, y);
    // The missing quadrant is the lower right one, so the bisector is at 3π/4.
    Ok(Body::new(turned(&l_shape(n)?, -0.75 * PI)?, material, &conditions)?)
}
