//! Cook's membrane: a tapered panel clamped on the left, sheared on the right.
//!
//! ```text
//!                    (48,60)
//!             .·''''│
//!   (0,44) ·'       │ ↑ 1/16      E = 1, ν = 1/3, plane stress; the shear adds up to 1
//!        ▓│        │
//!        ▓│       ╱ (48,44)
//!        ▓│    ╱
//!   (0,0) ·'
//! ```
//! Units: any consistent set. Source: Cook 1974; [`TIP`] is the vertical displacement in the middle of the loaded
//! side that the literature gives for fine meshes (23.96: Cook, Malkus, Plesha; 23.95 in dolfinx's demo of it).
//! Kind: other codes, four digits.

use crate::model::{Body, BoundaryConditions, Hypothesis, LinearElastic, Made, Vector, block};
use crate::shapes::moved;

/// Vertical displacement at (48, 52).
pub const TIP: f64 = 23.96;

/// The membrane on `n × n` cells.
///
/// # Errors
/// None for `n ≥ 1`.
pub fn body(n: usize) -> Made<Body> {
    let mesh = moved(&block([0.0, 0.0], [1.0, 1.0], [n, n])?, |x| {
        Vector::new(48.0 * x[0], 44.0 * x[0] + x[1] * (44.0 - 28.0 * x[0]))
    })?;
    let conditions =
        BoundaryConditions::new().fix("left").traction("right", [0.0.into(), (1.0 / 16.0).into()]);
    let material = LinearElastic::isotropic(1.0, 1.0 / 3.0, Hypothesis::PlaneStress)?;
    Ok(Body::new(mesh, material, &conditions)?)
}
