//! Nested rings: contact on a circle, which linear triangles see as a polygon.
//!
//! ```text
//!      ___c___        Ω₁: A ≤ r ≤ B;  Ω₂: B ≤ r ≤ C;  Γ_C: r = B, no friction
//!    /  _b_   \       quarter: rollers on both axes of symmetry, a pressure q on r = C
//!   | / ,a. \  |      whole: r = A held, r = C moved inwards by d and turned by w
//!   | | | | |  |
//! ```
//! Units: any consistent set. Exact: Lamé's solution, `σ_r, σ_θ = A ∓ B/r²`. Plane strain. The rotation of the outer ring
//! is a rigid one, since nothing rubs.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, Made, ScalarData, SymTensor2, Vector, isotropic, pair,
    ring,
};

/// Radius of the hole.
pub const A: f64 = 1.0;
/// Radius of the contact line.
pub const B: f64 = 1.5;
/// Outer radius.
pub const C: f64 = 2.0;

/// Young's modulus and Poisson's ratio of the inner and the outer ring.
pub type Materials = [(f64, f64); 2];

/// Lamé's stress `σ_r, σ_θ = mean ∓ deviation/r²` in one ring.
#[derive(Clone, Copy, Debug)]
pub struct Lame {
    /// Mean of the two stresses.
    pub mean: f64,
    /// Half their difference times r².
    pub deviation: f64,
}

impl Lame {
    /// Of a ring between two radii under pressures inside and outside.
    pub fn new(radii: [f64; 2], pressures: [f64; 2]) -> Self {
        let [a, b] = radii.map(|r| r * r);
        let [p, q] = pressures;
        Self { mean: (p * a - q * b) / (b - a), deviation: (p - q) * a * b / (b - a) }
    }

    /// The exact stress.
    pub fn stress(&self, x: Vector) -> SymTensor2 {
        let r2 = x[0] * x[0] + x[1] * x[1];
        let d = self.deviation / r2;
        let (c2, cs) = ((x[0] * x[0] - x[1] * x[1]) / r2, x[0] * x[1] / r2);
        SymTensor2::new(self.mean - d * c2, self.mean + d * c2, -2.0 * d * cs)
    }

    /// The exact radial displacement, `2µ u = (1 − 2ν) mean r + deviation/r`.
    pub fn radial(&self, (young, poisson): (f64, f64), r: f64) -> f64 {
        (1.0 + poisson) / young * ((1.0 - 2.0 * poisson) * self.mean * r + self.deviation / r)
    }
}

/// The exact contact pressure under the pressures `hole` on r = A and `outer` on r = C: the radial displacements of the
/// two rings at r = B are linear in it, and equal.
pub fn pressure(materials: Materials, hole: f64, outer: f64) -> f64 {
    let difference = |p: f64| {
        let [first, second] = exact(p, hole, outer);
        first.radial(materials[0], B) - second.radial(materials[1], B)
    };
    difference(0.0) / (difference(0.0) - difference(1.0))
}

/// The exact solutions of both rings for a contact pressure.
pub fn exact(p: f64, hole: f64, outer: f64) -> [Lame; 2] {
    [Lame::new([A, B], [hole, p]), Lame::new([B, C], [p, outer])]
}

/// A quarter of the rings under the pressures `hole` and `outer`, `cells` around and across each ring.
///
/// # Errors
/// None, for sensible numbers.
pub fn quarter(materials: Materials, hole: f64, outer: f64, cells: [usize; 2]) -> Made<ContactProblem> {
    let [inner, outer] = quarter_bodies(materials, hole, outer, [cells; 2])?;
    paired(inner, outer)
}

/// The two bodies of [`quarter`], each with its own cells.
///
/// # Errors
/// None, for sensible numbers.
pub fn quarter_bodies(
    materials: Materials,
    hole: f64,
    outer: f64,
    cells: [[usize; 2]; 2],
) -> Made<[Body; 2]> {
    let rollers = || BoundaryConditions::new().roller("start", 0.0).roller("end", 0.0);
    let inner = body(materials[0], [A, B], [0.0, 90.0], cells[0], rollers().pressure("inner", hole))?;
    let outer = body(materials[1], [B, C], [0.0, 90.0], cells[1], rollers().pressure("outer", outer))?;
    Ok([inner, outer])
}

