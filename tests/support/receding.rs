//! Receding contact: a layer lies on a base of another material and is pressed on a short part of its top. The layer lifts
//! off at a distance from the load that does not depend on the size of the load.
//!
//! ```text
//!    u_y = −0.01 for x ≤ one cell
//!   ┌─────────────────────────────┐ y = 1
//!   │ Ω₁, E = ratio               │ u_x = 0 on the left side
//!   ├─────────────────────────────┤ Γ_C: y = 0
//!   │ Ω₂, E = 1                   │ u_x = 0 on the left side
//!   └─────────────────────────────┘ y = −10, u_y = 0      0 ≤ x ≤ 10, ν = 0.3
//! ```
//! Plane strain. No reference values: a problem on which the iteration is slow, as the contact nodes move far.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, FacetSelection, Made, block, isotropic, stacked,
};

/// Makes the problem.
///
/// * `ratio`: Young's modulus of the layer over the base's.
/// * `cells`: across the height of the layer.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(ratio: f64, cells: usize) -> Made<ContactProblem> {
    let material = |young| isotropic(young, 0.3);
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let pressed = FacetSelection::group("top").within([[0.0, 1.0 / cells as f64], everywhere]);
    let symmetric = || BoundaryConditions::new().displace("left", Some(0.0.into()), None);
    let layer = Body::new(
        block([0.0, 0.0], [10.0, 1.0], [10 * cells, cells])?,
        material(ratio)?,
        &symmetric().displace(pressed, None, Some((-0.01).into())),
    )?;
    let base = Body::new(
        block([0.0, -10.0], [10.0, 10.0], [10 * cells, 10 * cells])?,
        material(1.0)?,
        &symmetric().displace("bottom", None, Some(0.0.into())),
    )?;
    stacked([layer, base])
}
