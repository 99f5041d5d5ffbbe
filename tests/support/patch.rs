//! The contact patch: stacked blocks under uniform pressure, exact for P1 triangles.
//!
//! ```text
//!   top pushed in by δ₁ + δ₂ (roller)
//!   ┌────────┐
//!  o│   Ω₁   │  0.75    each body on a roller on the left and free on the right, so that the lateral strain is
//!   ├────────┤  Γ_C     free; any two materials; everything turned by an angle
//!  o│   Ω₂   │  1
//!   └────────┘ roller at rest; width 2
//! ```
//! Units: any consistent set. Exact, by inspection: the uniaxial stress −p₀ along the pressed direction,
//! everything else 0, `δ_α = p₀ h_α/E'_α`, the interface moves by δ₂, and `e_CRE = 0`.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Hypothesis, LinearElastic, Made, block, stacked,
};
use crate::shapes::turned;

/// The pressure p₀.
pub const PRESSURE: f64 = 7.0;
/// Width of both bodies.
pub const WIDTH: f64 = 2.0;
/// Heights of the bodies.
pub const HEIGHTS: [f64; 2] = [0.75, 1.0];

/// The patch with the given (E, ν) of each body, hypothesis, and angle (radians) by which everything is turned.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(materials: [(f64, f64); 2], hypothesis: Hypothesis, angle: f64) -> Made<ContactProblem> {
    let bodies = bodies(materials, hypothesis, angle, [[7, 3], [7, 5]])?;
    stacked(bodies)
}

/// The two bodies of the patch, each with its own cells.
///
/// # Errors
/// None, for sensible numbers.
pub fn bodies(
    materials: [(f64, f64); 2],
    hypothesis: Hypothesis,
    angle: f64,
    cells: [[usize; 2]; 2],
) -> Made<[Body; 2]> {
    let [first, second] = materials.map(|(e, nu)| LinearElastic::isotropic(e, nu, hypothesis));
    let push: f64 = compressions(materials, hypothesis).iter().sum();
    let upper = Body::new(
        turned(&block([0.0, 1.0], [WIDTH, HEIGHTS[0]], cells[0])?, angle)?,
        first?,
        &BoundaryConditions::new().roller("left", 0.0).roller("top", -push),
    )?;
    let lower = Body::new(
        turned(&block([0.0, 0.0], [WIDTH, HEIGHTS[1]], cells[1])?, angle)?,
        second?,
        &BoundaryConditions::new().roller("left", 0.0).roller("bottom", 0.0),
    )?;
    Ok([upper, lower])
}

/// Exact compression δ of each body.
pub fn compressions(materials: [(f64, f64); 2], hypothesis: Hypothesis) -> [f64; 2] {
    [0, 1].map(|b| {
        let (young, poisson) = materials[b];
        let plane = match hypothesis {
            Hypothesis::PlaneStrain => young / (1.0 - poisson * poisson),
            Hypothesis::PlaneStress => young,
        };
        PRESSURE * HEIGHTS[b] / plane
    })
}

/// Exact energy norm² `∫ σ:ε = p₀ δ · width` of each body.
pub fn energies(materials: [(f64, f64); 2], hypothesis: Hypothesis) -> [f64; 2] {
    compressions(materials, hypothesis).map(|delta| PRESSURE * delta * WIDTH)
}
