//! Two stacked blocks with everything variable: the family of problems that the iteration must cope with.
//!
//! ```text
//!    u_y = −0.02 for x ≤ pressed, traction (0, lift) on the rest of the top and (0, pull) on the right side
//!   ┌──────────┐
//!   │ Ω₁, E₁ν₁ │ height₁     u_x = 0 on the left side
//!   ├──────────┤ Γ_C: y = 0
//!   │ Ω₂, E₂ν₂ │ height₂
//!   └──────────┘ clamped
//! ```
//! Plane strain, width 2. The paper's problem (`paper.rs`) is one member of the family, with
//! `pressed = 2`, `pull = 30`. No reference values: problems for counts and for bounds.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, FacetSelection, Made, block, isotropic, stacked,
};

/// One member of the family.
#[derive(Clone, Copy, Debug)]
pub struct Blocks {
    /// Young's moduli.
    pub young: [f64; 2],
    /// Poisson's ratios.
    pub poisson: [f64; 2],
    /// Heights.
    pub height: [f64; 2],
    /// The top is pressed for x up to this.
    pub pressed: f64,
    /// Vertical traction on the rest of the top.
    pub lift: f64,
    /// Vertical traction on the right side of the upper block.
    pub pull: f64,
    /// Cells along the width.
    pub cells: usize,
}

impl Default for Blocks {
    fn default() -> Self {
        Self {
            young: [2000.0, 1000.0],
            poisson: [0.3; 2],
            height: [1.0; 2],
            pressed: 2.0,
            lift: 0.0,
            pull: 30.0,
            cells: 18,
        }
    }
}

impl Blocks {
    /// The paper's loads with a contrast `E₁/E₂ = c`, `E₂ = 1000`, the pull small enough for the weaker body.
    pub fn contrast(c: f64) -> Self {
        let young = 1000.0 * c;
        Self { young: [young, 1000.0], pull: (0.02 * young).min(30.0), ..Self::default() }
    }

    /// The top pressed on half its length and lifted on the other: contact opens on about half of it, and the
    /// stress is singular where the pressed part ends.
    pub fn half_open(c: f64) -> Self {
        let young = 1000.0 * c;
        Self { young: [young, 1000.0], pressed: 1.0, lift: 5.0 * c.min(1.0), pull: 0.0, ..Self::default() }
    }

    /// Sets the cells along the width; cells stay about square.
    pub fn cells(self, cells: usize) -> Self {
        Self { cells, ..self }
    }

    /// Makes the problem.
    ///
    /// # Errors
    /// None, for sensible numbers.
    pub fn problem(&self) -> Made<ContactProblem> {
        let rows = |height: f64| ((self.cells as f64 * height / 2.0).round() as usize).max(2);
        let material = |b: usize| isotropic(self.young[b], self.poisson[b]);
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let pressed = FacetSelection::group("top").within([[0.0, self.pressed], everywhere]);
        let mut conditions = BoundaryConditions::new().displace("left", Some(0.0.into()), None).displace(
            pressed,
            None,
            Some((-0.02).into()),
        );
        if self.pressed < 2.0 && self.lift != 0.0 {
            let rest = FacetSelection::group("top").within([[self.pressed, 2.0], everywhere]);
            conditions = conditions.traction(rest, [0.0.into(), self.lift.into()]);
        }
        if self.pull != 0.0 {
            conditions = conditions.traction("right", [0.0.into(), self.pull.into()]);
        }
        let [h1, h2] = self.height;
        let upper =
            Body::new(block([0.0, 0.0], [2.0, h1], [self.cells, rows(h1)])?, material(0)?, &conditions)?;
        let lower = Body::new(
            block([0.0, -h2], [2.0, h2], [self.cells, rows(h2)])?,
            material(1)?,
            &BoundaryConditions::new().fix("bottom"),
        )?;
        stacked([upper, lower])
    }
}
