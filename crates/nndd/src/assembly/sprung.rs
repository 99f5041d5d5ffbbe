//! The operators of a body in its rows; those of a floating body are the ones of the body on its springs.

use crate::rows::BodyRow;
use fem_core::condensation::CondensedBody;
use nalgebra::DVector;

/// A condensed body whose rows are its interface unknowns, but for factors.
pub(super) struct Sprung<'a> {
    condensed: &'a CondensedBody,
    /// The interface unknown of each row, and the trace per unit of it.
    unknowns: Vec<(usize, f64)>,
}

impl<'a> Sprung<'a> {
    /// Finds the unknown of each row; `None` if rows depend on each other or on supports.
    pub(super) fn new(condensed: &'a CondensedBody, rows: &[BodyRow]) -> Option<Self> {
        let mut seen = vec![false; condensed.len()];
        let unknown = |row: &BodyRow| match row.terms[..] {
            [term] if !std::mem::replace(&mut seen[term.0], true) => Some(term),
            _ => None,
        };
        Some(Self { condensed, unknowns: rows.iter().map(unknown).collect::<Option<_>>()? })
    }

    /// Computes `S_s v`, N/m.
    pub(super) fn stiffness(&self, v: &DVector<f64>) -> DVector<f64> {
        let (mut x, mut forces) = (vec![0.0; self.condensed.len()], vec![0.0; self.condensed.len()]);
        self.unknowns.iter().zip(v).for_each(|((k, a), v)| x[*k] = v / a);
        self.condensed.apply_schur(&x, &mut forces);
        DVector::from_iterator(v.len(), self.unknowns.iter().map(|(k, a)| forces[*k] / a))
    }

    /// Returns the diagonal of `S_s`, N/m².
    pub(super) fn diagonal(&self) -> DVector<f64> {
        let entry = |k: usize| self.condensed.schur()[k * (self.condensed.len() + 1)];
        let diagonal = self.unknowns.iter().map(|(k, a)| entry(*k) / (a * a));
        DVector::from_iterator(self.unknowns.len(), diagonal)
    }

    /// Computes `S_s⁻¹ f`, m.
    pub(super) fn flexibility(&self, force: &DVector<f64>) -> DVector<f64> {
        let (mut x, mut traces) = (vec![0.0; self.condensed.len()], vec![0.0; self.condensed.len()]);
        self.unknowns.iter().zip(force).for_each(|((k, a), f)| x[*k] = a * f);
        self.condensed.trace_from_force(&x, &mut traces);
        DVector::from_iterator(force.len(), self.unknowns.iter().map(|(k, a)| a * traces[*k]))
    }

    /// Computes `S_s⁻¹`, column-major, both triangles, m²/N.
    pub(super) fn flexibility_matrix(&self) -> Vec<f64> {
        let (inverse, size) = (self.condensed.flexibility(), self.condensed.len());
        let mut matrix = Vec::with_capacity(self.unknowns.len() * self.unknowns.len());
        for (q, b) in &self.unknowns {
            matrix.extend(self.unknowns.iter().map(|(p, a)| a * b * inverse[q * size + p]));
        }
        matrix
    }
}
