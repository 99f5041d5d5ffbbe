//! A condensed body as its interface sees it: without a mesh and without a dimension.

use crate::cholesky::Cholesky;
use crate::dense::triangular;
use std::sync::{Arc, OnceLock};

/// The Steklov-Poincaré operator `S = L_CC L_CCᵀ` of a body, and its condensed load `g̃`.
#[derive(Clone, Debug)]
pub struct InterfaceOperator {
    /// `L`, whose last columns are `L_CC`.
    factor: Arc<Cholesky>,
    /// `S`, column-major, both triangles, if it was asked for.
    schur: OnceLock<Vec<f64>>,
    /// `g̃ = L_CC (L⁻¹ f)_C`.
    condensed_load: Vec<f64>,
}

impl InterfaceOperator {
    /// Takes a factor; the load is zero.
    ///
    /// * `size`: the number of columns of `L_CC`.
    pub(super) fn new(factor: Arc<Cholesky>, size: usize) -> Self {
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
        self.factor.product(forward_load)
    }

    /// Replaces the condensed load and returns the old one, N/m.
    pub(super) fn replace_load(&mut self, load: Vec<f64>) -> Vec<f64> {
        std::mem::replace(&mut self.condensed_load, load)
    }

    /// Returns `L_CC`, column-major, with zeros above the diagonal.
    fn trailing_factor(&self) -> Vec<f64> {
        self.factor.trailing_block(self.len())
    }

    /// Overwrites a force by `L_CC⁻¹ r`.
    pub(super) fn forward(&self, r: &mut [f64]) {
        self.factor.forward(r);
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
        self.schur.get_or_init(|| triangular::square(&self.trailing_factor(), self.len()))
    }

    /// Computes the diagonal of `S`, N/m², without `S`.
    pub fn diagonal(&self) -> Vec<f64> {
        self.factor.trailing_squares(self.len())
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

    /// Computes `S v = L_CC (L_CCᵀ v)`, N/m.
    ///
    /// # Panics
    /// If `v` or `r` has not `n_c` entries.
    pub fn apply_schur(&self, v: &[f64], r: &mut [f64]) {
        self.check("the trace", v);
        self.check("the reaction", r);
        let mut y = v.to_vec();
        self.factor.transposed_product(&mut y);
        r.copy_from_slice(&self.factor.product(&y));
    }

    /// Computes `VᵀS V` of several traces, column-major, both triangles, N/m.
    ///
    /// * `traces`: `V`, column-major, m.
    pub fn energies(&self, traces: &[f64]) -> Vec<f64> {
        triangular::energies(&self.trailing_factor(), self.len(), traces)
    }

    /// Computes the trace of a correction under a normal force, `w = S⁻¹ r` (m), by two triangular solves.
    ///
    /// # Panics
    /// If `r` or `w` has not `n_c` entries.
    pub fn trace_from_force(&self, r: &[f64], w: &mut [f64]) {
        self.check("the force", r);
        self.check("the trace", w);
        w.copy_from_slice(r);
        self.factor.forward(w);
        self.factor.backward(w, 0);
    }

    /// Computes `S⁻¹`, column-major, both triangles, m²/N: all traces under unit forces at once.
    pub fn flexibility(&self) -> Vec<f64> {
        triangular::invert(&self.trailing_factor(), self.len())
    }

    /// Asserts that there is one entry per interface unknown.
    pub(super) fn check(&self, what: &str, values: &[f64]) {
        let (found, expected) = (values.len(), self.len());
        assert!(found == expected, "{what} has {found} entries, the interface {expected} unknowns");
    }
}
