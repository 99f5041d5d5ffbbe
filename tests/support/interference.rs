//! Press fits: two blocks whose surfaces overlap at one end, and two rings of which the outer one is too small.
//!
//! ```text
//!   u_y = 0, traction (0, 30) on x = 2        ___c___
//!      ┌─────────────┐ u_x = 0 on x = 0     /  _b_   \      A ≤ r ≤ B: E = 1000, the first body
//!      │ Ω₁, E = 2000│                     | / ,a. \  |     B ≤ r ≤ C: E = 2000
//!      ├─────────────┤ g = −0.02 + 0.015 x | | | | |  |     g = −0.01, rollers on both axes
//!      │ Ω₂, E = 1000│
//!      └─────────────┘ clamped
//! ```
//! Units: any consistent set. ν = 0.3, plane strain. The figures are those of an independent prototype in another language; the rings also have
//! Lamé's exact solution.

use crate::model::{Body, BoundaryConditions, ContactProblem, Gap, Made, ScalarData, isotropic, pair, ring};
use crate::paper;
use crate::rings::Lame;

/// The figures of a press fit.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// `a(u, u)` of both bodies.
    pub energies: [f64; 2],
    /// The sum of the nodal forces, and the number of nodes with one.
    pub force: (f64, usize),
    /// `e_CRE` by EET alone, after two steps, to three digits, and the best in the space.
    pub bounds: [f64; 3],
}

/// The figures of [`blocks`] on 18×9 cells.
pub const BLOCKS: Figures = Figures {
    energies: [0.57698919944, 0.105315888349],
    force: (10.7828197305, 11),
    bounds: [0.54995555931, 0.2007, 0.183858763997],
};
/// `2 ∫ p o` of [`blocks`].
pub const BLOCKS_CONTACT: f64 = 9.0705748322e-06;
/// The figures of [`rings`] on 12×6 cells.
pub const RINGS: Figures = Figures {
    energies: [0.0283335204297, 0.0346514117295],
    force: (6.29849321592, 13),
    bounds: [0.0675151313862, 0.02437, 0.0223919558898],
};
/// `η_NNDD` of the first iterations of [`paper_with`] a gap of −0.02 and the top held, from `λ = 0`.
pub const ETA: [f64; 3] = [1.064346768, 0.151378893, 0.05090589421];

/// The radii of the rings, m.
pub const RADII: [f64; 3] = [0.5, 1.0, 1.5];
/// The interference of the rings, m.
pub const DELTA: f64 = 0.01;
/// Young's modulus and Poisson's ratio of the inner and of the outer ring.
pub const MATERIALS: [(f64, f64); 2] = [(1000.0, 0.3), (2000.0, 0.3)];

/// The paper's blocks with the top held and a gap.
///
/// # Errors
/// None, for sensible numbers.
pub fn paper_with(gap: ScalarData) -> Made<ContactProblem> {
    let problem = paper::problem_with(paper::COARSE, paper::YOUNG, paper::TRACTION, 0.0, 0.0)?;
    let Ok(bodies) = <[Body; 2]>::try_from(problem.bodies) else { return Err("two bodies".into()) };
    pair(bodies, ["bottom", "top"], &Gap::Given(gap))
}

/// Blocks that overlap for x < 4/3.
///
/// # Errors
/// None.
pub fn blocks() -> Made<ContactProblem> {
    paper_with(ScalarData::function(|x| -0.02 + 0.015 * x[0]))
}

/// A quarter of the rings, with `[around, across]` cells in each.
///
/// # Errors
/// None, for sensible numbers.
pub fn rings(cells: [usize; 2], gap: f64) -> Made<ContactProblem> {
    let [a, b, c] = RADII;
    let body = |(young, poisson): (f64, f64), radii| -> Made<Body> {
        let rollers = BoundaryConditions::new().roller("start", 0.0).roller("end", 0.0);
        Ok(Body::new(ring([0.0; 2], radii, [0.0, 90.0], cells)?, isotropic(young, poisson)?, &rollers)?)
    };
    let bodies = [body(MATERIALS[0], [a, b])?, body(MATERIALS[1], [b, c])?];
    pair(bodies, ["outer", "inner"], &Gap::Given(gap.into()))
}

/// The exact pressure between the rings for an interference `δ`, Pa, by Lamé:
/// `p = δ / (b [ (1/E_o')((c²+b²)/(c²−b²) + ν_o') + (1/E_i')((b²+a²)/(b²−a²) − ν_i') ])`, in plane strain `E' = E/(1−ν²)`, `ν' = ν/(1−ν)`.
pub fn pressure(delta: f64) -> f64 {
    let [a, b, c] = RADII.map(|r| r * r);
    let [(e_i, nu_i), (e_o, nu_o)] = MATERIALS.map(|(e, nu)| (e / (1.0 - nu * nu), nu / (1.0 - nu)));
    let outer = ((c + b) / (c - b) + nu_o) / e_o;
    let inner = ((b + a) / (b - a) - nu_i) / e_i;
    delta / (RADII[1] * (outer + inner))
}

/// The exact stresses of both rings.
pub fn exact(delta: f64) -> [Lame; 2] {
    let [a, b, c] = RADII;
    let p = pressure(delta);
    [Lame::new([a, b], [0.0, p]), Lame::new([b, c], [p, 0.0])]
}
