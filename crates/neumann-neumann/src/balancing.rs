//! The linear problem of a set of closed rows, by conjugate gradients that the Neumann problems of step 2 precondition and a coarse space
//! of all rigid motions balances.
//!
//! ```math
//! S_A λ = Nᵀ (g − S x₀),   S_A = Nᵀ S N           M = (I − Z C⁺ Zᵀ S_A) Dᵀ S⁺ D,   Z = Dᵀ R,   C = Zᵀ S_A Z
//! η² = r·M r = Σ ‖w_α‖²,   w_α = S_α⁺ D_α r,   0 where the closed rows fix traces
//! ```

use crate::broken::{Broken, Load, Sparse};
use crate::error::BalancingError;
use crate::fixed_traces::FixedTraces;
use crate::skeleton::Skeleton;
use crate::vector::dot;
use contact_qp::SparseFactor;
use fem_core::each_body;

/// A column of the coarse space that keeps less than this fraction of its energy beside the others depends on them.
const RANK: f64 = 1e-10;

/// A motion with less than this fraction of the energy of its traces, each alone, is not resisted.
const RESISTED: f64 = 1e-13;

/// η that rises below this fraction of the energy norm is noise.
const NOISE: f64 = 1e-10;

/// Inner iterations in which η must halve.
const PATIENCE: usize = 10;

/// The operators of the linear problem.
pub struct Balancing {
    /// The unknowns.
    pub skeleton: Skeleton,
    fixed: FixedTraces,
    /// Columns of `Z`, each with energy 1, and of `S_A Z`.
    columns: Vec<(Sparse, Sparse)>,
    /// The factor of `C`, which leaves dependent columns out.
    factor: SparseFactor,
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
    /// The energy of the first traces, `xᵀ S x`, or of the loads if it is larger.
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
        let (columns, factor) = coarse_space(broken, &skeleton)?;
        Ok(Self { skeleton, fixed, columns, factor })
    }

    /// Computes `S N λ` and `S_A λ`, N/m.
    fn operator(&self, broken: &Broken<'_>, lambda: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let forces = broken.stiffness(&self.skeleton.expand(lambda));
        let sums = self.skeleton.gather(&forces);
        (forces, sums)
    }

    /// Computes `Z C⁺ f` for one number per column.
    fn coarse(&self, mut f: Vec<f64>) -> Vec<f64> {
        self.factor.solve(&mut f);
        let mut lambda = vec![0.0; self.skeleton.len()];
        for ((z, _), amount) in self.columns.iter().zip(f) {
            z.iter().for_each(|(k, value)| lambda[*k] += amount * value);
        }
        lambda
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
            let loads: Vec<f64> = self.columns.iter().map(|(z, _)| part(z, &residual)).collect();
            let lambda = self.coarse(loads);
            subtract(&mut x, -1.0, &skeleton.expand(&lambda));
            subtract(&mut forces, 1.0, &self.operator(broken, &lambda).0);
        }
        let residual = skeleton.gather(&forces);
        let Step2 { direction, squared, holding } = self.step_2(broken, &residual);
        let energy = load.size.max(dot(&x, &load.forces) - dot(&x, &forces));
        Inner { energy, x, forces, residual, squared, direction, holding, count: 0, mark: squared, idle: 0 }
    }

    /// Step 2: the Neumann problems of all bodies under their shares of the imbalance.
    fn step_2(&self, broken: &Broken<'_>, residual: &[f64]) -> Step2 {
        let shares = self.skeleton.share(residual);
        let mut traces = broken.flexibility(&shares);
        let holding = self.fixed.hold(broken, &shares, &mut traces);
        let mut w = self.skeleton.mean(&traces);
        let squared = dot(residual, &w);
        let loads: Vec<f64> = self.columns.iter().map(|(_, moved)| part(moved, &w)).collect();
        subtract(&mut w, 1.0, &self.coarse(loads));
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
        inner.idle < PATIENCE
    }

    /// Bounds the energy of the displacements under forces in balance, `f·S_A⁺ f ≤ f·M f`: equal to it if no displacement is shared and no row closed.
    ///
    /// * `forces`: on the unknowns, N/m.
    pub fn energy_bound(&self, broken: &Broken<'_>, forces: &[f64]) -> f64 {
        let residual = self.skeleton.gather(forces);
        let loads: Vec<f64> = self.columns.iter().map(|(z, _)| part(z, &residual)).collect();
        let lambda = self.coarse(loads);
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

/// Lists the columns of `Z` and of `S_A Z`, and factorises `C`: most columns have no λ in common.
fn coarse_space(
    broken: &Broken<'_>,
    skeleton: &Skeleton,
) -> Result<(Vec<(Sparse, Sparse)>, SparseFactor), BalancingError> {
    let motions = broken.motions();
    let column = |k: usize| {
        let z = match motions[k][..] {
            // An obstacle has no stiffness to weigh it by.
            [(unknown, _)] if broken.is_obstacle(unknown) => skeleton.gather_sparse(&motions[k]),
            _ => skeleton.mean_sparse(&motions[k]),
        };
        let moved = skeleton.gather_sparse(&broken.stiffness_sparse(&skeleton.expand_sparse(&z)));
        let (mut energy, mut size) = (0.0, 0.0);
        merge(&z, &moved, |z, s| energy += z * s);
        z.iter().for_each(|(k, value)| size += value * value * skeleton.stiffness_of(*k));
        let scaled = |of: Sparse| of.into_iter().map(|(k, value)| (k, value / energy.sqrt())).collect();
        // A motion that nothing resists has rounding alone.
        (energy > RESISTED * size).then(|| (scaled(z), scaled(moved)))
    };
    let columns: Vec<(Sparse, Sparse)> = each_body(motions.len(), column).into_iter().flatten().collect();
    let mut by_lambda = vec![Vec::new(); skeleton.len()];
    for (i, (z, _)) in columns.iter().enumerate() {
        z.iter().for_each(|(k, z)| by_lambda[*k].push((i, *z)));
    }
    let (mut entries, mut column, mut met) = (Vec::new(), vec![0.0; columns.len()], Vec::new());
    for (j, (_, moved)) in columns.iter().enumerate() {
        for (k, s) in moved {
            for (i, z) in &by_lambda[*k] {
                if column[*i] == 0.0 {
                    met.push(*i);
                }
                column[*i] += z * s;
            }
        }
        let own = met.drain(..).map(|i| (i, j, std::mem::take(&mut column[i])));
        entries.extend(own.filter(|(i, j, entry)| i <= j && *entry != 0.0));
    }
    let factor = SparseFactor::semi_definite(columns.len(), entries, RANK)?;
    Ok((columns, factor))
}

fn part(sparse: &Sparse, all: &[f64]) -> f64 {
    sparse.iter().map(|(k, value)| value * all[*k]).sum()
}

/// Calls a function for every number that two vectors have in common.
fn merge(a: &Sparse, b: &Sparse, mut both: impl FnMut(f64, f64)) {
    let mut b = b.iter().peekable();
    for (k, value) in a {
        while b.next_if(|(other, _)| other < k).is_some() {}
        if let Some((_, other)) = b.next_if(|(other, _)| other == k) {
            both(*value, *other);
        }
    }
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= factor * b);
}
