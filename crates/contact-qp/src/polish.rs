//! The exact solution on a given active set: fix `x_A = l_A`, solve for the rest, compute the multipliers.

use crate::active_set::ActiveSet;
use crate::cholesky::Factor;
use crate::error::QpError;
use crate::kkt::{self, CheckedMatrix, KktResiduals, Scales};
use crate::problem::BoundQp;

/// Size up to which a wrong sign is round-off, relative to the scales of [`KktResiduals`]: a few units in the last
/// place of the terms that cancel.
pub(crate) const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// The checked programme and the scales that its errors are compared with.
pub(crate) struct Prepared<'a> {
    pub(crate) qp: BoundQp<'a>,
    pub(crate) scales: Scales,
}

impl<'a> Prepared<'a> {
    /// Checks the rest of a programme and computes its scales.
    ///
    /// # Errors
    /// Those of [`BoundQp::check`] that do not concern the matrix.
    pub(crate) fn new(
        matrix: &CheckedMatrix<'a>,
        linear: &'a [f64],
        bounded: &'a [usize],
        lower: &'a [f64],
    ) -> Result<Self, QpError> {
        let qp = BoundQp { matrix: matrix.view, linear, bounded, lower };
        qp.check_vectors()?;
        Ok(Self { qp, scales: Scales::new(matrix, linear) })
    }

    /// Checks a whole programme.
    #[cfg(test)]
    pub(crate) fn of(qp: &BoundQp<'a>) -> Result<Self, QpError> {
        Self::new(&CheckedMatrix::new(qp.matrix)?, qp.linear, qp.bounded, qp.lower)
    }

    /// Number of bounds.
    pub(crate) fn bounds(&self) -> usize {
        self.qp.bounded.len()
    }
}

/// The minimiser on `x_A = l_A` for one active set, whatever the signs.
pub(crate) struct Candidate {
    /// Unknowns that are not fixed, `I`.
    free: Vec<usize>,
    /// Factor of `P_II`; `None` if everything is fixed.
    factor: Option<Factor>,
    /// `x`, with `x_A = l_A` bit for bit.
    x: Vec<f64>,
    /// `P x + q`: the multipliers on `A`, round-off on `I`.
    gradient: Vec<f64>,
}

/// A solution whose bounds and signs hold exactly.
pub(crate) struct Admissible {
    pub(crate) x: Vec<f64>,
    pub(crate) multipliers: Vec<f64>,
    pub(crate) active: ActiveSet,
}

impl Candidate {
    /// Solves `P_II x_I = −q_I − P_IA l_A`.
    ///
    /// # Errors
    /// [`QpError::NotPositiveDefinite`] when `P_II` is not.
    pub(crate) fn new(problem: &Prepared<'_>, active: &ActiveSet) -> Result<Self, QpError> {
        let qp = &problem.qp;
        let mut is_free = vec![true; qp.linear.len()];
        let mut x = vec![0.0; qp.linear.len()];
        for (k, &i) in qp.bounded.iter().enumerate().filter(|&(k, _)| active.is_active(k)) {
            is_free[i] = false;
            x[i] = qp.lower[k];
        }
        let free: Vec<usize> = (0..x.len()).filter(|&i| is_free[i]).collect();
        let factor = if free.is_empty() { None } else { Some(Factor::of_block(&qp.matrix, &free)?) };
        let gradient = gradient(qp, &x);
        let mut candidate = Self { free, factor, x, gradient };
        let load = candidate.imbalance(&problem.scales);
        candidate.newton_step(qp);
        candidate.check_regular(&problem.scales, load)?;
        Ok(candidate)
    }

    /// Rejects a solution without a correct digit: round-off can make the zero pivot of a singular block positive,
    /// and then `|x_I|_D` exceeds the load by the inverse of the round-off.
    fn check_regular(&self, scales: &Scales, load: f64) -> Result<(), QpError> {
        let size = |i: usize| scales.roots()[i] * self.x[i].abs();
        match self.free.iter().copied().max_by(|&i, &j| size(i).total_cmp(&size(j))) {
            Some(index) if ROUND_OFF * size(index) > load => Err(QpError::NotPositiveDefinite { index }),
            _ => Ok(()),
        }
    }

