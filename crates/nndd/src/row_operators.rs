//! The operators of a body in its rows; those of a floating body are the ones of the body on its springs.

use fem_core::condensation::InterfaceOperator;
use fem_core::contact_system::BodyRow;
use nalgebra::DVector;
use std::borrow::Cow;

/// A condensed body whose rows are its interface unknowns, but for factors.
pub(crate) struct RowOperators<'a> {
    condensed: &'a InterfaceOperator,
    /// The interface unknown of each row, and the trace per unit of it.
    unknowns: Vec<(usize, f64)>,
}

impl<'a> RowOperators<'a> {
    /// Finds the unknown of each row; `None` if rows depend on each other or on supports.
    pub(crate) fn new(condensed: &'a InterfaceOperator, rows: &[BodyRow]) -> Option<Self> {
        let mut seen = vec![false; condensed.len()];
        let unknown = |row: &BodyRow| match row.terms[..] {
            [term] if !std::mem::replace(&mut seen[term.0], true) => Some(term),
            _ => None,
        };
        Some(Self { condensed, unknowns: rows.iter().map(unknown).collect::<Option<_>>()? })
    }

    /// Computes `S_s v`, N/m.
    pub(crate) fn stiffness(&self, v: &DVector<f64>) -> DVector<f64> {
        let (mut x, mut forces) = (vec![0.0; self.condensed.len()], vec![0.0; self.condensed.len()]);
        self.unknowns.iter().zip(v).for_each(|((k, a), v)| x[*k] = v / a);
        self.condensed.apply_schur(&x, &mut forces);
        DVector::from_iterator(v.len(), self.unknowns.iter().map(|(k, a)| forces[*k] / a))
    }

    /// Returns `S_s` in some rows, column-major, both triangles, N/m².
    pub(crate) fn stiffness_matrix(&self, rows: &[usize]) -> Cow<'a, [f64]> {
        let (schur, size) = (self.condensed.schur(), self.condensed.len());
        let first = self.unknowns.first().map_or(1.0, |of| of.1);
        let is_own = |(i, row): (usize, &usize)| i == *row && self.unknowns[*row] == (i, first);
        if rows.len() == size && first.abs() == 1.0 && rows.iter().enumerate().all(is_own) {
            return Cow::Borrowed(schur);
        }
        let mut matrix = Vec::with_capacity(rows.len() * rows.len());
        for (q, b) in rows.iter().map(|row| self.unknowns[*row]) {
            let entry = |row: &usize| schur[q * size + self.unknowns[*row].0] / (self.unknowns[*row].1 * b);
            matrix.extend(rows.iter().map(entry));
        }
        Cow::Owned(matrix)
    }

    /// Returns the condensed load, N/m.
    pub(crate) fn load(&self) -> DVector<f64> {
        let load = self.condensed.condensed_load();
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|(k, a)| load[*k] / a))
    }

    /// Returns the diagonal of `S_s`, N/m².
    pub(crate) fn diagonal(&self) -> DVector<f64> {
        let diagonal = self.condensed.diagonal();
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|(k, a)| diagonal[*k] / (a * a)))
    }

    /// Computes `S_s⁻¹ f`, m.
    pub(crate) fn flexibility(&self, force: &DVector<f64>) -> DVector<f64> {
        let (mut x, mut traces) = (vec![0.0; self.condensed.len()], vec![0.0; self.condensed.len()]);
        self.unknowns.iter().zip(force).for_each(|((k, a), f)| x[*k] = a * f);
        self.condensed.trace_from_force(&x, &mut traces);
        DVector::from_iterator(force.len(), self.unknowns.iter().map(|(k, a)| a * traces[*k]))
    }

    /// Computes `S_s⁻¹`, column-major, both triangles, m²/N.
    pub(crate) fn flexibility_matrix(&self) -> Vec<f64> {
        let (inverse, size) = (self.condensed.flexibility(), self.condensed.len());
        let mut matrix = Vec::with_capacity(self.unknowns.len() * self.unknowns.len());
        for (q, b) in &self.unknowns {
            matrix.extend(self.unknowns.iter().map(|(p, a)| a * b * inverse[q * size + p]));
        }
        matrix
    }
}
