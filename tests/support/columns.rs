//! Two heavy columns between smooth walls: contact in one dimension, solved exactly, with data that linear triangles
//! represent exactly.
//!
//! ```text
//!    u_y = −d
//!   o┌──────┐o 2      rollers on both sides and at the bottom; body forces (0, −b_α);
//!   o│  Ω₁  │o        an initial gap g between y = 1⁺ and y = 1⁻
//!   o├ Γ_C ─┤o 1
//!   o│  Ω₂  │o
//!   o└──────┘o 0
//!     o  o  o
//! ```
//! Units: any consistent set. Exact: with the confined modulus `M = E(1−ν)/((1+ν)(1−2ν))`, `M u'' = b`, the stress
//! `−p ± b·(distance from Γ_C)` is linear and u quadratic in y. Plane strain, width [`WIDTH`].

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, Made, SymTensor2, Vector, block, isotropic, pair,
};

/// Width of the columns.
pub const WIDTH: f64 = 2.0;

/// The data that vary.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    /// Young's modulus and Poisson's ratio of each body.
    pub materials: [(f64, f64); 2],
    /// Weights per area.
    pub weights: [f64; 2],
    /// Displacement of the top, downwards.
    pub push: f64,
    /// Initial gap.
    pub gap: f64,
}

/// The exact values.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// `a(u, u)` of both bodies.
    pub energy_norm_squared: f64,
    /// `½ a(u, u) − ℓ(u)`.
    pub potential_energy: f64,
    /// `∫ p ds`.
    pub contact_force: f64,
}

impl Columns {
    /// Heavy columns of different stiffness, pushed over a gap; the lower one has `E₂ = 1000`.
    pub fn contrast(contrast: f64) -> Self {
        let young = 1000.0 * contrast;
        let materials = [(young, 0.3), (1000.0, 0.2)];
        Self { materials, weights: [0.01 * young, 30.0], push: 0.01, gap: 0.001 }
    }

    fn moduli(&self) -> [f64; 2] {
        self.materials.map(|(e, nu)| e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)))
    }

    /// The problem on `n × n` cells per body.
    ///
    /// # Errors
    /// None, for sensible numbers.
    pub fn problem(&self, n: usize) -> Made<ContactProblem> {
        let material = |b: usize| {
            let (e, nu) = self.materials[b];
            isotropic(e, nu)
        };
        let walls = || BoundaryConditions::new().roller("left", 0.0).roller("right", 0.0);
        let upper = Body::new(
            block([0.0, 1.0], [WIDTH, 1.0], [n, n])?,
            material(0)?,
            &walls().displace("top", None, Some((-self.push).into())).body_force([0.0, -self.weights[0]]),
        )?;
        let lower = Body::new(
            block([0.0, 0.0], [WIDTH, 1.0], [n, n])?,
            material(1)?,
            &walls().roller("bottom", 0.0).body_force([0.0, -self.weights[1]]),
        )?;
        let gap = Gap::Given(self.gap.into());
        pair([upper, lower], ["bottom", "top"], &gap)
    }

    /// The exact stress of a body: `σ_yy = −p ± b·(distance from Γ_C)`, and what the walls add.
    pub fn stress(&self, body: usize, x: Vector) -> SymTensor2 {
        let p = self.exact().contact_force / WIDTH;
        let nu = self.materials[body].1;
        let vertical = -p + self.weights[body] * (x[1] - 1.0);
        SymTensor2::new(nu / (1.0 - nu) * vertical, vertical, 0.0)
    }

    /// The exact solution; the pressure is zero if the gap stays open.
    pub fn exact(&self) -> Exact {
        let [m1, m2] = self.moduli();
        let [b1, b2] = self.weights;
        // Opening g + u₁(1) − u₂(1) with u₁(1) = −d + p/M₁ − b₁/(2M₁), u₂(1) = −p/M₂ − b₂/(2M₂).
        let overlap = self.push - self.gap + 0.5 * b1 / m1 - 0.5 * b2 / m2;
        let p = (overlap / (1.0 / m1 + 1.0 / m2)).max(0.0);
        // ∫ σ²/M over the height: σ = −p + b₁ s above, −p − b₂ s below, s the distance from Γ_C.
        let energy = |s: f64, b: f64, m: f64| (p * p - s * p * b + b * b / 3.0) / m;
        let a = WIDTH * (energy(1.0, b1, m1) + energy(-1.0, b2, m2));
        // ℓ(u) = −b ∫ u: u₁ = u₁(1) + (−p s + b₁ s²/2)/M₁ above; u₂ = u₂(1) + (p s + b₂ s²/2)/M₂ below.
        let u1 = -self.push + (p - 0.5 * b1) / m1;
        let u2 = -(p + 0.5 * b2) / m2;
        let mean = [u1 + (-0.5 * p + b1 / 6.0) / m1, u2 + (0.5 * p + b2 / 6.0) / m2];
        let work = -WIDTH * (b1 * mean[0] + b2 * mean[1]);
        Exact { energy_norm_squared: a, potential_energy: 0.5 * a - work, contact_force: WIDTH * p }
    }
}
