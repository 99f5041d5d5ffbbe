//! The linear problem of a set of closed rows, by conjugate gradients that the Neumann problems of step 2 precondition and a coarse space
//! of all rigid motions balances.
//!
//! ```math
//! S_A λ = Nᵀ (g − S x₀),   S_A = Nᵀ S N           M = (I − Z C⁺ Zᵀ S_A) Dᵀ S⁺ D,   Z = Dᵀ R,   C = Zᵀ S_A Z
//! η² = r·M r = Σ ‖w_α‖²,   w_α = S_α⁺ D_α r,   0 where the closed rows fix traces
//! ```

use crate::broken::{Broken, Sparse};
use crate::fixed_traces::FixedTraces;
use crate::skeleton::Skeleton;
use crate::vector::dot;
use fem_core::each_body;
use nalgebra::DMatrix;

/// A column of the coarse space that keeps less than this fraction of its energy beside the others depends on them.
const RANK: f64 = 1e-10;

/// η that rises below this fraction of the energy norm is noise.
const NOISE: f64 = 1e-10;

/// Inner iterations in which η must halve.
const PATIENCE: usize = 10;

/// The operators of the linear problem.
pub(crate) struct Balancing<'a> {
    broken: &'a Broken<'a>,
    pub(crate) skeleton: Skeleton,
    fixed: FixedTraces,
    /// Columns of `Z`, independent ones, each with energy 1, and of `S_A Z`.
    columns: Vec<(Sparse, Sparse)>,
    /// The Cholesky factor of `C`.
    factor: DMatrix<f64>,
}

/// The traces and forces of an inner iteration.
pub(crate) struct Inner {
    /// `u_D`: the traces, one λ per cluster, m.
    pub(crate) x: Vec<f64>,
    /// `g − S x`, N/m.
    pub(crate) forces: Vec<f64>,
    /// `r = Nᵀ (g − S x)`, N/m.
    pub(crate) residual: Vec<f64>,
    /// `η² = r·M r`, and the direction of the next update of λ, m.
    pub(crate) squared: f64,
    direction: Vec<f64>,
    /// The forces that hold fixed traces in step 2, N/m.
    holding: Vec<f64>,
    /// Inner iterations so far.
    pub(crate) count: usize,
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

impl Inner {
    /// Computes the energy of the traces, `xᵀ S x`, or of the loads if it is larger.
    pub(crate) fn energy(&self, linear: &Balancing<'_>) -> f64 {
        let Broken { load, size, .. } = linear.broken;
        size.max(dot(&self.x, load) - dot(&self.x, &self.forces))
    }
}

impl<'a> Balancing<'a> {
    pub(crate) fn new(broken: &'a Broken<'a>, skeleton: Skeleton) -> Self {
        let fixed = FixedTraces::new(broken, |k| skeleton.is_fixed(k));
        let mut made = Self { broken, skeleton, fixed, columns: Vec::new(), factor: DMatrix::zeros(0, 0) };
        made.coarse_space();
        made
    }

    /// Finds the independent columns of `Z`, and the Cholesky factor of `C`, the column of largest energy first.
    fn coarse_space(&mut self) {
        let Self { broken, skeleton, .. } = &*self;
        let motions = broken.motions();
        let column = |k: usize| {
            let z = match motions[k][..] {
                // An obstacle has no stiffness to weigh it by.
                [(unknown, _)] if broken.is_obstacle(unknown) => skeleton.gather_sparse(&motions[k]),
                _ => skeleton.mean_sparse(&motions[k]),
            };
            let moved = skeleton.gather_sparse(&broken.stiffness_sparse(&skeleton.expand_sparse(&z)));
            let mut energy = 0.0;
            merge(&z, &moved, |z, s| energy += z * s);
            let scaled = |of: Sparse| of.into_iter().map(|(k, value)| (k, value / energy.sqrt())).collect();
            (energy > 0.0).then(|| [z, moved].map(scaled))
        };
        let all: Vec<[Sparse; 2]> = each_body(motions.len(), column).into_iter().flatten().collect();
        let mut dense = vec![0.0; skeleton.len()];
        let mut matrix = DMatrix::zeros(all.len(), all.len());
        for (j, [_, moved]) in all.iter().enumerate() {
            moved.iter().for_each(|(k, value)| dense[*k] = *value);
            (0..all.len()).for_each(|i| matrix[(i, j)] = all[i][0].iter().map(|(k, z)| z * dense[*k]).sum());
            moved.iter().for_each(|(k, _)| dense[*k] = 0.0);
        }
        let (order, factor) = independent(matrix);
        let mut all: Vec<Option<[Sparse; 2]>> = all.into_iter().map(Some).collect();
        self.columns = order.iter().filter_map(|k| all[*k].take()).map(|[z, moved]| (z, moved)).collect();
        self.factor = factor;
    }

    /// Computes `S N λ` and `S_A λ`, N/m.
    fn operator(&self, lambda: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let forces = self.broken.stiffness(&self.skeleton.expand(lambda));
        let sums = self.skeleton.gather(&forces);
        (forces, sums)
    }

