//! The equations of a set with a sparse matrix: one factor of all of them.
//!
//! ```math
//! [ P_FF + η I   G_Fᵀ ] [  Δx ]   [ −(P x + q − Gᵀ a)_F ]
//! [ G_F          −δ I ] [ −Δa ] = [  e − G x            ]
//! ```
//! is quasi-definite, so any order of elimination does (Vanderbei 1995). Repeated, it is the proximal method of multipliers: `η` and `δ` have no part
//! in its limit, in which rows that depend on each other have multipliers of least norm.

use crate::programme::BoxQp;
use crate::sparse::{SparseFactor, compressed};

/// `η` and `δ`, over the mean diagonal of `P` and its inverse.
const ADDED: f64 = 1e-9;

/// Corrections of a solution, at most, and at least before one that gains nothing ends them.
const CORRECTIONS: [usize; 2] = [30, 3];

/// No place among the free unknowns.
const FIXED: usize = usize::MAX;

/// A sparse matrix with what all sets share.
pub(super) struct Augmented<'a> {
    qp: &'a BoxQp<'a>,
    /// The mean diagonal of `P`.
    mean: f64,
}

impl<'a> Augmented<'a> {
    pub(super) fn new(qp: &'a BoxQp<'a>, mean: f64) -> Self {
        Self { qp, mean: if mean > 0.0 { mean } else { 1.0 } }
    }

    /// Solves for the free unknowns and the multipliers of the rows; `None` if that does not converge.
    ///
    /// * `lengths`: of the rows; `x`: at their bounds but for the free ones, 0; `a`: 0.
    pub(super) fn solve(
        &self,
        lengths: &[f64],
        free: &[usize],
        (x, a): (&mut [f64], &mut [f64]),
    ) -> Option<()> {
        let (f, m) = (free.len(), a.len());
        let factor = self.factor(lengths, free, x.len())?;
        let mut before = f64::INFINITY;
        for k in 0..CORRECTIONS[0] {
            let gradient = self.qp.gradient(x, a);
            let mut step: Vec<f64> = free.iter().map(|i| -gradient[*i]).collect();
            step.extend(self.qp.defect(x).iter().zip(lengths).map(|(d, length)| d / length));
            factor.solve(&mut step);
            let change = step[..f].iter().fold(0.0f64, |most, s| most.max(s.abs()));
            if !change.is_finite() {
                return None;
            }
            free.iter().zip(&step[..f]).for_each(|(i, s)| x[*i] += s);
            (0..m).for_each(|row| a[row] -= step[f + row] / lengths[row]);
            if change == 0.0 || k >= CORRECTIONS[1] && change >= 0.5 * before {
                break;
            }
            before = change;
        }
        Some(())
    }

    fn factor(&self, lengths: &[f64], free: &[usize], n: usize) -> Option<SparseFactor> {
        let (f, m) = (free.len(), lengths.len());
        let mut place = vec![FIXED; n];
        free.iter().enumerate().for_each(|(k, i)| place[*i] = k);
        let mut entries = Vec::new();
        self.qp.matrix.for_each_upper(|i, j, value| {
            if place[i] != FIXED && place[j] != FIXED {
                entries.push((place[i], place[j], value));
            }
        });
        entries.extend((0..f).map(|i| (i, i, ADDED * self.mean)));
        for ((k, row), length) in self.qp.rows.rows().enumerate().zip(lengths) {
            let inside = row.filter(|(i, _)| place[*i] != FIXED);
            entries.extend(inside.map(|(i, g)| (place[i], f + k, g / length)));
            entries.push((f + k, f + k, -ADDED / self.mean));
        }
        SparseFactor::quasi_definite(&compressed(f + m, entries), m).ok()
    }
}
