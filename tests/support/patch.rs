//! The contact patch: stacked blocks under uniform pressure, exact for P1 triangles.
//!
//! ```text
//!    ↓ ↓ ↓ p₀
//!   ┌────────┐      lateral sides free; each body held by a roller at one side, so that the lateral
//!   │   Ω₁   │      strain is free; any two materials
//!   ├────────┤ Γ_C
//!   │   Ω₂   │
//!   └────────┘ roller
//! ```
//! Exact: `σ_yy = −p₀`, everything else 0, and `e_CRE = 0`. Source: standard; exact by inspection.

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactInterface, ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::block;

/// The applied pressure.
pub const PRESSURE: f64 = 7.0;

/// The patch with the given (E, ν) of each body, hypothesis, and angle (radians) by which everything is turned.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(
    materials: [(f64, f64); 2],
    hypothesis: Hypothesis,
    angle: f64,
) -> Result<ContactProblem, Box<dyn std::error::Error>> {
    let (sin, cos) = angle.sin_cos();
    let turn = |mesh: TriMesh| -> Result<TriMesh, Box<dyn std::error::Error>> {
        if angle == 0.0 {
            return Ok(mesh);
        }
        let points: Vec<Vector> =
            mesh.points().iter().map(|p| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]]).collect();
        let groups = mesh.groups().iter().map(|(name, edges)| {
            (name.clone(), edges.iter().map(|&e| mesh.topology().edges()[e as usize]).collect())
        });
        Ok(TriMesh::new(points, mesh.triangles().to_vec(), groups.collect())?)
    };
    let [upper, lower] = materials.map(|(e, nu)| LinearElastic::isotropic(e, nu, hypothesis));
    let upper = Body::new(
        turn(block([0.0, 1.0], [2.0, 0.75], [7, 3])?)?,
        upper?,
        &BoundaryConditions::new().roller("left", 0.0).roller("top", -0.75 * compression(materials[0], hypothesis)),
    )?;
    let lower = Body::new(
        turn(block([0.0, 0.0], [2.0, 1.0], [7, 5])?)?,
        lower?,
        &BoundaryConditions::new().roller("left", 0.0).roller("bottom", -compression(materials[1], hypothesis)),
    )?;
    let interface = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
    Ok(ContactProblem { bodies: [upper, lower], interface })
}

/// Outward displacement of the far side that makes the pressure: compression of a body over its height, and
/// nothing more, so that the interface stays at rest.
fn compression((young, poisson): (f64, f64), hypothesis: Hypothesis) -> f64 {
    let plane = match hypothesis {
        Hypothesis::PlaneStrain => young / (1.0 - poisson * poisson),
        Hypothesis::PlaneStress => young,
    };
    PRESSURE / plane
}

/// Exact energy norm² `∫ σ:ε` of each body: `p₀² |Ω| / E'`.
pub fn energies(materials: [(f64, f64); 2], hypothesis: Hypothesis) -> [f64; 2] {
    let one = |m, height: f64| PRESSURE * compression(m, hypothesis) * 2.0 * height;
    [one(materials[0], 0.75), one(materials[1], 1.0)]
}
