//! The linear problem of a set of closed rows, by conjugate gradients that the Neumann problems of step 2 precondition and a coarse space
//! of all rigid motions balances.
//!
//! ```math
//! S_A λ = Nᵀ (g − S x₀),   S_A = Nᵀ S N           M = (I − Z C⁺ Zᵀ S_A) Dᵀ S⁺ D,   Z = Dᵀ R,   C = Zᵀ S_A Z
//! η² = r·M r = Σ ‖w_α‖²,   w_α = S_α⁺ D_α r,   0 where the closed rows fix traces
//! ```

use crate::broken::{Broken, Load};
use crate::coarse::CoarseSpace;
use crate::error::BalancingError;
use crate::fixed_traces::FixedTraces;
use crate::skeleton::Skeleton;
use crate::vector::dot;

/// η that rises below this fraction of the energy norm is noise.
const NOISE: f64 = 1e-10;

/// Inner iterations in which η must halve.
const PATIENCE: usize = 10;

/// The same with subdomains: rigid motions alone are a poor coarse space of nearly incompressible ones, and η falls slowly and not at every iteration.
const PATIENCE_OF_SUBDOMAINS: usize = 100;

/// The operators of the linear problem.
pub struct Balancing {
    /// The unknowns.
    pub skeleton: Skeleton,
    fixed: FixedTraces,
    coarse: CoarseSpace,
}

/// The traces and forces of an inner iteration.
pub struct Inner {
    /// `u_D`: the traces, one λ per cluster, m.
    pub x: Vec<f64>,
    /// `g − S x`, N/m.
    pub forces: Vec<f64>,
    /// `r = Nᵀ (g − S x)`, N/m.
    pub residual: Vec<f64>,
    /// `η² = r·M r`, and the direction of the next update of λ, m.
    pub squared: f64,
    direction: Vec<f64>,
    /// The forces that hold fixed traces in step 2, N/m.
    holding: Vec<f64>,
    /// Inner iterations so far.
    pub count: usize,
    /// The energy by which noise is known: of the first traces, `xᵀ S x`, or of the loads if it is larger.
    pub energy: f64,
    /// The last η² that was half of the one before, and the iterations since.
    mark: f64,
    idle: usize,
}

/// The answer of step 2.
struct Step2 {
    /// `M r`, m.
    direction: Vec<f64>,
    /// `η² = r·M r`.
    squared: f64,
    /// See [`Inner::holding`].
    holding: Vec<f64>,
}

impl Balancing {
    /// # Errors
    /// Numbers that are not finite.
    pub fn new(broken: &Broken<'_>, skeleton: Skeleton) -> Result<Self, BalancingError> {
        let fixed = FixedTraces::new(broken, |k| skeleton.is_fixed(k));
        let coarse = CoarseSpace::new(broken, &skeleton)?;
        Ok(Self { skeleton, fixed, coarse })
    }

    /// Computes `S N λ` and `S_A λ`, N/m.
    fn operator(&self, broken: &Broken<'_>, lambda: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let forces = broken.stiffness(&self.skeleton.expand(lambda));
        let sums = self.skeleton.gather(&forces);
        (forces, sums)
    }

    /// Step 1: λ is the mean of given traces, and the coarse space balances what that leaves.
    pub fn step_1(&self, broken: &Broken<'_>, load: &Load, x: &[f64]) -> Inner {
        let skeleton = &self.skeleton;
        let shifted: Vec<f64> = x.iter().zip(skeleton.constant()).map(|(x, c)| x - c).collect();
        let mut x = skeleton.expand(&skeleton.mean(&shifted));
        x.iter_mut().zip(skeleton.constant()).for_each(|(x, c)| *x += c);
        let mut forces = load.forces.clone();
        subtract(&mut forces, 1.0, &broken.stiffness(&x));
        // λ += Z C⁺ Zᵀ r, twice, so that the bodies balance to round-off.
        for _ in 0..2 {
            let residual = skeleton.gather(&forces);
            let lambda = self.coarse.apply(&residual);
            subtract(&mut x, -1.0, &skeleton.expand(&lambda));
            subtract(&mut forces, 1.0, &self.operator(broken, &lambda).0);
        }
        let residual = skeleton.gather(&forces);
        let Step2 { direction, squared, holding } = self.step_2(broken, &residual);
        let energy = load.size.max(dot(&x, &load.forces) - dot(&x, &forces));
        Inner { energy, x, forces, residual, squared, direction, holding, count: 0, mark: squared, idle: 0 }
    }

