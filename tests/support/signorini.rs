//! A two-body Signorini problem with a moving boundary of contact, any two materials, solved exactly.
//!
//! ```text
//!   -1        0        1
//!    ┌─────────────────┐ 1     exact displacements on top and bottom, exact tractions on the lateral sides
//!    │       Ω₁        │
//!    ├ open ──┬ contact┤ 0     Γ_C: y = 0
//!    │       Ω₂        │
//!    └─────────────────┘ -1
//! ```
//! Westergaard form with `Z = −c z^{1/2}` (the Williams term of exponent 3/2), mirrored in Ω₂: contact with
//! `σ_yy = −c√x` for `x > 0`, an opening `(4c/3)|x|^{3/2}/E*` for `x < 0`. With `k` a pure bending
//! `σ_xx = k E' y` is added, which gives both bodies `u_y = −k x²/2` on y = 0. Plane strain.
//!
//! Source: exact (equilibrium and contact conditions by inspection, displacements by finite differences).
//! [`ENERGY`] is the energy norm² of one body for c = 1, ν = 0.3, E = 1, k = 0, by an independent code.

use crate::model::{
    Body, ContactProblem, Made, SymTensor2, TriMesh, Vector, block, cut_out, isotropic, stacked,
};
use crate::shapes::moved;

/// Energy norm² of one body for E = 1, ν = 0.3, c = 1, k = 0; it falls with 1/E.
pub const ENERGY: f64 = 1.29318076082452;

/// The exact solution in one body.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Amplitude of the contact term.
    pub c: f64,
    /// Curvature of the added bending.
    pub k: f64,
    /// True if the body lies below the interface.
    pub below: bool,
}

impl Exact {
    /// √z and its angle for z = x + iy, y ≥ 0, principal branch.
    fn root(x: f64, y: f64) -> (f64, f64) {
        (x.hypot(y).sqrt(), 0.5 * y.atan2(x))
    }

    /// The exact stress.
    pub fn stress(&self, x: Vector) -> SymTensor2 {
        let (y, mirror) = if self.below { (-x[1], -1.0) } else { (x[1], 1.0) };
        let (m, t) = Self::root(x[0], y.max(0.0));
        let z = [-self.c * m * t.cos(), -self.c * m * t.sin()];
        // Z' = −c/(2√z)
        let slope =
            if m > 0.0 { [-0.5 * self.c / m * t.cos(), 0.5 * self.c / m * t.sin()] } else { [0.0; 2] };
        let plane = self.young / (1.0 - self.poisson * self.poisson);
        SymTensor2::new(
            z[0] - y * slope[1] + self.k * plane * x[1],
            z[0] + y * slope[1],
            mirror * (-y * slope[0]),
        )
    }

    /// The exact displacement.
    pub fn displacement(&self, x: Vector) -> Vector {
        let (y, mirror) = if self.below { (-x[1], -1.0) } else { (x[1], 1.0) };
        let (m, t) = Self::root(x[0], y.max(0.0));
        let z = [-self.c * m * t.cos(), -self.c * m * t.sin()];
        let integral = -2.0 / 3.0 * self.c * m * m * m;
        let zz = [integral * (3.0 * t).cos(), integral * (3.0 * t).sin()];
        let kappa = 3.0 - 4.0 * self.poisson;
        let mu = self.young / (2.0 * (1.0 + self.poisson));
        let ux = (0.5 * (kappa - 1.0) * zz[0] - y * z[1]) / (2.0 * mu);
        let uy = (0.5 * (kappa + 1.0) * zz[1] - y * z[0]) / (2.0 * mu);
        let ratio = self.poisson / (1.0 - self.poisson);
        let bending = [self.k * x[0] * x[1], -0.5 * self.k * (x[0] * x[0] + ratio * x[1] * x[1])];
        Vector::new(ux + bending[0], mirror * uy + bending[1])
    }
}

/// The exact solutions for two materials (E, ν).
pub fn exact(materials: [(f64, f64); 2], k: f64) -> [Exact; 2] {
    let one = |(young, poisson), below| Exact { young, poisson, c: 1.0, k, below };
    [one(materials[0], false), one(materials[1], true)]
}

/// The exact pressure at a point of the interface.
pub fn pressure(x: f64) -> f64 {
    x.max(0.0).sqrt()
}

/// The exact opening at a point of the interface, `(4/3)|x|^{3/2}/E*` where it is open.
pub fn opening(materials: [(f64, f64); 2], x: f64) -> f64 {
    let compliance: f64 = materials.iter().map(|(e, nu)| (1.0 - nu * nu) / e).sum();
    4.0 / 3.0 * (-x).max(0.0).powf(1.5) * compliance
}

/// The problem on `cells[0] × cells[1]` cells per body (an even number along x has a node where contact ends).
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(materials: [(f64, f64); 2], k: f64, cells: [usize; 2]) -> Made<ContactProblem> {
    let bodies = bodies(materials, k, [cells; 2], |x| x)?;
    stacked(bodies)
}

/// The two bodies, each with its own cells; the lower one's nodes are moved by `motion`.
///
/// # Errors
/// A motion that turns triangles over.
pub fn bodies(
    materials: [(f64, f64); 2],
    k: f64,
    cells: [[usize; 2]; 2],
    motion: impl Fn(Vector) -> Vector,
) -> Made<[Body; 2]> {
    let body = |e: Exact, far: &str, mesh: TriMesh| {
        let material = isotropic(e.young, e.poisson)?;
        cut_out(mesh, material, far, move |x| e.displacement(x), move |x| e.stress(x))
    };
    let [first, second] = exact(materials, k);
    let upper = body(first, "top", block([-1.0, 0.0], [2.0, 1.0], cells[0])?)?;
    let lower = body(second, "bottom", moved(&block([-1.0, -1.0], [2.0, 1.0], cells[1])?, motion)?)?;
    Ok([upper, lower])
}
