//! A quarter of a plate with a round hole under tension, whose outer side has the exact tractions.
//!
//! ```text
//!   y ___
//!   |     \        a ring 1 ≤ r ≤ 5, rollers on both axes, on r = 5 the tractions of
//!   |_     |  →    the infinite plate under the tension 1 along x
//!     \____| x
//! ```
//! Exact: Kirsch 1898. The largest stress is three times the tension, at (0, 1), along the hole.

use crate::model::{Body, BoundaryConditions, Hypothesis, LinearElastic, Made, Vector, components, ring};
use fem_core::body::{CurveKind, CurvedSide};

/// The largest stress over the tension.
pub const FACTOR: f64 = 3.0;

/// The exact traction on a circle about the hole.
fn traction(x: Vector) -> Vector {
    let r2 = x.dot(&x);
    let (c2, s2) = ((x[0] * x[0] - x[1] * x[1]) / r2, 2.0 * x[0] * x[1] / r2);
    let q = 1.0 / r2;
    let radial = 0.5 * (1.0 - q) + 0.5 * (1.0 - 4.0 * q + 3.0 * q * q) * c2;
    let shear = -0.5 * (1.0 + 2.0 * q - 3.0 * q * q) * s2;
    1.0 / r2.sqrt() * Vector::new(radial * x[0] - shear * x[1], radial * x[1] + shear * x[0])
}

/// The plate with both radii declared as `kind`, or as polygons.
///
/// # Errors
/// None, for sensible numbers.
pub fn plate(cells: [usize; 2], kind: Option<CurveKind>) -> Made<Body> {
    let mesh = ring([0.0; 2], [1.0, 5.0], [0.0, 90.0], cells)?;
    let conditions = BoundaryConditions::new()
        .roller("start", 0.0)
        .roller("end", 0.0)
        .traction("outer", components(traction));
    let material = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStress)?;
    let side = |kind| ["inner", "outer"].map(|on| CurvedSide { on: on.to_owned(), kind });
    let sides: Vec<CurvedSide> = kind.map(side).into_iter().flatten().collect();
    Ok(Body::new(mesh, material, &conditions)?.with_curves(&sides)?)
}
