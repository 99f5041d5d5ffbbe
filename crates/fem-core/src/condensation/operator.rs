//! A condensed body as its interface sees it: without a mesh and without a dimension.

use crate::dense::triangular;
use std::sync::OnceLock;

/// The Steklov-Poincaré operator `S = L_CC L_CCᵀ` of a body, and its condensed load `g̃`.
#[derive(Clone, Debug)]
pub struct InterfaceOperator {
    /// `L_CC`, column-major.
    factor: Vec<f64>,
    /// `S`, column-major, both triangles, if it was asked for.
    schur: OnceLock<Vec<f64>>,
    /// `g̃ = L_CC (L⁻¹ f)_C`.
    condensed_load: Vec<f64>,
}

impl InterfaceOperator {
    /// Takes a factor; the load is zero.
    ///
    /// * `factor`: `L_CC`, column-major; `size`: its number of columns.
    pub(super) fn new(factor: Vec<f64>, size: usize) -> Self {
        Self { factor, schur: OnceLock::new(), condensed_load: vec![0.0; size] }
    }

    /// Condenses a load.
    ///
    /// * `forward_load`: `(L⁻¹ f)_C`.
    pub(super) fn take_load(&mut self, forward_load: &[f64]) {
        self.condensed_load = self.condensed(forward_load);
    }

    /// Computes `g̃ = L_CC (L⁻¹ f)_C`, N/m.
    pub(super) fn condensed(&self, forward_load: &[f64]) -> Vec<f64> {
        let n_c = self.len();
        let mut condensed_load = vec![0.0; n_c];
        for (j, yj) in forward_load.iter().enumerate() {
            for i in j..n_c {
                condensed_load[i] += self.factor[j * n_c + i] * yj;
            }
        }
        condensed_load
    }

    /// Replaces the condensed load and returns the old one, N/m.
    pub(super) fn replace_load(&mut self, load: Vec<f64>) -> Vec<f64> {
        std::mem::replace(&mut self.condensed_load, load)
    }

    /// Returns `L_CC`, column-major.
    pub(super) fn factor(&self) -> &[f64] {
        &self.factor
    }

    /// Returns the number of interface unknowns.
    pub fn len(&self) -> usize {
        self.condensed_load.len()
    }

    /// Tells whether the body has no interface.
    pub fn is_empty(&self) -> bool {
        self.condensed_load.is_empty()
    }

    /// Returns `S`, column-major, both triangles, N/m²; computed once, when it is first needed.
    pub fn schur(&self) -> &[f64] {
        self.schur.get_or_init(|| triangular::square(&self.factor, self.len()))
    }

    /// Computes the diagonal of `S`, N/m², without `S`.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.len()];
        for (j, column) in self.factor.chunks_exact(self.len().max(1)).enumerate() {
            diagonal[j..].iter_mut().zip(&column[j..]).for_each(|(sum, l)| *sum += l * l);
        }
        diagonal
    }

    /// Returns `g̃`, N/m.
    pub fn condensed_load(&self) -> &[f64] {
        &self.condensed_load
    }

    /// Computes the reaction to an imposed normal trace, `r = S v − g̃` (N/m), in `2 n_c²` operations.
    ///
    /// # Panics
    /// If `v` or `r` has not `n_c` entries.
    pub fn reaction(&self, v: &[f64], r: &mut [f64]) {
        self.apply_schur(v, r);
        for (r, g) in r.iter_mut().zip(&self.condensed_load) {
            *r -= g;
        }
    }

    /// Computes `S v`, N/m.
    ///
    /// # Panics
    /// If `v` or `r` has not `n_c` entries.
    pub fn apply_schur(&self, v: &[f64], r: &mut [f64]) {
        self.check("the trace", v);
        self.check("the reaction", r);
        triangular::multiply(self.schur(), v, r);
    }

    /// Computes the trace of a correction under a normal force, `w = S⁻¹ r` (m), by two triangular solves.
    ///
    /// # Panics
    /// If `r` or `w` has not `n_c` entries.
    pub fn trace_from_force(&self, r: &[f64], w: &mut [f64]) {
        self.check("the force", r);
        self.check("the trace", w);
        w.copy_from_slice(r);
        triangular::forward(&self.factor, w);
        triangular::backward(&self.factor, w);
    }

    /// Computes `S⁻¹`, column-major, both triangles, m²/N: all traces under unit forces at once.
    pub fn flexibility(&self) -> Vec<f64> {
        triangular::invert(&self.factor, self.len())
    }

    /// Asserts that there is one entry per interface unknown.
    pub(super) fn check(&self, what: &str, values: &[f64]) {
        let (found, expected) = (values.len(), self.len());
        assert!(found == expected, "{what} has {found} entries, the interface {expected} unknowns");
    }
}
