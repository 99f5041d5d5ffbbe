//! The paper's test problem as this project poses it: two stacked blocks with loss of contact.
//!
//! ```text
//!        u_y = −0.02                 Ω₁ = (0,2)×(1,2), E₁ = 2000, carries λ
//!      ┌─────────────┐               Ω₂ = (0,2)×(0,1), E₂ = 1000
//! u_x=0│     Ω₁      │→ (0, 30)      ν = 0.3, plane strain, Γ_C: y = 1
//!      ├─────────────┤ Γ_C
//!      │     Ω₂      │
//!      └─────────────┘
//!          clamped
//! ```
//! Units: any consistent set. Source: Choi, Gallimard, Sassi, section 5; the geometry, which figure 1 shows,
//! is not in the text, and is fixed here so that it fits the words and both node counts (380 and 5994).
//!
//! The values of [`ITERATIONS`], [`ENERGIES`] and [`FORCE`] come from an independent prototype in another
//! language (18×9 cells per body, θ = 0.4).

use crate::model::{Body, BoundaryConditions, ContactProblem, Gap, Made, block, isotropic, pair};

/// Cells per body of the paper's coarse mesh, 380 nodes in all.
pub const COARSE: [usize; 2] = [18, 9];
/// Cells per body of the paper's fine mesh, 5994 nodes in all.
pub const FINE: [usize; 2] = [80, 36];

/// `ε_t`, `η_NNDD`, nodes in contact, `Σ r²` of the first iterations; the contact force of the first row is 0.
pub const ITERATIONS: [(f64, f64, usize, f64); 5] = [
    (2.0, 1.2270569444, 0, 0.0),
    (1.4192569513, 0.17789282682, 16, 23.050325277),
    (0.97543965180, 0.048336668644, 16, 25.829893313),
    (0.44808918188, 0.019877675214, 16, 26.185086570),
    (0.20409422098, 0.0087465331842, 16, 26.236182720),
];
/// Converged `a(u, u)` of the two bodies.
pub const ENERGIES: [f64; 2] = [0.751282805581, 0.332986279609];
/// Converged contact force.
pub const FORCE: f64 = 26.2501595729;

/// Arc length at which contact ends, `x = 5/3`, on the coarse mesh.
pub const CONTACT_END: f64 = 5.0 / 3.0;
/// The paper's moduli.
pub const YOUNG: [f64; 2] = [2000.0, 1000.0];
/// The traction on the right of Ω₁.
pub const TRACTION: f64 = 30.0;
/// The displacement of the top.
pub const PUSH: f64 = -0.02;

/// The paper's problem on a mesh of the given cells per body, with the given moduli, traction on the right,
/// displacement of the top and initial gap.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem_with(
    cells: [usize; 2],
    young: [f64; 2],
    traction: f64,
    push: f64,
    gap: f64,
) -> Made<ContactProblem> {
    let material = |e| isotropic(e, 0.3);
    let upper = Body::new(
        block([0.0, 1.0], [2.0, 1.0], cells)?,
        material(young[0])?,
        &BoundaryConditions::new()
            .displace("left", Some(0.0.into()), None)
            .displace("top", None, Some(push.into()))
            .traction("right", [0.0.into(), traction.into()]),
    )?;
    let lower = Body::new(
        block([0.0, 0.0], [2.0, 1.0], cells)?,
        material(young[1])?,
        &BoundaryConditions::new().fix("bottom"),
    )?;
    pair([upper, lower], ["bottom", "top"], &Gap::Given(gap.into()))
}

/// The paper's problem with its own moduli.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(cells: [usize; 2]) -> Made<ContactProblem> {
    problem_with(cells, YOUNG, TRACTION, PUSH, 0.0)
}
