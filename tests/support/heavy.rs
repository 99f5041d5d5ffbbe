//! Two heavy blocks on a slope, with every kind of condition, at any angle.
//!
//! ```text
//!       ↓ q ↓        q: pressure on top; b: body forces; t: a traction along the right side of Ω₂
//!   ┌──────────┐
//!  o│    Ω₁    │     Ω₁: roller on the left, Ω₂: rollers at the left and at the bottom; a gap that opens
//!   ├─ Γ_C ────┤     to the right; everything turned by the same angle
//!  o│    Ω₂    │→ t
//!   └──────────┘
//!     o  o  o
//! ```
//! Units: any consistent set. A roller on the part `x ≤ ½` of its top, pushed in by 0.01, holds Ω₁ against
//! falling. Reference: only invariance
//! (the answer does not depend on the angle) and equilibrium (reactions carry the loads), both exact.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, FacetSelection, Gap, Made, ScalarData, TriMesh, Vector, block,
    isotropic, pair, sides,
};
use crate::shapes::{turn, turned};

/// Body forces of the two bodies at the angle 0.
pub const BODY_FORCES: [Vector; 2] = [Vector::new(2.0, -11.0), Vector::new(1.0, -14.0)];
/// Traction on the right side of Ω₂ at the angle 0.
pub const TRACTION: Vector = Vector::new(6.0, 1.5);
/// Pressure on the free part of the top.
pub const PRESSURE: f64 = 9.0;

/// The problem turned by an angle, radians, on meshes of `2n` cells along the interface.
///
/// # Errors
/// None for `n ≥ 2`.
pub fn problem(angle: f64, n: usize) -> Made<ContactProblem> {
    let material = |e| isotropic(e, 0.3);
    let upper = split_top(&block([0.0, 1.0], [2.0, 0.8], [2 * n, n])?)?;
    let upper = Body::new(
        turned(&upper, angle)?,
        material(900.0)?,
        &BoundaryConditions::new()
            .roller("left", 0.0)
            .roller("held", -0.01)
            .pressure("pressed", PRESSURE)
            .body_force(turn(angle, BODY_FORCES[0])),
    )?;
    let traction = <[f64; 2]>::from(turn(angle, TRACTION)).map(ScalarData::from);
    let lower = Body::new(
        turned(&block([0.0, 0.0], [2.0, 1.0], [2 * n, n + 1])?, angle)?,
        material(500.0)?,
        &BoundaryConditions::new()
            .roller("left", 0.0)
            .roller(FacetSelection::group("bottom"), 0.0)
            .traction("right", traction)
            .body_force(turn(angle, BODY_FORCES[1])),
    )?;
    let gap = ScalarData::function(move |x| {
        let along = turn(-angle, x)[0];
        0.02 * (along - 0.7).max(0.0)
    });
    pair([upper, lower], ["bottom", "top"], &Gap::Given(gap))
}

/// Splits the group `top` at x = ½ into `held` and `pressed`.
fn split_top(mesh: &TriMesh) -> Made<TriMesh> {
    let edges = mesh.topology().facets();
    let mut groups = sides(mesh);
    let top = mesh.group("top").unwrap_or_default().iter().map(|&e| edges[e]);
    let (held, pressed) = top.partition(|e| e.iter().all(|&i| mesh.points()[i][0] <= 0.5 + 1e-9));
    groups.push(("held".into(), held));
    groups.push(("pressed".into(), pressed));
    Ok(TriMesh::new(mesh.points().to_vec(), mesh.cells().to_vec(), groups)?)
}