    /// [`Self::step_1`] at the traces of an earlier solve: what they leave asks for a correction, whose own size says what is noise.
    pub fn step_1_again(&self, broken: &Broken<'_>, load: &Load, x: &[f64]) -> Inner {
        let mut inner = self.step_1(broken, load, x);
        inner.energy = inner.squared;
        inner
    }

    /// Step 2: the Neumann problems of all bodies under their shares of the imbalance.
    fn step_2(&self, broken: &Broken<'_>, residual: &[f64]) -> Step2 {
        let shares = self.skeleton.share(residual);
        let mut traces = broken.flexibility(&shares);
        let holding = self.fixed.hold(broken, &shares, &mut traces);
        let mut w = self.skeleton.mean(&traces);
        let squared = dot(residual, &w);
        // `Zᵀ r`, which is rounding, is balanced too: else it would stay, and grow in the end.
        let mut unbalanced = self.operator(broken, &w).1;
        subtract(&mut unbalanced, 1.0, residual);
        subtract(&mut w, 1.0, &self.coarse.apply(&unbalanced));
        Step2 { direction: w, squared, holding }
    }

    /// Takes one inner iteration, the update of λ; `false` if rounding leaves nothing to gain.
    pub fn update(&self, broken: &Broken<'_>, inner: &mut Inner) -> bool {
        let (forces, sums) = self.operator(broken, &inner.direction);
        let theta = inner.squared / dot(&inner.direction, &sums);
        if !(theta > 0.0 && theta.is_finite()) {
            return false;
        }
        let mut residual = inner.residual.clone();
        subtract(&mut residual, theta, &sums);
        let Step2 { direction: correction, squared, holding } = self.step_2(broken, &residual);
        // Near round-off an increase is noise, which would grow.
        if !(squared <= inner.squared) && inner.squared <= NOISE * NOISE * inner.energy {
            return false;
        }
        subtract(&mut inner.x, -theta, &self.skeleton.expand(&inner.direction));
        subtract(&mut inner.forces, theta, &forces);
        let direction = inner.direction.iter_mut().zip(&correction);
        direction.for_each(|(p, z)| *p = z + squared / inner.squared * *p);
        (inner.residual, inner.squared, inner.holding) = (residual, squared, holding);
        inner.count += 1;
        inner.idle += 1;
        if squared <= 0.25 * inner.mark {
            (inner.mark, inner.idle) = (squared, 0);
        }
        inner.idle < if broken.shares() { PATIENCE_OF_SUBDOMAINS } else { PATIENCE }
    }

    /// Bounds the energy of the displacements under forces in balance, `f·S_A⁺ f ≤ f·M f`: equal to it if no displacement is shared and no row closed.
    ///
    /// * `forces`: on the unknowns, N/m.
    pub fn energy_bound(&self, broken: &Broken<'_>, forces: &[f64]) -> f64 {
        let residual = self.skeleton.gather(forces);
        let lambda = self.coarse.apply(&residual);
        let mut rest = residual.clone();
        subtract(&mut rest, 1.0, &self.operator(broken, &lambda).1);
        dot(&lambda, &residual) + self.step_2(broken, &rest).squared
    }

    /// Returns the forces on the unknowns that the closed rows press, balanced: `g − S (x + w)`, N/m.
    pub fn balanced(&self, inner: &Inner) -> Vec<f64> {
        let mut balanced = inner.forces.clone();
        subtract(&mut balanced, 1.0, &self.skeleton.share(&inner.residual));
        subtract(&mut balanced, -1.0, &inner.holding);
        balanced
    }
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= factor * b);
}
