//! Cattaneo's and Mindlin's contact with friction: Hertz' contact of two equal bodies, pressed and then pushed sideways, in the boxes of
//! [`crate::hertz_box`], solved exactly.
//!
//! The friction is `q = μ p₀ [√(1 − x²) − c √(1 − x²/c²)]` to the right on the lower body: the contact sticks for `|x| < c` and slips
//! outside of it, under a force `Q = μ P (1 − c²)`. By symmetry it does not change the pressure. In the upper half-plane
//! `Z = μ p₀ [f(z) − c f(z/c)]` with the function `f` of [`crate::hertz_box`] gives the second form of Westergaard:
//! `σ_xy = Re Z − y Im Z'`, `σ_yy = −y Re Z'`, `σ_xx = 2 Im Z + y Re Z'`; the lower one is turned by half a turn. Plane strain, a = p₀ = 1.
//!
//! Source: exact; Cattaneo (1938), Mindlin (1949), after Johnson, *Contact Mechanics*, section 7.2.

use crate::hertz_box;
use crate::model::{
    Body, ContactProblem, Gap, Made, ScalarData, SymTensor2, TriMesh, Vector, block, cut_out, isotropic, pair,
};
use crate::shapes::moved;
use fem_core::interface::Friction;

/// Young's modulus and Poisson's ratio of both bodies.
pub const MATERIAL: (f64, f64) = (1.0, 0.3);
/// The coefficient of friction.
pub const MU: f64 = 0.4;
/// The half width of the part that sticks.
pub const STICK: f64 = 0.6;

/// The exact friction at a place on the contact line.
pub fn friction(x: f64) -> f64 {
    let part = |a: f64| (1.0 - (x / a).powi(2)).max(0.0).sqrt();
    MU * (part(1.0) - STICK * part(STICK))
}

/// `Z`, its derivative and its integral.
fn potential(z: Vector) -> [Vector; 3] {
    let ([f, df, integral], [g, dg, of_g]) = (hertz_box::unit(z), hertz_box::unit(z / STICK));
    [MU * (f - STICK * g), MU * (df - dg), MU * (integral - STICK * STICK * of_g)]
}

/// Computes displacement and stress of the body above due to friction alone.
fn above(x: Vector) -> (Vector, SymTensor2) {
    let [value, slope, integral] = potential(x);
    let (young, poisson) = MATERIAL;
    let (kappa, mu) = (3.0 - 4.0 * poisson, young / (2.0 * (1.0 + poisson)));
    let y = x[1];
    let ux = (0.5 * (kappa + 1.0) * integral[1] + y * value[0]) / (2.0 * mu);
    let uy = (-0.5 * (kappa - 1.0) * integral[0] - y * value[1]) / (2.0 * mu);
    let stress = SymTensor2::new(2.0 * value[1] + y * slope[0], -y * slope[0], value[0] - y * slope[1]);
    (Vector::new(ux, uy), stress)
}

/// The exact displacement and stress of one body.
pub fn exact(below: bool, x: Vector) -> (Vector, SymTensor2) {
    let pressed = hertz_box::Exact { material: MATERIAL, below };
    let turn = if below { -1.0 } else { 1.0 };
    // A node of the contact line may lie on the other side of it by a signed zero.
    let place = turn * x;
    let (u, stress) = above(Vector::new(place[0], place[1].max(0.0)));
    (pressed.displacement(x) + turn * u, pressed.stress(x).plus(stress))
}

/// A block with cells that become finer towards the middle of the contact line.
///
/// * `cells`: along half of the contact line; a quarter of them along its normal.
fn graded(below: bool, cells: usize) -> Made<TriMesh> {
    let y = if below { -3.0 } else { 0.0 };
    let even = block([-3.0, y], [6.0, 3.0], [2 * cells, cells / 4])?;
    let finer = |t: f64, rate: f64| 3.0 * (rate * t / 3.0).sinh() / rate.sinh();
    Ok(moved(&even, |x| Vector::new(finer(x[0], 2.0), finer(x[1], 3.5)))?)
}

/// The problem: exact displacements on top and bottom, exact tractions on the lateral sides.
///
/// # Errors
/// None, for sensible numbers.
pub fn problem(cells: usize, law: Friction) -> Made<ContactProblem> {
    let body = |below: bool| -> Made<Body> {
        let far = if below { "bottom" } else { "top" };
        let material = isotropic(MATERIAL.0, MATERIAL.1)?;
        let displacement = move |x| exact(below, x).0;
        cut_out(graded(below, cells)?, material, far, displacement, move |x| exact(below, x).1)
    };
    let bodies = [body(false)?, body(true)?];
    let compliance = 2.0 * (1.0 - MATERIAL.1 * MATERIAL.1) / MATERIAL.0;
    let gap = Gap::Given(ScalarData::function(move |x| compliance * x[0] * x[0]));
    Ok(pair(bodies, ["bottom", "top"], &gap)?.with_friction(0, law)?)
}