    /// Takes one more Newton step with the same factor, and keeps it if it lowers the residual on `I`.
    pub(crate) fn refine(&mut self, problem: &Prepared<'_>) {
        let scales = &problem.scales;
        let imbalance = self.imbalance(scales);
        // No improvement is possible once the residual is below the last place of its terms.
        if imbalance <= f64::EPSILON * scales.force(&self.x) {
            return;
        }
        let before = (self.x.clone(), self.gradient.clone());
        self.newton_step(&problem.qp);
        let improved = self.imbalance(scales) < imbalance;
        if !improved {
            (self.x, self.gradient) = before;
        }
    }

    /// `x_I ← x_I − P_II⁻¹ (P x + q)_I`: the solution when `x_I = 0`, iterative refinement afterwards.
    fn newton_step(&mut self, qp: &BoundQp<'_>) {
        let Some(factor) = &self.factor else { return };
        let mut step: Vec<f64> = self.free.iter().map(|&i| self.gradient[i]).collect();
        factor.solve(&mut step);
        for (&i, step) in self.free.iter().zip(step) {
            self.x[i] -= step;
        }
        self.gradient = gradient(qp, &self.x);
    }

    /// Returns `|(P x + q)_I|_D`.
    fn imbalance(&self, scales: &Scales) -> f64 {
        kkt::largest(self.free.iter().map(|&i| self.gradient[i] / scales.roots()[i]))
    }

    /// Lists the bounds that must change sides: active with `r < 0`, or inactive with `x < l`.
    ///
    /// A sign is wrong only beyond round-off: `r_k < −slack · F √P_kk`, with the scales of [`KktResiduals`]. This
    /// ends a sequence of steps if a body is only just in contact: there `r` is round-off of either sign. For
    /// `x < l` the slack stays at [`ROUND_OFF`], whatever `slack` is: a point wrongly moved onto its bound has a
    /// round-off multiplier, which passes the first test, but moving it there without solving again
    /// leaves an imbalance `P_jk (l_k − x_k)` on its neighbours.
    pub(crate) fn wrong_signs(&self, problem: &Prepared<'_>, active: &ActiveSet, slack: f64) -> Vec<usize> {
        let (qp, scales) = (&problem.qp, &problem.scales);
        let least_multiplier = -slack * scales.force(&self.x);
        let least_opening = -ROUND_OFF * scales.length(&self.x);
        let is_wrong = |k: usize| {
            let (i, root) = (qp.bounded[k], scales.roots()[qp.bounded[k]]);
            if active.is_active(k) {
                self.gradient[i] < least_multiplier * root
            } else {
                (self.x[i] - qp.lower[k]) * root < least_opening
            }
        };
        (0..problem.bounds()).filter(|&k| is_wrong(k)).collect()
    }

    /// Makes bounds and signs exact, provided that the errors are round-off: a negative multiplier becomes 0 and
    /// its bound stays active; an inactive point on or below its bound is moved onto it and becomes active with
    /// multiplier 0. The KKT residuals then include these changes.
    pub(crate) fn into_admissible(mut self, qp: &BoundQp<'_>, active: &ActiveSet) -> Admissible {
        let mut flags = active.as_slice().to_vec();
        let mut multipliers = vec![0.0; flags.len()];
        for (k, &i) in qp.bounded.iter().enumerate() {
            if flags[k] {
                multipliers[k] = positive_part(self.gradient[i]);
            } else if self.x[i] <= qp.lower[k] {
                self.x[i] = qp.lower[k];
                flags[k] = true;
            }
        }
        debug_assert!(qp.bounded.iter().zip(qp.lower).all(|(&i, l)| self.x[i] >= *l || self.x[i].is_nan()));
        debug_assert!(multipliers.iter().all(|r| *r >= 0.0));
        Admissible { x: self.x, multipliers, active: ActiveSet::new(flags) }
    }
}

impl Admissible {
    /// Measures the KKT residuals.
    pub(crate) fn residuals(&self, problem: &Prepared<'_>) -> KktResiduals {
        kkt::residuals(&problem.qp, &problem.scales, &self.x, &self.multipliers)
    }
}

