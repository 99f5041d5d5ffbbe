//! Hertz' line contact of two cylinders, as half discs pressed together.
//!
//! ```text
//!    ───────── pushed down by d, held sideways
//!    \  R₁   /
//!      `---'          E₁ = 30000, ν₁ = 0.25, R₁ = 10 mm
//!      ,---.          E₂ = 29120, ν₂ = 0.3,  R₂ = 13 mm
//!    /  R₂   \
//!    ───────── held
//! ```
//! Units: N, mm. Source: ANSYS verification manual VM191: P = 3200 N/mm, a = 1.1997 mm, p₀ = 1698.1 MPa, from the closed
//! form for half-planes `a² = 4PR/(πE*)`, `p₀ = 2P/(πa)`.

use crate::model::{Body, BoundaryConditions, ContactProblem, Gap, Made, Vector, isotropic};
use contact_geometry::ContactNormal;
use fem_core::mesh::generate::{Facing, half_disc};

/// Young's modulus and Poisson's ratio of the upper and the lower body.
pub const MATERIALS: [(f64, f64); 2] = [(30000.0, 0.25), (29120.0, 0.3)];
/// Radii.
pub const RADII: [f64; 2] = [10.0, 13.0];
/// The force of the verification manual.
pub const FORCE: f64 = 3200.0;
/// Its half width and largest pressure, as printed.
pub const PRINTED: [f64; 2] = [1.1997, 1698.1];

/// Half width of the contact and largest pressure under a force, by the closed form.
pub fn closed_form(force: f64) -> [f64; 2] {
    let radius = 1.0 / RADII.iter().map(|r| 1.0 / r).sum::<f64>();
    let modulus = 1.0 / MATERIALS.iter().map(|(e, nu)| (1.0 - nu * nu) / e).sum::<f64>();
    let a = (4.0 * force * radius / (std::f64::consts::PI * modulus)).sqrt();
    [a, 2.0 * force / (std::f64::consts::PI * a)]
}

/// The problem with a contact side of `half_width`, `cells` to each side of the pole, pushed together by `push`.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(half_width: f64, cells: usize, push: f64) -> Made<ContactProblem> {
    let [upper, lower] = bodies(half_width, [cells; 2], push)?;
    let normal = ContactNormal::Fixed(Vector::new(0.0, -1.0));
    let interface = contact_geometry::pair_along(&upper, &lower, ["contact"; 2], &Gap::Geometric, normal)?;
    Ok(ContactProblem::between([upper, lower], interface))
}

/// The two bodies of [`problem`], each with its own cells.
///
/// # Errors
/// None, for sensible numbers.
pub fn bodies(half_width: f64, cells: [usize; 2], push: f64) -> Made<[Body; 2]> {
    let body = |b: usize, facing, conditions: BoundaryConditions| -> Made<Body> {
        let (young, poisson) = MATERIALS[b];
        let material = isotropic(young, poisson)?;
        Ok(Body::new(half_disc([0.0, 0.0], RADII[b], facing, half_width, cells[b])?, material, &conditions)?)
    };
    let pushed = BoundaryConditions::new().displace("flat", Some(0.0.into()), Some((-push).into()));
    let upper = body(0, Facing::Down, pushed)?;
    let lower = body(1, Facing::Up, BoundaryConditions::new().fix("flat"))?;
    Ok([upper, lower])
}
