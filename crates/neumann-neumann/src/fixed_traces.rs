//! The Neumann problems of step 2 with the traces held that a set of closed rows fixes: at supports, at obstacles, and what is tied to them.
//!
//! ```math
//! S w = f − E q,   Eᵀ w = 0,   Qᵀ (f − E q) = 0:      w = S_s⁻¹ (f − E q) + Q a,   F = Eᵀ S_s⁻¹ E
//! q = F⁻¹ Eᵀ (S_s⁻¹ f + Q a),                         (QᵀE F⁻¹ EᵀQ) a = Qᵀ f − QᵀE F⁻¹ Eᵀ S_s⁻¹ f
//! ```
//! A beam on many supports would otherwise be far softer in step 2 than in the problem that it preconditions.

use crate::broken::Broken;
use fem_core::dense::pseudo_inverse;
use fem_core::each_body;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Eigenvalues of the motions that fixed traces resist below this fraction of the largest one are zero.
const ZERO: f64 = 1e-10;

/// The bodies with fixed traces.
pub(crate) struct FixedTraces {
    bodies: Vec<FixedBody>,
}

/// A body with fixed traces `E`, by their numbers among all unknowns.
struct FixedBody {
    body: usize,
    fixed: Vec<usize>,
    /// The Cholesky factor of `F`.
    factor: Cholesky<f64, Dyn>,
    /// `F⁻¹ EᵀQ`, and the pseudo-inverse of `QᵀE F⁻¹ EᵀQ`.
    resisting: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl FixedTraces {
    /// * `is_fixed`: by unknown. Bodies without fixed traces are left out, as are those whose `F` is singular to round-off.
    pub(crate) fn new(broken: &Broken<'_>, is_fixed: impl Fn(usize) -> bool + Sync) -> Self {
        let made = each_body(broken.system().bodies.len(), |body| {
            let fixed: Vec<usize> = broken.of_body(body).filter(|k| is_fixed(*k)).collect();
            if fixed.is_empty() { None } else { FixedBody::new(broken, body, fixed) }
        });
        Self { bodies: made.into_iter().flatten().collect() }
    }

    /// Corrects the traces `S_s⁻¹ f` to those with the fixed ones held. Returns the forces `E q` that hold them, N/m.
    pub(crate) fn hold(&self, broken: &Broken<'_>, forces: &[f64], traces: &mut [f64]) -> Vec<f64> {
        let mut holding = vec![0.0; traces.len()];
        let mut moved = Vec::with_capacity(self.bodies.len());
        for of in &self.bodies {
            let basis = broken.basis(of.body);
            let free = DVector::from_iterator(of.fixed.len(), of.fixed.iter().map(|k| traces[*k]));
            let own = DVector::from_column_slice(&forces[broken.of_body(of.body)]);
            let motion = &of.inverse * (basis.tr_mul(&own) - of.resisting.tr_mul(&free));
            let q = of.factor.solve(&free) + &of.resisting * &motion;
            of.fixed.iter().zip(&q).for_each(|(k, q)| holding[*k] = *q);
            moved.push(basis * motion);
        }
        if !self.bodies.is_empty() {
            let taken = broken.flexibility(&holding);
            traces.iter_mut().zip(taken).for_each(|(w, taken)| *w -= taken);
        }
        for (of, moved) in self.bodies.iter().zip(moved) {
            traces[broken.of_body(of.body)].iter_mut().zip(&moved).for_each(|(w, moved)| *w += moved);
            of.fixed.iter().for_each(|k| traces[*k] = 0.0);
        }
        holding
    }
}

impl FixedBody {
    fn new(broken: &Broken<'_>, body: usize, fixed: Vec<usize>) -> Option<Self> {
        let own = broken.of_body(body);
        let place = |i: usize| fixed[i] - own.start;
        let flexibility = broken.flexibility_matrix(body);
        let entry = |i, j| flexibility[place(j) * own.len() + place(i)];
        let matrix = DMatrix::from_fn(fixed.len(), fixed.len(), entry);
        let factor = matrix.cholesky()?;
        let basis = broken.basis(body);
        let traces = DMatrix::from_fn(fixed.len(), basis.ncols(), |i, j| basis[(place(i), j)]);
        let resisting = factor.solve(&traces);
        let matrix = traces.tr_mul(&resisting);
        let zero = ZERO * matrix.amax();
        let inverse = if matrix.is_empty() { matrix } else { pseudo_inverse(matrix, zero)? };
        Some(Self { body, fixed, factor, resisting, inverse })
    }
}