/// Returns `max(v, 0)`, and `+0.0` for `−0.0` and for NaN.
pub(crate) fn positive_part(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

fn gradient(qp: &BoundQp<'_>, x: &[f64]) -> Vec<f64> {
    let mut gradient = qp.linear.to_vec();
    qp.matrix.add_product(x, &mut gradient);
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::MatrixView;

    /// `P = [4 −2; −2 4]`, whose pivots are squares of short numbers, with bounds on both unknowns.
    fn pair<'a>(linear: &'a [f64], lower: &'a [f64]) -> BoundQp<'a> {
        let matrix = MatrixView::Dense { n: 2, values: &[4.0, -2.0, -2.0, 4.0] };
        BoundQp { matrix, linear, bounded: &[0, 1], lower }
    }

    #[test]
    fn solves_on_the_set_and_lists_wrong_signs() {
        // On A = {0}: x₀ = 1, 4 x₁ = 6 + 2 x₀ = 8, so x₁ = 2 and r₀ = 4 − 4 − 6 = −6: bound 0 must leave.
        let qp = pair(&[-6.0, -6.0], &[1.0, 2.5]);
        let problem = Prepared::of(&qp).unwrap();
        let active = ActiveSet::new(vec![true, false]);
        let candidate = Candidate::new(&problem, &active).unwrap();
        assert_eq!(candidate.x, [1.0, 2.0]);
        assert_eq!(candidate.gradient, [-6.0, 0.0]);
        assert_eq!(candidate.wrong_signs(&problem, &active, ROUND_OFF), [0, 1]);
    }

    #[test]
    fn round_off_is_not_a_wrong_sign_and_is_made_exact() {
        // All fixed at 1: the multipliers are 4 − 2 + q.
        let linear = [-2.0 - 4.0 * f64::EPSILON, -1.5];
        let qp = pair(&linear, &[1.0, 1.0]);
        let problem = Prepared::of(&qp).unwrap();
        let active = ActiveSet::all(2);
        let candidate = Candidate::new(&problem, &active).unwrap();
        assert!(candidate.gradient[0] < 0.0);
        assert!(candidate.wrong_signs(&problem, &active, ROUND_OFF).is_empty());
        assert_eq!(candidate.wrong_signs(&problem, &active, 0.0), [0]);
        let answer = candidate.into_admissible(&qp, &active);
        assert_eq!((answer.multipliers[0], answer.multipliers[1]), (0.0, 0.5));
        assert!(answer.active.is_active(0));
        let residuals = answer.residuals(&problem);
        assert!(residuals.max() > 0.0 && residuals.max() < 1e-15, "{residuals:?}");
    }

    #[test]
    fn a_point_just_below_its_bound_becomes_active() {
        // Unconstrained minimiser (1, 1), bounds one unit in the last place above it.
        let lower = [1.0 + f64::EPSILON, -4.0];
        let qp = pair(&[-2.0, -2.0], &lower);
        let problem = Prepared::of(&qp).unwrap();
        let active = ActiveSet::none(2);
        let candidate = Candidate::new(&problem, &active).unwrap();
        assert!(candidate.x[0] < lower[0]);
        assert!(candidate.wrong_signs(&problem, &active, ROUND_OFF).is_empty());
        let answer = candidate.into_admissible(&qp, &active);
        assert_eq!(answer.x[0], lower[0]);
        assert_eq!(answer.active.as_slice(), [true, false]);
        assert_eq!(answer.multipliers, [0.0, 0.0]);
    }

    #[test]
    fn a_zero_pivot_hidden_by_round_off_is_refused() {
        // Chains of springs without supports: singular, but the last pivot is round-off of either sign.
        let mut hidden = 0;
        for case in 1..40 {
            let n = 6;
            let mut values = vec![0.0; n * n];
            for i in 0..n - 1 {
                let spring = 0.1 + (0.37 * f64::from(case) * (i + 1) as f64).fract();
                values[i * n + i] += spring;
                values[(i + 1) * n + i + 1] += spring;
                values[i * n + i + 1] -= spring;
                values[(i + 1) * n + i] -= spring;
            }
            let matrix = MatrixView::Dense { n, values: &values };
            let qp = BoundQp { matrix, linear: &[1.0; 6], bounded: &[], lower: &[] };
            let problem = Prepared::of(&qp).unwrap();
            let free: Vec<usize> = (0..n).collect();
            hidden += usize::from(Factor::of_block(&matrix, &free).is_ok());
            let found = Candidate::new(&problem, &ActiveSet::default()).err();
            assert!(matches!(found, Some(QpError::NotPositiveDefinite { .. })), "case {case}: {found:?}");
        }
        assert!(hidden > 5, "{hidden}");
    }
}
