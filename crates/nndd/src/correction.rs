//! Step 2: the direction in which λ is updated.
//!
//! ```math
//! w = M j,   j = P^1 − P^2,   M = ∑_α σ_α D_α Φ̃_α D_α σ_α + Z (Zᵀ S₀ Z)⁺ Zᵀ,   S₀ = ∑_α σ_α S_α σ_α
//! ```
//! `σ` is + in the rows where a body carries λ and − in the others, `D` shares the imbalance `j` between the two bodies
//! of a row. With the paper's weights `D = ½`, whose update is `w¹ − w²` and not `½ w¹ − ½ w²`, the direction is `2 M j`: θ is the paper's. Against an obstacle `σ` is 0. A held body has `Φ̃ = S⁻¹`. A floating one is put on springs that see rigid
//! motions only, `Φ̃ = (S + s̄ Q Qᵀ)⁻¹` with `s̄ = tr S/n`. Without the coarse space of its motions (Mandel 1993),
//! `Z = [σ_α D_α Q_α]`, a load would pass one body per iteration.

use crate::settings::Weights;
use crate::subdomain::Subdomain;
use fem_core::each_body;
use nalgebra::{DMatrix, DVector};
use neumann_neumann::dot;

/// Eigenvalues of the coarse operator below this fraction of the largest one are zero.
const RIGID: f64 = 1e-10;

/// The operator `M`.
pub(crate) struct Correction<'a> {
    bodies: &'a [Subdomain<'a>],
    /// `σ D` of each body, by row of the body.
    shares: Vec<DVector<f64>>,
    /// `1/s̄` of each body.
    springs: Vec<f64>,
    coarse: Option<Coarse>,
    /// The factor of `M j` in the update of λ, dimensionless.
    scale: f64,
}

/// The coarse space: `Z`, one column per motion, and `(ZᵀS_0Z)⁺`.
struct Coarse {
    columns: Vec<Vec<f64>>,
    inverse: DMatrix<f64>,
}

impl<'a> Correction<'a> {
    /// * `rows`: the number of rows of the assembly.
    pub(crate) fn new(bodies: &'a [Subdomain<'a>], rows: usize, weights: Weights, coarse: bool) -> Self {
        let diagonals = each_body(bodies.len(), |b| bodies[b].diagonal());
        let mut sums = vec![0.0; rows];
        for (body, diagonal) in bodies.iter().zip(&diagonals) {
            body.rows.iter().zip(diagonal.iter()).for_each(|(row, k)| sums[*row] += k);
        }
        let share = |(body, diagonal): (&Subdomain<'_>, &DVector<f64>)| match weights {
            Weights::Half => 0.5 * body.signs(),
            Weights::Stiffness => body.signs().component_mul(diagonal).component_div(&body.gather(&sums)),
        };
        let shares = bodies.iter().zip(&diagonals).map(share);
        let springs = diagonals.iter().map(|diagonal| 1.0 / diagonal.mean()).collect();
        let scale = match weights {
            Weights::Half => 2.0,
            Weights::Stiffness => 1.0,
        };
        let mut made = Self { bodies, shares: shares.collect(), springs, coarse: None, scale };
        if coarse {
            made.coarse = made.coarse_space(rows);
        }
        made
    }

    /// Returns the factor of `M j` in the update of λ.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Computes the direction of the update, `M j` times its factor.
    pub(crate) fn apply(&self, imbalance: &[f64]) -> Vec<f64> {
        let of_body = |b: usize| {
            let (body, share) = (&self.bodies[b], &self.shares[b]);
            let force = body.gather(imbalance).component_mul(share);
            self.neumann(b, force).component_mul(share)
        };
        let mut sum = vec![0.0; imbalance.len()];
        for (body, w) in self.bodies.iter().zip(each_body(self.bodies.len(), of_body)) {
            body.scatter(&w, &mut sum);
        }
        if let Some(Coarse { columns, inverse }) = &self.coarse {
            let loads =
                DVector::from_iterator(columns.len(), columns.iter().map(|column| dot(column, imbalance)));
            for (column, amount) in columns.iter().zip(&(inverse * loads)) {
                sum.iter_mut().zip(column).for_each(|(w, z)| *w += amount * z);
            }
        }
        sum.iter_mut().for_each(|w| *w *= self.scale);
        sum
    }

    /// Computes `S_0 v`.
    pub(crate) fn operator(&self, v: &[f64]) -> Vec<f64> {
        let of_body = |b: usize| {
            let (body, signs) = (&self.bodies[b], self.bodies[b].signs());
            let traces = body.gather(v).component_mul(&signs);
            // Most bodies have no part of a column of the coarse space.
            let seen = traces.iter().any(|v| *v != 0.0);
            if seen { body.stiffness(&traces).component_mul(&signs) } else { traces }
        };
        let mut sum = vec![0.0; v.len()];
        for (body, force) in self.bodies.iter().zip(each_body(self.bodies.len(), of_body)) {
            body.scatter(&force, &mut sum);
        }
        sum
    }

    /// Computes `Φ̃ f`.
    fn neumann(&self, b: usize, mut force: DVector<f64>) -> DVector<f64> {
        let body = &self.bodies[b];
        if !body.floats() {
            return body.flexibility(&force);
        }
        let basis = &body.rigid.basis;
        let resultant = basis.tr_mul(&force);
        force -= basis * &resultant;
        let traces = body.flexibility(&force);
        &traces + basis * (self.springs[b] * resultant - basis.tr_mul(&traces))
    }

    fn coarse_space(&self, rows: usize) -> Option<Coarse> {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (body, share) in self.bodies.iter().zip(&self.shares) {
            for q in body.rigid.basis.column_iter() {
                let mut column = vec![0.0; rows];
                body.scatter(&q.component_mul(share), &mut column);
                columns.push(column);
            }
        }
        if columns.is_empty() {
            return None;
        }
        let stiff: Vec<Vec<f64>> = columns.iter().map(|column| self.operator(column)).collect();
        let entry = |i: usize, j: usize| 0.5 * (dot(&columns[i], &stiff[j]) + dot(&columns[j], &stiff[i]));
        let eigen = DMatrix::from_fn(columns.len(), columns.len(), entry).symmetric_eigen();
        let least = RIGID * eigen.eigenvalues.max();
        let inverse = eigen.eigenvalues.map(|value| if value > least { 1.0 / value } else { 0.0 });
        let inverse = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
        Some(Coarse { columns, inverse })
    }
}