/// Whole rings: the hole held, the outside moved inwards by `d` and turned by the angle `w`.
///
/// # Errors
/// None, for sensible numbers.
pub fn whole(materials: Materials, motion: [f64; 2], cells: [usize; 2]) -> Made<ContactProblem> {
    let [inner, outer] = whole_bodies(materials, motion, [cells; 2], 0.0)?;
    paired(inner, outer)
}

/// The two bodies of [`whole`], each with its own cells, the outer one's turned by an angle in degrees.
///
/// # Errors
/// None, for sensible numbers.
pub fn whole_bodies(
    materials: Materials,
    [d, w]: [f64; 2],
    cells: [[usize; 2]; 2],
    turned: f64,
) -> Made<[Body; 2]> {
    let moved = |c: usize| {
        let sign = if c == 0 { -1.0 } else { 1.0 };
        Some(ScalarData::function(move |x: Vector| -d * x[c] / C + sign * w * x[1 - c]))
    };
    let held = BoundaryConditions::new().fix("inner");
    let inner = body(materials[0], [A, B], [0.0, 360.0], cells[0], held)?;
    let pushed = BoundaryConditions::new().displace("outer", moved(0), moved(1));
    let outer = body(materials[1], [B, C], [turned, turned + 360.0], cells[1], pushed)?;
    Ok([inner, outer])
}

/// The exact solutions of [`whole`], but for the outer ring's rotation: pressures in the hole and outside that give the
/// imposed displacements.
pub fn whole_exact(materials: Materials, d: f64) -> [Lame; 2] {
    let p = whole_pressure(materials, d);
    let hole = |q: f64| Lame::new([A, B], [q, p]).radial(materials[0], A);
    let outer = |q: f64| Lame::new([B, C], [p, q]).radial(materials[1], C) + d;
    let zero = |f: &dyn Fn(f64) -> f64| f(0.0) / (f(0.0) - f(1.0));
    exact(p, zero(&hole), zero(&outer))
}

/// The bodies of [`sliding`], each with its own angles and cells.
///
/// # Errors
/// None, for sensible numbers.
pub fn sliding_bodies(
    materials: Materials,
    push: [f64; 2],
    sectors: [[f64; 2]; 2],
    cells: [[usize; 2]; 2],
) -> Made<[Body; 2]> {
    let inner = body(materials[0], [A, B], sectors[0], cells[0], BoundaryConditions::new().fix("inner"))?;
    let moved = BoundaryConditions::new().displace("outer", Some(push[0].into()), Some(push[1].into()));
    let outer = body(materials[1], [B, C], sectors[1], cells[1], moved)?;
    Ok([inner, outer])
}

/// The exact pressure of [`whole`]: of pressures in the hole and outside, those that give the imposed displacements.
pub fn whole_pressure(materials: Materials, d: f64) -> f64 {
    // u(A) = 0 in the inner ring and u(C) = −d in the outer one are linear in the hole's and the outer pressure.
    let inner = |p: f64| {
        let at = |hole: f64| Lame::new([A, B], [hole, p]).radial(materials[0], A);
        Lame::new([A, B], [at(0.0) / (at(0.0) - at(1.0)), p]).radial(materials[0], B)
    };
    let outer = |p: f64| {
        let at = |q: f64| Lame::new([B, C], [p, q]).radial(materials[1], C) + d;
        Lame::new([B, C], [p, at(0.0) / (at(0.0) - at(1.0))]).radial(materials[1], B)
    };
    let difference = |p: f64| inner(p) - outer(p);
    difference(0.0) / (difference(0.0) - difference(1.0))
}

/// Two sectors from 40 to 140 degrees, the lower one held, the upper one pushed down and sideways: they slide, and part
/// of the line opens.
///
/// # Errors
/// None, for sensible numbers.
pub fn sliding(materials: Materials, push: [f64; 2], cells: [usize; 2]) -> Made<ContactProblem> {
    let [inner, outer] = sliding_bodies(materials, push, [[40.0, 140.0]; 2], [cells; 2])?;
    paired(inner, outer)
}

fn body(
    (young, poisson): (f64, f64),
    radii: [f64; 2],
    angles: [f64; 2],
    cells: [usize; 2],
    conditions: BoundaryConditions,
) -> Made<Body> {
    let material = isotropic(young, poisson)?;
    Ok(Body::new(ring([0.0, 0.0], radii, angles, cells)?, material, &conditions)?)
}

fn paired(inner: Body, outer: Body) -> Made<ContactProblem> {
    pair([inner, outer], ["outer", "inner"], &Gap::Given(0.0.into()))
}