    /// Computes `C⁺ f` for one number per column.
    fn coarse(&self, f: &[f64]) -> Vec<f64> {
        let (l, n, mut a) = (&self.factor, f.len(), f.to_vec());
        for i in 0..n {
            a[i] = (a[i] - (0..i).map(|j| l[(i, j)] * a[j]).sum::<f64>()) / l[(i, i)];
        }
        for i in (0..n).rev() {
            a[i] = (a[i] - (i + 1..n).map(|j| l[(j, i)] * a[j]).sum::<f64>()) / l[(i, i)];
        }
        a
    }

    /// Step 1: λ is the mean of given traces, and the coarse space balances what that leaves.
    pub(crate) fn step_1(&self, x: &[f64]) -> Inner {
        let Self { broken, skeleton, .. } = self;
        let shifted: Vec<f64> = x.iter().zip(skeleton.constant()).map(|(x, c)| x - c).collect();
        let mut x = skeleton.expand(&skeleton.mean(&shifted));
        x.iter_mut().zip(skeleton.constant()).for_each(|(x, c)| *x += c);
        let mut forces = broken.load.clone();
        subtract(&mut forces, 1.0, &broken.stiffness(&x));
        // λ += Z C⁺ Zᵀ r, twice, so that the bodies balance to round-off.
        for _ in 0..2 {
            let residual = skeleton.gather(&forces);
            let loads: Vec<f64> = self.columns.iter().map(|(z, _)| part(z, &residual)).collect();
            let mut lambda = vec![0.0; residual.len()];
            for ((z, _), amount) in self.columns.iter().zip(self.coarse(&loads)) {
                z.iter().for_each(|(k, value)| lambda[*k] += amount * value);
            }
            subtract(&mut x, -1.0, &skeleton.expand(&lambda));
            subtract(&mut forces, 1.0, &self.operator(&lambda).0);
        }
        let residual = skeleton.gather(&forces);
        let Step2 { direction, squared, holding } = self.step_2(&residual);
        Inner { x, forces, residual, squared, direction, holding, count: 0, mark: squared, idle: 0 }
    }

    /// Step 2: the Neumann problems of all bodies under their shares of the imbalance.
    fn step_2(&self, residual: &[f64]) -> Step2 {
        let shares = self.skeleton.share(residual);
        let mut traces = self.broken.flexibility(&shares);
        let holding = self.fixed.hold(self.broken, &shares, &mut traces);
        let mut w = self.skeleton.mean(&traces);
        let squared = dot(residual, &w);
        let loads: Vec<f64> = self.columns.iter().map(|(_, moved)| part(moved, &w)).collect();
        for ((z, _), amount) in self.columns.iter().zip(self.coarse(&loads)) {
            z.iter().for_each(|(k, value)| w[*k] -= amount * value);
        }
        Step2 { direction: w, squared, holding }
    }

    /// Takes one inner iteration, the update of λ; `false` if rounding leaves nothing to gain.
    pub(crate) fn update(&self, inner: &mut Inner) -> bool {
        let (forces, sums) = self.operator(&inner.direction);
        let theta = inner.squared / dot(&inner.direction, &sums);
        if !(theta > 0.0 && theta.is_finite()) {
            return false;
        }
        let mut residual = inner.residual.clone();
        subtract(&mut residual, theta, &sums);
        let Step2 { direction: correction, squared, holding } = self.step_2(&residual);
        // Near round-off an increase is noise, which would grow.
        if !(squared <= inner.squared) && inner.squared <= NOISE * NOISE * inner.energy(self) {
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

    /// Returns the forces on the unknowns that the closed rows press, balanced: `g − S (x + w)`, N/m.
    pub(crate) fn balanced(&self, inner: &Inner) -> Vec<f64> {
        let mut balanced = inner.forces.clone();
        subtract(&mut balanced, 1.0, &self.skeleton.share(&inner.residual));
        subtract(&mut balanced, -1.0, &inner.holding);
        balanced
    }
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

/// Chooses independent columns of a positive semi-definite matrix, whose diagonal is 1, and factorises their block.
fn independent(mut matrix: DMatrix<f64>) -> (Vec<usize>, DMatrix<f64>) {
    let n = matrix.nrows();
    let (mut order, mut rest): (Vec<usize>, Vec<usize>) = (Vec::new(), (0..n).collect());
    let mut columns: Vec<Vec<f64>> = Vec::new();
    while let Some(place) = (0..rest.len())
        .max_by(|a, b| matrix[(rest[*a], rest[*a])].total_cmp(&matrix[(rest[*b], rest[*b])]).then(b.cmp(a)))
    {
        let k = rest.remove(place);
        let pivot = matrix[(k, k)];
        if !(pivot > RANK) {
            break;
        }
        let root = pivot.sqrt();
        let column: Vec<f64> = (0..n).map(|i| matrix[(i, k)] / root).collect();
        let met: Vec<usize> = rest.iter().copied().filter(|i| column[*i] != 0.0).collect();
        for j in &met {
            met.iter().for_each(|i| matrix[(*i, *j)] -= column[*i] * column[*j]);
        }
        order.push(k);
        columns.push(column);
    }
    let rank = order.len();
    let factor = DMatrix::from_fn(rank, rank, |i, j| if j <= i { columns[j][order[i]] } else { 0.0 });
    (order, factor)
}
